use std::f32::consts::PI;

use glam::{Vec2, Vec3};
use gnomon_envmap::Equirect;
use gnomon_picture::{LUMINANCE, RgbImage};
use rayon::prelude::*;

use crate::{DistantLight, LightSet, LightShape};

/// Half the width of an outline's coloured core, and of the dark rim around it [pixels].
const CORE: f32 = 0.8;
const RIM: f32 = 1.8;

/// The tone-mapped map, `width` x `width / 2` pixels, with every light outlined in a colour of its own. Display-referred
/// linear values in `[0, 1]`, exposed by the map's own median and highlights: encode as sRGB without further tone mapping.
pub fn preview(map: &Equirect, lights: &LightSet, width: u32) -> RgbImage {
    let (width, height) = (width.max(2), (width / 2).max(1));
    let empty = map.width() == 0 || map.height() == 0;
    let mut picture = RgbImage::filled(width, height, Vec3::ZERO);
    let exposure = exposure(map);
    let outlines: Vec<Outline> =
        lights.lights.iter().enumerate().map(|(i, light)| Outline::new(light, i)).collect();
    let rows = picture.texels_mut().par_chunks_mut(width as usize).enumerate();
    rows.for_each(|(y, row)| {
        for (x, pixel) in row.iter_mut().enumerate() {
            let at = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
            let direction = |at: Vec2| {
                Equirect::direction_from_uv(Vec2::new(
                    at.x / width as f32,
                    (at.y / height as f32).clamp(0.0, 1.0),
                ))
            };
            let mut colour = if empty { Vec3::ZERO } else { tone_map(map.lookup(direction(at)) * exposure) };
            let centre = direction(at);
            // A pixel diagonal, for the cull below.
            let reach = 4.0 * RIM * PI / height as f32;
            for outline in &outlines {
                if !outline.near(centre, reach) {
                    continue;
                }
                let distance = outline.pixels_from(at, direction);
                colour = colour.lerp(Vec3::ZERO, 0.7 * coverage(distance, RIM));
                colour = colour.lerp(outline.colour, coverage(distance, CORE));
            }
            *pixel = colour;
        }
    });
    picture
}

/// Share of a pixel at `distance` from a line that the line of half width `half_width` covers.
fn coverage(distance: f32, half_width: f32) -> f32 {
    (half_width + 0.5 - distance).clamp(0.0, 1.0)
}

/// Filmic shoulder: x / (1 + x), with white at 4.
fn tone_map(radiance: Vec3) -> Vec3 {
    (radiance * (1.0 + radiance / 16.0) / (1.0 + radiance)).clamp(Vec3::ZERO, Vec3::ONE)
}

/// Factor that puts the log-average luminance of the map's sphere at 0.18.
fn exposure(map: &Equirect) -> f32 {
    let (mut sum, mut weight) = (0.0, 0.0);
    let mean = map.flux().dot(LUMINANCE.as_dvec3()) / (4.0 * std::f64::consts::PI);
    if !(mean.is_finite() && mean > 0.0) {
        return 1.0;
    }
    for y in 0..map.height() {
        let solid_angle = map.texel_solid_angle(y);
        for x in 0..map.width() {
            // The floor keeps black texels from dragging the average to nothing.
            sum += solid_angle * (f64::from(map.radiance().get(x, y).dot(LUMINANCE)) / mean + 1e-3).ln();
            weight += solid_angle;
        }
    }
    (0.18 / (mean * (sum / weight).exp())) as f32
}

struct Outline<'a> {
    light: &'a DistantLight,
    /// Largest angle between the centre and the outline [rad].
    radius: f32,
    colour: Vec3,
}

impl<'a> Outline<'a> {
    fn new(light: &'a DistantLight, index: usize) -> Self {
        let radius = match light.shape {
            LightShape::Disk { angular_radius } => angular_radius,
            LightShape::Rectangle { corners } => corners
                .iter()
                .map(|corner| corner.dot(light.direction).clamp(-1.0, 1.0).acos())
                .fold(0.0, f32::max),
        };
        // Golden-ratio steps keep neighbouring numbers apart in hue.
        let hue = (index as f32 * 0.618_034).fract() * 6.0;
        let channel = |offset: f32| ((hue + offset).rem_euclid(6.0) - 3.0).abs() - 1.0;
        let colour = Vec3::new(channel(0.0), channel(4.0), channel(2.0)).clamp(Vec3::ZERO, Vec3::ONE);
        Self { light, radius, colour: 0.15 + 0.85 * colour }
    }

    fn near(&self, direction: Vec3, reach: f32) -> bool {
        direction.dot(self.light.direction) > (self.radius + reach).min(PI).cos()
    }

    /// Distance [pixels] from the outline: the signed angle over its gradient along the picture's axes, which is right
    /// wherever the picture stretches the sphere, poles and seam included.
    fn pixels_from(&self, at: Vec2, direction: impl Fn(Vec2) -> Vec3) -> f32 {
        let angle = |at: Vec2| self.light.signed_angle(direction(at));
        let step = 0.5;
        let (dx, dy) = (Vec2::new(step, 0.0), Vec2::new(0.0, step));
        let gradient =
            Vec2::new(angle(at + dx) - angle(at - dx), angle(at + dy) - angle(at - dy)) / (2.0 * step);
        angle(at).abs() / gradient.length().max(1e-9)
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    fn outlined(light: DistantLight) -> RgbImage {
        let map = Equirect::new(RgbImage::filled(64, 32, Vec3::ONE));
        preview(&map, &LightSet::new("none", vec![light], map.clone()), 256)
    }

    fn is_grey(colour: Vec3) -> bool {
        colour.max_element() - colour.min_element() < 1e-3
    }

    #[test]
    fn an_outline_runs_where_the_light_ends_also_across_the_seam() {
        let picture = outlined(DistantLight::disk(DVec3::NEG_Z, 0.5, DVec3::ONE));
        // -z is the seam at the equator; 0.5 rad are 20.4 of 256 columns.
        assert!(!is_grey(picture.get(20, 63)) && !is_grey(picture.get(235, 63)));
        assert!(is_grey(picture.get(0, 64)) && is_grey(picture.get(128, 64)) && is_grey(picture.get(40, 64)));
    }

    #[test]
    fn an_outline_around_the_pole_is_a_level_line() {
        let picture = outlined(DistantLight::disk(DVec3::Y, 0.5, DVec3::ONE));
        assert!((0..256).all(|x| !is_grey(picture.get(x, 20))));
        assert!((0..256).all(|x| is_grey(picture.get(x, 3)) && is_grey(picture.get(x, 30))));
    }

    #[test]
    fn any_map_gives_values_between_zero_and_one() {
        for value in [0.0, 1e-30, 1.0, 1e30] {
            let map = Equirect::new(RgbImage::filled(3, 1, Vec3::splat(value)));
            let picture = preview(&map, &LightSet::new("none", Vec::new(), map.clone()), 16);
            assert!(picture.texels().iter().all(|p| p.min_element() >= 0.0 && p.max_element() <= 1.0));
        }
    }
}
