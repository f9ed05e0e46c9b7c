//! Skins (specification, section 3.7.3): meshes bent by the pose in which the file's nodes stand.

use glam::{Affine3A, Mat4, Vec3};

use super::accessors::Accessors;
use super::schema::{Int, Primitive, Root};
use super::{Budget, Fault, get};
use crate::{Mesh, normal_matrix};

/// Most joints that bend one vertex, in sets of four.
const JOINT_SETS: usize = 4;

/// The pose of a skinned mesh, to world space.
pub struct Pose {
    /// `world_from_joint * joint_from_bind` of every joint.
    joints: Vec<Affine3A>,
    /// For primitives without joints.
    world_from_node: Affine3A,
}

impl Pose {
    /// The pose of skin `index`; `None` where one of its joints is not in the scene.
    pub fn read(
        root: &Root,
        accessors: &Accessors,
        index: usize,
        world_from_node: Affine3A,
        world: impl Fn(usize) -> Option<Affine3A>,
        budget: &mut Budget,
    ) -> Result<Option<Self>, Fault> {
        let skin = get(&root.skins, index, "skin", "a node")?;
        let name = format!("skin {index}");
        let binds = match skin.inverse_bind_matrices {
            Some(Int(accessor)) => accessors.floats::<16>(accessor, &name, budget)?,
            None => Vec::new(),
        };
        if !binds.is_empty() && binds.len() < skin.joints.len() {
            return Err(Fault::Invalid(format!("{name} has fewer bind matrices than joints")));
        }
        budget.take(skin.joints.len(), size_of::<Affine3A>())?;
        let mut joints = Vec::with_capacity(skin.joints.len());
        for (number, &Int(joint)) in skin.joints.iter().enumerate() {
            get(&root.nodes, joint, "node", &name)?;
            let Some(world_from_joint) = world(joint) else { return Ok(None) };
            let bind = binds.get(number).map_or(Mat4::IDENTITY, Mat4::from_cols_array);
            joints.push(world_from_joint * Affine3A::from_mat4(bind));
        }
        Ok(Some(Self { joints, world_from_node }))
    }

    /// Moves the vertices of `mesh`, read from `primitive`, to world space. Weights are made to sum to 1; a vertex
    /// without any follows the node.
    pub fn apply(
        &self,
        primitive: &Primitive,
        accessors: &Accessors,
        name: &str,
        budget: &mut Budget,
        mesh: &mut Mesh,
    ) -> Result<(), Fault> {
        let count = mesh.positions.len();
        budget.take(count, size_of::<Affine3A>() + size_of::<f32>())?;
        let mut sums = vec![(Affine3A::ZERO, 0.0_f32); count];
        for set in 0..JOINT_SETS {
            let attribute = |semantic: &str| primitive.attributes.get(&format!("{semantic}_{set}"));
            let (Some(joints), Some(weights)) = (attribute("JOINTS"), attribute("WEIGHTS")) else { break };
            let joints = accessors.floats::<4>(joints.0, name, budget)?;
            let weights = accessors.floats::<4>(weights.0, name, budget)?;
            if joints.len() != count || weights.len() != count {
                return Err(Fault::Invalid(format!(
                    "{name} has not as many joints and weights as positions"
                )));
            }
            for ((sum, total), (joints, weights)) in sums.iter_mut().zip(joints.iter().zip(&weights)) {
                for (&joint, &weight) in joints.iter().zip(weights) {
                    // False for NaN.
                    if !(weight > 0.0 && weight.is_finite()) {
                        continue;
                    }
                    let matrix = self.joints.get(joint as usize).ok_or_else(|| {
                        let known = self.joints.len();
                        Fault::Invalid(format!("{name} refers to joint {joint}, but its skin has {known}"))
                    })?;
                    sum.matrix3 += matrix.matrix3 * weight;
                    sum.translation += matrix.translation * weight;
                    *total += weight;
                }
            }
        }
        for (vertex, (sum, total)) in sums.into_iter().enumerate() {
            let affine = if total > 0.0 {
                let scale = 1.0 / total;
                Affine3A { matrix3: sum.matrix3 * scale, translation: sum.translation * scale }
            } else {
                self.world_from_node
            };
            mesh.positions[vertex] = affine.transform_point3(mesh.positions[vertex]);
            if let Some(normal) = mesh.normals.get_mut(vertex) {
                *normal = normal_matrix(&affine) * *normal;
            }
            if let Some(tangent) = mesh.tangents.get_mut(vertex) {
                let turned: Vec3 = affine.transform_vector3(tangent.truncate());
                *tangent = turned.extend(tangent.w);
            }
        }
        Ok(())
    }
}
