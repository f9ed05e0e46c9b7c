//! The brightest texels of a map as lights of their own.

use std::f64::consts::PI;
use std::ops::Range;

use glam::{DVec3, Vec3};
use gnomon_envmap::Equirect;
use gnomon_picture::{LUMINANCE, RgbImage};

use crate::DistantLight;

/// Most lights that are made of what is taken out.
const MOST: usize = 64;
/// So many of the brightest places have lights of their own, and so many where fewer hold less than this share of what is taken out. The light
/// of other places goes to the nearest of them.
const FEW: usize = 8;
const MANY: usize = 32;
const SHARE: f64 = 0.99;

/// A place that reaches farther from its middle is cut in two [rad]: a disk at the middle of a bright horizon would shine from above.
const WIDEST: f64 = 0.3;

/// Half angles of the disks [rad]: a sun's, and short of a hemisphere.
const RADII: (f64, f64) = (0.004, 1.2);

/// A map whose texels have at most `limit` in every channel, which keeps their colours, and disks with the light that is taken out: one for
/// each place where texels that touch are brighter, as large as these are together, and several for one that is wide. Their flux is the map's own.
pub fn clamped(map: &Equirect, limit: f32) -> (Equirect, Vec<DistantLight>) {
    let bright = Bright { map, limit };
    let (mut texels, ranges) = bright.touching();
    let mut spots: Vec<Spot> = ranges.into_iter().map(|range| bright.spot(&texels, range)).collect();
    spots.sort_by(|a, b| b.brightness().total_cmp(&a.brightness()));
    let enough = SHARE * spots.iter().map(Spot::brightness).sum::<f64>();
    let mut held = 0.0;
    let is_kept = |(number, spot): &(usize, &Spot)| {
        let is_kept = *number < FEW || (*number < MANY && held < enough);
        held += spot.brightness();
        is_kept
    };
    let kept = spots.iter().enumerate().take_while(is_kept).count();
    let others = spots.split_off(kept);
    while spots.len() < MOST {
        let reaches = spots.iter().enumerate().filter(|(_, spot)| spot.reach > WIDEST);
        let Some((widest, _)) = reaches.max_by(|(_, a), (_, b)| a.reach.total_cmp(&b.reach)) else { break };
        let [part, rest] = bright.cut(&mut texels, &spots[widest]);
        spots[widest] = part;
        spots.push(rest);
    }
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
    let texel = |x, y| bright.at_most(map.radiance().get(x, y));
    (Equirect::new(RgbImage::from_fn(map.width(), map.height(), texel)), lights)
}

/// Bright texels: those that touch, or part of them.
struct Spot {
    /// Where they are in the list of all.
    texels: Range<usize>,
    flux: DVec3,
    solid_angle: f64,
    /// Sum of directions, each by its flux.
    towards: DVec3,
    /// Angle from the middle to the farthest [rad].
    reach: f64,
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

/// What of a map is above a limit. Texels are numbered row by row.
struct Bright<'a> {
    map: &'a Equirect,
    limit: f32,
}

