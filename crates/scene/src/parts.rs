//! The parts of a mesh: a ground that is part of its model's mesh is still known as one.

use std::collections::{BTreeMap, HashMap};
use std::ops::Range;

use glam::Vec3;

use crate::{Bounds, Mesh, Scene};

/// A box as thin as this share of its longest side counts as flat.
const FLAT: f32 = 1e-4;

impl Bounds {
    /// The axis along which a box is flat while it has an area across it.
    pub fn flat_axis(&self) -> Option<usize> {
        let size = self.max - self.min;
        let thin = FLAT * size.max_element();
        let axis = (0..3).find(|&axis| size[axis] <= thin)?;
        (size[(axis + 1) % 3] > thin && size[(axis + 2) % 3] > thin).then_some(axis)
    }

    /// The eight corners.
    pub fn corners(&self) -> [Vec3; 8] {
        let ends = [self.min, self.max];
        std::array::from_fn(|i| Vec3::new(ends[i & 1].x, ends[i >> 1 & 1].y, ends[i >> 2].z))
    }
}

/// Some of a mesh's triangles.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshPart {
    /// Around them, in the mesh's own space. Morph targets and joints are not in it.
    pub bounds: Bounds,
    /// Range of the mesh's triangles that holds them.
    pub triangles: Range<usize>,
    /// How many there are: as many as the range is long where no others lie among them.
    pub count: usize,
}

impl MeshPart {
    fn union(self, other: Self) -> Self {
        Self {
            bounds: self.bounds.union(other.bounds),
            triangles: self.triangles.start.min(other.triangles.start)
                ..self.triangles.end.max(other.triangles.end),
            count: self.count + other.count,
        }
    }
}

impl Mesh {
    /// The parts of a mesh: each flat connected part at least half as large as the mesh, such as a ground, and all the rest as one.
    pub fn parts(&self) -> Vec<MeshPart> {
        let parts = connected_parts(self);
        let Some(whole) = parts.iter().map(|part| part.bounds).reduce(Bounds::union) else {
            return Vec::new();
        };
        let longest_side = |bounds: &Bounds| (bounds.max - bounds.min).max_element();
        let large = 0.5 * longest_side(&whole);
        let is_ground =
            |part: &MeshPart| part.bounds.flat_axis().is_some() && longest_side(&part.bounds) >= large;
        let (mut found, others): (Vec<_>, Vec<_>) = parts.into_iter().partition(is_ground);
        found.extend(others.into_iter().reduce(MeshPart::union));
        found
    }
}

impl Scene {
    /// Boxes around the parts of every mesh where it is placed in the current pose, in world space; one for a mesh that deforms.
    pub(crate) fn world_part_boxes(&self) -> Vec<Bounds> {
        let pose = self.pose();
        let mut boxes = Vec::new();
        let mut parts_of = HashMap::new();
        for instance in self.instances_in(&pose.world_from_nodes) {
            let parts = if self.is_deformable(&instance) {
                &Vec::new()
            } else {
                parts_of.entry(instance.mesh.0).or_insert_with(|| self.meshes[instance.mesh.0].parts())
            };
            if parts.len() > 1 {
                let placed = |part: &MeshPart| {
                    part.bounds.corners().map(|corner| instance.world_from_mesh.transform_point3(corner))
                };
                boxes.extend(parts.iter().filter_map(|part| Bounds::around(placed(part))));
            } else {
                // Exact, where a turned box would be larger.
                boxes.extend(self.instance_bounds(&pose, &instance));
            }
        }
        boxes
    }
}

/// Of each vertex the first one at the same place: loaders split them for their normals.
pub(crate) fn first_vertices(positions: &[Vec3]) -> Vec<usize> {
    let mut first_at = HashMap::with_capacity(positions.len());
    (positions.iter().enumerate())
        // Minus zero is zero.
        .map(|(i, position)| *first_at.entry((*position + 0.0).to_array().map(f32::to_bits)).or_insert(i))
        .collect()
}

/// The parts of a mesh whose triangles hang together. Vertices at the same place count as one.
fn connected_parts(mesh: &Mesh) -> Vec<MeshPart> {
    let mut parents = first_vertices(&mesh.positions);
    for triangle in &mesh.triangles {
        let root = root_of(&mut parents, triangle[0] as usize);
        for &vertex in &triangle[1..] {
            let other = root_of(&mut parents, vertex as usize);
            parents[other] = root;
        }
    }
    let mut parts: BTreeMap<usize, MeshPart> = BTreeMap::new();
    for (index, triangle) in mesh.triangles.iter().enumerate() {
        let corners = triangle.map(|vertex| mesh.positions[vertex as usize]);
        let Some(bounds) = Bounds::around(corners) else { continue };
        let new = MeshPart { bounds, triangles: index..index + 1, count: 1 };
        let root = root_of(&mut parents, triangle[0] as usize);
        parts.entry(root).and_modify(|part| *part = part.clone().union(new.clone())).or_insert(new);
    }
    parts.into_values().collect()
}

/// Root of `vertex` in a union-find forest; the path to it is halved on the way.
pub(crate) fn root_of(parents: &mut [usize], mut vertex: usize) -> usize {
    while parents[vertex] != vertex {
        parents[vertex] = parents[parents[vertex]];
        vertex = parents[vertex];
    }
    vertex
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ground of two triangles and a tetrahedron on it, as one mesh.
    fn ground_and_model() -> Mesh {
        let p = Vec3::new;
        Mesh {
            positions: vec![
                p(-4.0, 0.0, -4.0),
                p(-4.0, 0.0, 4.0),
                p(4.0, 0.0, 4.0),
                p(4.0, 0.0, -4.0),
                p(0.0, 0.0, 0.0),
                p(1.0, 0.0, 0.0),
                p(0.0, 0.0, 1.0),
                p(0.0, 1.0, 0.0),
                // The same place as the first corner.
                p(-4.0, 0.0, -4.0),
            ],
            triangles: vec![[0, 1, 2], [8, 2, 3], [4, 5, 6], [4, 5, 7], [5, 6, 7]],
            ..Mesh::default()
        }
    }

    #[test]
    fn a_ground_within_a_mesh_is_a_box_of_its_own() {
        let ground = Bounds { min: Vec3::new(-4.0, 0.0, -4.0), max: Vec3::new(4.0, 0.0, 4.0) };
        let model = Bounds { min: Vec3::ZERO, max: Vec3::ONE };
        let part = |bounds, triangles: Range<usize>| MeshPart { bounds, count: triangles.len(), triangles };
        assert_eq!(ground_and_model().parts(), [part(ground, 0..2), part(model, 2..5)]);
        let mut mixed = ground_and_model();
        mixed.triangles.swap(1, 4);
        let counts =
            mixed.parts().iter().map(|part| (part.triangles.clone(), part.count)).collect::<Vec<_>>();
        assert_eq!(counts, [(0..5, 2), (1..4, 3)]);
    }

    #[test]
    fn a_box_has_eight_corners() {
        let corners = Bounds { min: Vec3::ZERO, max: Vec3::ONE }.corners();
        for x in [0.0, 1.0] {
            for y in [0.0, 1.0] {
                for z in [0.0, 1.0] {
                    assert!(corners.contains(&Vec3::new(x, y, z)));
                }
            }
        }
        assert_eq!(corners.len(), 8);
    }

    #[test]
    fn a_mesh_without_triangles_has_no_box() {
        assert!(Mesh::default().parts().is_empty());
    }
}
