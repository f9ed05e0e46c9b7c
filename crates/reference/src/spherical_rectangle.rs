use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

/// A rectangle projected onto the unit sphere about the origin, sampled uniformly in solid angle (Urena, Fajardo and King 2013, "An
/// area-preserving parametrization for spherical rectangles").
pub(crate) struct SphericalRectangle {
    axes: [DVec3; 3],
    /// Near corner and far corner along the axes; `z` is negative.
    min: DVec2,
    max: DVec2,
    z: f64,
    solid_angle: f64,
    b0: f64,
    b1: f64,
    k: f64,
}

impl SphericalRectangle {
    /// The rectangle from `corner` along two perpendicular unit `axes` by `size`. The origin is not in its plane.
    pub(crate) fn new(corner: DVec3, size: DVec2, axes: [DVec3; 2]) -> Self {
        let [x_axis, y_axis] = axes;
        let mut z_axis = x_axis.cross(y_axis);
        let mut z = corner.dot(z_axis);
        if z > 0.0 {
            (z_axis, z) = (-z_axis, -z);
        }
        let min = DVec2::new(corner.dot(x_axis), corner.dot(y_axis));
        let max = min + size;
        // Normals of the planes through the origin and the sides; each lies in a coordinate plane.
        let across = |y: f64| DVec2::new(z, y).normalize();
        let (bottom, top) = (across(min.y), across(max.y));
        let (left, right) = (across(min.x), across(max.x));
        // n0 = (0, z, -y0), n1 = (-z, 0, x1), n2 = (0, -z, y1), n3 = (z, 0, -x0), each over its length.
        let angle = |cosine: f64| (-cosine).clamp(-1.0, 1.0).acos();
        let g0 = angle(-bottom.y * right.y);
        let g1 = angle(right.y * top.y);
        let g2 = angle(-top.y * left.y);
        let g3 = angle(left.y * bottom.y);
        let k = TAU - g2 - g3;
        Self {
            axes: [x_axis, y_axis, z_axis],
            min,
            max,
            z,
            solid_angle: g0 + g1 - k,
            b0: -bottom.y,
            b1: top.y,
            k,
        }
    }

    /// [sr]
    pub(crate) fn solid_angle(&self) -> f64 {
        self.solid_angle
    }

    /// A point of the rectangle, relative to the origin.
    pub(crate) fn sample(&self, u: DVec2) -> DVec3 {
        let &Self { min, max, z, b0, b1, .. } = self;
        let (sin, cos) = (u.x * self.solid_angle + self.k).sin_cos();
        let f = (cos * b0 - b1) / sin;
        let c = (1.0 / (f * f + b0 * b0).sqrt()).copysign(f).clamp(-1.0, 1.0);
        let x = (-(c * z) / (1.0 - c * c).max(f64::MIN_POSITIVE).sqrt()).clamp(min.x, max.x);
        let d2 = x * x + z * z;
        let [h0, h1] = [min.y, max.y].map(|y| y / (d2 + y * y).sqrt());
        let h = h0 + u.y * (h1 - h0);
        let y = (h * d2.sqrt() / (1.0 - h * h).max(f64::MIN_POSITIVE).sqrt()).clamp(min.y, max.y);
        self.axes[0] * x + self.axes[1] * y + self.axes[2] * z
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::{Decision, Sequence};

    /// Antiderivative `atan(x y / (z sqrt(x^2 + y^2 + z^2)))` at the four corners.
    fn closed_form(min: DVec2, max: DVec2, z: f64) -> f64 {
        let corner = |x: f64, y: f64| (x * y / (z * (x * x + y * y + z * z).sqrt())).atan();
        corner(max.x, max.y) - corner(min.x, max.y) - corner(max.x, min.y) + corner(min.x, min.y)
    }

    #[test]
    fn solid_angles_and_shares_have_their_closed_form() {
        let sequence = Sequence::new(2, 0, 0);
        for (min, size, z) in [
            (DVec2::new(-1.0, -1.0), DVec2::splat(2.0), 1.0),
            (DVec2::new(0.5, -3.0), DVec2::new(2.0, 1.0), 0.3),
            (DVec2::new(-0.2, 0.1), DVec2::new(5.0, 0.02), 2.0),
            (DVec2::new(-1.0, -1.0), DVec2::new(3.0, 2.0), 1e-3),
        ] {
            for side in [1.0, -1.0] {
                let corner = min.extend(side * z);
                let rectangle = SphericalRectangle::new(corner, size, [DVec3::X, DVec3::Y]);
                let expected = closed_form(min, min + size, z);
                assert!((rectangle.solid_angle() / expected - 1.0).abs() < 1e-9, "{min} {size} {z}");
                // Shares of the samples in a quarter of the rectangle.
                let (middle, count) = (min + 0.5 * size, 1 << 12);
                let mut inside = 0;
                for index in 0..count {
                    let p = rectangle.sample(sequence.pair(index, Decision::Direction));
                    assert!((p.z - side * z).abs() < 1e-12 && p.truncate().cmpge(min - 1e-9).all());
                    assert!(p.truncate().cmple(min + size + 1e-9).all());
                    inside += u32::from(p.truncate().cmplt(middle).all());
                }
                let share = closed_form(min, middle, z) / expected;
                let found = f64::from(inside) / f64::from(count);
                assert!((found - share).abs() < 5e-3, "{min} {size} {z}: {found} {share}");
            }
        }
    }
}
