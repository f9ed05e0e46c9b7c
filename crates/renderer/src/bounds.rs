//! Boxes around what casts and receives shadows.

use glam::{Affine3A, Vec3};
use gnomon_scene::{Bounds, SUNKEN};

/// What lies so far on the other side of a plane lies in it, as a share of the longest side of the box around everything.
const IN_PLANE: f32 = 1e-4;

/// Box around some triangles of an instance, in its mesh's space.
#[derive(Clone, Debug)]
pub(crate) struct InstanceBox {
    pub bounds: Bounds,
    pub instance: usize,
    pub world_from_mesh: Affine3A,
}

impl InstanceBox {
    /// The eight corners in world space.
    pub fn corners(&self) -> [Vec3; 8] {
        self.bounds.corners().map(|corner| self.world_from_mesh.transform_point3(corner))
    }

    /// Centre and unit normal of a flat box's plane in world space; the normal's sign is arbitrary.
    fn plane(&self) -> Option<(Vec3, Vec3)> {
        let axis = self.bounds.flat_axis()?;
        let across = |axis: usize| self.world_from_mesh.matrix3.col(axis % 3);
        let normal = Vec3::from(across(axis + 1).cross(across(axis + 2))).try_normalize()?;
        Some((self.world_from_mesh.transform_point3(self.bounds.center()), normal))
    }

    /// Whether the other box, seen along this flat box's normal, lies within it.
    fn spans(&self, other: &[Vec3; 8]) -> bool {
        let Some(flat) = self.bounds.flat_axis() else { return false };
        let mesh_from_world = self.world_from_mesh.inverse();
        other.iter().all(|corner| {
            let p = mesh_from_world.transform_point3(*corner);
            (0..3)
                .filter(|&axis| axis != flat)
                .all(|axis| (self.bounds.min[axis]..=self.bounds.max[axis]).contains(&p[axis]))
        })
    }
}

/// The boxes of a pose in world space, as shadow maps are fitted around them.
#[derive(Clone, Debug, Default)]
pub(crate) struct PlacedBoxes {
    pub boxes: Vec<PlacedBox>,
    /// What is no farther from a plane lies in it [m].
    pub tolerance: f32,
}

#[derive(Clone, Debug)]
pub(crate) struct PlacedBox {
    pub corners: [Vec3; 8],
    /// Where it is flat and everything else lies on one side of it.
    pub ground: Option<Ground>,
}

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
    /// Whether everything else lies on the side to which `towards` points, or has sunk into the plane from there, which nobody sees
    /// who looks at that side.
    pub fn bears_towards(&self, towards: Vec3) -> bool {
        self.bears[usize::from(self.normal.dot(towards) < 0.0)]
    }
}

impl PlacedBoxes {
    pub fn new(boxes: &[InstanceBox]) -> Self {
        let corners: Vec<[Vec3; 8]> = boxes.iter().map(InstanceBox::corners).collect();
        let around = Bounds::around(corners.iter().flatten().copied());
        let tolerance = IN_PLANE * around.map_or(0.0, |around| (around.max - around.min).max_element());
        let ground = |index: usize| {
            let place = &boxes[index];
            // One that is alone bears nothing.
            let (center, normal) = place.plane().filter(|_| boxes.len() > 1)?;
            let bears = [normal, -normal].map(|up| {
                let mut others = corners.iter().enumerate().filter(|(other, _)| *other != index);
                others.all(|(_, other)| {
                    let (low, high) = heights(other, center, up);
                    low >= -tolerance || (low >= -SUNKEN * high && place.spans(other))
                })
            });
            bears.contains(&true).then_some(Ground { center, normal, bears })
        };
        let placed =
            |(index, corners): (usize, &[Vec3; 8])| PlacedBox { corners: *corners, ground: ground(index) };
        Self { boxes: corners.iter().enumerate().map(placed).collect(), tolerance }
    }

    pub fn corners(&self) -> impl Iterator<Item = Vec3> + '_ {
        self.boxes.iter().flat_map(|place| place.corners)
    }
}

/// Least and greatest height of points above a plane.
fn heights(points: &[Vec3; 8], center: Vec3, up: Vec3) -> (f32, f32) {
    let heights = points.iter().map(|point| (*point - center).dot(up));
    heights.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), h| (low.min(h), high.max(h)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_flat_box_with_an_area_has_a_plane() {
        let place = Affine3A::from_rotation_x(std::f32::consts::FRAC_PI_2);
        let flat = |max| InstanceBox {
            bounds: Bounds { min: Vec3::ZERO, max },
            instance: 0,
            world_from_mesh: place,
        };
        let (center, normal) = flat(Vec3::new(2.0, 0.0, 2.0)).plane().unwrap();
        assert!(center.abs_diff_eq(Vec3::new(1.0, -1.0, 0.0), 1e-6) && normal.z.abs() > 0.999);
        assert!(flat(Vec3::new(2.0, 1.0, 2.0)).plane().is_none());
        assert!(flat(Vec3::new(2.0, 0.0, 0.0)).plane().is_none());
        assert!(flat(Vec3::ZERO).plane().is_none());
    }

    /// An axis-aligned box at its place.
    fn placed(min: Vec3, max: Vec3) -> InstanceBox {
        InstanceBox { bounds: Bounds { min, max }, instance: 0, world_from_mesh: Affine3A::IDENTITY }
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
