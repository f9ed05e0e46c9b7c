//! Where every vertex is in the scene's current pose.

use glam::{Affine3A, Vec3, Vec4};

use crate::{Bounds, Mesh, MeshId, NodeId, Scene, SkinId, mirror_sign, normal_matrix};

/// Largest coordinate [m] or matrix entry that is drawn: squares of it stay finite.
pub(crate) const LARGEST: f32 = 1e15;

/// Nodes that bend meshes (glTF 2.0, section 3.7.3).
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Skin {
    /// Name in the file, empty where it has none.
    pub name: String,
    /// Its joints.
    pub joints: Vec<NodeId>,
    /// Takes mesh space to the joint's space in the pose in which the mesh was bound, for every joint.
    pub joint_from_bind: Vec<Affine3A>,
}

/// Which joints bend a mesh's vertices. Vertex `i` has `entries[starts[i]..starts[i + 1]]`.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Influences {
    /// One more than there are vertices, not decreasing; empty for a mesh without joints.
    pub starts: Vec<u32>,
    /// Joint (index into [`Skin::joints`]) and weight. A vertex's weights are positive and sum to 1; one without any
    /// follows its node.
    pub entries: Vec<(u32, f32)>,
}

impl Influences {
    /// Joints and weights of a vertex.
    pub fn of(&self, vertex: usize) -> &[(u32, f32)] {
        match self.starts.get(vertex..) {
            Some([start, end, ..]) => &self.entries[*start as usize..*end as usize],
            _ => &[],
        }
    }

    /// No vertex has a joint.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// The same for other vertices, given which each of them was.
    pub fn gathered(&self, vertices: impl Iterator<Item = usize>) -> Self {
        if self.is_empty() {
            return Self::default();
        }
        let mut gathered = Self { starts: vec![0], entries: Vec::new() };
        for vertex in vertices {
            gathered.push(self.of(vertex));
        }
        gathered
    }

    /// Appends a vertex. More entries than fit 32 bits are left out: nothing of that size is ever loaded.
    pub fn push(&mut self, entries: &[(u32, f32)]) {
        if self.starts.is_empty() {
            self.starts.push(0);
        }
        let end = u32::try_from(self.entries.len() + entries.len());
        if end.is_ok() {
            self.entries.extend_from_slice(entries);
        }
        self.starts.push(end.unwrap_or(self.entries.len() as u32));
    }
}

/// What a morph target of weight 1 adds to a mesh (glTF 2.0, section 3.7.2.2). Each array is as long as the mesh's
/// positions, or empty where the target has none.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct MorphTarget {
    /// Added to positions, in mesh space [m].
    pub positions: Vec<Vec3>,
    /// Added to normals.
    pub normals: Vec<Vec3>,
    /// Added to tangents, whose sign stays.
    pub tangents: Vec<Vec3>,
}

/// A mesh as a node places it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instance {
    /// The mesh.
    pub mesh: MeshId,
    /// The node.
    pub node: NodeId,
    /// The node's transform to world space; a skinned mesh follows its joints instead.
    pub world_from_mesh: Affine3A,
    /// The skin that bends this instance; `None` also where its mesh has no joints.
    pub skin: Option<SkinId>,
}

/// Transforms of the current pose.
#[derive(Clone, Debug, PartialEq)]
pub struct Pose {
    /// `world_from_node` of every node.
    pub world_from_nodes: Vec<Affine3A>,
    /// By skin: of every joint, what takes a bound vertex to world space, `world_from_joint * joint_from_bind`.
    pub world_from_bind: Vec<Vec<Affine3A>>,
}

/// An instance's vertices in world space; arrays as in [`Mesh`].
#[derive(Clone, Debug, PartialEq, Default)]
pub struct WorldVertices {
    /// Positions [m].
    pub positions: Vec<Vec3>,
    /// Unit normals.
    pub normals: Vec<Vec3>,
    /// Unit tangents with the bitangent's sign in w; empty where the mesh has none. They go through the normals' matrix, and the sign turns
    /// where a mesh is mirrored ([`crate::mirror_sign`]).
    pub tangents: Vec<Vec4>,
}

impl Scene {
    /// `world_from_node` of every node, in node order.
    pub fn world_from_nodes(&self) -> Vec<Affine3A> {
        let mut world: Vec<Affine3A> = Vec::with_capacity(self.nodes.len());
        for node in &self.nodes {
            let parent = node.parent.map_or(Affine3A::IDENTITY, |parent| world[parent.0]);
            world.push(parent * node.parent_from_node);
        }
        world
    }

