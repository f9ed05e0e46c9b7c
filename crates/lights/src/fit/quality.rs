//! How far the lights of any fit are from their map.

use glam::{DVec2, DVec3, Vec2, Vec3};
use gnomon_envmap::Equirect;
use gnomon_picture::RgbImage;
use rayon::prelude::*;

use super::cells::FACE_SIZE;
use super::edge_error::Points;
use super::faces::{Faces, luminance};
use super::optimized::{LARGEST_SHARE, sky};
use crate::{DistantLight, LightSet, LightShape};

/// Points along a light's side or radius, and around a disk.
const ALONG: usize = 5;
const AROUND: usize = 8;
/// Lights that the map is divided as finely for, at least.
const LEAST_COUNT: usize = 48;

/// The error of irradiance behind straight edges that lights and residual make together, relative to the irradiance there: root mean squares
/// over all surfaces of which an edge hides one half of the sky, luminance. It knows no scene. 0 for a black map.
pub fn error_behind_edges(map: &Equirect, set: &LightSet) -> f64 {
    let whole = luminance(map.flux());
    if whole <= 0.0 {
        return 0.0;
    }
    let (scale, largest) = (whole.recip(), LARGEST_SHARE / set.lights.len().max(LEAST_COUNT) as f64);
    // What is left is as it was: it makes no error.
    let left = set.residual.radiance();
    let taken = RgbImage::from_fn(map.width(), map.height(), |x, y| {
        (map.radiance().get(x, y) - left.get(x.min(left.width() - 1), y.min(left.height() - 1)))
            .max(Vec3::ZERO)
    });
    let of = |map: &Equirect| sky(&Faces::new(map, FACE_SIZE), scale, largest);
    let mut wrong = of(&Equirect::new(taken)).negated();
    for light in &set.lights {
        let points = points(light);
        let sum: f64 = points.iter().map(|(_, weight)| weight).sum();
        points
            .iter()
            .for_each(|(towards, weight)| wrong.push(*towards, light.flux() * (scale * weight / sum)));
    }
    (square(&wrong) / square(&of(map))).sqrt()
}

/// Mean square of what these points give behind edges, but for a factor.
fn square(points: &Points) -> f64 {
    let squares = points.all().into_par_iter().map(|(towards, flux)| flux * points.potential(towards));
    luminance(squares.sum::<DVec3>()).max(0.0)
}

/// Directions within a light, with their weights.
fn points(light: &DistantLight) -> Vec<(DVec3, f64)> {
    let middle = |i: usize, count: usize| (i as f64 + 0.5) / count as f64;
    let towards = |at: DVec2| {
        let [d, t, b] = [light.direction, light.tangent, light.bitangent].map(Vec3::as_dvec3);
        (d + at.x * t + at.y * b).normalize()
    };
    match light.plane_corners() {
        Some(corners) => {
            let [a, b, c, d] = corners.map(Vec2::as_dvec2);
            let at = |i: usize| {
                let [s, t] = [i % ALONG, i / ALONG].map(|index| middle(index, ALONG));
                a.lerp(b, s).lerp(d.lerp(c, s), t)
            };
            // On the plane, solid angle goes with the cube of the cosine.
            let weight = |at: DVec2| (1.0 + at.length_squared()).powf(-1.5);
            (0..ALONG * ALONG).map(at).map(|at| (towards(at), weight(at))).collect()
        }
        None => {
            let LightShape::Disk { angular_radius } = light.shape else { return Vec::new() };
            let one_minus_cos = 1.0 - f64::from(angular_radius).cos();
            let at = |i: usize| {
                let cosine = 1.0 - one_minus_cos * middle(i / AROUND, ALONG);
                let radius = (1.0 - cosine * cosine).max(0.0).sqrt() / cosine;
                DVec2::from_angle(std::f64::consts::TAU * middle(i % AROUND, AROUND)) * radius
            };
            (0..ALONG * AROUND).map(at).map(|at| (towards(at), 1.0)).collect()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{FitOptions, by_name};
    use super::*;

    fn map() -> Equirect {
        Equirect::new(RgbImage::from_fn(128, 64, |x, y| match (x, y) {
            (10..18, 20..34) => Vec3::new(20.0, 22.0, 30.0),
            (70..90, 24..30) => Vec3::new(9.0, 8.0, 6.0),
            _ => Vec3::new(0.4, 0.3 + 0.004 * y as f32, 0.3),
        }))
    }

    #[test]
    fn more_lights_are_nearer_and_none_with_the_whole_map_left_are_right() {
        let map = map();
        let error = |method: &str, light_count: usize| {
            let options = FitOptions { light_count: Some(light_count), ..FitOptions::default() };
            error_behind_edges(&map, &by_name(method, &options).unwrap().fit(&map).unwrap())
        };
        let [few, some, many] = [8, 30, 100].map(|count| error("optimized", count));
        assert!(few > 1.5 * some && some > 1.5 * many && many > 0.0, "{few} {some} {many}");
        assert!(few < 0.5, "{few}");
        assert!(error("disks", 2) < few, "{}", error("disks", 2));
        assert!(error_behind_edges(&map, &LightSet::new("none", Vec::new(), map.clone())) < 1e-9);
        // All light from elsewhere is wrong by as much as there is of it, and more.
        let elsewhere = vec![DistantLight::disk(DVec3::NEG_Y, 0.1, map.flux())];
        let black = Equirect::new(RgbImage::filled(128, 64, Vec3::ZERO));
        let error = error_behind_edges(&map, &LightSet::new("none", elsewhere, black));
        assert!(error > 0.8, "{error}");
    }
}
