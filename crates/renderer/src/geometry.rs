use std::collections::HashMap;
use std::num::NonZeroU64;
use std::ops::Range;
use std::sync::Arc;

use glam::{Affine3A, Vec3};
use gnomon_scene::{
    AlphaMode, Bounds, Instance, MaterialId, Mesh, NodeId, Pose, Scene, SimplerTriangles, SkinId, Texture,
    TextureRef,
};

use crate::casters::{Casters, DrawnCasters, InstanceBox, PlacedBoxes, SimplerIndices};
use crate::deformation::{DeformableBoxes, PoseData};
use crate::ray_scene::Micromaps;
use crate::{Gpu, RenderError};

mod details;
mod placements;
mod store;
mod transform;
mod triangles;
mod vertices;

use details::{MeshDetails, details};
use placements::check_count;
pub(crate) use placements::{Bodies, Draw, placements_layout};
pub(crate) use transform::TransformPass;
use triangles::{IndexLayout, Run};
use vertices::{Slot, Vertices, vertex_bytes};

/// Indices drawn with one material.
pub(crate) struct DrawRange {
    /// Index into the scene's materials; `None` is the default material.
    pub material: Option<usize>,
    /// Whether light passes it, in places or in part.
    pub alpha_mode: AlphaMode,
    pub indices: Range<u32>,
    /// Where they are drawn.
    pub placements: Range<u32>,
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
/// What deforms and what is placed once has vertices of its own, so that one draw call can hold all of it; copies of a large rigid mesh share
/// its vertices, which the first pass leaves where they are, and are instances of one draw.
pub(crate) struct Geometry {
    vertices: Vertices,
    pub indices: wgpu::Buffer,
    /// By body.
    runs: Vec<Run>,
    /// By body, which instances it is.
    bodies: Vec<Range<usize>>,
    /// Number of instances that are a body each.
    own: usize,
    /// By instance, the node that it hangs on.
    nodes: Vec<NodeId>,
    /// By instance, where it is.
    world_from_meshes: Vec<Affine3A>,
    pub ranges: Vec<DrawRange>,
    /// Of all bodies' triangles as they are; what follows them are simpler ones.
    pub index_count: u32,
    /// Of those in world space, which come first.
    own_index_count: u32,
    /// Transforms to world space from where vertices are drawn.
    placements: wgpu::Buffer,
    placements_group: wgpu::BindGroup,
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
    /// Of the pass that moves them, for parts of the vertices, each with their number.
    windows: Vec<(wgpu::BindGroup, u32)>,
}

/// Another pose of a geometry.
pub(crate) struct MovedGeometry {
    nodes: Vec<NodeId>,
    world_from_meshes: Vec<Affine3A>,
    boxes: Vec<InstanceBox>,
    placed_boxes: PlacedBoxes,
    data: PoseData,
}

impl MovedGeometry {
    pub fn placed_boxes(&self) -> &PlacedBoxes {
        &self.placed_boxes
    }
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
    /// What has its vertices, which may have those of copies as well.
    pub body: usize,
    /// Where those are drawn, 0 in world space.
    pub placement: u32,
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
        let bodies = Bodies::of(scene);
        check_count(gpu, &bodies, scene.materials.len())?;
        let firsts = bodies.firsts();
        let triangles: u64 = firsts.iter().map(|i| scene.meshes[i.mesh.0].triangles.len() as u64).sum();
        let most_triangles = (gpu.device.limits().max_buffer_size / 12).min(u64::from(u32::MAX) / 3);
        if triangles > most_triangles {
            return Err(over(gpu, "triangles", triangles, most_triangles));
        }
        let vertices = Vertices::new(gpu, scene, &firsts, before.map(|before| &before.vertices))?;
        let run_before = |slot: &Slot| Some(&before?.runs[slot.before?]);