impl Bright<'_> {
    fn at_most(&self, texel: Vec3) -> Vec3 {
        texel * (self.limit / texel.max_element()).min(1.0)
    }

    fn place(&self, texel: u32) -> (u32, u32) {
        (texel % self.map.width(), texel / self.map.width())
    }

    fn radiance(&self, texel: u32) -> Vec3 {
        let (x, y) = self.place(texel);
        self.map.radiance().get(x, y)
    }

    fn direction(&self, texel: u32) -> DVec3 {
        let (x, y) = self.place(texel);
        self.map.texel_direction(x, y).as_dvec3()
    }

    /// All that are bright, and ranges of those that touch, also at corners and across the seam.
    fn touching(&self) -> (Vec<u32>, Vec<Range<usize>>) {
        let (width, height) = (self.map.width(), self.map.height());
        let mut is_left: Vec<bool> =
            (0..width * height).map(|texel| self.radiance(texel).max_element() > self.limit).collect();
        let (mut texels, mut ranges) = (Vec::new(), Vec::new());
        for first in 0..width * height {
            let begin = texels.len();
            let mut next = begin;
            let mut take = |texel: u32, texels: &mut Vec<u32>| {
                if std::mem::take(&mut is_left[texel as usize]) {
                    texels.push(texel);
                }
            };
            take(first, &mut texels);
            // The list is its own queue.
            while let Some(&texel) = texels.get(next) {
                next += 1;
                let (x, y) = self.place(texel);
                for row in y.saturating_sub(1)..=(y + 1).min(height - 1) {
                    for step in [width - 1, 0, 1] {
                        take(row * width + (x + step) % width, &mut texels);
                    }
                }
            }
            if next > begin {
                ranges.push(begin..next);
            }
        }
        (texels, ranges)
    }

    fn spot(&self, texels: &[u32], range: Range<usize>) -> Spot {
        let mut spot =
            Spot { texels: range, flux: DVec3::ZERO, solid_angle: 0.0, towards: DVec3::ZERO, reach: 0.0 };
        let texels = &texels[spot.texels.clone()];
        for &texel in texels {
            let radiance = self.radiance(texel);
            let solid_angle = self.map.texel_solid_angle(self.place(texel).1);
            let flux = (radiance - self.at_most(radiance)).as_dvec3() * solid_angle;
            spot.flux += flux;
            spot.solid_angle += solid_angle;
            spot.towards += self.direction(texel) * flux.element_sum();
        }
        let middle = spot.middle();
        let nearness = texels.iter().map(|&texel| self.direction(texel).dot(middle)).fold(1.0, f64::min);
        Spot { reach: nearness.max(-1.0).acos(), ..spot }
    }

    /// The two halves of a spot, cut between two that are far from one another.
    fn cut(&self, texels: &mut [u32], spot: &Spot) -> [Spot; 2] {
        let own = &mut texels[spot.texels.clone()];
        let farthest = |from: DVec3| {
            let directions = own.iter().map(|&texel| self.direction(texel));
            directions.min_by(|a, b| a.dot(from).total_cmp(&b.dot(from))).unwrap_or(from)
        };
        let one = farthest(spot.middle());
        let axis = one - farthest(one);
        own.sort_unstable_by_key(|&texel| self.direction(texel).dot(axis) < 0.0);
        let middle = spot.texels.start + own.partition_point(|&texel| self.direction(texel).dot(axis) >= 0.0);
        [spot.texels.start..middle, middle..spot.texels.end].map(|range| self.spot(texels, range))
    }
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
        let many: Vec<(u32, u32)> = (0..200).map(|i| (3 * (i % 20), 2 + 2 * (i / 20))).collect();
        let many = map(&many);
        let (rest, lights) = clamped(&many, 2.0);
        let flux = rest.flux() + lights.iter().map(DistantLight::flux).sum::<DVec3>();
        assert_eq!(lights.len(), MANY);
        assert!((flux - many.flux()).length() < 1e-5 * many.flux().length());
    }

    /// A horizon, half a sky and all of one: irradiance is that of the map, whatever the surface looks at.
    #[test]
    fn wide_places_are_cut_and_light_from_where_they_are() {
        let rows =
            |from: u32, to: u32| (0..64).flat_map(|x| (from..to).map(move |y| (x, y))).collect::<Vec<_>>();
        for (bright, fewest) in [(rows(15, 17), 8), (rows(0, 16), 20), (rows(0, 32), 40)] {
            let map = map(&bright);
            let (rest, lights) = clamped(&map, 1.0);
            assert!(lights.len() >= fewest && lights.len() <= MOST, "{}", lights.len());
            let widest = lights.iter().map(|light| light.solid_angle).fold(0.0, f32::max);
            assert!(widest < 0.5, "{widest}");
            for normal in
                [Vec3::Y, Vec3::NEG_Y, Vec3::X, Vec3::Z, Vec3::new(0.6, 0.0, 0.8), Vec3::new(0.0, 0.6, -0.8)]
            {
                let of_lights: DVec3 = (lights.iter())
                    .map(|light| light.radiance.as_dvec3() * f64::from(light.irradiance(normal)))
                    .sum();
                let of_map = irradiance(&map, normal) - irradiance(&rest, normal);
                let all = irradiance(&map, Vec3::Y).max(irradiance(&map, Vec3::X));
                let error = ((of_lights - of_map) / all).abs().max_element();
                assert!(error < 0.03, "{normal}: {of_lights} is not {of_map}");
            }
        }
    }

    fn irradiance(map: &Equirect, normal: Vec3) -> DVec3 {
        let texels = (0..map.height()).flat_map(|y| (0..map.width()).map(move |x| (x, y)));
        let arriving = |(x, y): (u32, u32)| {
            let cosine = f64::from(map.texel_direction(x, y).dot(normal)).max(0.0);
            map.radiance().get(x, y).as_dvec3() * (cosine * map.texel_solid_angle(y))
        };
        texels.map(arriving).sum()
    }
}
