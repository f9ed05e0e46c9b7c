use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

use glam::{Affine3A, Vec3};
use gnomon_scene::{
    AlphaMode, Bounds, Instance, MaterialId, Mesh, NodeId, Pose, Scene, SimplerTriangles, SkinId, Texture,
    TextureRef,
};

use crate::casters::{InstanceBox, PlacedBoxes, SimplerIndices};
use crate::deformation::{DeformableBoxes, PoseData};
use crate::ray_scene::Micromaps;
use crate::{Gpu, RenderError};

mod details;
mod store;
mod transform;
mod triangles;
mod vertices;

use details::{MeshDetails, details};
pub(crate) use transform::TransformPass;
use triangles::{IndexLayout, Run};
use vertices::{Slot, Vertices};

/// Indices drawn with one material.
pub(crate) struct DrawRange {
    /// Index into the scene's materials; `None` is the default material.
    pub material: Option<usize>,
    /// Whether light passes it, in places or in part.
    pub alpha_mode: AlphaMode,
    pub indices: Range<u32>,
}

impl DrawRange {
    /// Whether light passes it in part.
    pub fn is_blended(&self) -> bool {
        self.alpha_mode == AlphaMode::Blend
    }
}

fn alpha_mode(scene: &Scene, mesh: &Mesh) -> AlphaMode {
    let material = mesh.material.and_then(|material| scene.materials.get(material.0));
    material.map_or(AlphaMode::Opaque, |material| material.alpha_mode)
}

/// The scene's triangles on the GPU: as they lie in their meshes, and in world space after the frame's first pass.
///
/// Every instance has its own vertices, so one draw call can hold the whole scene and a deformed instance is its own.
pub(crate) struct Geometry {
    vertices: Vertices,
    pub indices: wgpu::Buffer,
    /// By instance.
    runs: Vec<Run>,
    /// By instance, the node that it hangs on.
    nodes: Vec<NodeId>,
    pub ranges: Vec<DrawRange>,
    /// Of all triangles as they are; what follows them are simpler ones.
    pub index_count: u32,
    /// Around what casts and receives shadows. Those of deformed instances are conservative.
    pub boxes: Vec<InstanceBox>,
    /// The same where the pose has them.
    pub placed_boxes: PlacedBoxes,
    instances: wgpu::Buffer,
    joints: wgpu::Buffer,
    joint_count: usize,
    weights: wgpu::Buffer,
    /// A pose that the next frame takes over.
    moved: Option<PoseData>,
    placed: Vec<Kept>,
    pub details: MeshDetails,
    /// Of each deformable instance, where its box is among `boxes`.
    deformable: Vec<(usize, DeformableBoxes)>,
    bind_group: wgpu::BindGroup,
}

/// Another pose of a geometry.
pub(crate) struct MovedGeometry {
    nodes: Vec<NodeId>,
    boxes: Vec<InstanceBox>,
    placed_boxes: PlacedBoxes,
    data: PoseData,
}

/// What of an instance a new pose keeps.
struct Kept {
    mesh: Arc<Mesh>,
    /// What people know it by.
    name: String,
    material: Option<MaterialId>,
    alpha: Option<Alpha>,
    catches: bool,
    skin: Option<SkinId>,
    /// Of a mesh with alpha.
    micromaps: Option<Arc<Micromaps>>,
}

/// What tells where light passes a surface, beside the mesh.
struct Alpha {
    mode: AlphaMode,
    factor: f32,
    texture: Option<(TextureRef, Arc<Texture>)>,
}

impl PartialEq for Alpha {
    fn eq(&self, other: &Self) -> bool {
        let same_texture = match (&self.texture, &other.texture) {
            (Some((place, texture)), Some((other_place, other))) => {
                place == other_place && (Arc::ptr_eq(texture, other) || texture == other)
            }
            (texture, other) => texture.is_none() && other.is_none(),
        };
        (self.mode, self.factor) == (other.mode, other.factor) && same_texture
    }
}

impl Alpha {
    fn of(scene: &Scene, mesh: &Mesh) -> Option<Self> {
        let material = scene.materials.get(mesh.material?.0)?;
        let texture =
            |texture: TextureRef| Some((texture, Arc::clone(scene.textures.get(texture.texture.0)?)));
        (material.alpha_mode != AlphaMode::Opaque).then(|| Self {
            mode: material.alpha_mode,
            factor: material.alpha,
            texture: material.base_color_texture.and_then(texture),
        })
    }
}

/// A mesh that is placed, as rays see it.
pub(crate) struct PlacedMesh<'a> {
    pub mesh: &'a Arc<Mesh>,
    pub name: &'a str,
    /// Place of its first vertex among the frame's.
    pub first_vertex: u32,
    /// Where it has alpha.
    pub micromaps: Option<&'a Micromaps>,
    pub casts: bool,
}