        let mut indices = IndexLayout::default();
        let mut runs = Vec::with_capacity(firsts.len());
        let mut ranges: Vec<DrawRange> = Vec::new();
        let mut boxes = Vec::with_capacity(bodies.placed.len());
        let none = MeshDetails::new();
        let details = details(scene, &firsts, before.map_or(&none, |before| &before.details));
        // Boxes with simpler triangles, which follow once all that is drawn whole has its indices.
        let mut simpler: Vec<(Range<usize>, &[SimplerTriangles], usize)> = Vec::new();
        let mut deformable = Vec::new();
        let mut own_index_count = 0;
        for (body, (range, slot)) in bodies.ranges.iter().zip(&vertices.slots).enumerate() {
            let placement = &bodies.placed[range.start];
            let mesh = &scene.meshes[placement.mesh.0];
            let is_own = range.start < bodies.own;
            let known = run_before(slot).map(|run| &run.whole);
            let whole = indices.push(&mesh.triangles, slot.first_vertex, known);
            runs.push(Run { whole: whole.clone(), simpler: Vec::new() });
            let material = mesh.material.map(|material| material.0);
            let alpha_mode = alpha_mode(scene, mesh);
            let placements = bodies.placement(range.start)..bodies.placement(range.end - 1) + 1;
            match ranges.last_mut() {
                Some(range) if is_own && range.material == material => range.indices.end = whole.end,
                _ => ranges.push(DrawRange { material, alpha_mode, indices: whole.clone(), placements }),
            }
            own_index_count = if is_own { whole.end } else { own_index_count };
            let new_box = |instance: usize, bounds, indices| InstanceBox {
                bounds,
                indices,
                simpler: Vec::new(),
                instance,
                placement: bodies.placement(instance),
                world_from_mesh: bodies.placed[instance].world_from_mesh,
                casts: !scene.material(placement.mesh).catches,
            };
            if scene.is_deformable(placement) {
                // Its place is known once the pose is.
                if !mesh.triangles.is_empty() {
                    deformable.push((boxes.len(), DeformableBoxes::new(mesh, placement.skin.is_some())));
                    boxes.push(new_box(range.start, Bounds { min: Vec3::ZERO, max: Vec3::ZERO }, None));
                }
            } else if let Some(detail) = details.get(&address(mesh)) {
                let catches = scene.material(placement.mesh).catches;
                let first_box = boxes.len();
                if catches || !is_own {
                    // They are left out of maps, or drawn, as a whole.
                    if let Some(around) = detail.parts.iter().map(|part| part.bounds).reduce(Bounds::union) {
                        let new_box = |instance| new_box(instance, around, Some(whole.clone()));
                        boxes.extend(range.clone().map(new_box));
                    }
                } else {
                    let index = |triangle: usize| whole.start + 3 * triangle as u32;
                    boxes.extend(detail.parts.iter().map(|part| {
                        let is_alone = part.triangles.len() == part.count;
                        let indices =
                            is_alone.then(|| index(part.triangles.start)..index(part.triangles.end));
                        new_box(range.start, part.bounds, indices)
                    }));
                }
                if alpha_mode == AlphaMode::Opaque && !catches {
                    // Of meshes that are one part.
                    simpler.push((first_box..boxes.len(), &detail.simpler, body));
                }
            }
        }
        let index_count = indices.count;
        // Level after level, so that instances drawn at the same one lie side by side.
        let levels = simpler.iter().map(|(_, simplifications, _)| simplifications.len()).max().unwrap_or(0);
        for number in 0..levels {
            for (places, simplifications, body) in &simpler {
                let (Some(level), Some(places)) =
                    (simplifications.get(number), boxes.get_mut(places.clone()))
                else {
                    continue;
                };
                // Where there is no room for them, meshes are drawn whole.
                if u64::from(indices.count / 3) + level.triangles.len() as u64 <= most_triangles {
                    let slot = &vertices.slots[*body];
                    let known = run_before(slot).and_then(|run| run.simpler.get(number));
                    let range = indices.push(&level.triangles, slot.first_vertex, known);
                    runs[*body].simpler.push(range.clone());
                    let simpler = SimplerIndices { deviation: level.deviation, indices: range };
                    places.iter_mut().for_each(|place| place.simpler.push(simpler.clone()));
                }
            }
        }

