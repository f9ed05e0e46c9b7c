//! A camera that turns around a point.

use std::f32::consts::{FRAC_PI_2, TAU};

use crate::{Bounds, Camera, Film, Projection};
use glam::{DVec3, Vec2, Vec3};

/// Highest tilt up and down [rad]: straight up has no direction to the side.
const MAX_PITCH: f32 = FRAC_PI_2 - 0.01;
/// Least and greatest distance from the point [m].
const DISTANCES: (f32, f32) = (1e-4, 1e6);

/// A view that can be turned, moved and brought nearer. It keeps +y up.
#[derive(Clone, Debug, PartialEq)]
pub struct Orbit {
    /// What it turns around, and looks at [m].
    target: Vec3,
    /// Direction from there to the eye: angle about +y from +z, and above the horizon [rad].
    yaw: f32,
    pitch: f32,
    /// From there to the eye [m].
    distance: f32,
    projection: Projection,
    film: Film,
    /// Of the space of all that ([`Camera::origin`]).
    origin: DVec3,
}

impl Orbit {
    /// Takes over a camera. It turns around what it looks at: the point of its axis that is nearest to the middle of `bounds`.
    pub fn from_camera(camera: &Camera, bounds: Option<Bounds>) -> Self {
        let eye = camera.eye();
        let back = camera.world_from_camera.z_axis.truncate().try_normalize().unwrap_or(Vec3::Z);
        let (center, radius) = bounds.map_or((Vec3::ZERO, 1.0), |b| (b.center(), b.radius()));
        let least = (0.05 * radius).clamp(DISTANCES.0, DISTANCES.1);
        let distance = (eye - center).dot(back).clamp(least, DISTANCES.1);
        Self {
            target: eye - distance * back,
            yaw: back.x.atan2(back.z),
            pitch: back.y.clamp(-1.0, 1.0).asin().clamp(-MAX_PITCH, MAX_PITCH),
            distance,
            projection: camera.projection,
            film: camera.film,
            origin: camera.origin,
        }
    }

    /// The camera.
    pub fn camera(&self) -> Camera {
        let eye = self.target + self.distance * self.back();
        let Self { projection, film, origin, .. } = *self;
        Camera { projection, film, origin, ..Camera::look_at(eye, self.target, 1.0) }
    }

    fn back(&self) -> Vec3 {
        let (sin, cos) = self.pitch.sin_cos();
        Vec3::new(cos * self.yaw.sin(), sin, cos * self.yaw.cos())
    }

    /// Turns the eye around the target: to the right and up [rad].
    pub fn turn(&mut self, by: Vec2) {
        if by.is_finite() {
            self.yaw = (self.yaw + by.x).rem_euclid(TAU);
            self.pitch = (self.pitch + by.y).clamp(-MAX_PITCH, MAX_PITCH);
        }
    }

    /// Moves the view to the right and up, in widths of what is seen at the target.
    pub fn pan(&mut self, by: Vec2) {
        let width = match self.projection {
            Projection::Perspective { fov_x } => 2.0 * self.distance * (0.5 * fov_x).tan(),
            Projection::Orthographic { half_width } => 2.0 * half_width,
        };
        let right = Vec3::new(self.yaw.cos(), 0.0, -self.yaw.sin());
        let up = self.back().cross(right);
        let target = self.target + width * (by.x * right + by.y * up);
        if target.is_finite() && target.abs().max_element() < DISTANCES.1 {
            self.target = target;
        }
    }

    /// Multiplies the distance; in a parallel view, the width of what is seen.
    pub fn dolly(&mut self, factor: f32) {
        if !(factor.is_finite() && factor > 0.0) {
            return;
        }
        self.distance = (self.distance * factor).clamp(DISTANCES.0, DISTANCES.1);
        if let Projection::Orthographic { half_width } = &mut self.projection {
            *half_width = (*half_width * factor).clamp(DISTANCES.0, DISTANCES.1);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn start() -> Orbit {
        let camera = Camera::look_at(Vec3::new(3.0, 2.0, 4.0), Vec3::new(0.5, 0.25, -0.5), 0.8);
        let bounds = Bounds { min: Vec3::new(-0.5, -0.75, -1.5), max: Vec3::new(1.5, 1.25, 0.5) };
        Orbit::from_camera(&camera, Some(bounds))
    }

    #[track_caller]
    fn assert_same(a: &Camera, b: &Camera) {
        let far = (0..4).map(|i| (a.world_from_camera.col(i) - b.world_from_camera.col(i)).length());
        assert!(far.fold(0.0, f32::max) < 1e-5, "{a:?} is not {b:?}");
        assert_eq!(a.projection, b.projection);
    }

    #[test]
    fn it_starts_with_the_camera_it_was_given() {
        let camera = Camera::look_at(Vec3::new(3.0, 2.0, 4.0), Vec3::new(0.5, 0.25, -0.5), 0.8);
        assert_same(&start().camera(), &camera);
        for bounds in [None, Some(Bounds { min: Vec3::splat(50.0), max: Vec3::splat(51.0) })] {
            assert_same(&Orbit::from_camera(&camera, bounds).camera(), &camera);
        }
    }

    #[test]
    fn a_full_turn_comes_back_and_distances_stay() {
        let mut orbit = start();
        let distance = |orbit: &Orbit| (orbit.camera().eye() - orbit.target).length();
        let before = distance(&orbit);
        for _ in 0..8 {
            orbit.turn(Vec2::new(TAU / 8.0, 0.0));
            assert!((distance(&orbit) - before).abs() < 1e-4);
        }
        assert_same(&orbit.camera(), &start().camera());
        orbit.turn(Vec2::new(0.0, 9.0));
        let camera = orbit.camera();
        assert!(camera.eye().y > orbit.target.y && camera.world_from_camera.is_finite());
    }

    #[test]
    fn a_pan_of_half_a_width_brings_the_edge_to_the_middle() {
        let mut orbit = start();
        let before = orbit.camera();
        orbit.pan(Vec2::new(0.5, 0.0));
        let seen = before.world_from_camera.inverse().transform_point3(orbit.target);
        assert!((seen.x / -seen.z - (0.4_f32).tan()).abs() < 1e-4 && seen.y.abs() < 1e-4, "{seen}");
        let axes = |camera: &Camera| camera.world_from_camera.z_axis;
        assert!((axes(&orbit.camera()) - axes(&before)).length() < 1e-5);
    }

    #[test]
    fn dolly_scales_the_distance_and_refuses_nonsense() {
        let mut orbit = start();
        let before = orbit.clone();
        for factor in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            orbit.dolly(factor);
        }
        orbit.turn(Vec2::splat(f32::NAN));
        orbit.pan(Vec2::splat(f32::INFINITY));
        assert_eq!(orbit, before);
        orbit.dolly(0.5);
        assert!((orbit.distance - 0.5 * before.distance).abs() < 1e-6);
        for _ in 0..2000 {
            orbit.dolly(0.5);
        }
        assert!(orbit.camera().world_from_camera.is_finite());
    }

    #[test]
    fn a_parallel_view_stays_one_and_zooms() {
        let projection = Projection::Orthographic { half_width: 2.0 };
        let camera = Camera { projection, ..Camera::look_at(Vec3::new(0.0, 1.0, 5.0), Vec3::ZERO, 1.0) };
        let mut orbit = Orbit::from_camera(&camera, None);
        orbit.dolly(0.5);
        assert_eq!(orbit.camera().projection, Projection::Orthographic { half_width: 1.0 });
    }
}
