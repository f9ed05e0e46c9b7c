use std::f32::consts::PI;

use glam::{Vec2, Vec3};
use gnomon_picture::RgbImage;
use rayon::prelude::*;

use crate::Equirect;

/// Haziness of the air: 2 very clear, 3 clear, 6 hazy.
const TURBIDITY: f32 = 3.0;
/// Height of the sun above the horizon, by day and in the evening [rad].
const DAY_ELEVATION: f32 = 38.0 * PI / 180.0;
const EVENING_ELEVATION: f32 = 9.0 * PI / 180.0;
/// Where the sun stands, as the equirect coordinate `u`: ahead of a camera that looks along -z, and to its right.
const SUN_U: f32 = 0.14;
/// Half the sun's mean apparent diameter of 0.533 degrees [rad].
const SUN_RADIUS: f32 = 0.5 * 0.533 * PI / 180.0;
/// Illuminance outside the atmosphere on a surface that faces the sun [klx].
const SOLAR_CONSTANT: f32 = 128.0;
/// Luminance that counts as radiance 1 [kcd/m^2].
const UNIT: f32 = 16.0;
/// Reflectance of the ground.
const GROUND: Vec3 = Vec3::new(0.20, 0.18, 0.12);
/// Samples along each side of a texel that the sun's edge may cross.
const SUN_SAMPLES: u32 = 32;

/// A clear sky by day.
pub(super) fn sky(width: u32, height: u32) -> Equirect {
    clear_sky(DAY_ELEVATION, width, height)
}

/// The same sky in the evening: a low, reddish sun and long shadows.
pub(super) fn evening(width: u32, height: u32) -> Equirect {
    clear_sky(EVENING_ELEVATION, width, height)
}

/// A clear sky after Preetham, Shirley and Smits 1999 with the sun as a disc of its true size, over matte ground.
fn clear_sky(sun_elevation: f32, width: u32, height: u32) -> Equirect {
    let model = Daylight::new(sun_elevation);
    let mut map = Equirect::new(RgbImage::filled(width, height, Vec3::ZERO));
    let directions = map.clone();
    let ground = model.ground();
    let mut image = map.into_radiance();
    image.texels_mut().par_chunks_mut(width as usize).enumerate().for_each(|(y, row)| {
        for (x, texel) in row.iter_mut().enumerate() {
            let direction = directions.texel_direction(x as u32, y as u32);
            *texel = if direction.y > 0.0 {
                model.sky(direction)
            } else {
                // Haze hides the ground towards the horizon.
                let haze = (direction.y * 9.0).exp();
                ground.lerp(model.sky(Vec3::new(direction.x, 0.0, direction.z).normalize()) * 0.85, haze)
            };
        }
    });
    map = Equirect::new(image);
    add_sun(map, model.sun, model.sun_illuminance)
}

/// Adds a disc of uniform radiance: each texel by the part of the disc that it covers, all of them with exactly the
/// disc's flux.
fn add_sun(map: Equirect, sun: Vec3, illuminance: Vec3) -> Equirect {
    let (width, height) = (map.width(), map.height());
    let centre = Equirect::uv_from_direction(sun);
    let rows = (centre.y * height as f32) as u32;
    let reach = (SUN_RADIUS / PI * height as f32).ceil() as u32 + 1;
    let mut covered: Vec<(u32, u32, f64)> = Vec::new();
    for y in rows.saturating_sub(reach)..(rows + reach + 1).min(height) {
        for x in 0..width {
            let far = 2.0 * PI / width as f32 + PI / height as f32 + SUN_RADIUS;
            if map.texel_direction(x, y).angle_between(sun) < far {
                let inside = |sample: u32| {
                    let at = Vec2::new((sample % SUN_SAMPLES) as f32, (sample / SUN_SAMPLES) as f32) + 0.5;
                    let at = Vec2::new(x as f32, y as f32) + at / SUN_SAMPLES as f32;
                    let direction = Equirect::direction_from_uv(at / Vec2::new(width as f32, height as f32));
                    // The chord, as the cosine loses its digits at such angles.
                    direction.distance(sun) < 2.0 * (0.5 * SUN_RADIUS).sin()
                };
                let count = (0..SUN_SAMPLES * SUN_SAMPLES).filter(|&sample| inside(sample)).count();
                covered.push((x, y, count as f64 * map.texel_solid_angle(y)));
            }
        }
    }
    if covered.iter().all(|&(.., weight)| weight == 0.0) {
        // Texels so large that the samples miss the disc.
        let x = ((centre.x * width as f32) as u32).min(width - 1);
        covered = vec![(x, rows.min(height - 1), 1.0)];
    }
    let total: f64 = covered.iter().map(|&(.., weight)| weight).sum();
    let angles: Vec<f64> = (0..height).map(|y| map.texel_solid_angle(y)).collect();
    let mut image = map.into_radiance();
    for (x, y, weight) in covered {
        *image.get_mut(x, y) += (illuminance.as_dvec3() * (weight / total / angles[y as usize])).as_vec3();
    }
    Equirect::new(image)
}