        let pose = scene.pose();
        let numbers: Vec<u32> = vertices.slots.iter().map(|slot| slot.instance).collect();
        let data = PoseData::new(scene, &pose, &bodies, &numbers);
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
        let placements = gpu.buffer_with(
            "placements",
            bytemuck::cast_slice(&data.placements),
            storage | wgpu::BufferUsages::COPY_SRC,
        );
        let placements_group =
            gpu.bind_group("placements", &placements_layout(gpu), &[(0, placements.as_entire_binding())]);
        let window = |(first, count): (u32, u32)| {
            let part = |buffer, bytes_each: u64| {
                let size = NonZeroU64::new(bytes_each * u64::from(count));
                let offset = bytes_each * u64::from(first);
                wgpu::BindingResource::Buffer(wgpu::BufferBinding { buffer, offset, size })
            };
            let [positions_world, normals_world, tangents_world] = &vertices.world;
            let resources = [
                (0, part(&vertices.mesh.buffer, vertex_bytes())),
                (1, instances.as_entire_binding()),
                (2, part(positions_world, 16)),
                (3, part(normals_world, 16)),
                (4, part(tangents_world, 16)),
                (5, vertices.records.buffer.as_entire_binding()),
                (6, joints.as_entire_binding()),
                (7, weights.as_entire_binding()),
            ];
            (gpu.bind_group("transform", &transform.layout, &resources), count)
        };
        let windows = vertices.windows(gpu).map(window).collect();
        let mut geometry = Self {
            vertices,
            indices: indices.buffer(gpu, before.map(|before| &before.indices)),
            runs,
            nodes: nodes(&bodies.placed),
            world_from_meshes: world_from_meshes(&bodies.placed),
            ranges,
            index_count,
            own_index_count,
            placements,
            placements_group,
            boxes,
            placed_boxes: PlacedBoxes::default(),
            instances,
            joints,
            joint_count: joint_count(scene),
            weights,
            moved: None,
            placed: kept(scene, &bodies.placed),
            own: bodies.own,
            bodies: bodies.ranges,
            details,
            deformable,
            windows,
        };
        (geometry.boxes, geometry.placed_boxes) = geometry.moved_boxes(scene, &pose, &bodies.placed)?;
        Ok(geometry)
    }

    /// Positions in world space, normals, tangents; and attributes that no animation changes.
    pub fn vertex_buffers(&self) -> [&wgpu::Buffer; 4] {
        let [positions, normals, tangents] = &self.vertices.world;
        [positions, normals, tangents, &self.vertices.attributes.buffer]
    }

    /// Node and number of the material, in the scene, of every instance.
    pub fn instances(&self) -> impl Iterator<Item = (NodeId, Option<usize>)> {
        let material = |kept: &Kept| kept.material.map(|material| material.0);
        self.nodes.iter().zip(&self.placed).map(move |(&node, kept)| (node, material(kept)))
    }

    /// Every body by itself, with the number of its material in the scene, and a number which together with that of a placement is the place
    /// of what is drawn there among the instances, counted from 1.
    pub fn bodies(&self) -> impl Iterator<Item = (u32, Option<usize>, Draw)> {
        self.bodies.iter().zip(&self.runs).map(|(range, run)| {
            let placement = |place: usize| (place + 1).saturating_sub(self.own) as u32;
            let placements = placement(range.start)..placement(range.end - 1) + 1;
            let number = self.own.min(range.start + 1) as u32;
            let material = self.placed[range.start].material.map(|material| material.0);
            (number, material, Draw { indices: run.whole.clone(), placements })
        })
    }

    /// Where an instance is.
    pub fn world_from_mesh(&self, instance: usize) -> Affine3A {
        self.world_from_meshes.get(instance).copied().unwrap_or_default()
    }

    /// Of every instance its body, and its placement.
    fn body_of_instances(&self) -> impl Iterator<Item = (usize, u32)> {
        let bodies =
            self.bodies.iter().enumerate().flat_map(|(body, range)| range.clone().map(move |_| body));
        bodies.enumerate().map(|(place, body)| (body, (place + 1).saturating_sub(self.own) as u32))
    }

