use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

use glam::{Affine3A, Vec3};
use gnomon_scene::{
    AlphaMode, Bounds, Instance, MaterialId, Mesh, MeshPart, Pose, Scene, SimplerTriangles, SkinId,
};
use gnomon_shaders::layout;
use rayon::prelude::*;

use crate::bindings::Binding;
use crate::casters::{InstanceBox, PlacedBoxes, SimplerIndices};
use crate::deformation::{DeformableBoxes, PoseData, Records};
use crate::recorder::Recorder;
use crate::{Gpu, RenderError};

/// Attributes that no animation changes, as the G-buffer reads them.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct StaticAttributes {
    uvs: [f32; 4],
    color: [f32; 4],
}

/// Indices drawn with one material.
pub(crate) struct DrawRange {
    /// Index into the scene's materials; `None` is the default material.
    pub material: Option<usize>,
    /// Whether alpha cuts holes into it.
    pub is_masked: bool,
    pub indices: Range<u32>,
}

fn is_masked(scene: &Scene, mesh: &Mesh) -> bool {
    let material = mesh.material.and_then(|material| scene.materials.get(material.0));
    material.is_some_and(|material| matches!(material.alpha_mode, AlphaMode::Mask { .. }))
}

/// The scene's triangles on the GPU: as they lie in their meshes, and in world space after the frame's first pass.
///
/// Every instance has its own vertices, so one draw call can hold the whole scene and a deformed instance is its own.
pub(crate) struct Geometry {
    pub positions_world: wgpu::Buffer,
    pub normals_world: wgpu::Buffer,
    pub tangents_world: wgpu::Buffer,
    pub static_attributes: wgpu::Buffer,
    pub indices: wgpu::Buffer,
    pub ranges: Vec<DrawRange>,
    /// Of all triangles as they are; what follows them are simpler ones.
    pub index_count: u32,
    /// Around what casts and receives shadows. Those of deformed instances are conservative.
    pub boxes: Vec<InstanceBox>,
    /// The same where the pose has them.
    pub placed_boxes: PlacedBoxes,
    vertex_count: u32,
    instances: wgpu::Buffer,
    joints: wgpu::Buffer,
    joint_count: usize,
    weights: wgpu::Buffer,
    placed: Vec<Kept>,
    pub details: MeshDetails,
    /// Of each deformable instance, where its box is among `boxes`.
    deformable: Vec<(usize, DeformableBoxes)>,
    bind_group: wgpu::BindGroup,
}

/// What of an instance a new pose keeps.
struct Kept {
    mesh: Arc<Mesh>,
    material: Option<MaterialId>,
    is_masked: bool,
    skin: Option<SkinId>,
}

impl Kept {
    fn new(scene: &Scene, instance: &Instance) -> Self {
        let mesh = Arc::clone(&scene.meshes[instance.mesh.0]);
        let is_masked = is_masked(scene, &mesh);
        Self { material: mesh.material, is_masked, mesh, skin: instance.skin }
    }
}

impl PartialEq for Kept {
    fn eq(&self, other: &Self) -> bool {
        // A mesh that was made anew, such as a ground, may be the same.
        let same_mesh = Arc::ptr_eq(&self.mesh, &other.mesh) || self.mesh == other.mesh;
        let rest = |kept: &Self| (kept.material, kept.is_masked, kept.skin);
        same_mesh && rest(self) == rest(other)
    }
}

/// What is worked out of a mesh once, whatever scenes it is part of.
pub(crate) struct MeshDetail {
    /// Keeps the address that it is known by from being used for another.
    _mesh: Arc<Mesh>,
    parts: Vec<MeshPart>,
    /// For shadow maps, where the mesh is one part.
    simpler: Vec<SimplerTriangles>,
}

impl MeshDetail {
    fn new(mesh: &Arc<Mesh>) -> Self {
        let parts = mesh.parts();
        let simpler = if parts.len() == 1 { mesh.simplifications() } else { Vec::new() };
        Self { _mesh: Arc::clone(mesh), parts, simpler }
    }
}

/// Details by the address of their mesh.
pub(crate) type MeshDetails = HashMap<usize, Arc<MeshDetail>>;

fn address(mesh: &Arc<Mesh>) -> usize {
    Arc::as_ptr(mesh) as usize
}

/// Details of the rigid meshes among those placed; of meshes that were there before, those that are `known`.
fn details(scene: &Scene, placed: &[Instance], known: &MeshDetails) -> MeshDetails {
    let rigid = placed.iter().filter(|instance| !scene.is_deformable(instance));
    let meshes: HashMap<usize, &Arc<Mesh>> =
        rigid.map(|instance| &scene.meshes[instance.mesh.0]).map(|mesh| (address(mesh), mesh)).collect();
    let detail = |(address, mesh): (usize, &Arc<Mesh>)| {
        let detail = known.get(&address).cloned();
        (address, detail.unwrap_or_else(|| Arc::new(MeshDetail::new(mesh))))
    };
    meshes.into_par_iter().map(detail).collect()
}

