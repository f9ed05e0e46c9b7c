use std::f64::consts::{PI, TAU};

use glam::DVec3;
use gnomon_envmap::Equirect;

use super::grid::Grid;
use super::{Cell, Sample};
use crate::fit::faces::luminance;
use crate::fit::sphere_grid::cone_half_width;

pub(super) const SUMMARY: &str =
    "levels of radiance, each covered evenly by farthest-first points (Agarwal et al. 2003)";

/// Levels of radiance, one standard deviation apart (section 4.1).
const LEVELS: usize = 6;
/// Exponent of a stratum's solid angle in its importance, the exponent of its flux being 1 (section 3.2).
const SOLID_ANGLE_EXPONENT: f64 = 0.25;
/// Solid angle [sr] beyond which a stratum matters no more: parts of it that are farther apart are hidden independently.
const SOLID_ANGLE_LIMIT: f64 = 0.01;
/// A connected part of a level is a stratum of its own if its importance is worth so many samples.
const LEAST_SAMPLES: f64 = 2.0;
/// Columns of a row that share one maximum.
const BLOCK: usize = 64;

/// `count` samples, fewer only where fewer texels are not black: Agarwal, Ramamoorthi, Belongie and Jensen 2003, "Structured
/// importance sampling of environment maps". A stratum is a connected part of the map between two levels of radiance, and all small
/// parts between these are one. Samples are shared out by flux times the fourth root of solid angle, and within a stratum each is
/// placed on the texel farthest from those before (Hochbaum and Shmoys 1985). A sample then stands for the texels of its stratum that
/// are nearest to it, at their centroid.
pub(super) fn sample(map: &Equirect, count: usize, _seed: u64) -> Vec<Sample> {
    let grid = Grid::new(map);
    let mut strata = strata(&grid, count);
    share_out(&mut strata, count);
    let mut spread = Spread::new(&grid);
    strata.iter().flat_map(|stratum| spread.over(stratum)).collect()
}

/// Texels of similar radiance.
#[derive(Clone, Default)]
struct Stratum {
    /// Indices, row by row.
    texels: Vec<usize>,
    luminous_flux: f64,
    solid_angle: f64,
    samples: usize,
}

impl Stratum {
    fn add(&mut self, grid: &Grid<'_>, texel: usize) {
        let (x, y) = (texel % grid.width, texel / grid.width);
        self.texels.push(texel);
        self.luminous_flux += grid.luminous_flux(x, y);
        self.solid_angle += grid.solid_angle(y);
    }

    fn merge(&mut self, other: Self) {
        self.texels.extend(other.texels);
        self.luminous_flux += other.luminous_flux;
        self.solid_angle += other.solid_angle;
    }

    /// The metric of section 3.2.
    fn importance(&self) -> f64 {
        self.luminous_flux * self.solid_angle.min(SOLID_ANGLE_LIMIT).powf(SOLID_ANGLE_EXPONENT)
    }
}

/// At most `count` strata of texels that are not black.
fn strata(grid: &Grid<'_>, count: usize) -> Vec<Stratum> {
    // At most half as many parts are worth two samples each.
    let levels = LEVELS.min(count.div_ceil(2));
    let parts = connected_parts(grid, &texel_levels(grid, levels));
    let total: f64 = parts.iter().map(|(_, part)| part.importance()).sum();
    let mut small = vec![Stratum::default(); levels];
    let mut strata = Vec::new();
    for (level, part) in parts {
        if part.importance() * count as f64 >= LEAST_SAMPLES * total {
            strata.push(part);
        } else {
            small[level].merge(part);
        }
    }
    strata.extend(small.into_iter().filter(|stratum| !stratum.texels.is_empty()));
    strata
}

