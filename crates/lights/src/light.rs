use glam::{DVec2, DVec3, Quat, Vec2, Vec3};

use crate::form_factor::{disk_form_factor, rectangle_form_factor, rectangle_vector_irradiance};

/// Outline of a distant light on the plane that touches the unit sphere at the light's centre direction (gnomonic
/// projection), in the light's own `tangent` and `bitangent`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightShape {
    /// All directions within `angular_radius` [rad] of the centre.
    Disk {
        /// Half the apex angle of the cone [rad], in (0, pi/2).
        angular_radius: f32,
    },
    /// A convex quadrilateral, counter-clockwise seen from the scene: the four corners as unit directions.
    Rectangle {
        /// Corner directions (unit). A rectangle on a cube face seen from its own centre is this quadrilateral.
        corners: [Vec3; 4],
    },
}

/// A uniform area light infinitely far away.
#[derive(Clone, Debug, PartialEq)]
pub struct DistantLight {
    /// Unit direction from the scene towards the light's centre. For a rectangle on a cube face this halves the angle
    /// between opposite sides along both face axes, so that the outline's bounding box on the tangent plane is nearly
    /// symmetric.
    pub direction: Vec3,
    /// Unit direction, perpendicular to `direction`: the first axis of the light's plane.
    pub tangent: Vec3,
    /// `direction x tangent`: the second axis.
    pub bitangent: Vec3,
    /// Outline.
    pub shape: LightShape,
    /// Exact solid angle of the outline [sr].
    pub solid_angle: f32,
    /// Radiance, uniform over the outline; linear Rec. 709.
    pub radiance: Vec3,
}

impl DistantLight {
    /// A disk around the unit `direction`: all directions within `angular_radius` [rad], in (0, pi/2), with the given
    /// flux [radiance x sr] spread evenly over the solid angle `2 pi (1 - cos angular_radius)`.
    pub fn disk(direction: DVec3, angular_radius: f64, flux: DVec3) -> Self {
        let shape = LightShape::Disk { angular_radius: angular_radius as f32 };
        Self::with_flux(direction, horizontal(direction), shape, disk_solid_angle(angular_radius), flux)
    }

    /// A disk of this radiance around the unit `direction`: all directions within `angular_radius` [rad], in (0, pi/2). Its tangent is the
    /// part of `along` across `direction`, or horizontal where there is none.
    pub fn around(direction: Vec3, along: Vec3, angular_radius: f32, radiance: Vec3) -> Self {
        let tangent = across(along, direction);
        Self {
            direction,
            tangent,
            bitangent: direction.cross(tangent),
            shape: LightShape::Disk { angular_radius },
            solid_angle: disk_solid_angle(angular_radius.into()) as f32,
            radiance,
        }
    }

    /// A light of this radiance with its outline on the plane that touches the unit sphere at the unit `direction`: the corners of a convex
    /// quadrilateral in turn, along tangent and bitangent. The tangent is the part of `along` across `direction`, or horizontal where there
    /// is none. `None` where the corners are not those of a convex quadrilateral with an inside.
    pub fn quadrilateral(
        direction: Vec3,
        along: Vec3,
        mut corners: [Vec2; 4],
        radiance: Vec3,
    ) -> Option<Self> {
        let tangent = across(along, direction);
        let bitangent = direction.cross(tangent);
        let turn = |i: usize| {
            let [a, b, c] = [i, i + 1, i + 2].map(|corner| corners[corner % 4]);
            (b - a).perp_dot(c - b)
        };
        let turns: [f32; 4] = std::array::from_fn(turn);
        // `tangent x bitangent` points away from the scene.
        if turns.iter().all(|turn| *turn > 0.0) {
            corners.reverse();
        } else if !turns.iter().all(|turn| *turn < 0.0) {
            return None;
        }
        let corners = corners.map(|at| (direction + at.x * tangent + at.y * bitangent).normalize());
        let solid_angle = (triangle_solid_angle([corners[0], corners[1], corners[2]])
            + triangle_solid_angle([corners[0], corners[2], corners[3]])) as f32;
        let light = Self {
            direction,
            tangent,
            bitangent,
            shape: LightShape::Rectangle { corners },
            solid_angle,
            radiance,
        };
        (solid_angle > 0.0 && solid_angle.is_finite()).then_some(light)
    }