    /// Transforms of all nodes and joints.
    pub fn pose(&self) -> Pose {
        let world_from_nodes = self.world_from_nodes();
        let joints = |skin: &Skin| {
            let pairs = skin.joints.iter().zip(&skin.joint_from_bind);
            pairs.map(|(joint, bind)| world_from_nodes[joint.0] * *bind).collect()
        };
        Pose { world_from_bind: self.skins.iter().map(joints).collect(), world_from_nodes }
    }

    /// Every placed mesh, in node order.
    pub fn instances(&self) -> Vec<Instance> {
        self.instances_in(&self.world_from_nodes())
    }

    pub(crate) fn instances_in(&self, world_from_nodes: &[Affine3A]) -> Vec<Instance> {
        let placed = self.nodes.iter().zip(world_from_nodes).enumerate();
        placed
            .flat_map(|(index, (node, &world_from_mesh))| {
                node.meshes.iter().map(move |&mesh| Instance {
                    mesh,
                    node: NodeId(index),
                    world_from_mesh,
                    skin: node.skin.filter(|_| !self.meshes[mesh.0].influences.is_empty()),
                })
            })
            .collect()
    }

    /// Whether an instance's vertices may move against each other: it has a skin or morph targets.
    pub fn is_deformable(&self, instance: &Instance) -> bool {
        instance.skin.is_some() || !self.meshes[instance.mesh.0].targets.is_empty()
    }

    /// Weights of an instance's morph targets, as many as its mesh has.
    pub fn morph_weights(&self, instance: &Instance) -> impl Iterator<Item = f32> {
        let weights = &self.nodes[instance.node.0].weights;
        let count = self.meshes[instance.mesh.0].targets.len();
        (0..count).map(|target| weights.get(target).copied().unwrap_or(0.0))
    }

    /// An instance's vertices in world space in `pose`, which is [`Scene::pose`]: morph targets first, then joints.
    pub fn world_vertices(&self, pose: &Pose, instance: &Instance) -> WorldVertices {
        let mesh = &self.meshes[instance.mesh.0];
        let mut vertices = self.morphed(mesh, instance);
        let joints = instance.skin.map(|skin| pose.world_from_bind[skin.0].as_slice());
        let rigid = (instance.world_from_mesh, normal_matrix(&instance.world_from_mesh));
        for vertex in 0..vertices.positions.len() {
            let blended = joints.and_then(|joints| blend(joints, mesh.influences.of(vertex)));
            let (affine, normal_from_mesh) = blended.map_or(rigid, |affine| (affine, normal_matrix(&affine)));
            vertices.positions[vertex] = affine.transform_point3(vertices.positions[vertex]);
            if let Some(normal) = vertices.normals.get_mut(vertex) {
                *normal = (normal_from_mesh * *normal).normalize_or_zero();
            }
            if let Some(tangent) = vertices.tangents.get_mut(vertex) {
                let turned = (normal_from_mesh * tangent.truncate()).normalize_or_zero();
                *tangent = turned.extend(tangent.w * mirror_sign(&affine));
            }
        }
        vertices
    }

    /// The mesh with its morph targets added, in mesh space.
    fn morphed(&self, mesh: &Mesh, instance: &Instance) -> WorldVertices {
        let mut vertices = WorldVertices {
            positions: mesh.positions.clone(),
            normals: mesh.normals.clone(),
            tangents: mesh.tangents.clone(),
        };
        for (target, weight) in mesh.targets.iter().zip(self.morph_weights(instance)) {
            if weight == 0.0 {
                continue;
            }
            for (value, offset) in vertices.positions.iter_mut().zip(&target.positions) {
                *value += weight * *offset;
            }
            for (value, offset) in vertices.normals.iter_mut().zip(&target.normals) {
                *value += weight * *offset;
            }
            for (value, offset) in vertices.tangents.iter_mut().zip(&target.tangents) {
                *value += (weight * *offset).extend(0.0);
            }
        }
        vertices
    }

