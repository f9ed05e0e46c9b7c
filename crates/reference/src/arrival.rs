use glam::{DVec2, Quat, UVec2, Vec2, Vec3};
use gnomon_brdf::Frame;
use gnomon_lights::fit::Arrival;
use gnomon_scene::{Camera, Scene};
use rayon::prelude::*;

use crate::camera_ray::check_camera;
use crate::sampler::{Decision, Sequence, to_vec2};
use crate::traced_scene::TracedScene;
use crate::{Ray, ReferenceError, camera_ray};

/// Places of the picture that receivers are seen at.
const RECEIVERS: UVec2 = UVec2::new(32, 24);
/// Most placed triangles that are traced where nobody asked for it: the hierarchy of more would take a gigabyte. Scenes of more are taken
/// for no interiors.
pub const MOST_UNASKED_TRIANGLES: usize = 1 << 22;
/// A receiver looks in one of so many directions, each another part of them.
const PARTS: usize = 4;
/// Where rays begin and end.
const SEED: u64 = 0x6172_7269;

/// What of the light of every direction arrives in an interior: at what the camera sees, and at what can be seen from there, so that a
/// camera that turns finds much the same. Directions are the environment's, which is turned by `world_from_environment`; `aspect` is the
/// picture's width over its height. `None` where a scene is no interior: much of the sky is open, or nothing is seen; and where it has more than
/// [`MOST_UNASKED_TRIANGLES`].
///
/// # Errors
/// As [`crate::render`].
pub fn interior_arrival(
    scene: &Scene,
    camera: &Camera,
    aspect: f32,
    world_from_environment: Quat,
) -> Result<Option<Arrival>, ReferenceError> {
    check_camera(camera)?;
    if scene.triangle_count() > MOST_UNASKED_TRIANGLES {
        return Ok(None);
    }
    let traced = TracedScene::new(scene)?;
    // The lens is as wide as the picture's: only proportions of the size count.
    let size = UVec2::new((aspect.clamp(1e-3, 1e3) * 4096.0) as u32 + 1, 4096);
    let seen: Vec<[Vec<f64>; 2]> = (0..RECEIVERS.x * RECEIVERS.y)
        .into_par_iter()
        .flat_map_iter(|number| {
            let sequence = Sequence::new(SEED, number, 0);
            let place = Vec2::new((number % RECEIVERS.x) as f32, (number / RECEIVERS.x) as f32)
                + to_vec2(sequence.pair(0, Decision::Pixel));
            let ray = camera_ray(camera, size, place / RECEIVERS.as_vec2() * size.as_vec2());
            let opacity = sequence.pair(0, Decision::Opacity);
            let first = receiver(&traced, &ray, opacity.x);
            let second = first.and_then(|receiver| {
                let direction = cosine_direction(receiver.normal, sequence.pair(0, Decision::Direction));
                self::receiver(&traced, &Ray { origin: receiver.lifted, direction }, opacity.y)
            });
            first
                .into_iter()
                .chain(second)
                .enumerate()
                .map(|(i, receiver)| {
                    looked(&traced, &receiver, &sequence, number as usize + i, world_from_environment)
                })
                .collect::<Vec<_>>()
        })
        .collect();
    let mut sums = [vec![0.0; Arrival::DIRECTIONS], vec![0.0; Arrival::DIRECTIONS]];
    for seen in &seen {
        for (sums, seen) in sums.iter_mut().zip(seen) {
            sums.iter_mut().zip(seen).for_each(|(sum, seen)| *sum += seen);
        }
    }
    let [arrives, offered] = sums;
    Ok(Arrival::of_interior(&arrives, &offered))
}

#[derive(Clone, Copy)]
struct Receiver {
    lifted: Vec3,
    normal: Vec3,
}

fn receiver(traced: &TracedScene<'_>, ray: &Ray, chance: f64) -> Option<Receiver> {
    let point = traced.hit_point(&traced.closest_hit(ray, chance)?, -ray.direction);
    Some(Receiver { lifted: point.lifted(), normal: point.geometric_normal })
}

/// A direction with a density in proportion to its cosine (Malley's method).
fn cosine_direction(n: Vec3, u: DVec2) -> Vec3 {
    let (sin, cos) = (std::f64::consts::TAU * u.x).sin_cos();
    let local = DVec2::new(cos, sin) * u.y.sqrt();
    let frame = Frame::from_normal(n);
    frame.t * local.x as f32 + frame.b * local.y as f32 + n * (1.0 - u.y).max(0.0).sqrt() as f32
}

/// Cosines of the directions that a receiver looks in, once as far as nothing blocks them and once all.
fn looked(
    traced: &TracedScene<'_>,
    receiver: &Receiver,
    sequence: &Sequence,
    number: usize,
    world_from_environment: Quat,
) -> [Vec<f64>; 2] {
    let (mut arrives, mut offered) = (vec![0.0; Arrival::DIRECTIONS], vec![0.0; Arrival::DIRECTIONS]);
    for index in (number % PARTS..Arrival::DIRECTIONS).step_by(PARTS) {
        let u = to_vec2(sequence.pair(index as u32, Decision::Choice));
        let direction = world_from_environment * Arrival::direction(index, u).normalize();
        let cosine = f64::from(direction.dot(receiver.normal));
        if cosine > 0.0 {
            offered[index] = cosine;
            let ray = Ray { origin: receiver.lifted, direction };
            arrives[index] = cosine * f64::from(traced.transmittance(&ray, f32::INFINITY));
        }
    }
    [arrives, offered]
}

#[cfg(test)]
mod tests {
    use std::f32::consts::FRAC_PI_2;

    use glam::Mat4;
    use gnomon_scene::builtin;

    use super::*;

    #[test]
    fn boxes_on_a_plane_are_no_interior() {
        let scene = builtin::by_name("three-boxes").unwrap();
        let arrival = interior_arrival(&scene, &scene.cameras[0], 1.5, Quat::IDENTITY).unwrap();
        assert!(arrival.is_none());
        let mut up = scene.cameras[0].clone();
        up.world_from_camera = Mat4::from_translation(50.0 * Vec3::Y) * Mat4::from_rotation_x(FRAC_PI_2);
        assert!(interior_arrival(&scene, &up, 1.5, Quat::IDENTITY).unwrap().is_none(), "nothing is seen");
    }
}
