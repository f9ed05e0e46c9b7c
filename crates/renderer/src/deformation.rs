//! Skins and morph targets on the GPU: what bends each vertex is uploaded once, the pose every time that it changes.

use std::collections::HashMap;

use glam::{Affine3A, Mat4, Vec3};
use gnomon_scene::{Mesh, MeshId, Pose, Scene, normal_matrix};
use gnomon_shaders::layout;

use crate::geometry::Bodies;

/// The records of all meshes' vertices, as `transform.wgsl` reads them.
pub(crate) struct Records {
    pub words: Vec<u32>,
    /// Number of the first of them.
    first_word: u32,
    /// By mesh, the record of each vertex.
    known: HashMap<usize, Vec<u32>>,
}

impl Records {
    /// Records that follow so many words.
    pub fn after(first_word: u32) -> Self {
        // Word 0 belongs to nobody: a vertex with record 0 is rigid.
        let words = if first_word == 0 { vec![0] } else { Vec::new() };
        Self { words, first_word, known: HashMap::new() }
    }

    /// Number of words, with those before.
    pub fn end(&self) -> u64 {
        u64::from(self.first_word) + self.words.len() as u64
    }

    /// Where the record of each vertex of a mesh begins; empty for a mesh that nothing deforms. `None` where there are
    /// more words than 32 bits count.
    pub fn of(&mut self, id: MeshId, mesh: &Mesh) -> Option<&[u32]> {
        if !self.known.contains_key(&id.0) {
            let mut starts = Vec::new();
            if !mesh.influences.is_empty() || !mesh.targets.is_empty() {
                for vertex in 0..mesh.positions.len() {
                    starts.push(u32::try_from(self.end()).ok()?);
                    self.push(mesh, vertex);
                }
            }
            self.known.insert(id.0, starts);
        }
        self.known.get(&id.0).map(Vec::as_slice)
    }

    fn push(&mut self, mesh: &Mesh, vertex: usize) {
        let joints = mesh.influences.of(vertex);
        let counts = self.words.len();
        self.words.extend([joints.len() as u32, 0]);
        self.words.extend(joints.iter().flat_map(|&(joint, weight)| [joint, weight.to_bits()]));
        for (number, target) in mesh.targets.iter().enumerate() {
            let offset = |values: &[Vec3]| values.get(vertex).copied().unwrap_or_default();
            let offsets = [&target.positions, &target.normals, &target.tangents].map(|values| offset(values));
            // Most targets of a face leave most of it alone.
            if offsets != [Vec3::ZERO; 3] {
                self.words.push(number as u32);
                self.words.extend(offsets.iter().flat_map(|offset| offset.to_array().map(f32::to_bits)));
                self.words[counts + 1] += 1;
            }
        }
    }
}

/// What a pose brings to the GPU.
pub(crate) struct PoseData {
    /// By the numbers of instances.
    pub instances: Vec<layout::Instance>,
    /// `world_from_bind` of the joints of all skins.
    pub joints: Vec<[[f32; 4]; 4]>,
    /// Morph weights of all instances that have targets.
    pub weights: Vec<f32>,
    /// As [`Bodies::placements`].
    pub placements: Vec<[[f32; 4]; 4]>,
}

impl PoseData {
    /// `numbers` are those that the vertices of each body know their instance by.
    pub fn new(scene: &Scene, pose: &Pose, bodies: &Bodies, numbers: &[u32]) -> Self {
        let mut joints = Vec::new();
        let mut first_joints = Vec::with_capacity(pose.world_from_bind.len());
        for skin in &pose.world_from_bind {
            first_joints.push(joints.len() as u32);
            joints.extend(skin.iter().map(|&joint| Mat4::from(joint).to_cols_array_2d()));
        }
        let mut weights = Vec::new();
        let count = numbers.iter().max().map_or(0, |last| *last as usize + 1);
        let mut instances = vec![layout::Instance::default(); count];
        for (range, number) in bodies.ranges.iter().zip(numbers) {
            if range.start >= bodies.own {
                // Copies are placed as they are drawn.
                instances[*number as usize] = layout::Instance {
                    world_from_mesh: Mat4::IDENTITY,
                    normal_from_mesh: Mat4::IDENTITY,
                    first_joint: layout::NO_SKIN,
                    first_weight: 0,
                };
                continue;
            }
            let instance = &bodies.placed[range.start];
            let first_weight = weights.len() as u32;
            weights.extend(scene.morph_weights(instance));
            instances[*number as usize] = layout::Instance {
                world_from_mesh: Mat4::from(instance.world_from_mesh),
                normal_from_mesh: Mat4::from_mat3(normal_matrix(&instance.world_from_mesh)),
                first_joint: instance.skin.map_or(layout::NO_SKIN, |skin| first_joints[skin.0]),
                first_weight,
            };
        }
        // A binding holds at least one element.
        if joints.is_empty() {
            joints.push(Mat4::IDENTITY.to_cols_array_2d());
        }
        if weights.is_empty() {
            weights.push(0.0);
        }
        let placements = bodies.placements().iter().map(Mat4::to_cols_array_2d).collect();
        Self { instances, joints, weights, placements }
    }
}

