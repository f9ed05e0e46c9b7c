use std::f64::consts::{PI, TAU};

use glam::DVec3;
use gnomon_envmap::Equirect;

use super::Sample;
use crate::fit::faces::luminance;

/// `count` samples of equal luminous flux, fewer only for a black map: the median cut of Debevec 2005, "A median cut
/// algorithm for light probe sampling", for any number. A region is cut across its longer side where its luminous flux
/// divides as its samples do, between texels or within one; a sample lies at the centroid of its region and carries the
/// region's flux. The map's seam lies opposite to the centroid of its light, so that samples turn with the map.
pub(super) fn sample(map: &Equirect, count: usize) -> Vec<Sample> {
    let grid = Grid::new(map);
    let mut samples = Vec::with_capacity(count);
    let seam = grid.seam();
    let sphere = Region { min: [seam, 0.0], max: [seam + grid.width as f64, grid.height as f64] };
    let mut open = vec![(sphere, count)];
    while let Some((region, count)) = open.pop() {
        let flux = grid.luminous_flux(region);
        if flux <= 0.0 {
            continue;
        }
        if count == 1 {
            samples.push(grid.centroid(region));
            continue;
        }
        let first = count / 2;
        let axis = grid.longer_axis(region);
        let at = grid.cut(region, axis, flux * first as f64 / count as f64);
        let [low, high] = region.split(axis, at);
        open.extend([(high, count - first), (low, first)]);
    }
    samples
}

/// Columns and rows from `min` to `max`, fractions included; columns go on past the seam. The fraction of a row is one of
/// its solid angle.
#[derive(Clone, Copy, Debug)]
struct Region {
    min: [f64; 2],
    max: [f64; 2],
}

impl Region {
    fn split(self, axis: usize, at: f64) -> [Self; 2] {
        let (mut low, mut high) = (self, self);
        low.max[axis] = at;
        high.min[axis] = at;
        [low, high]
    }
}

struct Grid<'a> {
    map: &'a Equirect,
    width: usize,
    height: usize,
    /// `(width + 1) x (height + 1)` sums of luminous flux over all texels above and to the left.
    table: Vec<f64>,
}

impl<'a> Grid<'a> {
    fn new(map: &'a Equirect) -> Self {
        let (width, height) = (map.width() as usize, map.height() as usize);
        let mut table = vec![0.0; (width + 1) * (height + 1)];
        for y in 0..height {
            let solid_angle = map.texel_solid_angle(y as u32);
            let mut row = 0.0;
            for x in 0..width {
                row += luminance(map.radiance().get(x as u32, y as u32).as_dvec3()) * solid_angle;
                table[(y + 1) * (width + 1) + x + 1] = table[y * (width + 1) + x + 1] + row;
            }
        }
        Self { map, width, height, table }
    }

    /// Luminous flux above row `y` and between the first column and `x`, once around at most twice.
    fn sum(&self, x: f64, y: f64) -> f64 {
        let turns = (x / self.width as f64).floor();
        let x = x - turns * self.width as f64;
        let cell = |at: f64, count: usize| (at as usize).min(count - 1);
        let (column, row) = (cell(x, self.width), cell(y, self.height));
        let at = |column: usize| {
            let [above, below] = [row, row + 1].map(|row| self.table[row * (self.width + 1) + column]);
            above + (y - row as f64) * (below - above)
        };
        let (low, high) = (at(column), at(column + 1));
        let around = if turns > 0.0 { turns * at(self.width) } else { 0.0 };
        around + low + (x - column as f64) * (high - low)
    }

    fn luminous_flux(&self, region: Region) -> f64 {
        let ([x0, y0], [x1, y1]) = (region.min, region.max);
        self.sum(x1, y1) - self.sum(x0, y1) - (self.sum(x1, y0) - self.sum(x0, y0))
    }

    /// The column opposite to the azimuth of the light's centroid.
    fn seam(&self) -> f64 {
        let mut centroid = DVec3::ZERO;
        for (x, y) in (0..self.height).flat_map(|y| (0..self.width).map(move |x| (x, y))) {
            let radiance = luminance(self.map.radiance().get(x as u32, y as u32).as_dvec3());
            let flux = radiance * self.map.texel_solid_angle(y as u32);
            centroid += flux * self.direction(x as f64 + 0.5, y as f64 + 0.5);
        }
        // The azimuth of a direction is that of its column; half a turn on is its negative.
        (-centroid.x).atan2(centroid.z).rem_euclid(TAU) / TAU * self.width as f64
    }

    /// Cosine of the polar angle of a row, whose fraction is one of solid angle.
    fn cos_theta(&self, y: f64) -> f64 {
        let row = (y as usize).min(self.height - 1);
        let edge = |row: usize| (PI * row as f64 / self.height as f64).cos();
        edge(row) + (y - row as f64) * (edge(row + 1) - edge(row))
    }

    fn direction(&self, x: f64, y: f64) -> DVec3 {
        let cos_theta = self.cos_theta(y).clamp(-1.0, 1.0);
        let sin_theta = (1.0 - cos_theta * cos_theta).sqrt();
        let (sin_phi, cos_phi) = (TAU * x / self.width as f64).sin_cos();
        DVec3::new(sin_theta * sin_phi, cos_theta, -sin_theta * cos_phi)
    }

    /// 0 where a region is wider than high, by its longest circle of latitude.
    fn longer_axis(&self, region: Region) -> usize {
        let [top, bottom] = [region.min[1], region.max[1]].map(|y| self.cos_theta(y).clamp(-1.0, 1.0).acos());
        let widest = if top <= 0.5 * PI && bottom >= 0.5 * PI { 1.0 } else { top.sin().max(bottom.sin()) };
        let width = (region.max[0] - region.min[0]) * TAU / self.width as f64 * widest;
        usize::from(width < bottom - top)
    }

