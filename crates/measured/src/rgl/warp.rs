//! Functions over the unit square, and the warp that brings even samples to such a density; slices stand for views between which they are
//! interpolated.

use crate::error::{MeasuredError, invalid};

/// Slices of values over the unit square, bilinear between texels whose outermost ones lie on its border.
#[derive(Clone, Debug)]
pub struct Grid {
    size: [usize; 2],
    values: Vec<f32>,
}

/// Texels around a place.
struct Cell {
    /// Column and row of the first.
    place: [usize; 2],
    /// From there on, in texels.
    along: [f32; 2],
}

impl Grid {
    /// Slices of so many columns and rows.
    pub fn new(size: [usize; 2], values: Vec<f32>) -> Result<Self, MeasuredError> {
        if size.iter().any(|side| *side < 2) {
            return Err(invalid("a table must have at least two rows and columns"));
        }
        Ok(Self { size, values })
    }

    fn cell(&self, at: [f32; 2]) -> Cell {
        let place = |axis: usize| at[axis].clamp(0.0, 1.0) * (self.size[axis] - 1) as f32;
        let first = |axis: usize| (place(axis) as usize).min(self.size[axis] - 2);
        let corner = [first(0), first(1)];
        Cell { place: corner, along: [place(0) - corner[0] as f32, place(1) - corner[1] as f32] }
    }

    fn index(&self, slice: usize, [column, row]: [usize; 2]) -> usize {
        (slice * self.size[1] + row) * self.size[0] + column
    }

    /// A slice's value.
    pub fn at(&self, slice: usize, at: [f32; 2]) -> f32 {
        let Cell { place, along } = self.cell(at);
        let first = self.index(slice, place);
        let row =
            |start: usize| self.values[start] + along[0] * (self.values[start + 1] - self.values[start]);
        let (low, high) = (row(first), row(first + self.size[0]));
        low + along[1] * (high - low)
    }
}

/// Views that slices stand for.
#[derive(Clone, Debug)]
pub struct Parameters {
    phi: Vec<f32>,
    theta: Vec<f32>,
}

impl Parameters {
    /// Rising angles [rad].
    pub fn new(phi: Vec<f32>, theta: Vec<f32>) -> Result<Self, MeasuredError> {
        if !phi.windows(2).chain(theta.windows(2)).all(|pair| pair[0] < pair[1]) {
            return Err(invalid("'phi_i' and 'theta_i' must rise"));
        }
        Ok(Self { phi, theta })
    }

    /// Four slices and their weights, which sum to 1.
    pub fn slices(&self, phi: f32, theta: f32) -> [(usize, f32); 4] {
        let between = |values: &[f32], value: f32| match values.len() {
            1 => [(0, 1.0), (0, 0.0)],
            count => {
                let low = values.partition_point(|other| *other <= value).clamp(1, count - 1) - 1;
                let along = ((value - values[low]) / (values[low + 1] - values[low])).clamp(0.0, 1.0);
                [(low, 1.0 - along), (low + 1, along)]
            }
        };
        let [a, b] = between(&self.phi, phi);
        let [c, d] = between(&self.theta, theta);
        [(a, c), (a, d), (b, c), (b, d)].map(|(p, t)| (p.0 * self.theta.len() + t.0, p.1 * t.1))
    }
}

/// A density over the unit square, each slice with the integral 1, and the sums that invert its sampling.
#[derive(Clone, Debug)]
pub struct Warp {
    density: Grid,
    /// Of every row the integral from its start.
    conditional: Grid,
    /// Integral of the rows from the first on, a column of each slice.
    marginal: Vec<f32>,
}

impl Warp {
    /// Of densities up to their scale.
    pub fn new(mut density: Grid) -> Self {
        let [columns, rows] = density.size;
        let mut sums = vec![0.0; density.values.len()];
        let mut marginal = Vec::with_capacity(density.values.len() / columns);
        for (slice, values) in density.values.chunks_mut(columns * rows).enumerate() {
            let of_slice = &mut sums[slice * columns * rows..][..columns * rows];
            for (row, values) in values.chunks(columns).enumerate() {
                let mut sum = 0.0f64;
                for column in 1..columns {
                    sum += 0.5 * (f64::from(values[column - 1]) + f64::from(values[column]));
                    of_slice[row * columns + column] = sum as f32;
                }
            }
            let end = |row: usize| f64::from(of_slice[(row + 1) * columns - 1]);
            let mut below = vec![0.0f64];
            let mut sum = 0.0;
            for row in 1..rows {
                sum += 0.5 * (end(row - 1) + end(row));
                below.push(sum);
            }
            let scale = if sum > 0.0 { 1.0 / sum } else { 0.0 };
            marginal.extend(below.into_iter().map(|below| (below * scale) as f32));
            values.iter_mut().chain(of_slice).for_each(|value| *value = (f64::from(*value) * scale) as f32);
        }
        let conditional = Grid { size: density.size, values: sums };
        Self { density, conditional, marginal }
    }

    /// The even sample that the warp brings to a place.
    pub fn inverted(&self, at: [f32; 2], slices: &[(usize, f32); 4]) -> [f32; 2] {
        let Cell { place: [column, row], along: [x, y] } = self.density.cell(at);
        let mean = |grid: &Grid, column: usize, row: usize| -> f32 {
            slices.iter().map(|&(slice, weight)| weight * grid.values[grid.index(slice, [column, row])]).sum()
        };
        let [columns, rows] = self.density.size;
        // Across the row: the density there is linear between its two ends.
        let density = |column| {
            let (low, high) = (mean(&self.density, column, row), mean(&self.density, column, row + 1));
            low + y * (high - low)
        };
        let (left, right) = (density(column), density(column + 1));
        let within = x * (left + 0.5 * x * (right - left));
        let before = |row: usize| mean(&self.conditional, column, row);
        let whole = |row: usize| mean(&self.conditional, columns - 1, row);
        let before = before(row) + y * (before(row + 1) - before(row));
        let (first, last) = (whole(row), whole(row + 1));
        let all = first + y * (last - first);
        let u = if all > 0.0 { (before + within) / all } else { 0.0 };
        let below: f32 =
            slices.iter().map(|&(slice, weight)| weight * self.marginal[slice * rows + row]).sum();
        [u.clamp(0.0, 1.0), (below + y * (first + 0.5 * y * (last - first))).clamp(0.0, 1.0)]
    }
}