    /// The instances, in the order of [`crate::casters::PlacedBox::instance`].
    pub fn placed_meshes(&self) -> impl Iterator<Item = PlacedMesh<'_>> {
        self.placed.iter().zip(self.body_of_instances()).map(|(kept, (body, placement))| PlacedMesh {
            mesh: &kept.mesh,
            name: &kept.name,
            body,
            placement,
            first_vertex: self.vertices.slots[body].first_vertex,
            micromaps: kept.micromaps.as_deref(),
            casts: !kept.catches,
        })
    }

    /// Most surfaces behind one another of those that light passes in part: the number of their triangles.
    pub fn most_layers(&self) -> u32 {
        let blended = self.ranges.iter().filter(|range| range.is_blended());
        let surfaces = |range: &DrawRange| range.indices.len() as u64 / 3 * range.placements.len() as u64;
        u32::try_from(blended.map(surfaces).sum::<u64>()).unwrap_or(u32::MAX)
    }

    /// Parts of `draws` that light passes, each with its range's material, and those that are drawn whole.
    pub fn split_masked(&self, draws: &[Draw]) -> (Vec<DrawRange>, Vec<Draw>) {
        let (mut masked, mut whole) = (Vec::new(), Vec::new());
        for Draw { indices, placements } in draws {
            let mut start = indices.start;
            let holds = |range: &&DrawRange| {
                range.alpha_mode != AlphaMode::Opaque
                    && range.placements.start <= placements.start
                    && placements.end <= range.placements.end
            };
            let draw = |indices| Draw { indices, placements: placements.clone() };
            for range in self.ranges.iter().filter(holds) {
                let part = range.indices.start.max(start)..range.indices.end.min(indices.end);
                if part.is_empty() {
                    continue;
                }
                whole.push(draw(start..part.start));
                start = part.end;
                masked.push(DrawRange { indices: part, placements: placements.clone(), ..*range });
            }
            whole.push(draw(start..indices.end));
        }
        whole.retain(|draw| !draw.indices.is_empty());
        (masked, whole)
    }

    /// The scene's instances, where it places the same meshes, each with the material and skin that it had.
    pub fn placed_by(&self, scene: &Scene) -> Option<Bodies> {
        let bodies = Bodies::of(scene);
        let is_same = bodies.ranges == self.bodies
            && joint_count(scene) == self.joint_count
            && bodies
                .placed
                .iter()
                .zip(&self.placed)
                .all(|(instance, kept)| Kept::new(scene, instance) == *kept);
        is_same.then_some(bodies)
    }

    /// A new pose of the same scene, whose instances are those of `bodies`.
    pub fn moved(&self, scene: &Scene, bodies: &Bodies) -> Result<MovedGeometry, RenderError> {
        let placed = &bodies.placed;
        let pose = scene.pose();
        let (boxes, placed_boxes) = self.moved_boxes(scene, &pose, placed)?;
        let numbers: Vec<u32> = self.vertices.slots.iter().map(|slot| slot.instance).collect();
        let data = PoseData::new(scene, &pose, bodies, &numbers);
        let (nodes, world_from_meshes) = (nodes(placed), world_from_meshes(placed));
        Ok(MovedGeometry { nodes, world_from_meshes, boxes, placed_boxes, data })
    }

    /// Takes such a pose over, for the next frame.
    pub fn take(&mut self, moved: MovedGeometry) {
        let MovedGeometry { nodes, world_from_meshes, boxes, placed_boxes, data } = moved;
        (self.boxes, self.placed_boxes, self.moved) = (boxes, placed_boxes, Some(data));
        (self.nodes, self.world_from_meshes) = (nodes, world_from_meshes);
    }

    /// Brings to the GPU what has moved.
    pub fn upload(&mut self, gpu: &Gpu) {
        if let Some(PoseData { instances, joints, weights, placements }) = self.moved.take() {
            gpu.write(&self.instances, instances.as_slice());
            gpu.write_bytes(&self.joints, 0, bytemuck::cast_slice(&joints));
            gpu.write_bytes(&self.weights, 0, bytemuck::cast_slice(&weights));
            gpu.write_bytes(&self.placements, 0, bytemuck::cast_slice(&placements));
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

    /// Number of vertices, with those that nothing draws any more.
    pub fn vertex_count(&self) -> u32 {
        self.vertices.count()
    }

    /// What of it can cast a shadow.
    pub fn casters(&self, wanted: &Casters<'_>) -> DrawnCasters {
        self.placed_boxes.casters(wanted, self.own_index_count)
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

fn world_from_meshes(placed: &[Instance]) -> Vec<Affine3A> {
    placed.iter().map(|instance| instance.world_from_mesh).collect()
}

fn nodes(placed: &[Instance]) -> Vec<NodeId> {
    placed.iter().map(|instance| instance.node).collect()
}

#[cfg(test)]
mod tests;
