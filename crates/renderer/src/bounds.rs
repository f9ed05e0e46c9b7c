//! Boxes around what casts and receives shadows.

use std::collections::{BTreeMap, HashMap};

use glam::{Affine3A, Vec3};
use gnomon_scene::Mesh;

/// A box as thin as this share of its longest side counts as flat.
const FLAT: f32 = 1e-4;

/// Share of its height over a ground by which a model may have sunk into it and still stands on it: feet of a walking model do,
/// and boxes around bent meshes are larger than these.
const SUNKEN: f32 = 0.15;

/// Box around some triangles of an instance, in its mesh's space.
#[derive(Clone, Debug)]
pub(crate) struct InstanceBox {
    pub min: Vec3,
    pub max: Vec3,
    pub instance: usize,
    pub world_from_mesh: Affine3A,
}

impl InstanceBox {
    /// The eight corners in world space.
    pub fn corners(&self) -> impl Iterator<Item = Vec3> + '_ {
        (0..8).map(|i| {
            let pick = |bit: u32, low: f32, high: f32| if i & bit == 0 { low } else { high };
            self.world_from_mesh.transform_point3(Vec3::new(
                pick(1, self.min.x, self.max.x),
                pick(2, self.min.y, self.max.y),
                pick(4, self.min.z, self.max.z),
            ))
        })
    }

    /// Centre and unit normal of a flat box's plane in world space; the normal's sign is arbitrary.
    pub fn plane(&self) -> Option<(Vec3, Vec3)> {
        let axis = flat_axis(self.min, self.max)?;
        let across = |axis: usize| self.world_from_mesh.matrix3.col(axis % 3);
        let normal = Vec3::from(across(axis + 1).cross(across(axis + 2))).try_normalize()?;
        Some((self.world_from_mesh.transform_point3(0.5 * (self.min + self.max)), normal))
    }

    /// Whether `other` lies on the side of this flat box's plane to which `towards` points, within `tolerance` [m], or has sunk into
    /// it from there, which nobody sees who looks at that side.
    pub fn bears(&self, other: &Self, towards: Vec3, tolerance: f32) -> bool {
        let Some((center, normal)) = self.plane() else { return false };
        let up = normal * normal.dot(towards).signum();
        let heights = other.corners().map(|corner| (corner - center).dot(up));
        let (low, high) =
            heights.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), h| (low.min(h), high.max(h)));
        low >= -tolerance || (low >= -SUNKEN * high && self.spans(other))
    }

    /// Whether the other box, seen along this flat box's normal, lies within it.
    fn spans(&self, other: &Self) -> bool {
        let Some(flat) = flat_axis(self.min, self.max) else { return false };
        let mesh_from_world = self.world_from_mesh.inverse();
        other.corners().all(|corner| {
            let p = mesh_from_world.transform_point3(corner);
            (0..3)
                .filter(|&axis| axis != flat)
                .all(|axis| (self.min[axis]..=self.max[axis]).contains(&p[axis]))
        })
    }
}

/// The axis along which a box is flat while it has an area across it.
fn flat_axis(min: Vec3, max: Vec3) -> Option<usize> {
    let size = max - min;
    let thin = FLAT * size.max_element();
    let axis = (0..3).find(|&axis| size[axis] <= thin)?;
    (size[(axis + 1) % 3] > thin && size[(axis + 2) % 3] > thin).then_some(axis)
}

/// Boxes of a mesh: one for each flat connected part at least half as large as the mesh, such as a ground, and one for all the
/// rest. A ground that is part of its model's mesh then is still known as one.
pub(crate) fn mesh_boxes(mesh: &Mesh) -> Vec<(Vec3, Vec3)> {
    let parts = connected_parts(mesh);
    let whole = parts.iter().copied().reduce(united);
    let Some((min, max)) = whole else { return Vec::new() };
    let large = 0.5 * (max - min).max_element();
    let (mut boxes, others): (Vec<_>, Vec<_>) = parts
        .into_iter()
        .partition(|&(min, max)| flat_axis(min, max).is_some() && (max - min).max_element() >= large);
    boxes.extend(others.into_iter().reduce(united));
    boxes
}