    /// Box around the triangle corners of an instance in `pose`, in world space; `None` without triangles.
    pub(crate) fn instance_bounds(&self, pose: &Pose, instance: &Instance) -> Option<Bounds> {
        let mesh = &self.meshes[instance.mesh.0];
        let indices = mesh.triangles.iter().flatten().map(|&index| index as usize);
        if self.is_deformable(instance) {
            let vertices = self.world_vertices(pose, instance);
            Bounds::around(indices.map(|index| vertices.positions[index]))
        } else {
            let affine = instance.world_from_mesh;
            Bounds::around(indices.map(|index| affine.transform_point3(mesh.positions[index])))
        }
    }
}

/// The mean of the joints' transforms (linear blend skinning); `None` for a vertex without joints.
fn blend(joints: &[Affine3A], influences: &[(u32, f32)]) -> Option<Affine3A> {
    if influences.is_empty() {
        return None;
    }
    let mut sum = Affine3A::ZERO;
    for &(joint, weight) in influences {
        let joint = &joints[joint as usize];
        sum.matrix3 += joint.matrix3 * weight;
        sum.translation += joint.translation * weight;
    }
    Some(sum)
}

#[cfg(test)]
mod tests {
    use glam::Quat;

    use super::*;
    use crate::Node;

    /// A triangle on a joint, with a morph target that shears it. Its normal and tangents are those of its plane.
    fn bent(world_from_joint: Affine3A, weight: f32) -> Scene {
        let mesh = Mesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
            normals: vec![Vec3::Z; 3],
            tangents: vec![Vec4::new(1.0, 0.0, 0.0, -1.0); 3],
            triangles: vec![[0, 1, 2]],
            influences: Influences { starts: vec![0, 1, 2, 3], entries: vec![(0, 1.0); 3] },
            targets: vec![MorphTarget {
                positions: vec![Vec3::ZERO, Vec3::Z, Vec3::ZERO],
                // From (0, 0, 1) to (-1, 0, 1), and along the edge.
                normals: vec![Vec3::NEG_X; 3],
                tangents: vec![Vec3::Z; 3],
            }],
            ..Mesh::default()
        };
        let (mesh, skin) = (vec![mesh.into()], Skin { joints: vec![NodeId(1)], ..Skin::default() });
        let placed = Node {
            meshes: vec![MeshId(0)],
            skin: Some(SkinId(0)),
            weights: vec![weight],
            // Counts for nothing.
            parent_from_node: Affine3A::from_translation(Vec3::splat(9.0)),
            ..Node::default()
        };
        let joint = Node { parent_from_node: world_from_joint, ..Node::default() };
        let skins = vec![Skin { joint_from_bind: vec![Affine3A::IDENTITY], ..skin }];
        Scene { meshes: mesh, skins, nodes: vec![placed, joint], ..Scene::default() }
    }

    #[test]
    fn normals_stay_upright_on_bent_surfaces() {
        let turn = Quat::from_rotation_y(0.7) * Quat::from_rotation_x(0.4);
        for scale in [Vec3::ONE, Vec3::new(1.0, 4.0, 0.3), Vec3::new(-2.0, 1.0, 1.0)] {
            let joint = Affine3A::from_scale_rotation_translation(scale, turn, Vec3::ONE);
            for weight in [0.0, 1.0] {
                let scene = bent(joint, weight);
                let vertices = scene.world_vertices(&scene.pose(), &scene.instances()[0]);
                let [a, b, c] = [0, 1, 2].map(|i| vertices.positions[i]);
                let plane = (b - a).cross(c - a).normalize() * scale.x.signum();
                for normal in &vertices.normals {
                    assert!(normal.distance(plane) < 1e-5, "{scale}, {weight}: {normal}, not {plane}");
                }
                assert!((a - Vec3::ONE).length() < 1e-6, "joints place it, not its node");
            }
        }
    }

    #[test]
    fn tangents_turn_with_their_joints_and_morph() {
        let turn = Quat::from_rotation_z(0.5) * Quat::from_rotation_y(1.2);
        for (weight, tangent) in [(0.0, Vec3::X), (1.0, Vec3::new(1.0, 0.0, 1.0).normalize())] {
            let scene = bent(Affine3A::from_quat(turn), weight);
            let vertices = scene.world_vertices(&scene.pose(), &scene.instances()[0]);
            let expected = (turn * tangent).extend(-1.0);
            assert!(vertices.tangents[2].distance(expected) < 1e-6, "{}", vertices.tangents[2]);
        }
    }
}
