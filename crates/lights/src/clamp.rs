//! The brightest texels of a map as lights of their own.

use std::f64::consts::PI;

use glam::{DVec3, Vec3};
use gnomon_envmap::Equirect;
use gnomon_picture::{LUMINANCE, RgbImage};

use crate::DistantLight;

/// Most lights that are made of what is taken out. The light of other places goes to the nearest of them.
const MOST: usize = 8;

/// Half angles of the disks [rad]: a sun's, and short of a hemisphere.
const RADII: (f64, f64) = (0.004, 1.2);

/// A map whose texels have at most `limit` in every channel, which keeps their colours, and disks with the light that is taken out: one for
/// each place where texels that touch are brighter, as large as these are together. Their flux is the map's own.
pub fn clamped(map: &Equirect, limit: f32) -> (Equirect, Vec<DistantLight>) {
    let radiance = map.radiance();
    let at_most = |texel: Vec3| texel * (limit / texel.max_element()).min(1.0);
    let is_bright = |x: u32, y: u32| radiance.get(x, y).max_element() > limit;
    let mut spots = spots(map, is_bright, |texel| texel - at_most(texel));
    spots.sort_by(|a, b| b.brightness().total_cmp(&a.brightness()));
    let others = spots.split_off(spots.len().min(MOST));
    for other in others {
        let middle = other.middle();
        let nearest =
            spots.iter_mut().max_by(|a, b| a.middle().dot(middle).total_cmp(&b.middle().dot(middle)));
        // Its own direction would make a light between the two.
        if let Some(spot) = nearest {
            spot.flux += other.flux;
        }
    }
    let lights = spots.iter().map(Spot::light).collect();
    let texels = RgbImage::from_fn(map.width(), map.height(), |x, y| at_most(radiance.get(x, y)));
    (Equirect::new(texels), lights)
}

/// Bright texels that touch.
#[derive(Default)]
struct Spot {
    flux: DVec3,
    solid_angle: f64,
    /// Sum of directions, each by its flux.
    towards: DVec3,
}

impl Spot {
    fn brightness(&self) -> f64 {
        self.flux.dot(LUMINANCE.as_dvec3())
    }

    fn middle(&self) -> DVec3 {
        self.towards.normalize_or(DVec3::Y)
    }

    fn light(&self) -> DistantLight {
        let radius = (1.0 - self.solid_angle / (2.0 * PI)).clamp(-1.0, 1.0).acos();
        DistantLight::disk(self.middle(), radius.clamp(RADII.0, RADII.1), self.flux)
    }
}

/// Texels that are bright, gathered where they touch, also at corners and across the seam.
fn spots(map: &Equirect, is_bright: impl Fn(u32, u32) -> bool, excess: impl Fn(Vec3) -> Vec3) -> Vec<Spot> {
    let (width, height) = (map.width(), map.height());
    let mut seen = vec![false; (width * height) as usize];
    let mut spots = Vec::new();
    for first in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
        let mut waiting = vec![first];
        let mut spot = Spot::default();
        while let Some((x, y)) = waiting.pop() {
            let place = (y * width + x) as usize;
            if seen[place] || !is_bright(x, y) {
                continue;
            }
            seen[place] = true;
            let solid_angle = map.texel_solid_angle(y);
            let flux = excess(map.radiance().get(x, y)).as_dvec3() * solid_angle;
            spot.flux += flux;
            spot.solid_angle += solid_angle;
            spot.towards += map.texel_direction(x, y).as_dvec3() * flux.element_sum();
            let rows = y.saturating_sub(1)..=(y + 1).min(height - 1);
            waiting.extend(rows.flat_map(|y| [width - 1, 0, 1].map(|step| ((x + step) % width, y))));
        }
        if spot.solid_angle > 0.0 {
            spots.push(spot);
        }
    }
    spots
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Even but for some texels.
    fn map(bright: &[(u32, u32)]) -> Equirect {
        let texel = |x, y| if bright.contains(&(x, y)) { Vec3::new(100.0, 50.0, 10.0) } else { Vec3::ONE };
        Equirect::new(RgbImage::from_fn(64, 32, texel))
    }

    #[test]
    fn flux_and_colour_stay_and_the_light_lies_where_it_was() {
        let map = map(&[(10, 8), (11, 8)]);
        let (clamped, lights) = clamped(&map, 4.0);
        let [light] = &lights[..] else { panic!("{lights:?}") };
        let flux = clamped.flux() + light.flux();
        assert!((flux - map.flux()).length() < 1e-5 * map.flux().length(), "{flux} {}", map.flux());
        assert!(clamped.radiance().get(10, 8).abs_diff_eq(Vec3::new(4.0, 2.0, 0.4), 1e-5));
        let towards = (map.texel_direction(10, 8) + map.texel_direction(11, 8)).normalize();
        assert!(light.direction.distance(towards) < 1e-4);
        assert!((f64::from(light.solid_angle) / (2.0 * map.texel_solid_angle(8)) - 1.0).abs() < 1e-3);
    }

    #[test]
    fn places_across_the_seam_are_one_and_what_is_not_bright_stays() {
        let across = map(&[(0, 16), (63, 15)]);
        let (_, lights) = clamped(&across, 4.0);
        assert_eq!(lights.len(), 1);
        assert!((lights[0].direction - Vec3::NEG_Z).length() < 0.05, "{}", lights[0].direction);
        let (same, none) = clamped(&across, 100.0);
        assert!(none.is_empty() && same == across);
    }

    #[test]
    fn many_places_become_few_lights_with_all_of_the_light() {
        let many: Vec<(u32, u32)> = (0..20).map(|i| (3 * i, 10)).collect();
        let many = map(&many);
        let (rest, lights) = clamped(&many, 2.0);
        let flux = rest.flux() + lights.iter().map(DistantLight::flux).sum::<DVec3>();
        assert_eq!(lights.len(), MOST);
        assert!((flux - many.flux()).length() < 1e-5 * many.flux().length());
    }
}
