//! What every fit must keep, as checkers that report how far off it is.

use glam::{DVec3, Vec3};
use gnomon_envmap::Equirect;
use gnomon_lights::{DistantLight, LightSet, LightShape};
use gnomon_picture::RgbImage;

/// Largest error of any channel's flux, relative to that channel's flux in the map (summed here, texel by texel).
pub fn flux_error(map: &Equirect, set: &LightSet) -> f64 {
    let expected = flux(map);
    let lights: DVec3 =
        set.lights.iter().map(|light| light.radiance.as_dvec3() * f64::from(light.solid_angle)).sum();
    let error = (lights + flux(&set.residual) - expected).abs();
    (0..3).map(|i| if expected[i] > 0.0 { error[i] / expected[i] } else { error[i] }).fold(0.0, f64::max)
}

fn flux(map: &Equirect) -> DVec3 {
    let (width, height) = (map.width(), map.height());
    let theta = |y: u32| std::f64::consts::PI * f64::from(y) / f64::from(height);
    (0..height)
        .map(|y| {
            let band = std::f64::consts::TAU * (theta(y).cos() - theta(y + 1).cos()) / f64::from(width);
            (0..width).map(|x| map.radiance().get(x, y).as_dvec3()).sum::<DVec3>() * band
        })
        .sum()
}

/// Whether radiance is finite and nowhere negative, in the lights and in the residual, and the latter as large as the map.
pub fn is_physical(map: &Equirect, set: &LightSet) -> bool {
    let valid = |radiance: Vec3| radiance.is_finite() && radiance.min_element() >= 0.0;
    (set.residual.width(), set.residual.height()) == (map.width(), map.height())
        && set.lights.iter().all(|light| valid(light.radiance) && light.solid_angle > 0.0)
        && set.residual.radiance().texels().iter().all(|texel| valid(*texel))
}

/// The map turned a quarter about +y: what was towards `d` is then towards `(d.z, d.y, -d.x)`, a quarter of the width to
/// the left.
pub fn quarter_turn(map: &Equirect) -> Equirect {
    let width = map.width();
    Equirect::new(RgbImage::from_fn(width, map.height(), |x, y| {
        map.radiance().get((x + width / 4) % width, y)
    }))
}

/// Largest distance between a light of the turned map and the turned light of the map (centres and corners on the unit
/// sphere, relative radiance); infinite where the numbers of lights differ.
pub fn turn_error(before: &LightSet, after: &LightSet) -> f32 {
    if before.lights.len() != after.lights.len() {
        return f32::INFINITY;
    }
    let turned = |d: Vec3| Vec3::new(d.z, d.y, -d.x);
    let apart = |a: &DistantLight, b: &DistantLight| {
        let radiance =
            (a.radiance - b.radiance).abs().max_element() / a.radiance.max_element().max(f32::MIN_POSITIVE);
        let outline = match (a.shape, b.shape) {
            (LightShape::Disk { angular_radius: a }, LightShape::Disk { angular_radius: b }) => (a - b).abs(),
            (LightShape::Rectangle { corners: a }, LightShape::Rectangle { corners: b }) => a
                .iter()
                .map(|corner| b.iter().map(|c| (turned(*corner) - *c).length()).fold(f32::INFINITY, f32::min))
                .fold(0.0, f32::max),
            _ => f32::INFINITY,
        };
        outline.max(radiance).max((turned(a.direction) - b.direction).length())
    };
    let nearest = |a: &DistantLight| after.lights.iter().map(|b| apart(a, b)).fold(f32::INFINITY, f32::min);
    before.lights.iter().map(nearest).fold(0.0, f32::max)
}
