use glam::{Affine3A, Mat4};
use gnomon_scene::{MaterialId, MeshId, Scene, normal_matrix};
use gnomon_shaders::layout;

use crate::bindings::Binding;
use crate::bounds::{InstanceBox, mesh_boxes};
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
    pub indices: std::ops::Range<u32>,
}

/// The scene's triangles on the GPU: as they lie in their meshes, and in world space after the frame's first pass.
///
/// Every instance has its own vertices, so one draw call holds the whole scene and a deformed instance is its own.
pub(crate) struct Geometry {
    pub positions_world: wgpu::Buffer,
    pub normals_world: wgpu::Buffer,
    pub tangents_world: wgpu::Buffer,
    pub static_attributes: wgpu::Buffer,
    pub indices: wgpu::Buffer,
    pub ranges: Vec<DrawRange>,
    pub index_count: u32,
    pub boxes: Vec<InstanceBox>,
    vertex_count: u32,
    instances: wgpu::Buffer,
    /// Mesh and material of every instance.
    placed: Vec<(MeshId, Option<MaterialId>)>,
    bind_group: wgpu::BindGroup,
}

impl Geometry {
    pub fn new(gpu: &Gpu, transform: &TransformPass, scene: &Scene) -> Result<Self, RenderError> {
        let placed = by_material(scene);
        let total: usize = placed.iter().map(|(mesh, _)| scene.meshes[mesh.0].positions.len()).sum();
        let limits = gpu.device.limits();
        let vertex_bytes = size_of::<layout::MeshVertex>() as u64;
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
        let triangles: u64 = placed.iter().map(|(mesh, _)| scene.meshes[mesh.0].triangles.len() as u64).sum();
        let most_triangles = (limits.max_buffer_size / 12).min(u64::from(u32::MAX) / 3);
        if triangles > most_triangles {
            return Err(over("triangles", triangles, most_triangles));
        }

        let mut vertices = Vec::with_capacity(total);
        let mut attributes = Vec::with_capacity(total);
        let mut indices: Vec<u32> = Vec::with_capacity(3 * triangles as usize);
        let mut ranges: Vec<DrawRange> = Vec::new();
        let mut boxes = Vec::with_capacity(placed.len());
        for (instance, (id, world_from_mesh)) in placed.iter().enumerate() {
            let mesh = &scene.meshes[id.0];
            let first_vertex = vertices.len() as u32;
            let first_index = indices.len() as u32;
            for (i, position) in mesh.positions.iter().enumerate() {
                let tangent = mesh.tangents.get(i).copied().unwrap_or_default();
                let uv = |set: usize| mesh.uvs[set].get(i).copied().unwrap_or_default();
                vertices.push(layout::MeshVertex {
                    position: position.to_array(),
                    instance: instance as u32,
                    normal: mesh.normals.get(i).copied().unwrap_or_default().to_array(),
                    tangent_sign: tangent.w,
                    tangent: tangent.truncate().to_array(),
                    padding: 0.0,
                });
                attributes.push(StaticAttributes {
                    uvs: [uv(0).x, uv(0).y, uv(1).x, uv(1).y],
                    color: mesh.colors.get(i).map_or([1.0; 4], |color| color.to_array()),
                });
            }
            indices.extend(mesh.triangles.iter().flatten().map(|index| first_vertex + index));
            let end = indices.len() as u32;
            let material = mesh.material.map(|material| material.0);
            match ranges.last_mut() {
                Some(range) if range.material == material => range.indices.end = end,
                _ => ranges.push(DrawRange { material, indices: first_index..end }),
            }
            let world_from_mesh = *world_from_mesh;
            boxes.extend(mesh_boxes(mesh).into_iter().map(|(min, max)| InstanceBox {
                min,
                max,
                instance,
                world_from_mesh,
            }));
        }

        let storage = wgpu::BufferUsages::STORAGE;
        let mesh_vertices = gpu.buffer_with("mesh vertices", bytemuck::cast_slice(&vertices), storage);
        let instances =
            gpu.buffer_with("instances", &instance_bytes(placed.iter().map(|(_, w)| *w)), storage);
        let world = |label| gpu.empty_buffer(label, 16 * total as u64, storage | wgpu::BufferUsages::VERTEX);
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
            ],
        );
        Ok(Self {
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
            index_count: indices.len() as u32,
            boxes,
            vertex_count: total as u32,
            instances,
            placed: placed.iter().map(|(mesh, _)| (*mesh, scene.meshes[mesh.0].material)).collect(),
            bind_group,
        })
    }

    /// Whether these are the instances of the scene's that were uploaded, each with the material it had.
    fn is_of(&self, scene: &Scene, placed: &[(MeshId, Affine3A)]) -> bool {
        let now = placed.iter().map(|(mesh, _)| (*mesh, scene.meshes[mesh.0].material));
        now.eq(self.placed.iter().copied())
    }

    /// Whether the scene places the same meshes, each with the material that it had.
    pub fn has_materials_of(&self, scene: &Scene) -> bool {
        self.is_of(scene, &by_material(scene))
    }

    /// Takes over new placements of the same scene, for the next frame. Boxes follow.
    pub fn move_instances(&mut self, gpu: &Gpu, scene: &Scene) -> bool {
        let placed = by_material(scene);
        if !self.is_of(scene, &placed) {
            return false;
        }
        gpu.queue.write_buffer(&self.instances, 0, &instance_bytes(placed.iter().map(|(_, w)| *w)));
        for place in &mut self.boxes {
            place.world_from_mesh = placed[place.instance].1;
        }
        true
    }
}

/// Every placed mesh. One draw a material: instances of the same material lie side by side.
fn by_material(scene: &Scene) -> Vec<(MeshId, Affine3A)> {
    let mut placed = scene.instances();
    placed.sort_by_key(|(mesh, _)| scene.meshes[mesh.0].material.map(|material| material.0));
    placed
}

fn instance_bytes(placements: impl Iterator<Item = Affine3A>) -> Vec<u8> {
    let instances: Vec<layout::Instance> = placements
        .map(|world_from_mesh| layout::Instance {
            world_from_mesh: Mat4::from(world_from_mesh).to_cols_array_2d(),
            normal_from_mesh: Mat4::from_mat3(normal_matrix(&world_from_mesh)).to_cols_array_2d(),
        })
        .collect();
    bytemuck::cast_slice(&instances).to_vec()
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
        let layout = gpu.layout(
            "transform",
            wgpu::ShaderStages::COMPUTE,
            &[(0, read), (1, read), (2, write), (3, write), (4, write)],
        );
        let pipeline = gpu.compute_pipeline(&gpu.shader("transform", &[])?, "transform", &[Some(&layout)]);
        Ok(Self { layout, pipeline })
    }

    pub fn encode(&self, recorder: &mut Recorder<'_>, geometry: &Geometry) {
        let groups = geometry.vertex_count.div_ceil(64);
        if groups == 0 {
            return;
        }
        let x = groups.min(1024);
        let mut pass = recorder.encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &geometry.bind_group, &[]);
        pass.dispatch_workgroups(x, groups.div_ceil(x), 1);
    }
}