/// No box reaches farther [m]: squares of coordinates stay finite.
const FARTHEST: f32 = 1e15;

impl Geometry {
    /// The geometry of a scene. What `before` worked out of meshes that both scenes share is not worked out again.
    pub fn new(
        gpu: &Gpu,
        transform: &TransformPass,
        scene: &Scene,
        before: Option<&Self>,
    ) -> Result<Self, RenderError> {
        let placed = by_material(scene);
        let total: usize = placed.iter().map(|i| scene.meshes[i.mesh.0].positions.len()).sum();
        let limits = gpu.device.limits();
        let vertex_bytes = layout::size::<layout::MeshVertex>();
        let largest = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        let over = |what, wanted: u64, limit: u64| RenderError::OverLimit {
            what,
            wanted,
            limit,
            adapter: gpu.adapter().name.clone(),
        };
        if total as u64 > (largest / vertex_bytes).min(u64::from(u32::MAX)) {
            return Err(over("vertices", total as u64, largest / vertex_bytes));
        }
        let triangles: u64 = placed.iter().map(|i| scene.meshes[i.mesh.0].triangles.len() as u64).sum();
        let most_triangles = (limits.max_buffer_size / 12).min(u64::from(u32::MAX) / 3);
        if triangles > most_triangles {
            return Err(over("triangles", triangles, most_triangles));
        }

        let mut vertices = Vec::with_capacity(total);
        let mut attributes = Vec::with_capacity(total);
        let mut indices: Vec<u32> = Vec::with_capacity(3 * triangles as usize);
        let mut ranges: Vec<DrawRange> = Vec::new();
        let mut boxes = Vec::with_capacity(placed.len());
        let none = MeshDetails::new();
        let details = details(scene, &placed, before.map_or(&none, |before| &before.details));
        // Boxes with simpler triangles, which follow once all that is drawn whole has its indices.
        let mut simpler: Vec<(usize, &[SimplerTriangles], u32)> = Vec::new();
        let mut records = Records::new();
        let mut deformable = Vec::new();
        for (instance, placement) in placed.iter().enumerate() {
            let mesh = &scene.meshes[placement.mesh.0];
            let most_words = largest / 4;
            let vertex_records = records.of(placement.mesh, mesh).unwrap_or_default().to_vec();
            if records.words.len() as u64 > most_words.min(u64::from(u32::MAX)) {
                return Err(over(
                    "words of joints and morph targets",
                    records.words.len() as u64,
                    most_words,
                ));
            }
            let first_vertex = vertices.len() as u32;
            let first_index = indices.len() as u32;
            for (i, position) in mesh.positions.iter().enumerate() {
                let tangent = mesh.tangents.get(i).copied().unwrap_or_default();
                let uv = |set: usize| mesh.uvs[set].get(i).copied().unwrap_or_default();
                vertices.push(layout::MeshVertex {
                    position: *position,
                    instance: instance as u32,
                    normal: mesh.normals.get(i).copied().unwrap_or_default(),
                    tangent_sign: tangent.w,
                    tangent: tangent.truncate(),
                    record: vertex_records.get(i).copied().unwrap_or(0),
                });
                attributes.push(StaticAttributes {
                    uvs: [uv(0).x, uv(0).y, uv(1).x, uv(1).y],
                    color: mesh.colors.get(i).map_or([1.0; 4], |color| color.to_array()),
                });
            }
            indices.extend(mesh.triangles.iter().flatten().map(|index| first_vertex + index));
            let end = indices.len() as u32;
            let material = mesh.material.map(|material| material.0);
            let is_masked = is_masked(scene, mesh);
            match ranges.last_mut() {
                Some(range) if range.material == material => range.indices.end = end,
                _ => ranges.push(DrawRange { material, is_masked, indices: first_index..end }),
            }
            let world_from_mesh = placement.world_from_mesh;
            let new_box = |bounds, indices| InstanceBox {
                bounds,
                indices,
                simpler: Vec::new(),
                instance,
                world_from_mesh,
            };
            if scene.is_deformable(placement) {
                // Its place is known once the pose is.
                if !mesh.triangles.is_empty() {
                    deformable.push((boxes.len(), DeformableBoxes::new(mesh, placement.skin.is_some())));
                    boxes.push(new_box(Bounds { min: Vec3::ZERO, max: Vec3::ZERO }, None));
                }
            } else if let Some(detail) = details.get(&address(mesh)) {
                if !is_masked {
                    simpler.push((boxes.len(), &detail.simpler, first_vertex));
                }
                let index = |triangle: usize| first_index + 3 * triangle as u32;
                boxes.extend(detail.parts.iter().map(|part| {
                    let is_alone = part.triangles.len() == part.count;
                    let indices = is_alone.then(|| index(part.triangles.start)..index(part.triangles.end));
                    new_box(part.bounds, indices)
                }));
            }
        }
        let index_count = indices.len() as u32;
        // Level after level, so that instances drawn at the same one lie side by side.
        let levels = simpler.iter().map(|(_, simplifications, _)| simplifications.len()).max().unwrap_or(0);
        for level in 0..levels {
            for (place, simplifications, first_vertex) in &simpler {
                let (Some(level), Some(place)) = (simplifications.get(level), boxes.get_mut(*place)) else {
                    continue;
                };
                // Where there is no room for them, meshes are drawn whole.
                if (indices.len() / 3 + level.triangles.len()) as u64 <= most_triangles {
                    let start = indices.len() as u32;
                    indices.extend(level.triangles.iter().flatten().map(|index| first_vertex + index));
                    let range = start..indices.len() as u32;
                    place.simpler.push(SimplerIndices { deviation: level.deviation, indices: range });
                }
            }
        }

        let pose = scene.pose();
        let data = PoseData::new(scene, &pose, &placed);
        let joint_bytes = size_of_val(data.joints.as_slice()) as u64;
        if joint_bytes > largest {
            return Err(over("joints", data.joints.len() as u64, largest / 64));
        }
        if data.weights.len() as u64 > largest / 4 {
            return Err(over("morph weights", data.weights.len() as u64, largest / 4));
        }

        let storage = wgpu::BufferUsages::STORAGE;
        let mesh_vertices = gpu.shared_buffer("mesh vertices", vertices.as_slice(), storage);
        let instances = gpu.shared_buffer("instances", data.instances.as_slice(), storage);
        let joints = gpu.buffer_with("joints", bytemuck::cast_slice(&data.joints), storage);
        let weights = gpu.buffer_with("morph weights", bytemuck::cast_slice(&data.weights), storage);
        let records = gpu.buffer_with("deformation records", bytemuck::cast_slice(&records.words), storage);
        let vertex = wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_SRC;
        let world = |label| gpu.empty_buffer(label, 16 * total as u64, storage | vertex);
        let (positions_world, normals_world, tangents_world) =
            (world("positions_world"), world("normals_world"), world("tangents_world"));
        let bind_group = gpu.bind_group(
            "transform",
            &transform.layout,
            &[
                (0, mesh_vertices.as_entire_binding()),
                (1, instances.as_entire_binding()),
                (2, positions_world.as_entire_binding()),
                (3, normals_world.as_entire_binding()),
                (4, tangents_world.as_entire_binding()),
                (5, records.as_entire_binding()),
                (6, joints.as_entire_binding()),
                (7, weights.as_entire_binding()),
            ],
        );
        let mut geometry = Self {
            positions_world,
            normals_world,
            tangents_world,
            static_attributes: gpu.buffer_with(
                "static attributes",
                bytemuck::cast_slice(&attributes),
                wgpu::BufferUsages::VERTEX,
            ),
            indices: gpu.buffer_with("indices", bytemuck::cast_slice(&indices), wgpu::BufferUsages::INDEX),
            ranges,
            index_count,
            boxes,
            placed_boxes: PlacedBoxes::default(),
            vertex_count: total as u32,
            instances,
            joints,
            joint_count: data.joints.len(),
            weights,
            placed: placed.iter().map(|instance| Kept::new(scene, instance)).collect(),
            details,
            deformable,
            bind_group,
        };
        geometry.move_boxes(scene, &pose, &placed)?;
        Ok(geometry)
    }

