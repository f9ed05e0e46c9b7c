//! The vertices of placed meshes on the GPU. Every instance has its own, uploaded once: they stay where they are when others come or go.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use gnomon_scene::{Instance, Mesh, Scene};
use gnomon_shaders::layout;

use super::store::Store;
use super::{address, over};
use crate::deformation::Records;
use crate::{Gpu, RenderError};

/// Attributes that no animation changes, as the G-buffer reads them.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct StaticAttributes {
    uvs: [f32; 4],
    color: [f32; 4],
}

/// Where the vertices of an instance lie.
#[derive(Clone)]
pub(super) struct Slot {
    /// Keeps the address that it is known by from being used for another.
    mesh: Arc<Mesh>,
    pub first_vertex: u32,
    /// Number that its vertices know their instance by.
    pub instance: u32,
    /// Place in `slots` of the geometry before, where it was there.
    pub before: Option<usize>,
}

/// All vertices, in mesh space and in world space.
pub(super) struct Vertices {
    /// One for each placed mesh.
    pub slots: Vec<Slot>,
    pub mesh: Store,
    pub attributes: Store,
    /// Of joints and morph targets.
    pub records: Store,
    /// Positions, normals, tangents.
    pub world: [wgpu::Buffer; 3],
}

/// Vertices that no slot has any more are at most this share of those that one has; beyond, all are uploaded anew.
const MOST_UNUSED: f64 = 0.25;

/// Of a vertex in mesh space.
fn vertex_bytes() -> u64 {
    layout::size::<layout::MeshVertex>()
}

impl Vertices {
    /// The vertices of `placed` meshes. Those that `before` has of the same meshes, by their `Arc`, stay where they are.
    pub fn new(
        gpu: &Gpu,
        scene: &Scene,
        placed: &[Instance],
        before: Option<&Self>,
    ) -> Result<Self, RenderError> {
        let count = |mesh: &Mesh| mesh.positions.len() as u64;
        let total: u64 = placed.iter().map(|instance| count(&scene.meshes[instance.mesh.0])).sum();
        let most = (gpu.largest_storage() / vertex_bytes()).min(u64::from(u32::MAX));
        if total > most {
            return Err(over(gpu, "vertices", total, most));
        }
        if let Some(before) = before {
            let kept = before.slots_kept(scene, placed);
            let in_use: u64 = kept.iter().flatten().map(|&slot| count(&before.slots[slot].mesh)).sum();
            let end = u64::from(before.count());
            let unused = (end - in_use) as f64;
            if in_use > 0 && unused <= MOST_UNUSED * total as f64 && end + total - in_use <= most {
                let extended = before.extended(gpu, scene, placed, &kept);
                // Records that are still there of meshes that are gone may be in the way.
                if !matches!(extended, Err(RenderError::OverLimit { .. })) {
                    return extended;
                }
            }
        }
        Self::anew(gpu, scene, placed)
    }

    /// Of all that were ever placed since all were uploaded.
    pub fn count(&self) -> u32 {
        (self.mesh.end() / vertex_bytes()) as u32
    }

    fn anew(gpu: &Gpu, scene: &Scene, placed: &[Instance]) -> Result<Self, RenderError> {
        let mut added = Added::new(gpu, 0, 0);
        let slots = (0..).zip(placed).map(|(instance, placed)| added.slot(gpu, scene, placed, instance));
        let slots = slots.collect::<Result<_, _>>()?;
        let storage = wgpu::BufferUsages::STORAGE;
        let Added { vertices, attributes, records, .. } = added;
        let mesh = Store::new(gpu, "mesh vertices", &layout::bytes(vertices.as_slice()), storage);
        let attributes = Store::new(
            gpu,
            "static attributes",
            bytemuck::cast_slice(&attributes),
            wgpu::BufferUsages::VERTEX,
        );
        let records = Store::new(gpu, "deformation records", bytemuck::cast_slice(&records.words), storage);
        Ok(Self { slots, world: world_buffers(gpu, &mesh), mesh, attributes, records })
    }

