//! Unshadowed irradiance of a whole environment for every normal: closed forms for what is small and bright, a map for the rest.
//!
//! A map over the sphere of normals interpolates, and its sum over texels of a coarser environment moves a sun by up to a degree. Under a
//! low sun both are tens of percent of what a level floor gets. So suns and lamps are taken out first.

use std::f32::consts::PI;

use glam::{DVec3, Vec2, Vec3};
use gnomon_envmap::Equirect;
use gnomon_picture::{LUMINANCE, RgbImage};
use gnomon_shaders::layout::{self, Emitter};
use rayon::prelude::*;

/// Height of the map over the normals.
const HEIGHT: u32 = 64;
/// Height of the map that it is integrated from.
const SOURCE_HEIGHT: u32 = 64;
/// Largest angle from the middle of an emitter to its texels' centres [rad].
const REACH: f32 = 0.0125;
/// An emitter has at least this share of the flux of the environment.
const LEAST_SHARE: f64 = 0.005;
/// Most emitters: what a shader loops over.
const MOST: usize = layout::MAX_EMITTERS as usize;

/// Irradiance of an environment.
#[derive(Clone, Debug)]
pub(crate) struct Irradiance {
    pub emitters: Vec<Emitter>,
    /// Irradiance of all else, an equirect map over the sphere of normals.
    pub rest: RgbImage,
}

impl Irradiance {
    pub fn new(map: &Equirect) -> Self {
        let mut rest = map.radiance().clone();
        let emitters = take_emitters(map, &mut rest);
        Self { emitters, rest: irradiance_map(&Equirect::new(rest)) }
    }
}

/// Takes the texels of small bright parts out of `rest`, the brightest first.
fn take_emitters(map: &Equirect, rest: &mut RgbImage) -> Vec<Emitter> {
    let luminance_flux = map.flux().dot(LUMINANCE.as_dvec3());
    // What fills a disk of that reach with the least share of the flux is as bright as this.
    let reach = REACH.max(0.75 * PI / map.height() as f32);
    let least_luminance = (LEAST_SHARE * luminance_flux / f64::from(PI * reach * reach)) as f32;
    let mut bright: Vec<(f32, u32, u32)> = (0..map.height())
        .flat_map(|y| (0..map.width()).map(move |x| (x, y)))
        .map(|(x, y)| (map.radiance().get(x, y).dot(LUMINANCE), x, y))
        .filter(|(luminance, ..)| *luminance > 0.25 * least_luminance)
        .collect();
    bright.sort_by(|a, b| b.0.total_cmp(&a.0).then_with(|| (a.2, a.1).cmp(&(b.2, b.1))));
    let mut emitters = Vec::new();
    for &(luminance, x, y) in &bright {
        if emitters.len() == MOST || luminance < least_luminance {
            break;
        }
        if rest.get(x, y) == Vec3::ZERO {
            continue;
        }
        let middle = map.texel_direction(x, y);
        let taken: Vec<(u32, u32)> = bright
            .iter()
            .map(|&(_, x, y)| (x, y))
            .filter(|&(x, y)| rest.get(x, y) != Vec3::ZERO)
            .filter(|&(x, y)| map.texel_direction(x, y).distance(middle) <= reach)
            .collect();
        let texels = || {
            taken.iter().map(|&(x, y)| {
                let radiance = rest.get(x, y).as_dvec3();
                (map.texel_direction(x, y).as_dvec3(), map.texel_solid_angle(y), radiance)
            })
        };
        let flux: DVec3 = texels().map(|(_, solid_angle, radiance)| radiance * solid_angle).sum();
        let share = flux.dot(LUMINANCE.as_dvec3());
        if share < LEAST_SHARE * luminance_flux {
            continue;
        }
        let weight =
            |solid_angle: f64, radiance: DVec3| solid_angle * radiance.dot(LUMINANCE.as_dvec3()) / share;
        let vector: DVec3 =
            texels().map(|(w, solid_angle, radiance)| w * weight(solid_angle, radiance)).sum();
        let Some(direction) = vector.try_normalize() else { continue };
        // A disk of radius r has a mean squared distance of r^2 / 2 from its middle, a square of area a one of a / 6.
        let squares: f64 = texels()
            .map(|(w, solid_angle, radiance)| {
                weight(solid_angle, radiance) * (w.distance_squared(direction) + solid_angle / 6.0)
            })
            .sum();
        let angular_radius = (2.0 * squares).sqrt().clamp(1e-3, 0.1);
        let facing = std::f64::consts::PI * angular_radius.sin().powi(2);
        emitters.push(Emitter {
            direction: direction.as_vec3(),
            angular_radius: angular_radius as f32,
            radiance: (flux * (vector.length() / facing)).as_vec3(),
        });
        for (x, y) in taken {
            *rest.get_mut(x, y) = Vec3::ZERO;
        }
    }
    emitters
}

