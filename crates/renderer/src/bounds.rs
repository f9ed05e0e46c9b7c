//! Boxes around what casts and receives shadows.

use glam::{Affine3A, Vec3};
use gnomon_scene::Bounds;

/// Share of its height over a ground by which a model may have sunk into it and still stands on it: feet of a walking model do,
/// and boxes around bent meshes are larger than these.
const SUNKEN: f32 = 0.15;

/// Box around some triangles of an instance, in its mesh's space.
#[derive(Clone, Debug)]
pub(crate) struct InstanceBox {
    pub bounds: Bounds,
    pub instance: usize,
    pub world_from_mesh: Affine3A,
}

impl InstanceBox {
    /// The eight corners in world space.
    pub fn corners(&self) -> impl Iterator<Item = Vec3> + '_ {
        self.bounds.corners().map(|corner| self.world_from_mesh.transform_point3(corner))
    }

    /// Centre and unit normal of a flat box's plane in world space; the normal's sign is arbitrary.
    pub fn plane(&self) -> Option<(Vec3, Vec3)> {
        let axis = self.bounds.flat_axis()?;
        let across = |axis: usize| self.world_from_mesh.matrix3.col(axis % 3);
        let normal = Vec3::from(across(axis + 1).cross(across(axis + 2))).try_normalize()?;
        Some((self.world_from_mesh.transform_point3(self.bounds.center()), normal))
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
        let Some(flat) = self.bounds.flat_axis() else { return false };
        let mesh_from_world = self.world_from_mesh.inverse();
        other.corners().all(|corner| {
            let p = mesh_from_world.transform_point3(corner);
            (0..3)
                .filter(|&axis| axis != flat)
                .all(|axis| (self.bounds.min[axis]..=self.bounds.max[axis]).contains(&p[axis]))
        })
    }
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
}