impl Kept {
    fn new(scene: &Scene, instance: &Instance) -> Self {
        let mesh = Arc::clone(&scene.meshes[instance.mesh.0]);
        let alpha = Alpha::of(scene, &mesh);
        let catches = scene.material(instance.mesh).catches;
        let name = match scene.nodes.get(instance.node.0).map(|node| node.name.as_str()) {
            None | Some("") => format!("mesh {}", instance.mesh.0),
            Some(node) => format!("mesh {} of {node}", instance.mesh.0),
        };
        Self { material: mesh.material, name, alpha, catches, mesh, skin: instance.skin, micromaps: None }
    }
}

impl PartialEq for Kept {
    fn eq(&self, other: &Self) -> bool {
        // A mesh that was made anew, such as a ground, may be the same.
        let same_mesh = Arc::ptr_eq(&self.mesh, &other.mesh) || self.mesh == other.mesh;
        let rest = |kept: &Self| (kept.material, kept.catches, kept.skin);
        same_mesh && rest(self) == rest(other) && self.alpha == other.alpha
    }
}

fn address(mesh: &Arc<Mesh>) -> usize {
    Arc::as_ptr(mesh) as usize
}

fn over(gpu: &Gpu, what: &'static str, wanted: u64, limit: u64) -> RenderError {
    RenderError::OverLimit { what, wanted, limit, adapter: gpu.adapter().name.clone() }
}

/// No box reaches farther [m]: squares of coordinates stay finite.
const FARTHEST: f32 = 1e15;

