//! The parts of a mesh: a ground that is part of its model's mesh is still known as one.

use std::collections::{BTreeMap, HashMap};

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

impl Mesh {
    /// Boxes around the parts of a mesh, in its own space: one for each flat connected part at least half as large as the mesh, such as
    /// a ground, and one for all the rest. Morph targets and joints are not in them.
    pub fn part_boxes(&self) -> Vec<Bounds> {
        let parts = connected_parts(self);
        let Some(whole) = parts.iter().copied().reduce(Bounds::union) else { return Vec::new() };
        let longest_side = |bounds: &Bounds| (bounds.max - bounds.min).max_element();
        let large = 0.5 * longest_side(&whole);
        let (mut boxes, others): (Vec<_>, Vec<_>) =
            parts.into_iter().partition(|part| part.flat_axis().is_some() && longest_side(part) >= large);
        boxes.extend(others.into_iter().reduce(Bounds::union));
        boxes
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
                parts_of.entry(instance.mesh.0).or_insert_with(|| self.meshes[instance.mesh.0].part_boxes())
            };
            if parts.len() > 1 {
                let placed = |part: &Bounds| {
                    part.corners().map(|corner| instance.world_from_mesh.transform_point3(corner))
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

/// Boxes of the parts of a mesh whose triangles hang together. Vertices at the same place count as one: loaders split them
/// for their normals.
fn connected_parts(mesh: &Mesh) -> Vec<Bounds> {
    let mut first_at = HashMap::new();
    let mut parents: Vec<usize> = (mesh.positions.iter().enumerate())
        .map(|(i, position)| *first_at.entry(position.to_array().map(f32::to_bits)).or_insert(i))
        .collect();
    for triangle in &mesh.triangles {
        let root = root_of(&mut parents, triangle[0] as usize);
        for &vertex in &triangle[1..] {
            let other = root_of(&mut parents, vertex as usize);
            parents[other] = root;
        }
    }
    let mut parts: BTreeMap<usize, Bounds> = BTreeMap::new();
    for &vertex in mesh.triangles.iter().flatten() {
        let p = mesh.positions[vertex as usize];
        let point = Bounds { min: p, max: p };
        let part = parts.entry(root_of(&mut parents, vertex as usize)).or_insert(point);
        *part = part.union(point);
    }
    parts.into_values().collect()
}

/// Root of `vertex` in a union-find forest; the path to it is halved on the way.
fn root_of(parents: &mut [usize], mut vertex: usize) -> usize {
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
        assert_eq!(ground_and_model().part_boxes(), [ground, model]);
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
        assert!(Mesh::default().part_boxes().is_empty());
    }
}