/// Level of every texel, one standard deviation of radiance each; `None` for black ones.
fn texel_levels(grid: &Grid<'_>, levels: usize) -> Vec<Option<usize>> {
    let (mut mean, mut square) = (0.0, 0.0);
    for (x, y) in grid.texels() {
        let radiance = luminance(grid.radiance(x, y));
        mean += radiance * grid.solid_angle(y) / (4.0 * PI);
        square += radiance * radiance * grid.solid_angle(y) / (4.0 * PI);
    }
    let deviation = (square - mean * mean).max(0.0).sqrt();
    let level = |radiance: f64| {
        // A map without contrast is one level.
        let level = if deviation > 0.0 { (radiance / deviation) as usize } else { 0 };
        (radiance > 0.0).then_some(level.min(levels - 1))
    };
    grid.texels().map(|(x, y)| level(luminance(grid.radiance(x, y)))).collect()
}

/// Parts of one level whose texels touch, across the seam too, each with its level.
fn connected_parts(grid: &Grid<'_>, levels: &[Option<usize>]) -> Vec<(usize, Stratum)> {
    let (width, height) = (grid.width, grid.height);
    let mut is_open = vec![true; levels.len()];
    let mut parts = Vec::new();
    for start in 0..levels.len() {
        let Some(level) = levels[start].filter(|_| is_open[start]) else { continue };
        let (mut part, mut front) = (Stratum::default(), vec![start]);
        is_open[start] = false;
        while let Some(texel) = front.pop() {
            part.add(grid, texel);
            let (x, y) = (texel % width, texel / width);
            for row in y.saturating_sub(1)..=(y + 1).min(height - 1) {
                for next in [width - 1, 0, 1].map(|step| row * width + (x + step) % width) {
                    if is_open[next] && levels[next] == Some(level) {
                        is_open[next] = false;
                        front.push(next);
                    }
                }
            }
        }
        parts.push((level, part));
    }
    parts
}

/// Gives each stratum one sample, then the next one to the stratum with most importance for those it has (Webster's method),
/// until all are shared out or every texel has one. There are at least as many samples as strata.
fn share_out(strata: &mut [Stratum], count: usize) {
    strata.iter_mut().for_each(|stratum| stratum.samples = 1);
    for _ in strata.len()..count {
        let want = |stratum: &Stratum| stratum.importance() / (2 * stratum.samples + 1) as f64;
        let open = strata.iter_mut().filter(|stratum| stratum.samples < stratum.texels.len());
        match open.max_by(|a, b| want(a).total_cmp(&want(b))) {
            Some(stratum) => stratum.samples += 1,
            None => break,
        }
    }
}

/// How far a texel is from the nearest sample (one minus the cosine), then its luminous flux: the largest is next.
type Need = (f64, f64);

/// The need of a texel of another stratum.
const NONE: Need = (f64::NEG_INFINITY, 0.0);

/// Samples spreading over a stratum. A new one lies as far from all others as any texel does, so only texels within that
/// distance of it can become its own.
struct Spread<'a> {
    grid: &'a Grid<'a>,
    /// Sine and cosine of the polar angle of each row's middle.
    polar: Vec<(f64, f64)>,
    /// Cosine of the azimuth between columns that are so many columns apart: the same for turned maps to the last bit.
    cos_azimuth: Vec<f64>,
    needs: Vec<Need>,
    /// Largest need of each block.
    blocks: Vec<Need>,
    /// Index of the nearest sample.
    owner: Vec<u32>,
}

impl<'a> Spread<'a> {
    fn new(grid: &'a Grid<'a>) -> Self {
        let (width, height) = (grid.width, grid.height);
        let cos_azimuth = |x: usize| (TAU * x.min(width - x) as f64 / width as f64).cos();
        Self {
            grid,
            polar: (0..height).map(|y| (PI * (y as f64 + 0.5) / height as f64).sin_cos()).collect(),
            cos_azimuth: (0..width).map(cos_azimuth).collect(),
            needs: vec![NONE; width * height],
            blocks: vec![NONE; width.div_ceil(BLOCK) * height],
            owner: vec![0; width * height],
        }
    }