impl Geometry {
    /// The geometry of a scene. What `before` has of meshes that both scenes share, by their `Arc`, is neither worked out nor uploaded
    /// again; `before` stays as it is.
    pub fn new(
        gpu: &Gpu,
        transform: &TransformPass,
        scene: &Scene,
        before: Option<&Self>,
    ) -> Result<Self, RenderError> {
        let placed = by_material(scene);
        let triangles: u64 = placed.iter().map(|i| scene.meshes[i.mesh.0].triangles.len() as u64).sum();
        let most_triangles = (gpu.device.limits().max_buffer_size / 12).min(u64::from(u32::MAX) / 3);
        if triangles > most_triangles {
            return Err(over(gpu, "triangles", triangles, most_triangles));
        }
        let vertices = Vertices::new(gpu, scene, &placed, before.map(|before| &before.vertices))?;
        let run_before = |slot: &Slot| Some(&before?.runs[slot.before?]);

        let mut indices = IndexLayout::default();
        let mut runs = Vec::with_capacity(placed.len());
        let mut ranges: Vec<DrawRange> = Vec::new();
        let mut boxes = Vec::with_capacity(placed.len());
        let none = MeshDetails::new();
        let details = details(scene, &placed, before.map_or(&none, |before| &before.details));
        // Boxes with simpler triangles, which follow once all that is drawn whole has its indices.
        let mut simpler: Vec<(usize, &[SimplerTriangles], usize)> = Vec::new();
        let mut deformable = Vec::new();
        for (instance, (placement, slot)) in placed.iter().zip(&vertices.slots).enumerate() {
            let mesh = &scene.meshes[placement.mesh.0];
            let known = run_before(slot).map(|run| &run.whole);
            let whole = indices.push(&mesh.triangles, slot.first_vertex, known);
            runs.push(Run { whole: whole.clone(), simpler: Vec::new() });
            let material = mesh.material.map(|material| material.0);
            let alpha_mode = alpha_mode(scene, mesh);
            match ranges.last_mut() {
                Some(range) if range.material == material => range.indices.end = whole.end,
                _ => ranges.push(DrawRange { material, alpha_mode, indices: whole.clone() }),
            }
            let world_from_mesh = placement.world_from_mesh;
            let new_box = |bounds, indices| InstanceBox {
                bounds,
                indices,
                simpler: Vec::new(),
                instance,
                world_from_mesh,
                casts: !scene.material(placement.mesh).catches,
            };
            if scene.is_deformable(placement) {
                // Its place is known once the pose is.
                if !mesh.triangles.is_empty() {
                    deformable.push((boxes.len(), DeformableBoxes::new(mesh, placement.skin.is_some())));
                    boxes.push(new_box(Bounds { min: Vec3::ZERO, max: Vec3::ZERO }, None));
                }
            } else if let Some(detail) = details.get(&address(mesh)) {
                if scene.material(placement.mesh).catches {
                    // It is left out of maps as a whole.
                    let around = detail.parts.iter().map(|part| part.bounds).reduce(Bounds::union);
                    boxes.extend(around.map(|bounds| new_box(bounds, Some(whole.clone()))));
                    continue;
                }
                if alpha_mode == AlphaMode::Opaque {
                    simpler.push((boxes.len(), &detail.simpler, instance));
                }
                let index = |triangle: usize| whole.start + 3 * triangle as u32;
                boxes.extend(detail.parts.iter().map(|part| {
                    let is_alone = part.triangles.len() == part.count;
                    let indices = is_alone.then(|| index(part.triangles.start)..index(part.triangles.end));
                    new_box(part.bounds, indices)
                }));
            }
        }
        let index_count = indices.count;
        // Level after level, so that instances drawn at the same one lie side by side.
        let levels = simpler.iter().map(|(_, simplifications, _)| simplifications.len()).max().unwrap_or(0);
        for number in 0..levels {
            for &(place, simplifications, instance) in &simpler {
                let (Some(level), Some(place)) = (simplifications.get(number), boxes.get_mut(place)) else {
                    continue;
                };
                // Where there is no room for them, meshes are drawn whole.
                if u64::from(indices.count / 3) + level.triangles.len() as u64 <= most_triangles {
                    let slot = &vertices.slots[instance];
                    let known = run_before(slot).and_then(|run| run.simpler.get(number));
                    let range = indices.push(&level.triangles, slot.first_vertex, known);
                    runs[instance].simpler.push(range.clone());
                    place.simpler.push(SimplerIndices { deviation: level.deviation, indices: range });
                }
            }
        }

        let pose = scene.pose();
        let numbers: Vec<u32> = vertices.slots.iter().map(|slot| slot.instance).collect();
        let data = PoseData::new(scene, &pose, &placed, &numbers);
        let largest = gpu.largest_storage();
        if size_of_val(data.joints.as_slice()) as u64 > largest {
            return Err(over(gpu, "joints", data.joints.len() as u64, largest / 64));
        }
        if data.weights.len() as u64 > largest / 4 {
            return Err(over(gpu, "morph weights", data.weights.len() as u64, largest / 4));
        }

        let storage = wgpu::BufferUsages::STORAGE;
        let instances = gpu.shared_buffer("instances", data.instances.as_slice(), storage);
        let joints = gpu.buffer_with("joints", bytemuck::cast_slice(&data.joints), storage);
        let weights = gpu.buffer_with("morph weights", bytemuck::cast_slice(&data.weights), storage);
        let [positions_world, normals_world, tangents_world] = &vertices.world;
        let bind_group = gpu.bind_group(
            "transform",
            &transform.layout,
            &[
                (0, vertices.mesh.buffer.as_entire_binding()),
                (1, instances.as_entire_binding()),
                (2, positions_world.as_entire_binding()),
                (3, normals_world.as_entire_binding()),
                (4, tangents_world.as_entire_binding()),
                (5, vertices.records.buffer.as_entire_binding()),
                (6, joints.as_entire_binding()),
                (7, weights.as_entire_binding()),
            ],
        );
        let mut geometry = Self {
            vertices,
            indices: indices.buffer(gpu, before.map(|before| &before.indices)),
            runs,
            nodes: nodes(&placed),
            ranges,
            index_count,
            boxes,
            placed_boxes: PlacedBoxes::default(),
            instances,
            joints,
            joint_count: joint_count(scene),
            weights,
            moved: None,
            placed: kept(scene, &placed),
            details,
            deformable,
            bind_group,
        };
        (geometry.boxes, geometry.placed_boxes) = geometry.moved_boxes(scene, &pose, &placed)?;
        Ok(geometry)
    }

    /// Positions in world space, normals, tangents; and attributes that no animation changes.
    pub fn vertex_buffers(&self) -> [&wgpu::Buffer; 4] {
        let [positions, normals, tangents] = &self.vertices.world;
        [positions, normals, tangents, &self.vertices.attributes.buffer]
    }

    /// Each instance by itself: its node, the number of its material in the scene, its indices.
    pub fn instances(&self) -> impl Iterator<Item = (NodeId, Option<usize>, Range<u32>)> {
        let placed = self.nodes.iter().zip(&self.placed).zip(&self.runs);
        placed.map(|((&node, kept), run)| (node, kept.material.map(|material| material.0), run.whole.clone()))
    }

