use std::cmp::Ordering;
use std::collections::BinaryHeap;

use glam::DVec4;
use gnomon_envmap::Equirect;

use super::grid::Grid;
use super::{Cell, Sample};

pub(super) const SUMMARY: &str =
    "cells cut where their light then spreads least (Viriyothai and Debevec 2009)";

/// `count` samples at the centroids of rectangles of texels, fewer only where fewer texels are not black: Viriyothai and
/// Debevec 2009, "Variance minimization light probe sampling". A region's variance is the sum over its texels of luminous
/// flux times squared distance to the centroid, on the sphere. A region is cut, along either axis, where the larger variance
/// of both parts is least. Where the paper cuts all regions in turn, here the one of largest variance is next, for any number.
/// The map's seam lies opposite to the centroid of its light.
pub(super) fn sample(map: &Equirect, count: usize, _seed: u64) -> Vec<Sample> {
    let sums = Sums::new(map);
    let mut open = BinaryHeap::from_iter(sums.region([0, 0], [sums.grid.width, sums.grid.height]));
    let mut done = Vec::new();
    while done.len() + open.len() < count {
        let Some(region) = open.pop() else { break };
        match sums.best_cut(region) {
            Some(parts) => open.extend(parts),
            None => done.push(region),
        }
    }
    done.extend(open);
    done.iter().map(|region| sums.centroid(region)).collect()
}

/// Texels that become one sample: columns, from the seam, and rows from `min` up to but without `max`. Regions are ordered
/// by variance, equal ones by place.
#[derive(Clone, Copy)]
struct Region {
    variance: f64,
    min: [usize; 2],
    max: [usize; 2],
}

impl Ord for Region {
    fn cmp(&self, other: &Self) -> Ordering {
        self.variance.total_cmp(&other.variance).then_with(|| other.min.cmp(&self.min))
    }
}

impl PartialOrd for Region {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Region {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Region {}

/// Luminous flux and its first moments over any region.
struct Sums<'a> {
    grid: Grid<'a>,
    /// Column of the map at which regions start.
    seam: usize,
    /// `(width + 1) x (height + 1)` sums over all texels above and to the left of `(flux x direction, flux)`.
    table: Vec<DVec4>,
    /// Luminous flux below which a region is black: more than the sums round.
    black: f64,
}

impl<'a> Sums<'a> {
    fn new(map: &'a Equirect) -> Self {
        let grid = Grid::new(map);
        let (stride, seam) = (grid.width + 1, grid.seam().round() as usize % grid.width);
        let mut table = vec![DVec4::ZERO; stride * (grid.height + 1)];
        for y in 0..grid.height {
            let mut row = DVec4::ZERO;
            for x in 0..grid.width {
                let column = (x + seam) % grid.width;
                let direction = grid.direction(column as f64 + 0.5, y as f64 + 0.5);
                row += grid.luminous_flux(column, y) * direction.extend(1.0);
                table[(y + 1) * stride + x + 1] = table[y * stride + x + 1] + row;
            }
        }
        let total = table.last().map_or(0.0, |sum| sum.w);
        Self { grid, seam, table, black: 1e-13 * total }
    }

    fn sum(&self, min: [usize; 2], max: [usize; 2]) -> DVec4 {
        let at = |x: usize, y: usize| self.table[y * (self.grid.width + 1) + x];
        at(max[0], max[1]) - at(min[0], max[1]) - (at(max[0], min[1]) - at(min[0], min[1]))
    }

    /// Sum of luminous flux times squared distance to the centroid; `None` for a black region.
    fn variance(&self, min: [usize; 2], max: [usize; 2]) -> Option<f64> {
        let sum = self.sum(min, max);
        // Directions are unit: the mean square about the mean is 1 - |mean|^2.
        (sum.w > self.black).then(|| (sum.w - sum.truncate().length_squared() / sum.w).max(0.0))
    }

    /// `None` if it is black.
    fn region(&self, min: [usize; 2], max: [usize; 2]) -> Option<Region> {
        self.variance(min, max).map(|variance| Region { variance, min, max })
    }

    /// The parts that are not black after the best cut; `None` for a single texel.
    fn best_cut(&self, region: Region) -> Option<impl Iterator<Item = Region>> {
        let parts = |axis: usize, at: usize| {
            let (mut low_max, mut high_min) = (region.max, region.min);
            low_max[axis] = at;
            high_min[axis] = at;
            [(region.min, low_max), (high_min, region.max)]
        };
        let worse = |parts: [([usize; 2], [usize; 2]); 2]| {
            parts.map(|(min, max)| self.variance(min, max).unwrap_or(0.0)).into_iter().fold(0.0, f64::max)
        };
        let cuts = (0..2).flat_map(|axis| (region.min[axis] + 1..region.max[axis]).map(move |at| (axis, at)));
        let (_, best) = cuts
            .map(|(axis, at)| (worse(parts(axis, at)), parts(axis, at)))
            .reduce(|best, next| if next.0 < best.0 { next } else { best })?;
        Some(best.into_iter().filter_map(|(min, max)| self.region(min, max)))
    }

    /// All of a region's flux at its centroid.
    fn centroid(&self, region: &Region) -> Sample {
        let mut cell = Cell::default();
        for y in region.min[1]..region.max[1] {
            for x in region.min[0]..region.max[0] {
                let column = (x + self.seam) % self.grid.width;
                let direction = self.grid.direction(column as f64 + 0.5, y as f64 + 0.5);
                cell.add(self.grid.flux(column, y), direction);
            }
        }
        let middle = |axis: usize| 0.5 * (region.min[axis] + region.max[axis]) as f64;
        cell.sample(self.grid.direction(middle(0) + self.seam as f64, middle(1)))
    }
}