    /// The directions `forward + s right + t up` with `(s, t)` between `min` and `max`, where `frame` holds the unit axes
    /// `[right, up, forward]` of a cube face seen from inside (`right = forward x up`) and the whole face is
    /// `[-1, 1]^2`; the given flux [radiance x sr] is spread evenly over the exact solid angle.
    pub fn rectangle(frame: [DVec3; 3], min: DVec2, max: DVec2, flux: DVec3) -> Self {
        let [right, up, forward] = frame;
        let towards = |s: f64, t: f64| (forward + s * right + t * up).normalize();
        let halfway = |a: f64, b: f64| (0.5 * (a.atan() + b.atan())).tan();
        let direction = towards(halfway(min.x, max.x), halfway(min.y, max.y));
        let tangent = (right - direction * right.dot(direction)).normalize();
        let corners =
            [towards(min.x, min.y), towards(max.x, min.y), towards(max.x, max.y), towards(min.x, max.y)];
        let shape = LightShape::Rectangle { corners: corners.map(|corner| corner.as_vec3()) };
        Self::with_flux(direction, tangent, shape, rectangle_solid_angle(min, max), flux)
    }

    fn with_flux(direction: DVec3, tangent: DVec3, shape: LightShape, solid_angle: f64, flux: DVec3) -> Self {
        // Radiance from the *rounded* solid angle, so that their product gives the flux back.
        let solid_angle = solid_angle as f32;
        let radiance = (flux / f64::from(solid_angle)).min(DVec3::splat(f64::from(f32::MAX)));
        Self {
            direction: direction.as_vec3(),
            tangent: tangent.as_vec3(),
            bitangent: direction.cross(tangent).as_vec3(),
            shape,
            solid_angle,
            radiance: radiance.as_vec3(),
        }
    }

    /// Flux [radiance x sr], channel by channel.
    pub fn flux(&self) -> DVec3 {
        self.radiance.as_dvec3() * f64::from(self.solid_angle)
    }

    /// Projected solid angle [sr] seen by a surface with unit normal `n`: the exact integral of `max(0, n . w) dw` over
    /// the outline. Times [`DistantLight::radiance`] it is the unshadowed irradiance.
    pub fn irradiance(&self, n: Vec3) -> f32 {
        match self.shape {
            LightShape::Disk { angular_radius } => disk_form_factor(n, self.direction, angular_radius),
            LightShape::Rectangle { corners } => rectangle_form_factor(n, corners),
        }
    }

    /// Vector irradiance [sr] at radiance 1: its product with a unit normal that has the whole light above its horizon is
    /// [`DistantLight::irradiance`]. A light without size that comes from there lights such surfaces alike.
    pub fn vector_irradiance(&self) -> Vec3 {
        match self.shape {
            LightShape::Disk { angular_radius } => {
                let sine = angular_radius.sin();
                std::f32::consts::PI * sine * sine * self.direction
            }
            LightShape::Rectangle { corners } => rectangle_vector_irradiance(corners),
        }
    }

    /// Corners of a rectangle on the plane that touches the unit sphere at its centre, along `tangent` and `bitangent`; none of a disk.
    pub fn plane_corners(&self) -> Option<[Vec2; 4]> {
        let LightShape::Rectangle { corners } = self.shape else { return None };
        Some(corners.map(|corner| {
            Vec2::new(corner.dot(self.tangent), corner.dot(self.bitangent)) / corner.dot(self.direction)
        }))
    }

    /// Full angular width and height [rad] along `tangent` and `bitangent`, through the centre.
    pub fn extent(&self) -> Vec2 {
        let half = self.tan_half_extent();
        Vec2::new(2.0 * half.x.atan(), 2.0 * half.y.atan())
    }