/// Irradiance of a map for every normal, by summing over all texels.
fn irradiance_map(map: &Equirect) -> RgbImage {
    let height = SOURCE_HEIGHT.min(map.height());
    let source = map.resized(2 * height, height);
    let emitters: Vec<(Vec3, f32, Vec3)> = (0..height)
        .flat_map(|y| (0..source.width()).map(move |x| (x, y)))
        .map(|(x, y)| {
            let solid_angle = source.texel_solid_angle(y) as f32;
            (source.texel_direction(x, y), solid_angle, source.radiance().get(x, y))
        })
        .collect();
    let size = Vec2::new(2.0 * HEIGHT as f32, HEIGHT as f32);
    let texel = |(x, y): (u32, u32)| {
        let n = Equirect::direction_from_uv(Vec2::new(x as f32 + 0.5, y as f32 + 0.5) / size);
        let (sum, cosines) =
            emitters.iter().fold((Vec3::ZERO, 0.0), |(sum, cosines), (w, solid_angle, radiance)| {
                let projected = w.dot(n).max(0.0) * solid_angle;
                (sum + *radiance * projected, cosines + projected)
            });
        // The cosines sum to pi only up to discretisation; this makes a constant map exact.
        sum * (PI / cosines)
    };
    let texels: Vec<Vec3> = (0..2 * HEIGHT * HEIGHT)
        .into_par_iter()
        .map(|i| texel((i % (2 * HEIGHT), i / (2 * HEIGHT))))
        .collect();
    RgbImage::from_fn(2 * HEIGHT, HEIGHT, |x, y| texels[(y * 2 * HEIGHT + x) as usize])
}

#[cfg(test)]
mod tests {
    use gnomon_lights::form_factor::disk_form_factor;

    use super::*;

    /// The sum over the texels of the map, each in 4 x 4 parts.
    fn brute_force(map: &Equirect, n: Vec3) -> Vec3 {
        let (width, height) = (map.width(), map.height());
        let mut sum = DVec3::ZERO;
        for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
            let radiance = map.radiance().get(x, y).as_dvec3();
            let cosine: f32 = (0..16)
                .map(|i| {
                    let uv = Vec2::new(x as f32, y as f32)
                        + (Vec2::new((i % 4) as f32, (i / 4) as f32) + 0.5) / 4.0;
                    Equirect::direction_from_uv(uv / Vec2::new(width as f32, height as f32)).dot(n).max(0.0)
                })
                .sum();
            sum += radiance * (f64::from(cosine) / 16.0 * map.texel_solid_angle(y));
        }
        sum.as_vec3()
    }

    fn irradiance(irradiance: &Irradiance, n: Vec3) -> Vec3 {
        let suns: Vec3 = (irradiance.emitters.iter())
            .map(|sun| sun.radiance * disk_form_factor(n, sun.direction, sun.angular_radius))
            .sum();
        Equirect::new(irradiance.rest.clone()).lookup(n) + suns
    }

    #[test]
    fn a_sun_of_any_height_lights_any_normal_as_the_sum_over_its_texels() {
        for (width, height) in [(512, 256), (256, 128)] {
            for elevation in [3.0f32, 5.0, 8.0, 12.0, 20.0, 35.0, 60.0, 89.0] {
                let mut radiance = RgbImage::filled(width, height, Vec3::splat(0.3));
                let row = ((90.0 - elevation) / 180.0 * height as f32) as u32;
                *radiance.get_mut(width / 3, row) = Vec3::new(3e5, 2e5, 1e5);
                *radiance.get_mut(width / 3 + 1, row) = Vec3::new(9e4, 6e4, 3e4);
                let map = Equirect::new(radiance);
                let found = Irradiance::new(&map);
                assert!(!found.emitters.is_empty());
                for n in [Vec3::Y, Vec3::new(0.6, 0.8, 0.0), Vec3::new(0.0, 0.6, -0.8), Vec3::NEG_Y, Vec3::X]
                {
                    let (right, got) = (brute_force(&map, n), irradiance(&found, n));
                    assert!(
                        (got - right).abs().max_element() <= 0.005 * right.max_element(),
                        "{elevation} {n}: {got} for {right}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_map_without_suns_has_no_emitters_and_a_black_one_no_light() {
        let flat = Irradiance::new(&Equirect::new(RgbImage::filled(64, 32, Vec3::splat(0.7))));
        assert!(flat.emitters.is_empty());
        assert!((irradiance(&flat, Vec3::Y).x / (0.7 * PI) - 1.0).abs() < 1e-4);
        let black = Irradiance::new(&Equirect::new(RgbImage::filled(64, 32, Vec3::ZERO)));
        assert!(black.emitters.is_empty() && irradiance(&black, Vec3::X) == Vec3::ZERO);
    }
}