    /// Parts of `indices` that are drawn with holes, each with its range's material, and those that are drawn whole.
    pub fn split_masked(&self, indices: &[Range<u32>]) -> (Vec<DrawRange>, Vec<Range<u32>>) {
        let (mut masked, mut whole) = (Vec::new(), Vec::new());
        for indices in indices {
            let mut start = indices.start;
            for range in self.ranges.iter().filter(|range| range.is_masked) {
                let part = range.indices.start.max(start)..range.indices.end.min(indices.end);
                if part.is_empty() {
                    continue;
                }
                whole.push(start..part.start);
                start = part.end;
                masked.push(DrawRange { indices: part, ..*range });
            }
            whole.push(start..indices.end);
        }
        whole.retain(|range| !range.is_empty());
        (masked, whole)
    }

    /// Whether the scene places the same meshes, each with the material and skin that it had.
    pub fn is_of(&self, scene: &Scene) -> bool {
        self.holds(scene, &by_material(scene))
    }

    fn holds(&self, scene: &Scene, placed: &[Instance]) -> bool {
        placed.len() == self.placed.len()
            && placed.iter().zip(&self.placed).all(|(instance, kept)| Kept::new(scene, instance) == *kept)
    }

    /// Takes over a new pose of the same scene, for the next frame; `false` where it is another scene. Boxes follow.
    pub fn take_pose(&mut self, gpu: &Gpu, scene: &Scene) -> Result<bool, RenderError> {
        let placed = by_material(scene);
        let pose = scene.pose();
        let data = PoseData::new(scene, &pose, &placed);
        if !self.holds(scene, &placed) || data.joints.len() != self.joint_count {
            return Ok(false);
        }
        self.move_boxes(scene, &pose, &placed)?;
        gpu.write(&self.instances, data.instances.as_slice());
        gpu.queue.write_buffer(&self.joints, 0, bytemuck::cast_slice(&data.joints));
        gpu.queue.write_buffer(&self.weights, 0, bytemuck::cast_slice(&data.weights));
        Ok(true)
    }