    /// Half the width and height of the outline's bounding box on the tangent plane (tangents of half angles).
    pub fn tan_half_extent(&self) -> Vec2 {
        match self.shape {
            LightShape::Disk { angular_radius } => Vec2::splat(angular_radius.tan()),
            LightShape::Rectangle { .. } => {
                let corners = self.plane_corners().unwrap_or_default();
                corners.map(Vec2::abs).into_iter().fold(Vec2::ZERO, Vec2::max)
            }
        }
    }

    /// Whether the unit direction `w` meets the light.
    pub fn contains(&self, w: Vec3) -> bool {
        self.signed_angle(w) <= 0.0
    }

    /// How far the unit direction `w` lies outside the outline [rad]; negative inside. For a rectangle outside, the
    /// distance to the farthest of the four edges' great circles: a lower bound near corners.
    pub fn signed_angle(&self, w: Vec3) -> f32 {
        match self.shape {
            LightShape::Disk { angular_radius } => {
                w.cross(self.direction).length().atan2(w.dot(self.direction)) - angular_radius
            }
            LightShape::Rectangle { corners } => (0..4)
                .map(|i| {
                    corners[i].cross(corners[(i + 1) % 4]).normalize_or_zero().dot(w).clamp(-1.0, 1.0).asin()
                })
                .fold(f32::NEG_INFINITY, f32::max),
        }
    }

    /// The same light with its radiance multiplied, channel by channel.
    pub fn times(&self, factor: Vec3) -> Self {
        Self { radiance: (self.radiance * factor).min(Vec3::MAX), ..self.clone() }
    }

    /// The same light turned about +y by `yaw` [rad], right-hand rule.
    pub fn rotated(&self, yaw: f32) -> Self {
        self.turned(Quat::from_rotation_y(yaw))
    }

    /// The same light with every direction `d` of it at `rotation * d`.
    pub fn turned(&self, rotation: Quat) -> Self {
        Self {
            direction: rotation * self.direction,
            tangent: rotation * self.tangent,
            bitangent: rotation * self.bitangent,
            shape: match self.shape {
                LightShape::Rectangle { corners } => {
                    LightShape::Rectangle { corners: corners.map(|corner| rotation * corner) }
                }
                disk @ LightShape::Disk { .. } => disk,
            },
            ..self.clone()
        }
    }
}

/// Solid angle [sr] of all directions within `angular_radius` [rad] of one: `2 pi (1 - cos)` without its cancellation.
fn disk_solid_angle(angular_radius: f64) -> f64 {
    let half_sine = (0.5 * angular_radius).sin();
    4.0 * std::f64::consts::PI * half_sine * half_sine
}

/// A unit direction across `direction`: horizontal where there is a horizon, so that a rotation about y turns the light's own axes with it.
fn horizontal(direction: DVec3) -> DVec3 {
    let horizontal = DVec3::Y.cross(direction);
    if horizontal.length_squared() > 1e-12 { horizontal.normalize() } else { DVec3::X }
}

/// The unit direction of the part of `along` across the unit `direction`, or a horizontal one where there is none.
fn across(along: Vec3, direction: Vec3) -> Vec3 {
    // As it is where it is across already, so that lights keep their axes to the last bit.
    if along.is_normalized() && along.dot(direction).abs() < 1e-6 {
        return along;
    }
    let part = along - direction * along.dot(direction);
    match part.length() > 1e-3 * along.length() {
        true => part.normalize(),
        false => horizontal(direction.as_dvec3()).as_vec3(),
    }
}

/// Solid angle [sr] of the spherical triangle between unit directions (Van Oosterom and Strackee 1983).
fn triangle_solid_angle(corners: [Vec3; 3]) -> f64 {
    let [a, b, c] = corners.map(|corner| corner.as_dvec3().normalize());
    let volume = (b - a).cross(c - a).dot(a).abs();
    2.0 * volume.atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a))
}