fn united(a: (Vec3, Vec3), b: (Vec3, Vec3)) -> (Vec3, Vec3) {
    (a.0.min(b.0), a.1.max(b.1))
}

/// Boxes of the parts of a mesh whose triangles hang together. Vertices at the same place count as one: loaders split them
/// for their normals.
fn connected_parts(mesh: &Mesh) -> Vec<(Vec3, Vec3)> {
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
    let mut parts: BTreeMap<usize, (Vec3, Vec3)> = BTreeMap::new();
    for &vertex in mesh.triangles.iter().flatten() {
        let p = mesh.positions[vertex as usize];
        let part = parts.entry(root_of(&mut parents, vertex as usize)).or_insert((p, p));
        *part = united(*part, (p, p));
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
        let boxes = mesh_boxes(&ground_and_model());
        assert_eq!(boxes, [(Vec3::new(-4.0, 0.0, -4.0), Vec3::new(4.0, 0.0, 4.0)), (Vec3::ZERO, Vec3::ONE)]);
    }

    #[test]
    fn only_a_flat_box_with_an_area_has_a_plane() {
        let place = Affine3A::from_rotation_x(std::f32::consts::FRAC_PI_2);
        let flat = |max| InstanceBox { min: Vec3::ZERO, max, instance: 0, world_from_mesh: place };
        let (center, normal) = flat(Vec3::new(2.0, 0.0, 2.0)).plane().unwrap();
        assert!(center.abs_diff_eq(Vec3::new(1.0, -1.0, 0.0), 1e-6) && normal.z.abs() > 0.999);
        assert!(flat(Vec3::new(2.0, 1.0, 2.0)).plane().is_none());
        assert!(flat(Vec3::new(2.0, 0.0, 0.0)).plane().is_none());
        assert!(flat(Vec3::ZERO).plane().is_none());
    }

    /// An axis-aligned box at its place.
    fn placed(min: Vec3, max: Vec3) -> InstanceBox {
        InstanceBox { min, max, instance: 0, world_from_mesh: Affine3A::IDENTITY }
    }

    #[test]
    fn a_ground_bears_what_has_sunk_into_it_a_little() {
        let p = Vec3::new;
        let ground = placed(p(-4.0, 0.0, -4.0), p(4.0, 0.0, 4.0));
        let model = |depth: f32| placed(p(-1.0, -depth, -1.0), p(1.0, 2.0, 1.0));
        assert!(ground.bears(&model(0.0), Vec3::Y, 1e-4) && !ground.bears(&model(0.0), -Vec3::Y, 1e-4));
        assert!(ground.bears(&model(0.2), Vec3::Y, 1e-4));
        assert!(!ground.bears(&model(0.5), Vec3::Y, 1e-4));
        // The other way round it hangs from a ceiling.
        let hanging = placed(p(-1.0, -2.0, -1.0), p(1.0, 0.2, 1.0));
        assert!(ground.bears(&hanging, -Vec3::Y, 1e-4) && !ground.bears(&hanging, Vec3::Y, 1e-4));
        // A table top in a high room: what is lower lies beside it and is in its shadow.
        let room = placed(p(-8.0, -0.4, -8.0), p(8.0, 6.0, 8.0));
        assert!(!ground.bears(&room, Vec3::Y, 1e-4));
        let floor = placed(p(-8.0, -0.4, -8.0), p(8.0, -0.4, 8.0));
        assert!(!ground.bears(&floor, Vec3::Y, 1e-4));
    }

    #[test]
    fn a_mesh_without_triangles_has_no_box() {
        assert!(mesh_boxes(&Mesh::default()).is_empty());
    }
}
