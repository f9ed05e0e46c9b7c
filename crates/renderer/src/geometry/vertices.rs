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

/// Passes see parts of the buffers: only the buffers' own size bounds them.
fn most_vertices(gpu: &Gpu) -> u64 {
    (gpu.device.limits().max_buffer_size / vertex_bytes()).min(u64::from(u32::MAX))
}

/// Of a vertex in mesh space.
pub(super) fn vertex_bytes() -> u64 {
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
        let total = count_of(scene, placed.iter());
        let most = most_vertices(gpu);
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

    /// Parts of all vertices that a pass can be given, each the first of them and their number.
    pub fn windows(&self, gpu: &Gpu) -> impl Iterator<Item = (u32, u32)> + use<> {
        // Where they begin suits the bindings of everything that is a multiple of 16 bytes a vertex.
        let step = (gpu.device.limits().min_storage_buffer_offset_alignment / 16).max(1);
        let most = (gpu.largest_storage() / vertex_bytes()).min(1 << 30) as u32 / step * step;
        let count = self.count();
        (0..count).step_by(most.max(step) as usize).map(move |first| (first, most.min(count - first)))
    }

    fn anew(gpu: &Gpu, scene: &Scene, placed: &[Instance]) -> Result<Self, RenderError> {
        let storage = wgpu::BufferUsages::STORAGE;
        let count = count_of(scene, placed.iter());
        let mesh = Store::with_room(gpu, "mesh vertices", count * vertex_bytes(), storage);
        let bytes = count * size_of::<StaticAttributes>() as u64;
        let attributes = Store::with_room(gpu, "static attributes", bytes, wgpu::BufferUsages::VERTEX);
        let mut added = Added::new(gpu, (mesh, attributes), 0);
        let slots = (0..).zip(placed).map(|(instance, placed)| added.slot(scene, placed, instance));
        let slots = slots.collect::<Result<_, _>>()?;
        let Added { mesh, attributes, records, .. } = added.written();
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
        let new = placed.iter().zip(kept).filter(|(_, kept)| kept.is_none()).map(|(instance, _)| instance);
        let (count, most) = (count_of(scene, new), most_vertices(gpu));
        let bytes_each = size_of::<StaticAttributes>() as u64;
        let mesh = self.mesh.grown(gpu, count * vertex_bytes(), most * vertex_bytes());
        let attributes = self.attributes.grown(gpu, count * bytes_each, most * bytes_each);
        let mut added = Added::new(gpu, (mesh, attributes), (self.records.end() / 4) as u32);
        let mut slots = Vec::with_capacity(placed.len());
        for (instance, &kept) in placed.iter().zip(kept) {
            slots.push(match kept {
                Some(place) => Slot { before: kept, ..self.slots[place].clone() },
                None => added.slot(scene, instance, free.next().unwrap_or_default())?,
            });
        }
        let Added { mesh, attributes, records, most_words, .. } = added.written();
        let words = bytemuck::cast_slice(&records.words);
        let mut records = self.records.grown(gpu, words.len() as u64, 4 * most_words);
        records.push(gpu, words);
        let world =
            if mesh.buffer == self.mesh.buffer { self.world.clone() } else { world_buffers(gpu, &mesh) };
        Ok(Self { slots, mesh, attributes, records, world })
    }
}

fn count_of<'a>(scene: &Scene, placed: impl Iterator<Item = &'a Instance>) -> u64 {
    placed.map(|instance| scene.meshes[instance.mesh.0].positions.len() as u64).sum()
}

/// With room for as many vertices as `mesh`.
fn world_buffers(gpu: &Gpu, mesh: &Store) -> [wgpu::Buffer; 3] {
    let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_SRC;
    let size = 16 * (mesh.buffer.size() / vertex_bytes());
    ["positions_world", "normals_world", "tangents_world"].map(|label| gpu.empty_buffer(label, size, usage))
}

/// Vertices on their way: all of them at a time would be as much memory again.
struct Added<'a> {
    gpu: &'a Gpu,
    mesh: Store,
    attributes: Store,
    next_vertex: u32,
    /// Those that are to be written next.
    vertices: Vec<layout::MeshVertex>,
    of_vertices: Vec<StaticAttributes>,
    records: Records,
    most_words: u64,
}

/// Vertices that are written at a time.
const PART: usize = 1 << 16;

impl<'a> Added<'a> {
    /// To stores of vertices and attributes that have room for them, behind so many words of records.
    fn new(gpu: &'a Gpu, (mesh, attributes): (Store, Store), first_word: u32) -> Self {
        Self {
            gpu,
            next_vertex: (mesh.end() / vertex_bytes()) as u32,
            mesh,
            attributes,
            vertices: Vec::new(),
            of_vertices: Vec::new(),
            records: Records::after(first_word),
            most_words: (gpu.largest_storage() / 4).min(u64::from(u32::MAX)),
        }
    }

    fn slot(&mut self, scene: &Scene, placed: &Instance, instance: u32) -> Result<Slot, RenderError> {
        let mesh = &scene.meshes[placed.mesh.0];
        let first_vertex = self.next_vertex;
        let of_vertices = self.records.of(placed.mesh, mesh).unwrap_or_default().to_vec();
        if self.records.end() > self.most_words {
            let (wanted, most) = (self.records.end(), self.most_words);
            return Err(over(self.gpu, "words of joints and morph targets", wanted, most));
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
            self.of_vertices.push(StaticAttributes {
                uvs: [uv(0).x, uv(0).y, uv(1).x, uv(1).y],
                color: mesh.colors.get(i).map_or([1.0; 4], |color| color.to_array()),
            });
            if self.vertices.len() == PART {
                self.write();
            }
        }
        self.next_vertex += mesh.positions.len() as u32;
        Ok(Slot { mesh: Arc::clone(mesh), first_vertex, instance, before: None })
    }

    fn write(&mut self) {
        self.mesh.push(self.gpu, &layout::bytes(self.vertices.as_slice()));
        self.attributes.push(self.gpu, bytemuck::cast_slice(&self.of_vertices));
        self.vertices.clear();
        self.of_vertices.clear();
        // What was copied is let go once it has arrived.
        self.gpu.queue.submit([]);
    }

    fn written(mut self) -> Self {
        if !self.vertices.is_empty() {
            self.write();
        }
        self
    }
}