/// Solid angle [sr] of the rectangle from `min` to `max` on the plane at distance 1: the antiderivative
/// `atan(s t / sqrt(1 + s^2 + t^2))` at the four corners.
pub(crate) fn rectangle_solid_angle(min: DVec2, max: DVec2) -> f64 {
    let corner = |s: f64, t: f64| (s * t / (1.0 + s * s + t * t).sqrt()).atan();
    corner(max.x, max.y) - corner(min.x, max.y) - corner(max.x, min.y) + corner(min.x, min.y)
}

#[cfg(test)]
mod tests {
    use std::f32::consts::{FRAC_PI_2, PI};

    use super::*;

    const FRONT: [DVec3; 3] = [DVec3::X, DVec3::Y, DVec3::NEG_Z];

    #[test]
    fn a_whole_face_is_a_sixth_of_the_sphere() {
        let face = DistantLight::rectangle(FRONT, -DVec2::ONE, DVec2::ONE, DVec3::new(1.0, 2.0, 3.0));
        assert!((face.solid_angle - 4.0 * PI / 6.0).abs() < 1e-6);
        assert!((face.flux() - DVec3::new(1.0, 2.0, 3.0)).length() < 1e-6);
        assert!((face.tan_half_extent() - Vec2::ONE).length() < 1e-6);
        assert!((face.extent() - Vec2::splat(FRAC_PI_2)).length() < 1e-6);
    }

    #[test]
    fn corners_run_counter_clockwise_seen_from_the_origin() {
        let light = DistantLight::rectangle(FRONT, DVec2::new(-0.5, 0.1), DVec2::new(0.2, 0.9), DVec3::ONE);
        let LightShape::Rectangle { corners: [a, b, c, _] } = light.shape else { panic!("not a rectangle") };
        assert!((b - a).cross(c - b).dot(-light.direction) > 0.0);
        assert!((light.direction.cross(light.tangent) - light.bitangent).length() < 1e-6);
        assert!(light.contains(light.direction) && !light.contains(-light.direction));
    }

    #[test]
    fn a_quadrilateral_of_its_own_corners_is_the_light_again() {
        let light = DistantLight::rectangle(FRONT, DVec2::new(-0.5, 0.1), DVec2::new(0.2, 0.9), DVec3::ONE);
        let corners = light.plane_corners().unwrap();
        let mut reversed = corners;
        reversed.reverse();
        for corners in [corners, reversed] {
            let again =
                DistantLight::quadrilateral(light.direction, light.tangent, corners, light.radiance).unwrap();
            assert!((again.solid_angle / light.solid_angle - 1.0).abs() < 1e-5);
            for n in [Vec3::NEG_Z, Vec3::Y, Vec3::X] {
                assert!((again.irradiance(n) - light.irradiance(n)).abs() < 1e-5, "{n}");
            }
        }
    }

    #[test]
    fn vector_irradiance_lights_a_plane_as_the_light_does() {
        let rectangle =
            DistantLight::rectangle(FRONT, DVec2::new(-0.2, 0.1), DVec2::new(0.5, 0.4), DVec3::ONE);
        for light in [rectangle, DistantLight::disk(DVec3::NEG_Z, 0.4, DVec3::ONE)] {
            for n in [Vec3::NEG_Z, Vec3::new(0.3, 0.3, -0.9).normalize()] {
                assert!((light.vector_irradiance().dot(n) - light.irradiance(n)).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn a_quarter_turn_takes_minus_z_to_minus_x() {
        let light = DistantLight::disk(DVec3::NEG_Z, 0.1, DVec3::ONE).rotated(FRAC_PI_2);
        assert!((light.direction - Vec3::NEG_X).length() < 1e-6);
    }

    #[test]
    fn the_cone_keeps_its_solid_angle_when_tiny_and_when_wide() {
        let tiny = DistantLight::disk(DVec3::Y, 1e-4, DVec3::ONE);
        assert!((tiny.solid_angle / (PI * 1e-8) - 1.0).abs() < 1e-6);
        let hemisphere = DistantLight::disk(DVec3::Y, std::f64::consts::FRAC_PI_2, DVec3::ONE);
        assert!((hemisphere.solid_angle - 2.0 * PI).abs() < 1e-5);
    }
}