    /// By placed mesh, the place of the slot that has its vertices.
    fn slots_kept(&self, scene: &Scene, placed: &[Instance]) -> Vec<Option<usize>> {
        let mut free: HashMap<usize, Vec<usize>> = HashMap::new();
        for (place, slot) in self.slots.iter().enumerate().rev() {
            free.entry(address(&slot.mesh)).or_default().push(place);
        }
        let take = |instance: &Instance| free.get_mut(&address(&scene.meshes[instance.mesh.0]))?.pop();
        placed.iter().map(take).collect()
    }

    fn extended(
        &self,
        gpu: &Gpu,
        scene: &Scene,
        placed: &[Instance],
        kept: &[Option<usize>],
    ) -> Result<Self, RenderError> {
        let taken: HashSet<u32> = kept.iter().flatten().map(|&slot| self.slots[slot].instance).collect();
        let mut free = (0..).filter(|number| !taken.contains(number));
        let mut added = Added::new(gpu, self.count(), (self.records.end() / 4) as u32);
        let mut slots = Vec::with_capacity(placed.len());
        for (instance, &kept) in placed.iter().zip(kept) {
            slots.push(match kept {
                Some(place) => Slot { before: kept, ..self.slots[place].clone() },
                None => added.slot(gpu, scene, instance, free.next().unwrap_or_default())?,
            });
        }
        let Added { vertices, attributes, records, most_words, .. } = added;
        let most = gpu.largest_storage() / vertex_bytes();
        let mesh = self.mesh.with(gpu, &layout::bytes(vertices.as_slice()), most * vertex_bytes());
        let bytes_each = size_of::<StaticAttributes>() as u64;
        let attributes = self.attributes.with(gpu, bytemuck::cast_slice(&attributes), most * bytes_each);
        let records = self.records.with(gpu, bytemuck::cast_slice(&records.words), 4 * most_words);
        let world =
            if mesh.buffer == self.mesh.buffer { self.world.clone() } else { world_buffers(gpu, &mesh) };
        Ok(Self { slots, mesh, attributes, records, world })
    }
}

/// With room for as many vertices as `mesh`.
fn world_buffers(gpu: &Gpu, mesh: &Store) -> [wgpu::Buffer; 3] {
    let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_SRC;
    let size = 16 * (mesh.buffer.size() / vertex_bytes());
    ["positions_world", "normals_world", "tangents_world"].map(|label| gpu.empty_buffer(label, size, usage))
}

/// Vertices to be uploaded.
struct Added {
    first_vertex: u32,
    vertices: Vec<layout::MeshVertex>,
    attributes: Vec<StaticAttributes>,
    records: Records,
    most_words: u64,
}

impl Added {
    /// Behind so many vertices and words of records.
    fn new(gpu: &Gpu, first_vertex: u32, first_word: u32) -> Self {
        let most_words = (gpu.largest_storage() / 4).min(u64::from(u32::MAX));
        let records = Records::after(first_word);
        Self { first_vertex, vertices: Vec::new(), attributes: Vec::new(), records, most_words }
    }

    fn slot(
        &mut self,
        gpu: &Gpu,
        scene: &Scene,
        placed: &Instance,
        instance: u32,
    ) -> Result<Slot, RenderError> {
        let mesh = &scene.meshes[placed.mesh.0];
        let first_vertex = self.first_vertex + self.vertices.len() as u32;
        let of_vertices = self.records.of(placed.mesh, mesh).unwrap_or_default().to_vec();
        if self.records.end() > self.most_words {
            return Err(over(gpu, "words of joints and morph targets", self.records.end(), self.most_words));
        }
        for (i, position) in mesh.positions.iter().enumerate() {
            let tangent = mesh.tangents.get(i).copied().unwrap_or_default();
            let uv = |set: usize| mesh.uvs[set].get(i).copied().unwrap_or_default();
            self.vertices.push(layout::MeshVertex {
                position: *position,
                instance,
                normal: mesh.normals.get(i).copied().unwrap_or_default(),
                tangent_sign: tangent.w,
                tangent: tangent.truncate(),
                record: of_vertices.get(i).copied().unwrap_or(0),
            });
            self.attributes.push(StaticAttributes {
                uvs: [uv(0).x, uv(0).y, uv(1).x, uv(1).y],
                color: mesh.colors.get(i).map_or([1.0; 4], |color| color.to_array()),
            });
        }
        Ok(Slot { mesh: Arc::clone(mesh), first_vertex, instance, before: None })
    }
}
