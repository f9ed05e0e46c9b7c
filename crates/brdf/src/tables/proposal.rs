use std::f32::consts::{FRAC_2_PI, PI, TAU};

use glam::{Vec2, Vec3};

use super::quarter_angle;
use super::table::{Table, spread_place, unspread_place};
use crate::sampling::reflect;

/// A density of half vectors, constant over cells of their angle delta to the normal and of their azimuth: what samples of tables are drawn
/// from. Both the density and its integrals are a table.
#[derive(Clone, Debug, PartialEq)]
pub struct Proposal {
    /// Of a column's cells up to this one their share, the density [1/sr], the share of all columns up to this one.
    cells: Table,
    /// Where columns lie.
    scale: f32,
}

const COLUMNS: usize = 64;
/// Cells around the normal, of what is not isotropic.
const ROWS: usize = 32;
/// Cosines to the viewer that a density is a mean over.
const VIEWS: [f32; 5] = [0.97, 0.8, 0.55, 0.3, 0.12];
/// Azimuths of the viewer, of what is not isotropic.
const AZIMUTHS: usize = 6;
/// Azimuths of half vectors that are summed over, of what is isotropic: half a turn of them.
const ISOTROPIC_AZIMUTHS: usize = 24;

/// `sin^2 (delta / 2)` of a column's lower border: where cells are cut evenly in solid angle, `1 - cos` without its rounding.
fn half_sine2(place: f32, scale: f32) -> f32 {
    let sine = (0.5 * quarter_angle(unspread_place(place, scale))).sin();
    sine * sine
}

fn direction(half_sine2: f32, azimuth: f32) -> Vec3 {
    let (sin, cos) = azimuth.sin_cos();
    let sine = 2.0 * (half_sine2 * (1.0 - half_sine2)).max(0.0).sqrt();
    Vec3::new(sine * cos, sine * sin, 1.0 - 2.0 * half_sine2)
}

fn view(n_dot_v: f32, azimuth: f32) -> Vec3 {
    let (sin, cos) = azimuth.sin_cos();
    let sine = ((1.0 - n_dot_v) * (1.0 + n_dot_v)).max(0.0).sqrt();
    Vec3::new(sine * cos, sine * sin, n_dot_v)
}