    /// Where to cut a region so that the lower part has luminous flux `wanted`.
    fn cut(&self, region: Region, axis: usize, wanted: f64) -> f64 {
        let below = |at: f64| self.luminous_flux(region.split(axis, at)[0]);
        let (mut low, mut high) = (region.min[axis], region.max[axis]);
        // Whole texels first, within which flux grows linearly.
        while high.ceil() - low.floor() > 1.0 {
            let middle = (0.5 * (low.floor() + high.ceil())).floor().clamp(low, high);
            if middle <= low || middle >= high {
                break;
            }
            if below(middle) < wanted { low = middle } else { high = middle }
        }
        let (from, to) = (below(low), below(high));
        let share = if to > from { ((wanted - from) / (to - from)).clamp(0.0, 1.0) } else { 0.5 };
        low + share * (high - low)
    }

    /// All of a region's flux at its centroid.
    fn centroid(&self, region: Region) -> Sample {
        let ([x0, y0], [x1, y1]) = (region.min, region.max);
        let (mut flux, mut centroid) = (DVec3::ZERO, DVec3::ZERO);
        for row in y0 as usize..(y1.ceil() as usize).min(self.height) {
            let (top, bottom) = (y0.max(row as f64), y1.min((row + 1) as f64));
            let solid_angle = self.map.texel_solid_angle(row as u32) * (bottom - top);
            for column in x0 as usize..x1.ceil() as usize {
                let (left, right) = (x0.max(column as f64), x1.min((column + 1) as f64));
                let texel = self.map.radiance().get((column % self.width) as u32, row as u32);
                let part = texel.as_dvec3() * solid_angle * (right - left);
                flux += part;
                centroid += luminance(part) * self.direction(left.midpoint(right), top.midpoint(bottom));
            }
        }
        let direction = centroid.normalize_or(self.direction(x0.midpoint(x1), y0.midpoint(y1)));
        Sample { direction, flux }
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use gnomon_image::RgbImage;

    use super::*;

    fn lamps() -> Equirect {
        Equirect::new(RgbImage::from_fn(128, 64, |x, y| {
            let lamp = (x.abs_diff(40).pow(2) + y.abs_diff(20).pow(2) < 30) || (x, y) == (127, 31);
            let dim = Vec3::new(1.0, 0.5 + 0.01 * y as f32, 0.2 + 0.001 * x as f32);
            if lamp { dim + Vec3::new(80.0, 60.0, 30.0) } else { dim }
        }))
    }

    #[test]
    fn samples_have_equal_luminous_flux_and_together_all_of_it() {
        let map = lamps();
        for count in [1, 2, 3, 17, 500, 4096] {
            let samples = sample(&map, count);
            assert_eq!(samples.len(), count);
            let sum: DVec3 = samples.iter().map(|sample| sample.flux).sum();
            assert!((sum / map.flux() - 1.0).abs().max_element() < 1e-9, "{count}");
            let share = luminance(map.flux()) / count as f64;
            for sample in &samples {
                assert!((luminance(sample.flux) / share - 1.0).abs() < 1e-6, "{count}");
                assert!((sample.direction.length() - 1.0).abs() < 1e-12);
            }
        }
    }

    /// Largest difference, over many caps, between the share of samples and the share of luminous flux inside.
    fn discrepancy(map: &Equirect, directions: &[DVec3]) -> f64 {
        let total = luminance(map.flux());
        let mut worst: f64 = 0.0;
        for cap in 0..60 {
            let y = 1.0 - (2.0 * f64::from(cap) + 1.0) / 60.0;
            let (sin, cos) = (2.4 * f64::from(cap)).sin_cos();
            let axis = DVec3::new((1.0 - y * y).sqrt() * sin, y, (1.0 - y * y).sqrt() * cos);
            for cos_radius in [0.95, 0.7, 0.2] {
                let mut inside = 0.0;
                for (x, y) in (0..map.height()).flat_map(|y| (0..map.width()).map(move |x| (x, y))) {
                    if map.texel_direction(x, y).as_dvec3().dot(axis) > cos_radius {
                        inside += luminance(map.radiance().get(x, y).as_dvec3()) * map.texel_solid_angle(y);
                    }
                }
                let hits = directions.iter().filter(|direction| direction.dot(axis) > cos_radius).count();
                worst = worst.max((hits as f64 / directions.len() as f64 - inside / total).abs());
            }
        }
        worst
    }

    #[test]
    fn samples_follow_the_luminance_far_closer_than_chance() {
        let map = lamps();
        for count in [64, 1000] {
            let directions: Vec<DVec3> = sample(&map, count).iter().map(|sample| sample.direction).collect();
            let found = discrepancy(&map, &directions);
            // Independent samples would be off by up to about 1.5 / sqrt(count).
            assert!(found < 1.2 * (count as f64).powf(-0.7), "{count}: {found}");
            // The checker must see samples that ignore the lamps.
            let even: Vec<DVec3> = (0..count)
                .map(|i| {
                    let y = 1.0 - (2.0 * i as f64 + 1.0) / count as f64;
                    let (sin, cos) = (2.399_963 * i as f64).sin_cos();
                    DVec3::new((1.0 - y * y).sqrt() * sin, y, (1.0 - y * y).sqrt() * cos)
                })
                .collect();
            assert!(discrepancy(&map, &even) > 0.2);
        }
    }
}
