use glam::DVec3;
use gnomon_envmap::Equirect;

use super::Sample;
use super::grid::Grid;
use crate::fit::faces::luminance;

pub(super) const SUMMARY: &str = "one random point in each of equal parts of the luminance's inverse CDF";

/// `count` samples, fewer only for a black map: the unit square in as many rectangles of equal area, as nearly square on the
/// map as that allows, one random point in each, and both through the inverse of the map's cumulative luminous flux, rows
/// first and then columns. Directions have the density of luminance; each sample carries the flux of its own rectangle, which
/// is an equal share of the luminous flux. The map's seam lies opposite to the centroid of its light.
pub(super) fn sample(map: &Equirect, count: usize, seed: u64) -> Vec<Sample> {
    let inverse = InverseCdf::new(map);
    if inverse.total() <= 0.0 {
        return Vec::new();
    }
    let bands = ((0.5 * count as f64).sqrt().round() as usize).clamp(1, count);
    let first_of = |band: usize| band * count / bands;
    let mut samples = Vec::with_capacity(count);
    for band in 0..bands {
        let (from, to) = (first_of(band), first_of(band + 1));
        let edges = [from, to].map(|index| index as f64 / count as f64);
        let fluxes = inverse.fluxes(edges, to - from);
        for (column, flux) in fluxes.into_iter().enumerate() {
            let [u, v] = [0, 1].map(|axis| uniform(seed, (2 * (from + column) + axis) as u64));
            let share = (column as f64 + u) / (to - from) as f64;
            let direction = inverse.direction(edges[0] + v * (edges[1] - edges[0]), share);
            samples.push(Sample { direction, flux });
        }
    }
    samples
}

/// The `index`th number of a sequence, in [0, 1): SplitMix64 (Steele, Lea and Flood 2014).
fn uniform(seed: u64, index: u64) -> f64 {
    let mix = |z: u64| {
        let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    };
    let state = mix(seed).wrapping_add(index.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15));
    (mix(state) >> 11) as f64 / (1_u64 << 53) as f64
}

/// Running sums of flux over a map.
struct InverseCdf<'a> {
    grid: Grid<'a>,
    seam: f64,
    /// Luminous flux of all rows above each row's edge: `height + 1` sums.
    rows: Vec<f64>,
    /// Flux of all texels to the left in the same row: `width + 1` sums a row.
    columns: Vec<DVec3>,
}

impl<'a> InverseCdf<'a> {
    fn new(map: &'a Equirect) -> Self {
        let grid = Grid::new(map);
        let mut rows = vec![0.0];
        let mut columns = Vec::with_capacity((grid.width + 1) * grid.height);
        for y in 0..grid.height {
            let mut sum = DVec3::ZERO;
            columns.push(sum);
            for x in 0..grid.width {
                sum += grid.flux(x, y);
                columns.push(sum);
            }
            rows.push(rows[y] + luminance(sum));
        }
        let seam = grid.seam();
        Self { grid, seam, rows, columns }
    }

    /// Luminous flux of the whole map.
    fn total(&self) -> f64 {
        self.rows[self.grid.height]
    }

    /// The row, with its fraction, above which there is `share` of the luminous flux.
    fn row(&self, share: f64) -> f64 {
        place(&self.rows, share * self.total(), |sum| *sum)
    }

    fn sums(&self, row: usize) -> &[DVec3] {
        &self.columns[row * (self.grid.width + 1)..(row + 1) * (self.grid.width + 1)]
    }

    /// Flux of a row between its first column and `x`.
    fn flux_before(&self, row: usize, x: f64) -> DVec3 {
        let sums = self.sums(row);
        let column = (x as usize).min(self.grid.width - 1);
        sums[column] + (x - column as f64) * (sums[column + 1] - sums[column])
    }

    /// The column of a row between which and the seam there is `share` of its luminous flux, and the flux between its first
    /// column and there; past the last column both go on.
    fn column(&self, row: usize, share: f64) -> (f64, DVec3) {
        let sums = self.sums(row);
        let total = sums[self.grid.width];
        let wanted = luminance(self.flux_before(row, self.seam)) + share * luminance(total);
        let turns = if wanted >= luminance(total) { 1.0 } else { 0.0 };
        let x = place(sums, wanted - turns * luminance(total), |sum| luminance(*sum));
        (x + turns * self.grid.width as f64, self.flux_before(row, x) + turns * total)
    }

    /// Fluxes of the `parts` equal parts, by luminous flux in each row, of the band between two shares of the whole.
    fn fluxes(&self, band: [f64; 2], parts: usize) -> Vec<DVec3> {
        let [top, bottom] = band.map(|share| self.row(share));
        let mut fluxes = vec![DVec3::ZERO; parts];
        for row in top as usize..(bottom.ceil() as usize).min(self.grid.height) {
            let share = bottom.min((row + 1) as f64) - top.max(row as f64);
            let start = self.flux_before(row, self.seam);
            let mut before = start;
            for (part, flux) in fluxes.iter_mut().enumerate() {
                let is_last = part + 1 == parts;
                let end = match is_last {
                    true => start + self.sums(row)[self.grid.width],
                    false => self.column(row, (part + 1) as f64 / parts as f64).1,
                };
                *flux += share * (end - before).max(DVec3::ZERO);
                before = end;
            }
        }
        fluxes
    }

    /// The direction that has `above` of the luminous flux in the rows above it, and `share` of its row's between the seam and
    /// itself.
    fn direction(&self, above: f64, share: f64) -> DVec3 {
        let y = self.row(above);
        let row = (y as usize).min(self.grid.height - 1);
        self.grid.direction(self.column(row, share).0, y)
    }
}

/// Where running sums reach `wanted`, in indices and linearly between them.
fn place<T>(sums: &[T], wanted: f64, value: impl Fn(&T) -> f64) -> f64 {
    // The first edge beyond `wanted`, so that the part before it holds flux.
    let end = sums.partition_point(|sum| value(sum) <= wanted).clamp(1, sums.len() - 1);
    let (low, high) = (value(&sums[end - 1]), value(&sums[end]));
    let fraction = if high > low { ((wanted - low) / (high - low)).clamp(0.0, 1.0) } else { 1.0 };
    (end - 1) as f64 + fraction
}