/// First of `count` rising numbers that exceeds `u`.
fn first_above(u: f32, count: usize, number: impl Fn(usize) -> f32) -> usize {
    let (mut low, mut high) = (0, count - 1);
    while low < high {
        let middle = (low + high) / 2;
        if number(middle) > u {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    low
}

impl Proposal {
    /// One for a reflectance `value(wo, wi)`: the mean over views of what each sees most of. Columns are closest below `scale`.
    pub(super) fn new(is_isotropic: bool, scale: f32, value: &dyn Fn(Vec3, Vec3) -> Vec3) -> Self {
        let rows = if is_isotropic { 1 } else { ROWS };
        let empty = vec![Vec3::ZERO; COLUMNS * rows];
        let shape = Self { cells: Table { columns: COLUMNS, values: empty }, scale };
        let mut weights = vec![0.0f64; COLUMNS * rows];
        for n_dot_v in VIEWS {
            for azimuth in shape.azimuths() {
                let mut seen = vec![0.0f64; weights.len()];
                shape.for_each(view(n_dot_v, azimuth), |cell, weight, wo, wi| {
                    seen[cell] += f64::from(weight * value(wo, wi).element_sum());
                });
                let total: f64 = seen.iter().sum();
                if total > 0.0 && total.is_finite() {
                    weights.iter_mut().zip(&seen).for_each(|(weight, seen)| *weight += seen / total);
                }
            }
        }
        shape.with_weights(&weights)
    }

    fn with_weights(mut self, weights: &[f64]) -> Self {
        let rows = self.cells.rows();
        let total: f64 = weights.iter().sum();
        let of_column = |column: usize| (0..rows).map(|row| weights[row * COLUMNS + column]).sum::<f64>();
        let mut below = 0.0;
        for column in 0..COLUMNS {
            // Nothing reflected: any density will do.
            let share = if total > 0.0 { of_column(column) / total } else { 1.0 / COLUMNS as f64 };
            below += share;
            let marginal = if column + 1 == COLUMNS { 1.0 } else { below };
            let mut in_column = 0.0;
            for row in 0..rows {
                let of_cell = match of_column(column) {
                    0.0 => 1.0 / rows as f64,
                    all => weights[row * COLUMNS + column] / all,
                };
                in_column += of_cell;
                let conditional = if row + 1 == rows { 1.0 } else { in_column };
                let density = share * of_cell / f64::from(self.cell_solid_angle(column));
                self.cells.values[row * COLUMNS + column] =
                    Vec3::new(conditional as f32, density as f32, marginal as f32);
            }
        }
        self
    }

    fn border(&self, column: usize) -> f32 {
        half_sine2(column as f32 / COLUMNS as f32, self.scale)
    }

    fn cell_solid_angle(&self, column: usize) -> f32 {
        2.0 * (self.border(column + 1) - self.border(column)) * TAU / self.cells.rows() as f32
    }

    /// Azimuths of the view that stand for all.
    fn azimuths(&self) -> impl Iterator<Item = f32> + use<> {
        let count = if self.cells.rows() == 1 { 1 } else { AZIMUTHS };
        (0..count).map(move |i| TAU * (i as f32 + 0.37) / count as f32)
    }

    /// The middle of every cell as half vector of a view and a light: the cell, and what a value between them has to be multiplied by so
    /// that the sum is the share of uniform light that is reflected.
    fn for_each(&self, wo: Vec3, mut visit: impl FnMut(usize, f32, Vec3, Vec3)) {
        let rows = self.cells.rows();
        // Half of an isotropic one is like the other.
        let azimuths = if rows == 1 { ISOTROPIC_AZIMUTHS } else { rows };
        let (first, step) = match rows {
            1 => (wo.y.atan2(wo.x), PI / azimuths as f32),
            _ => (0.0, TAU / azimuths as f32),
        };
        for column in 0..COLUMNS {
            let middle = 0.5 * (self.border(column) + self.border(column + 1));
            let part = self.cell_solid_angle(column) * rows as f32 / azimuths as f32;
            for i in 0..azimuths {
                let h = direction(middle, first + (i as f32 + 0.5) * step);
                let wi = reflect(h, wo);
                let v_dot_h = wo.dot(h);
                if wi.z > 0.0 && v_dot_h > 0.0 {
                    let cell = if rows == 1 { column } else { i * COLUMNS + column };
                    visit(cell, part * wi.z * 4.0 * v_dot_h, wo, wi);
                }
            }
        }
    }

    /// Share of uniform light that a reflectance gives to views of a cosine, of several azimuths where they differ.
    pub(super) fn reflected(&self, n_dot_v: f32, value: impl Fn(Vec3, Vec3) -> Vec3) -> Vec<Vec3> {
        let of_view = |azimuth| {
            let mut sum = Vec3::ZERO;
            self.for_each(view(n_dot_v, azimuth), |_, weight, wo, wi| sum += weight * value(wo, wi));
            sum
        };
        self.azimuths().map(of_view).collect()
    }

    /// Its cells: the share up to a row of its column, the density [1/sr], the share up to a column.
    pub fn table(&self) -> &Table {
        &self.cells
    }

    /// Where its columns lie, see [`spread_place`].
    pub fn scale(&self) -> f32 {
        self.scale
    }

    /// A half vector for `u` in `[0, 1)^2`.
    pub(super) fn sample(&self, u: Vec2) -> Vec3 {
        let cells = &self.cells.values;
        let column = first_above(u.x, COLUMNS, |column| cells[column].z);
        let below = if column > 0 { cells[column - 1].z } else { 0.0 };
        let along = (u.x - below) / (cells[column].z - below).max(1e-12);
        let rows = self.cells.rows();
        let row = first_above(u.y, rows, |row| cells[row * COLUMNS + column].x);
        let before = if row > 0 { cells[(row - 1) * COLUMNS + column].x } else { 0.0 };
        let around = (u.y - before) / (cells[row * COLUMNS + column].x - before).max(1e-12);
        let [low, high] = [self.border(column), self.border(column + 1)];
        direction(low + (high - low) * along, TAU * (row as f32 + around) / rows as f32)
    }

    /// Density of `sample` [1/sr] at a half vector above the surface.
    pub(super) fn density(&self, h: Vec3) -> f32 {
        let delta = FRAC_2_PI * (h.x * h.x + h.y * h.y).sqrt().atan2(h.z);
        let column = ((spread_place(delta, self.scale) * COLUMNS as f32) as usize).min(COLUMNS - 1);
        let rows = self.cells.rows();
        let turns = h.y.atan2(h.x) / TAU;
        let row = (((turns - turns.floor()) * rows as f32) as usize).min(rows - 1);
        self.cells.values[row * COLUMNS + column].y
    }

    /// Roughness of GGX whose median half vector is as far from the normal, or Beckmann's, which differ by a fifth of alpha.
    pub(super) fn equivalent_roughness(&self) -> f32 {
        let cells = &self.cells.values;
        let column = first_above(0.5, COLUMNS, |column| cells[column].z);
        let below = if column > 0 { cells[column - 1].z } else { 0.0 };
        let along = (0.5 - below) / (cells[column].z - below).max(1e-12);
        let [low, high] = [self.border(column), self.border(column + 1)];
        let median = direction(low + (high - low) * along, 0.0);
        (1.1 * median.x / median.z.max(1e-3)).clamp(0.0, 1.0).sqrt()
    }
}
