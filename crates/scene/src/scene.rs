use glam::{Affine3A, Vec2, Vec3, Vec4};

use crate::{Camera, Material, Texture};

/// Index into [`Scene::meshes`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct MeshId(pub usize);

/// Index into [`Scene::materials`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct MaterialId(pub usize);

/// Index into [`Scene::nodes`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct NodeId(pub usize);

/// Triangles of one material. All vertex arrays are as long as `positions`, or empty where marked.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Mesh {
    /// Positions in mesh space [m].
    pub positions: Vec<Vec3>,
    /// Unit shading normals in mesh space. Loaders make flat ones (vertices unshared) where the file has none.
    pub normals: Vec<Vec3>,
    /// Unit tangents with the bitangent's sign in w; empty unless the material has a normal texture.
    pub tangents: Vec<Vec4>,
    /// Up to two texture coordinate sets; a missing set is empty.
    pub uvs: [Vec<Vec2>; 2],
    /// Linear vertex colours that multiply the base colour; empty where there are none.
    pub colors: Vec<Vec4>,
    /// Vertex indices, counter-clockwise seen from the front; every index is in range.
    pub triangles: Vec<[u32; 3]>,
    /// Material; `None` is [`Material::default`].
    pub material: Option<MaterialId>,
}

/// A place in the hierarchy. Parents come before children in [`Scene::nodes`].
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// Name in the file, empty where it has none.
    pub name: String,
    /// Parent, `None` for a root; always an earlier node.
    pub parent: Option<NodeId>,
    /// Transform to the parent's space.
    pub parent_from_node: Affine3A,
    /// Meshes placed here (one for each primitive of a glTF mesh).
    pub meshes: Vec<MeshId>,
}

/// Everything that is drawn, and from where.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Scene {
    /// Meshes.
    pub meshes: Vec<Mesh>,
    /// Materials.
    pub materials: Vec<Material>,
    /// Textures.
    pub textures: Vec<Texture>,
    /// Nodes, parents before children.
    pub nodes: Vec<Node>,
    /// Cameras, in file order; the first is used unless another is named.
    pub cameras: Vec<Camera>,
    /// What the loader repaired or ignored, one line each, for the user to read.
    pub warnings: Vec<String>,
}

/// An axis-aligned box in world space [m].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Smallest corner.
    pub min: Vec3,
    /// Largest corner.
    pub max: Vec3,
}

impl Bounds {
    /// Centre [m].
    pub fn center(&self) -> Vec3 {
        0.5 * (self.min + self.max)
    }

    /// Half the diagonal [m].
    pub fn radius(&self) -> f32 {
        0.5 * (self.max - self.min).length()
    }
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

    /// Every placed mesh with its transform to world space.
    pub fn instances(&self) -> Vec<(MeshId, Affine3A)> {
        let world = self.world_from_nodes();
        self.nodes
            .iter()
            .zip(world)
            .flat_map(|(node, world_from_node)| node.meshes.iter().map(move |&mesh| (mesh, world_from_node)))
            .collect()
    }

    /// Box around every placed triangle corner; `None` for a scene without triangles.
    pub fn bounds(&self) -> Option<Bounds> {
        let mut bounds: Option<Bounds> = None;
        for (mesh, world_from_mesh) in self.instances() {
            let mesh = &self.meshes[mesh.0];
            for &index in mesh.triangles.iter().flatten() {
                let p = world_from_mesh.transform_point3(mesh.positions[index as usize]);
                let b = bounds.get_or_insert(Bounds { min: p, max: p });
                b.min = b.min.min(p);
                b.max = b.max.max(p);
            }
        }
        bounds
    }

    /// Number of placed triangles.
    pub fn triangle_count(&self) -> usize {
        self.instances().iter().map(|(mesh, _)| self.meshes[mesh.0].triangles.len()).sum()
    }
}
