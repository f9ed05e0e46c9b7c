use glam::{Vec3, Vec4};

/// The tangent frame of a surface point: three perpendicular unit vectors in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Tangent, the local x: along u of the texture where the mesh has tangents, else any direction.
    pub t: Vec3,
    /// Bitangent, the local y. It is that of the mesh from both sides, so that a frame seen from behind is left-handed.
    pub b: Vec3,
    /// Shading normal, the local z.
    pub n: Vec3,
}

impl Frame {
    /// Some frame about a unit normal (Duff et al. 2017).
    pub fn from_normal(n: Vec3) -> Self {
        let (t, b) = n.any_orthonormal_pair();
        Self { t, b, n }
    }

    /// The frame about a unit normal whose tangent lies nearest to a mesh's, with the bitangent's sign in w: `b = w n x t`. Any frame
    /// where that tangent is zero or along the normal.
    pub fn from_tangent(n: Vec3, tangent: Vec4) -> Self {
        let across = tangent.truncate() - n * n.dot(tangent.truncate());
        let length2 = across.length_squared();
        if length2 <= MIN_LENGTH2 * tangent.truncate().length_squared() {
            return Self::from_normal(n);
        }
        // What little is left of a tangent along the normal is rounding for the most part: once more makes it perpendicular.
        let t = (across - n * n.dot(across)).normalize();
        Self { t, b: n.cross(t) * if tangent.w < 0.0 { -1.0 } else { 1.0 }, n }
    }

    /// A world vector in the frame.
    pub fn local_from_world(&self, world: Vec3) -> Vec3 {
        Vec3::new(world.dot(self.t), world.dot(self.b), world.dot(self.n))
    }

    /// Inverse of [`Frame::local_from_world`].
    pub fn world_from_local(&self, local: Vec3) -> Vec3 {
        self.t * local.x + self.b * local.y + self.n * local.z
    }
}

/// Squared sine of the angle between tangent and normal below which the tangent's direction is rounding.
const MIN_LENGTH2: f32 = 1e-8;

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn vector() -> impl Strategy<Value = Vec3> {
        prop::array::uniform3(-1f32..1.0).prop_map(Vec3::from)
    }

    #[test]
    fn a_tangent_almost_along_the_normal_makes_a_frame() {
        let n = Vec3::new(-0.117_635_59, 0.897_659_9, 0.735_486_3).normalize();
        let frame = Frame::from_tangent(n, Vec3::new(0.123_113_126, -0.850_625_6, -0.705_025).extend(1.0));
        assert!(frame.t.dot(n).abs() < 1e-6 && (frame.t.length() - 1.0).abs() < 1e-6, "{frame:?}");
    }

    proptest! {
        #[test]
        fn frames_are_orthonormal_and_inverse(n in vector(), tangent in vector(), mirrored: bool, d in vector()) {
            prop_assume!(n.length() > 0.01);
            let n = n.normalize();
            let sign = if mirrored { -1.0 } else { 1.0 };
            for frame in [Frame::from_normal(n), Frame::from_tangent(n, tangent.extend(sign))] {
                prop_assert!(frame.local_from_world(frame.world_from_local(d)).distance(d) < 1e-5);
                prop_assert!((frame.local_from_world(d).length() - d.length()).abs() < 1e-5);
                prop_assert!(frame.world_from_local(Vec3::Z).distance(n) < 1e-6);
            }
            let frame = Frame::from_tangent(n, tangent.extend(sign));
            if n.cross(tangent).length() > 1e-3 {
                prop_assert!(frame.t.dot(tangent) > 0.0 && frame.n.cross(frame.t).dot(frame.b) * sign > 0.999);
            }
        }
    }

    #[test]
    fn a_tangent_along_the_normal_gives_any_frame() {
        for tangent in [Vec3::ZERO, Vec3::Y, -3.0 * Vec3::Y] {
            assert_eq!(Frame::from_tangent(Vec3::Y, tangent.extend(1.0)), Frame::from_normal(Vec3::Y));
        }
    }
}