    /// The samples of a stratum.
    fn over(&mut self, stratum: &Stratum) -> Vec<Sample> {
        self.place(stratum);
        let samples = self.samples(stratum);
        for &texel in &stratum.texels {
            self.needs[texel] = NONE;
            let block = self.block_of(texel);
            self.blocks[block] = NONE;
        }
        samples
    }

    fn block_of(&self, texel: usize) -> usize {
        texel / self.grid.width * self.grid.width.div_ceil(BLOCK) + texel % self.grid.width / BLOCK
    }

    /// One minus the cosine of the angle between two texels.
    fn distance(&self, a: usize, b: usize) -> f64 {
        let width = self.grid.width;
        let ((sin_a, cos_a), (sin_b, cos_b)) = (self.polar[a / width], self.polar[b / width]);
        1.0 - (sin_a * sin_b * self.cos_azimuth[(a % width).abs_diff(b % width)] + cos_a * cos_b)
    }

    /// Places a stratum's samples; the first on the texel of most flux.
    fn place(&mut self, stratum: &Stratum) {
        for &texel in &stratum.texels {
            let (x, y) = (texel % self.grid.width, texel / self.grid.width);
            let need = (f64::INFINITY, self.grid.luminous_flux(x, y));
            self.needs[texel] = need;
            let block = self.block_of(texel);
            if need > self.blocks[block] {
                self.blocks[block] = need;
            }
        }
        for sample in 0..stratum.samples as u32 {
            let Some(texel) = self.neediest() else { return };
            let distance = match self.needs[texel].0 {
                f64::INFINITY => stratum.texels.iter().map(|&b| self.distance(texel, b)).fold(0.0, f64::max),
                distance => distance,
            };
            self.add(sample, texel, (1.0 - distance).clamp(-1.0, 1.0).acos() + 1e-6);
        }
    }

    fn neediest(&self) -> Option<usize> {
        let largest = |needs: &[Need]| {
            (0..needs.len()).reduce(|best, next| if needs[next] > needs[best] { next } else { best })
        };
        let per_row = self.grid.width.div_ceil(BLOCK);
        let block = largest(&self.blocks)?;
        let start = block / per_row * self.grid.width + block % per_row * BLOCK;
        let end = (start + BLOCK).min((block / per_row + 1) * self.grid.width);
        Some(start + largest(&self.needs[start..end])?)
    }

    /// Gives `sample`, on a texel, every texel within `radius` [rad] that is nearer to it than to any other.
    fn add(&mut self, sample: u32, texel: usize, radius: f64) {
        let (width, height) = (self.grid.width, self.grid.height);
        let (column, row) = (texel % width, texel / width);
        let theta = |row: f64| PI * (row + 0.5) / height as f64;
        let rows_around = radius / PI * height as f64;
        let first = (row as f64 - rows_around).floor().max(0.0) as usize;
        let last = ((row as f64 + rows_around).ceil() as usize).min(height - 1);
        for y in first..=last {
            let reach = cone_half_width(theta(row as f64), theta(y as f64), radius) / TAU * width as f64;
            let columns = (2 * reach.ceil() as usize + 1).min(width);
            let start = (column + width - columns / 2) % width;
            for x in (0..columns).map(|step| (start + step) % width) {
                let index = y * width + x;
                let distance = self.distance(index, texel);
                let need = &mut self.needs[index];
                if distance < need.0 {
                    need.0 = if index == texel { 0.0 } else { distance.max(f64::MIN_POSITIVE) };
                    self.owner[index] = sample;
                }
            }
            let to_edge = columns.min(width - start);
            self.find_largest(y, start, start + to_edge);
            self.find_largest(y, 0, columns - to_edge);
        }
    }

    /// Brings the blocks of a row up to date that hold columns from `start` up to but without `end`.
    fn find_largest(&mut self, y: usize, start: usize, end: usize) {
        let width = self.grid.width;
        for block in start / BLOCK..end.div_ceil(BLOCK) {
            let needs = &self.needs[y * width + block * BLOCK..y * width + ((block + 1) * BLOCK).min(width)];
            let largest = needs.iter().copied().fold(NONE, |a, b| if b > a { b } else { a });
            self.blocks[y * width.div_ceil(BLOCK) + block] = largest;
        }
    }