/// Sky light and sun light for one position of the sun.
struct Daylight {
    sun: Vec3,
    /// Of the sun above the horizon [rad].
    elevation: f32,
    /// Irradiance on a surface that faces the sun.
    sun_illuminance: Vec3,
    /// Perez's five coefficients for luminance and the chromaticities x and y, and their values at the zenith.
    perez: [[f32; 5]; 3],
    zenith: Vec3,
}

impl Daylight {
    fn new(elevation: f32) -> Self {
        let t = TURBIDITY;
        let sun = Equirect::direction_from_uv(Vec2::new(SUN_U, 0.5 - elevation / PI));
        let s = 0.5 * PI - elevation;
        // Preetham et al., appendix A.2.
        let perez = [
            [
                0.1787 * t - 1.4630,
                -0.3554 * t + 0.4275,
                -0.0227 * t + 5.3251,
                0.1206 * t - 2.5771,
                -0.0670 * t + 0.3703,
            ],
            [
                -0.0193 * t - 0.2592,
                -0.0665 * t + 0.0008,
                -0.0004 * t + 0.2125,
                -0.0641 * t - 0.8989,
                -0.0033 * t + 0.0452,
            ],
            [
                -0.0167 * t - 0.2608,
                -0.0950 * t + 0.0092,
                -0.0079 * t + 0.2102,
                -0.0441 * t - 1.6537,
                -0.0109 * t + 0.0529,
            ],
        ];
        let chi = (4.0 / 9.0 - t / 120.0) * (PI - 2.0 * s);
        let luminance = (4.0453 * t - 4.9710) * chi.tan() - 0.2155 * t + 2.4192;
        let cubic = |c: [f32; 4]| ((c[0] * s + c[1]) * s + c[2]) * s + c[3];
        let chromaticity = |rows: [[f32; 4]; 3]| (cubic(rows[0]) * t + cubic(rows[1])) * t + cubic(rows[2]);
        let x = chromaticity([
            [0.00166, -0.00375, 0.00209, 0.0],
            [-0.02903, 0.06377, -0.03202, 0.00394],
            [0.11693, -0.21196, 0.06052, 0.25886],
        ]);
        let y = chromaticity([
            [0.00275, -0.00610, 0.00317, 0.0],
            [-0.04214, 0.08970, -0.04153, 0.00516],
            [0.15346, -0.26756, 0.06670, 0.26688],
        ]);
        // Appendix A.1: Rayleigh scattering and haze at the wavelengths of the primaries [micrometres].
        let air_mass = 1.0 / elevation.sin();
        let beta = 0.04608 * t - 0.04586;
        let transmittance = |wavelength: f32| {
            let depth = 0.008_735 * wavelength.powf(-4.08) + beta * wavelength.powf(-1.3);
            (-depth * air_mass).exp()
        };
        let transmitted = Vec3::new(transmittance(0.61), transmittance(0.55), transmittance(0.465));
        let sun_illuminance = transmitted * (SOLAR_CONSTANT / UNIT);
        Self { sun, elevation, sun_illuminance, perez, zenith: Vec3::new(luminance, x, y) }
    }

    /// Radiance of the sky without the sun, for a unit direction that does not point down.
    fn sky(&self, direction: Vec3) -> Vec3 {
        let cos_theta = direction.y.max(0.005);
        let gamma = direction.angle_between(self.sun);
        let perez = |c: &[f32; 5], cos_theta: f32, gamma: f32| {
            (1.0 + c[0] * (c[1] / cos_theta).exp())
                * (1.0 + c[2] * (c[3] * gamma).exp() + c[4] * gamma.cos().powi(2))
        };
        let relative = |index: usize| {
            let c = &self.perez[index];
            // The fitted chromaticities turn pink in the last degrees above the horizon.
            let cos_theta = if index == 0 { cos_theta } else { cos_theta.max(0.17) };
            self.zenith[index] * perez(c, cos_theta, gamma) / perez(c, 1.0, 0.5 * PI - self.elevation)
        };
        let (luminance, x, y) = (relative(0), relative(1), relative(2));
        let xyz = Vec3::new(x / y, 1.0, (1.0 - x - y) / y) * luminance.max(0.0);
        gnomon_picture::rec709_from_xyz(xyz / UNIT).max(Vec3::ZERO)
    }

    /// Radiance of the ground under this sky.
    fn ground(&self) -> Vec3 {
        const ROWS: u32 = 32;
        let dome = Equirect::new(RgbImage::filled(2 * ROWS, 2 * ROWS, Vec3::ZERO));
        let mut irradiance = self.sun_illuminance * self.sun.y;
        for y in 0..ROWS {
            for x in 0..2 * ROWS {
                let direction = dome.texel_direction(x, y);
                irradiance += self.sky(direction) * (direction.y * dome.texel_solid_angle(y) as f32);
            }
        }
        GROUND * irradiance / PI
    }
}