    /// The instances, in the order of [`crate::casters::PlacedBox::instance`].
    pub fn placed_meshes(&self) -> impl Iterator<Item = PlacedMesh<'_>> {
        self.placed.iter().zip(&self.vertices.slots).map(|(kept, slot)| PlacedMesh {
            mesh: &kept.mesh,
            name: &kept.name,
            first_vertex: slot.first_vertex,
            micromaps: kept.micromaps.as_deref(),
            casts: !kept.catches,
        })
    }

    /// Most surfaces behind one another of those that light passes in part: the number of their triangles.
    pub fn most_layers(&self) -> u32 {
        let blended = self.ranges.iter().filter(|range| range.is_blended());
        blended.map(|range| range.indices.len() as u32 / 3).sum()
    }

    /// Parts of `indices` that light passes, each with its range's material, and those that are drawn whole.
    pub fn split_masked(&self, indices: &[Range<u32>]) -> (Vec<DrawRange>, Vec<Range<u32>>) {
        let (mut masked, mut whole) = (Vec::new(), Vec::new());
        for indices in indices {
            let mut start = indices.start;
            for range in self.ranges.iter().filter(|range| range.alpha_mode != AlphaMode::Opaque) {
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

    /// The scene's instances, where it places the same meshes, each with the material and skin that it had.
    pub fn placed_by(&self, scene: &Scene) -> Option<Vec<Instance>> {
        let placed = by_material(scene);
        let is_same = placed.len() == self.placed.len()
            && joint_count(scene) == self.joint_count
            && placed.iter().zip(&self.placed).all(|(instance, kept)| Kept::new(scene, instance) == *kept);
        is_same.then_some(placed)
    }

    /// A new pose of the same scene, whose instances are `placed`.
    pub fn moved(&self, scene: &Scene, placed: &[Instance]) -> Result<MovedGeometry, RenderError> {
        let pose = scene.pose();
        let (boxes, placed_boxes) = self.moved_boxes(scene, &pose, placed)?;
        let numbers: Vec<u32> = self.vertices.slots.iter().map(|slot| slot.instance).collect();
        let data = PoseData::new(scene, &pose, placed, &numbers);
        Ok(MovedGeometry { nodes: nodes(placed), boxes, placed_boxes, data })
    }

    /// Takes such a pose over, for the next frame.
    pub fn take(&mut self, moved: MovedGeometry) {
        let MovedGeometry { nodes, boxes, placed_boxes, data } = moved;
        (self.boxes, self.placed_boxes, self.moved) = (boxes, placed_boxes, Some(data));
        self.nodes = nodes;
    }

    /// Brings to the GPU what has moved.
    pub fn upload(&mut self, gpu: &Gpu) {
        if let Some(PoseData { instances, joints, weights }) = self.moved.take() {
            gpu.write(&self.instances, instances.as_slice());
            gpu.write_bytes(&self.joints, 0, bytemuck::cast_slice(&joints));
            gpu.write_bytes(&self.weights, 0, bytemuck::cast_slice(&weights));
        }
    }

    /// The boxes where the pose has them.
    fn moved_boxes(
        &self,
        scene: &Scene,
        pose: &Pose,
        placed: &[Instance],
    ) -> Result<(Vec<InstanceBox>, PlacedBoxes), RenderError> {
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
                (place.bounds, place.world_from_mesh) = (bounds, world_from_mesh);
            }
        }
        let placed_boxes = PlacedBoxes::new(&boxes);
        // False for NaN.
        let near = |corner: Vec3| corner.abs().max_element() <= FARTHEST && corner.is_finite();
        // Boxes do not tell: a minimum skips what is no number.
        let finite = pose.world_from_nodes.iter().all(Affine3A::is_finite);
        if finite && placed_boxes.corners().all(near) {
            Ok((boxes, placed_boxes))
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
        self.placed_boxes.around
    }
}

/// What of every instance stays, with the opacities that rays meet.
fn kept(scene: &Scene, placed: &[Instance]) -> Vec<Kept> {
    let mut micromaps: HashMap<usize, Arc<Micromaps>> = HashMap::new();
    let mut kept = |instance: &Instance| {
        let mut kept = Kept::new(scene, instance);
        if kept.alpha.is_some() {
            let made = || Arc::new(Micromaps::new(scene, instance.mesh));
            kept.micromaps = Some(micromaps.entry(address(&kept.mesh)).or_insert_with(made).clone());
        }
        kept
    };
    placed.iter().map(&mut kept).collect()
}

fn joint_count(scene: &Scene) -> usize {
    scene.skins.iter().map(|skin| skin.joint_from_bind.len()).sum()
}

fn nodes(placed: &[Instance]) -> Vec<NodeId> {
    placed.iter().map(|instance| instance.node).collect()
}

/// Every placed mesh. One draw a material: instances of the same material lie side by side.
pub(crate) fn by_material(scene: &Scene) -> Vec<Instance> {
    let mut placed = scene.instances();
    placed.sort_by_key(|instance| scene.meshes[instance.mesh.0].material.map(|material| material.0));
    placed
}

#[cfg(test)]
mod tests;