/// Boxes in mesh space from which the box of a deformed instance follows in any pose, without a look at its vertices. That box
/// is conservative: it may be larger than what it holds, but nothing reaches out of it.
pub(crate) struct DeformableBoxes {
    /// By joint: around the bound vertices that it bends, whatever its share in them.
    joints: Vec<(usize, Box3)>,
    /// Around the vertices that no joint bends.
    free: Option<Box3>,
    /// By morph target: around its offsets and 0.
    targets: Vec<Box3>,
}

/// Smallest and largest corner.
pub(crate) type Box3 = (Vec3, Vec3);

impl DeformableBoxes {
    /// `skinned`: the instance has a skin.
    pub fn new(mesh: &Mesh, skinned: bool) -> Self {
        let mut joints: HashMap<u32, Box3> = HashMap::new();
        let mut free: Option<Box3> = None;
        let grow = |(min, max): &mut Box3, p: Vec3| (*min, *max) = (min.min(p), max.max(p));
        for &vertex in mesh.triangles.iter().flatten() {
            let p = mesh.positions[vertex as usize];
            let bends = if skinned { mesh.influences.of(vertex as usize) } else { &[] };
            for &(joint, _) in bends {
                grow(joints.entry(joint).or_insert((p, p)), p);
            }
            if bends.is_empty() {
                grow(free.get_or_insert((p, p)), p);
            }
        }
        let targets = mesh.targets.iter().map(|target| {
            target
                .positions
                .iter()
                .fold((Vec3::ZERO, Vec3::ZERO), |(min, max), &offset| (min.min(offset), max.max(offset)))
        });
        let mut joints: Vec<_> = joints.into_iter().map(|(joint, bound)| (joint as usize, bound)).collect();
        joints.sort_by_key(|(joint, _)| *joint);
        Self { joints, free, targets: targets.collect() }
    }

    /// The box in a pose and the space it is in, as its transform to the world; `None` without vertices. `joints` has
    /// `world_from_bind` of the instance's skin.
    pub fn around(
        &self,
        weights: impl Iterator<Item = f32>,
        joints: Option<&[Affine3A]>,
        world_from_mesh: Affine3A,
    ) -> Option<(Box3, Affine3A)> {
        let mut grown = (Vec3::ZERO, Vec3::ZERO);
        for (weight, (min, max)) in weights.zip(&self.targets) {
            let (a, b) = (weight * *min, weight * *max);
            grown = (grown.0 + a.min(b), grown.1 + a.max(b));
        }
        let morphed = |(min, max): Box3| (min + grown.0, max + grown.1);
        let Some(joints) = joints else { return Some((morphed(self.free?), world_from_mesh)) };
        // A vertex is a mean of where its joints take it, and so within the box around all those places.
        let placed = self.joints.iter().map(|&(joint, bound)| (joints[joint], bound));
        let placed = placed.chain(self.free.map(|bound| (world_from_mesh, bound)));
        let boxes = placed.map(|(affine, bound)| transformed(affine, morphed(bound)));
        boxes.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))).map(|bound| (bound, Affine3A::IDENTITY))
    }
}

/// Axis-aligned box around a transformed box.
fn transformed(affine: Affine3A, (min, max): Box3) -> Box3 {
    let center = affine.transform_point3(0.5 * (min + max));
    let half = 0.5 * (max - min);
    let m = affine.matrix3;
    let reach: Vec3 = (m.x_axis.abs() * half.x + m.y_axis.abs() * half.y + m.z_axis.abs() * half.z).into();
    (center - reach, center + reach)
}

#[cfg(test)]
mod tests;
