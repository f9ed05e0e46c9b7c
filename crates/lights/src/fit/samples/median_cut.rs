use std::f64::consts::{PI, TAU};

use gnomon_envmap::Equirect;

use super::grid::Grid;
use super::{Cell, Sample};

pub(super) const SUMMARY: &str =
    "cells of equal luminous flux, halved across their longer side (Debevec 2005)";

/// `count` samples of equal luminous flux, fewer only for a black map: the median cut of Debevec 2005, "A median cut
/// algorithm for light probe sampling", for any number. A region is cut across its longer side where its luminous flux
/// divides as its samples do, between texels or within one; a sample lies at the centroid of its region and carries the
/// region's flux. The map's seam lies opposite to the centroid of its light, so that samples turn with the map.
pub(super) fn sample(map: &Equirect, count: usize, _seed: u64) -> Vec<Sample> {
    let grid = Sums::new(map);
    let mut samples = Vec::with_capacity(count);
    let seam = grid.grid.seam();
    let sphere = Region { min: [seam, 0.0], max: [seam + grid.grid.width as f64, grid.grid.height as f64] };
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

/// Luminous flux of any region of a map.
struct Sums<'a> {
    grid: Grid<'a>,
    /// `(width + 1) x (height + 1)` sums of luminous flux over all texels above and to the left.
    table: Vec<f64>,
}

impl<'a> Sums<'a> {
    fn new(map: &'a Equirect) -> Self {
        let grid = Grid::new(map);
        let stride = grid.width + 1;
        let mut table = vec![0.0; stride * (grid.height + 1)];
        for y in 0..grid.height {
            let mut row = 0.0;
            for x in 0..grid.width {
                row += grid.luminous_flux(x, y);
                table[(y + 1) * stride + x + 1] = table[y * stride + x + 1] + row;
            }
        }
        Self { grid, table }
    }

    /// Luminous flux above row `y` and between the first column and `x`, once around at most twice.
    fn sum(&self, x: f64, y: f64) -> f64 {
        let (width, height) = (self.grid.width, self.grid.height);
        let turns = (x / width as f64).floor();
        let x = x - turns * width as f64;
        let cell = |at: f64, count: usize| (at as usize).min(count - 1);
        let (column, row) = (cell(x, width), cell(y, height));
        let at = |column: usize| {
            let [above, below] = [row, row + 1].map(|row| self.table[row * (width + 1) + column]);
            above + (y - row as f64) * (below - above)
        };
        let (low, high) = (at(column), at(column + 1));
        let around = if turns > 0.0 { turns * at(width) } else { 0.0 };
        around + low + (x - column as f64) * (high - low)
    }

    fn luminous_flux(&self, region: Region) -> f64 {
        let ([x0, y0], [x1, y1]) = (region.min, region.max);
        self.sum(x1, y1) - self.sum(x0, y1) - (self.sum(x1, y0) - self.sum(x0, y0))
    }

    /// 0 where a region is wider than high, by its longest circle of latitude.
    fn longer_axis(&self, region: Region) -> usize {
        let [top, bottom] =
            [region.min[1], region.max[1]].map(|y| self.grid.cos_theta(y).clamp(-1.0, 1.0).acos());
        let widest = if top <= 0.5 * PI && bottom >= 0.5 * PI { 1.0 } else { top.sin().max(bottom.sin()) };
        let width = (region.max[0] - region.min[0]) * TAU / self.grid.width as f64 * widest;
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
        let mut cell = Cell::default();
        for row in y0 as usize..(y1.ceil() as usize).min(self.grid.height) {
            let (top, bottom) = (y0.max(row as f64), y1.min((row + 1) as f64));
            for column in x0 as usize..x1.ceil() as usize {
                let (left, right) = (x0.max(column as f64), x1.min((column + 1) as f64));
                let part = (bottom - top) * (right - left);
                let flux = self.grid.flux(column % self.grid.width, row) * part;
                cell.add(flux, self.grid.direction(left.midpoint(right), top.midpoint(bottom)));
            }
        }
        cell.sample(self.grid.direction(x0.midpoint(x1), y0.midpoint(y1)))
    }
}
