//! Flat parts that bear everything else: what lies on them receives shadows without a place in the map.

use glam::Vec3;
use gnomon_lights::{DistantLight, LightShape};
use gnomon_scene::SUNKEN;

use crate::casters::InstanceBox;

/// Plane of a flat box that has everything else on one side.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ground {
    pub center: Vec3,
    /// Unit, of any sign.
    pub normal: Vec3,
    /// Whether everything else lies where the normal points to, and on the other side; both if it lies in the plane.
    bears: [bool; 2],
}

impl Ground {
    /// The plane of a flat box, the one at `index` of `all_corners`, that bears the others.
    pub fn of(place: &InstanceBox, index: usize, all_corners: &[[Vec3; 8]], tolerance: f32) -> Option<Self> {
        // One that is alone bears nothing.
        let (center, normal) = plane(place).filter(|_| all_corners.len() > 1)?;
        let bears = [normal, -normal].map(|up| {
            let mut others = all_corners.iter().enumerate().filter(|(other, _)| *other != index);
            others.all(|(_, other)| {
                let (low, high) = heights(other, center, up);
                low >= -tolerance || (low >= -SUNKEN * high && spans(place, other))
            })
        });
        bears.contains(&true).then_some(Self { center, normal, bears })
    }

    /// Whether everything else lies on the side to which `towards` points, or has sunk into the plane from there, which nobody sees
    /// who looks at that side.
    pub fn bears_towards(&self, towards: Vec3) -> bool {
        self.bears[usize::from(self.normal.dot(towards) < 0.0)]
    }

    /// Whether it blocks no part of the light for what it bears: all of the outline lies on that side.
    pub fn blocks_nothing_of(&self, light: &DistantLight) -> bool {
        let up = self.normal * self.normal.dot(light.direction).signum();
        let is_above = match light.shape {
            LightShape::Disk { angular_radius } => {
                up.dot(light.direction).clamp(-1.0, 1.0).asin() > angular_radius
            }
            LightShape::Rectangle { corners } => corners.iter().all(|corner| up.dot(*corner) > 0.0),
        };
        is_above && self.bears_towards(light.direction)
    }
}

/// Centre and unit normal of a flat box's plane in world space; the normal's sign is arbitrary.
fn plane(place: &InstanceBox) -> Option<(Vec3, Vec3)> {
    let axis = place.bounds.flat_axis()?;
    let across = |axis: usize| place.world_from_mesh.matrix3.col(axis % 3);
    let normal = Vec3::from(across(axis + 1).cross(across(axis + 2))).try_normalize()?;
    Some((place.world_from_mesh.transform_point3(place.bounds.center()), normal))
}

/// Whether the other box, seen along this flat box's normal, lies within it.
fn spans(place: &InstanceBox, other: &[Vec3; 8]) -> bool {
    let Some(flat) = place.bounds.flat_axis() else { return false };
    let mesh_from_world = place.world_from_mesh.inverse();
    other.iter().all(|corner| {
        let p = mesh_from_world.transform_point3(*corner);
        (0..3)
            .filter(|&axis| axis != flat)
            .all(|axis| (place.bounds.min[axis]..=place.bounds.max[axis]).contains(&p[axis]))
    })
}

/// Least and greatest height of points above a plane.
fn heights(points: &[Vec3; 8], center: Vec3, up: Vec3) -> (f32, f32) {
    let heights = points.iter().map(|point| (*point - center).dot(up));
    heights.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), h| (low.min(h), high.max(h)))
}

#[cfg(test)]
mod tests {
    use glam::Affine3A;
    use gnomon_scene::Bounds;

    use super::*;
    use crate::casters::PlacedBoxes;
    use crate::casters::tests::placed;

    #[test]
    fn only_a_flat_box_with_an_area_has_a_plane() {
        let place = Affine3A::from_rotation_x(std::f32::consts::FRAC_PI_2);
        let flat = |max| InstanceBox {
            bounds: Bounds { min: Vec3::ZERO, max },
            indices: None,
            simpler: Vec::new(),
            instance: 0,
            placement: 0,
            world_from_mesh: place,
            casts: true,
        };
        let (center, normal) = plane(&flat(Vec3::new(2.0, 0.0, 2.0))).unwrap();
        assert!(center.abs_diff_eq(Vec3::new(1.0, -1.0, 0.0), 1e-6) && normal.z.abs() > 0.999);
        assert!(plane(&flat(Vec3::new(2.0, 1.0, 2.0))).is_none());
        assert!(plane(&flat(Vec3::new(2.0, 0.0, 0.0))).is_none());
        assert!(plane(&flat(Vec3::ZERO)).is_none());
    }

    /// Whether the first of both bears the other, up and down.
    fn bears(ground: &InstanceBox, other: InstanceBox) -> [bool; 2] {
        let placed = PlacedBoxes::new(&[ground.clone(), other]);
        [Vec3::Y, Vec3::NEG_Y].map(|up| placed.boxes[0].ground.is_some_and(|ground| ground.bears_towards(up)))
    }

    #[test]
    fn a_ground_bears_what_has_sunk_into_it_a_little() {
        let p = Vec3::new;
        let ground = placed(p(-4.0, 0.0, -4.0), p(4.0, 0.0, 4.0));
        let model = |depth: f32| placed(p(-1.0, -depth, -1.0), p(1.0, 2.0, 1.0));
        assert_eq!(bears(&ground, model(0.0)), [true, false]);
        assert_eq!(bears(&ground, model(0.2)), [true, false]);
        assert_eq!(bears(&ground, model(0.5)), [false, false]);
        // The other way round it hangs from a ceiling.
        assert_eq!(bears(&ground, placed(p(-1.0, -2.0, -1.0), p(1.0, 0.2, 1.0))), [false, true]);
        // A table top in a high room: what is lower lies beside it and is in its shadow.
        assert_eq!(bears(&ground, placed(p(-8.0, -0.4, -8.0), p(8.0, 6.0, 8.0))), [false, false]);
        assert_eq!(bears(&ground, placed(p(-8.0, -0.4, -8.0), p(8.0, -0.4, 8.0))), [false, true]);
        assert_eq!(bears(&ground, placed(p(5.0, 0.0, 5.0), p(6.0, 0.0, 6.0))), [true, true]);
        assert!(PlacedBoxes::new(&[ground]).boxes[0].ground.is_none());
    }
}