    /// Brings the boxes to where the pose has them.
    fn move_boxes(&mut self, scene: &Scene, pose: &Pose, placed: &[Instance]) -> Result<(), RenderError> {
        let mut boxes = self.boxes.clone();
        for place in &mut boxes {
            place.world_from_mesh = placed[place.instance].world_from_mesh;
        }
        for (index, deformable) in &self.deformable {
            let Some(place) = boxes.get_mut(*index) else { continue };
            let instance = &placed[place.instance];
            let joints = instance.skin.map(|skin| pose.world_from_bind[skin.0].as_slice());
            let around = deformable.around(scene.morph_weights(instance), joints, instance.world_from_mesh);
            if let Some(((min, max), world_from_mesh)) = around {
                let bounds = Bounds { min, max };
                *place = InstanceBox {
                    bounds,
                    indices: None,
                    simpler: Vec::new(),
                    instance: place.instance,
                    world_from_mesh,
                };
            }
        }
        let placed_boxes = PlacedBoxes::new(&boxes);
        // False for NaN.
        let near = |corner: Vec3| corner.abs().max_element() <= FARTHEST && corner.is_finite();
        // Boxes do not tell: a minimum skips what is no number.
        let finite = pose.world_from_nodes.iter().all(Affine3A::is_finite);
        if finite && placed_boxes.corners().all(near) {
            (self.boxes, self.placed_boxes) = (boxes, placed_boxes);
            Ok(())
        } else {
            Err(RenderError::OutOfRange {
                what: "the distance of a vertex from the origin",
                range: format!("at most {FARTHEST:.0e} m"),
                value: "more".to_owned(),
            })
        }
    }

    /// Around all boxes; `None` without geometry.
    pub fn bounds(&self) -> Option<Bounds> {
        Bounds::around(self.placed_boxes.corners())
    }
}

/// Every placed mesh. One draw a material: instances of the same material lie side by side.
pub(crate) fn by_material(scene: &Scene) -> Vec<Instance> {
    let mut placed = scene.instances();
    placed.sort_by_key(|instance| scene.meshes[instance.mesh.0].material.map(|material| material.0));
    placed
}

/// Brings every vertex to world space, every frame.
pub(crate) struct TransformPass {
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::ComputePipeline,
}

impl TransformPass {
    pub fn new(gpu: &Gpu) -> Result<Self, RenderError> {
        let read = Binding::Storage { read_only: true };
        let write = Binding::Storage { read_only: false };
        let bindings = gpu.layout(
            "transform",
            wgpu::ShaderStages::COMPUTE,
            &[(0, read), (1, read), (2, write), (3, write), (4, write), (5, read), (6, read), (7, read)],
        );
        let pipeline = gpu.compute_pipeline(
            &gpu.shader("transform", &[])?,
            "transform",
            &[(layout::GROUP_PASS, &bindings)],
        );
        Ok(Self { layout: bindings, pipeline })
    }

    pub fn encode(&self, recorder: &mut Recorder<'_>, geometry: &Geometry) {
        let groups = geometry.vertex_count.div_ceil(layout::VERTEX_WORKGROUP);
        if groups == 0 {
            return;
        }
        let x = groups.min(1024);
        let mut pass = recorder.encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(layout::GROUP_PASS, &geometry.bind_group, &[]);
        pass.dispatch_workgroups(x, groups.div_ceil(x), 1);
    }
}