    /// The samples with the flux of their texels, at their centroids.
    fn samples(&self, stratum: &Stratum) -> Vec<Sample> {
        let mut cells = vec![Cell::default(); stratum.samples];
        let mut anywhere = vec![DVec3::Y; stratum.samples];
        for &texel in &stratum.texels {
            let (x, y) = (texel % self.grid.width, texel / self.grid.width);
            let direction = self.grid.direction(x as f64 + 0.5, y as f64 + 0.5);
            let owner = self.owner[texel] as usize;
            cells[owner].add(self.grid.flux(x, y), direction);
            anywhere[owner] = direction;
        }
        cells.iter().zip(anywhere).map(|(cell, direction)| cell.sample(direction)).collect()
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use gnomon_picture::RgbImage;

    use super::*;

    fn map() -> Equirect {
        Equirect::new(RgbImage::from_fn(150, 60, |x, y| {
            let noise = ((x * 7919 + y * 104_729) % 1013) as f32 / 1013.0;
            Vec3::splat(if x.abs_diff(50).pow(2) + y.abs_diff(20).pow(2) < 90 { 40.0 } else { 0.0 } + noise)
        }))
    }

    #[test]
    fn samples_lie_where_searching_every_texel_puts_them() {
        let map = map();
        let grid = Grid::new(&map);
        for mut stratum in strata(&grid, 40) {
            stratum.samples = 60.min(stratum.texels.len());
            let mut spread = Spread::new(&grid);
            spread.place(&stratum);
            let towards =
                |texel: usize| map.texel_direction((texel % 150) as u32, (texel / 150) as u32).as_dvec3();
            let directions: Vec<DVec3> = stratum.texels.iter().map(|&texel| towards(texel)).collect();
            let centres: Vec<DVec3> = (0..stratum.samples as u32)
                .map(|sample| {
                    let own =
                        |texel: &&usize| spread.owner[**texel] == sample && spread.needs[**texel].0 == 0.0;
                    towards(*stratum.texels.iter().find(own).unwrap())
                })
                .collect();
            for count in 1..centres.len() {
                let gap = |w: DVec3| centres[..count].iter().map(|c| c.angle_between(w)).fold(9.0, f64::min);
                let largest = directions.iter().map(|w| gap(*w)).fold(0.0, f64::max);
                assert!(gap(centres[count]) > largest - 1e-4, "{count}: {} {largest}", gap(centres[count]));
            }
            for (direction, texel) in directions.iter().zip(&stratum.texels) {
                let own = centres[spread.owner[*texel] as usize].angle_between(*direction);
                let nearest = centres.iter().map(|c| c.angle_between(*direction)).fold(9.0, f64::min);
                assert!(own < nearest + 1e-4);
            }
        }
    }

    #[test]
    fn a_small_lamp_has_more_samples_for_its_size_and_fewer_for_its_flux() {
        let lamp = |x: u32, y: u32| x.abs_diff(70) <= 1 && y.abs_diff(40) <= 1;
        let map = Equirect::new(RgbImage::from_fn(300, 150, |x, y| {
            Vec3::splat(if lamp(x, y) { 200.0 } else { 0.5 })
        }));
        let mut strata = strata(&Grid::new(&map), 60);
        share_out(&mut strata, 60);
        let [lamp, sky] = &strata[..] else { panic!("{} strata", strata.len()) };
        let [lamp, sky] = if lamp.texels.len() == 9 { [lamp, sky] } else { [sky, lamp] };
        assert!((lamp.texels.len(), lamp.samples + sky.samples) == (9, 60));
        let per = |stratum: &Stratum, what: f64| stratum.samples as f64 / what;
        assert!(per(lamp, lamp.solid_angle) > 2.0 * per(sky, sky.solid_angle));
        assert!(per(lamp, lamp.luminous_flux) < per(sky, sky.luminous_flux));
    }
}
