use std::f64::consts::{PI, TAU};
use std::ops::Range;

use glam::DVec3;
use gnomon_envmap::Equirect;
use gnomon_picture::LUMINANCE;

/// Luminous flux on an equirect grid, with prefix sums along the rows: the flux inside a cone is one interval a row.
pub(super) struct SphereGrid {
    pub(super) width: usize,
    pub(super) height: usize,
    /// Flux [radiance x sr] of each cell.
    flux: Vec<f64>,
    /// Row by row, `2 width + 1` running sums over the row laid out twice, so that no interval meets a seam.
    prefix: Vec<f64>,
}

/// The part of one grid row inside a cone: columns from `centre - half_width` to `centre + half_width`.
#[derive(Clone, Copy)]
pub(super) struct RowInterval {
    pub(super) row: usize,
    /// In cells; at most half the width.
    pub(super) half_width: f64,
}

impl SphereGrid {
    /// The map's flux on a grid of `width` x `height`: each texel's flux goes to the cells under it by overlap.
    pub(super) fn from_map(map: &Equirect, width: usize, height: usize) -> Self {
        let (map_width, map_height) = (map.width() as usize, map.height() as usize);
        let luminance: Vec<f64> =
            map.radiance().texels().iter().map(|texel| f64::from(texel.dot(LUMINANCE))).collect();
        let theta = |y: f64| PI * y / height as f64;
        let columns = overlaps(map_width, width);
        let mut grid = Self { width, height, flux: vec![0.0; width * height], prefix: Vec::new() };
        for (y, row_parts) in overlaps(map_height, height).into_iter().enumerate() {
            let texels = &luminance[y * map_width..(y + 1) * map_width];
            for (row, from, to) in row_parts {
                let solid_angle_per_cell = TAU / width as f64 * (theta(from).cos() - theta(to).cos());
                let cells = &mut grid.flux[row * width..(row + 1) * width];
                for (texel, parts) in texels.iter().zip(&columns) {
                    for &(column, from, to) in parts {
                        cells[column] += texel * solid_angle_per_cell * (to - from);
                    }
                }
            }
        }
        grid.prefix = vec![0.0; height * (2 * width + 1)];
        grid.sum_rows(0..height);
        grid
    }

    fn sum_rows(&mut self, rows: Range<usize>) {
        for row in rows {
            let cells = &self.flux[row * self.width..(row + 1) * self.width];
            let start = row * (2 * self.width + 1);
            let mut sum = 0.0;
            let prefix = &mut self.prefix[start + 1..start + 2 * self.width + 1];
            for (to, cell) in prefix.iter_mut().zip(cells.iter().chain(cells)) {
                sum += cell;
                *to = sum;
            }
        }
    }

    /// Flux of the whole grid.
    pub(super) fn total(&self) -> f64 {
        self.flux.iter().sum()
    }

    /// Flux of one cell.
    pub(super) fn cell(&self, column: usize, row: usize) -> f64 {
        self.flux[row * self.width + column]
    }

    /// Mean radiance (luminance) of one cell.
    pub(super) fn radiance(&self, column: usize, row: usize) -> f64 {
        let theta = |y: usize| PI * y as f64 / self.height as f64;
        self.cell(column, row) / (TAU / self.width as f64 * (theta(row).cos() - theta(row + 1).cos()))
    }

    /// Polar angle [rad] of a row's middle.
    pub(super) fn theta(&self, row: usize) -> f64 {
        PI * (row as f64 + 0.5) / self.height as f64
    }

    /// Unit direction through a cell's middle; the axes of [`Equirect::direction_from_uv`].
    pub(super) fn direction(&self, column: usize, row: usize) -> DVec3 {
        let (sin_theta, cos_theta) = self.theta(row).sin_cos();
        let (sin_phi, cos_phi) = (TAU * (column as f64 + 0.5) / self.width as f64).sin_cos();
        DVec3::new(sin_theta * sin_phi, cos_theta, -sin_theta * cos_phi)
    }

    /// The rows that a cone of half angle `radius` around a centre in row `centre_row` meets, judged at their middles.
    pub(super) fn cone(&self, centre_row: usize, radius: f64) -> Vec<RowInterval> {
        let centre = self.theta(centre_row);
        let cells_per_radian = self.height as f64 / PI;
        let first = ((centre - radius) * cells_per_radian).floor().max(0.0) as usize;
        let last = (((centre + radius) * cells_per_radian).ceil() as usize).min(self.height);
        (first..last)
            .map(|row| RowInterval {
                row,
                half_width: cone_half_width(centre, self.theta(row), radius) / TAU * self.width as f64,
            })
            .filter(|interval| interval.half_width > 0.0)
            .collect()
    }

    /// Flux inside a cone from [`SphereGrid::cone`] around the middle of `column`; cut cells count in part.
    pub(super) fn cone_flux(&self, column: usize, cone: &[RowInterval]) -> f64 {
        let centre = column as f64 + 0.5;
        cone.iter()
            .map(|interval| {
                let from = centre - interval.half_width;
                let from = if from < 0.0 { from + self.width as f64 } else { from };
                let start = interval.row * (2 * self.width + 1);
                let prefix = &self.prefix[start..start + 2 * self.width + 1];
                let at = |x: f64| {
                    let cell = (x as usize).min(2 * self.width - 1);
                    let fraction = x - cell as f64;
                    prefix[cell] + fraction * (prefix[cell + 1] - prefix[cell])
                };
                at(from + 2.0 * interval.half_width) - at(from)
            })
            .sum()
    }

    /// Scales down every cell by the share of it that the cone covers.
    pub(super) fn remove_cone(&mut self, centre: DVec3, radius: f64) {
        let coverage = cone_coverage(self.width, self.height, centre, radius);
        for part in &coverage {
            let cell = &mut self.flux[part.row * self.width + part.column];
            *cell *= 1.0 - part.share;
        }
        let rows = coverage.iter().map(|part| part.row);
        if let (Some(first), Some(last)) = (rows.clone().min(), rows.max()) {
            self.sum_rows(first..last + 1);
        }
    }
}

/// Half the azimuth range [rad] of the circle of latitude `theta` inside the cone of half angle `radius` around a
/// direction at polar angle `centre`: 0 where they do not meet, pi where the circle lies inside.
pub(super) fn cone_half_width(centre: f64, theta: f64, radius: f64) -> f64 {
    // Spherical law of cosines.
    let cosine = (radius.cos() - centre.cos() * theta.cos()) / (centre.sin() * theta.sin());
    if cosine >= 1.0 {
        0.0
    } else if cosine <= -1.0 {
        PI
    } else {
        cosine.acos()
    }
}

/// For each of `from` equal parts of an interval: the parts of a division in `to` under it, as (index, start, end) in
/// units of the latter.
fn overlaps(from: usize, to: usize) -> Vec<Vec<(usize, f64, f64)>> {
    let scale = to as f64 / from as f64;
    (0..from)
        .map(|i| {
            let (start, end) = (i as f64 * scale, (i + 1) as f64 * scale);
            let last = (end.ceil() as usize).min(to);
            (start.floor() as usize..last)
                .map(|j| (j, start.max(j as f64), end.min((j + 1) as f64)))
                .filter(|(_, start, end)| end > start)
                .collect()
        })
        .collect()
}

/// One cell that a cone covers, wholly or in part.
pub(super) struct CoveredCell {
    pub(super) column: usize,
    pub(super) row: usize,
    /// Covered share of the cell's solid angle, in (0, 1].
    pub(super) share: f64,
}

/// Which cells of an equirect grid the cone around the unit direction `centre` covers, and how much of each.
pub(super) fn cone_coverage(width: usize, height: usize, centre: DVec3, radius: f64) -> Vec<CoveredCell> {
    let centre_theta = DVec3::new(centre.x, 0.0, centre.z).length().atan2(centre.y);
    let centre_column = (centre.x.atan2(-centre.z) / TAU).rem_euclid(1.0) * width as f64;
    let row_angle = PI / height as f64;
    // Rows are cut into strips thin against the radius: a strip counts wholly or not at all where it meets a pole.
    let strips = (32.0 * row_angle / radius).ceil().max(1.0) as usize;
    let first = ((centre_theta - radius) / row_angle).floor().max(0.0) as usize;
    let last = (((centre_theta + radius) / row_angle).ceil() as usize).min(height);
    let mut covered = Vec::new();
    let mut shares = vec![0.0; width];
    for row in first..last {
        shares.fill(0.0);
        let polar = |strip: usize| row_angle * (row as f64 + strip as f64 / strips as f64);
        let row_band = polar(0).cos() - polar(strips).cos();
        for strip in 0..strips {
            let middle = 0.5 * (polar(strip) + polar(strip + 1));
            let half_width = cone_half_width(centre_theta, middle, radius) / TAU * width as f64;
            let weight = (polar(strip).cos() - polar(strip + 1).cos()) / row_band;
            if half_width > 0.0 {
                add_interval(&mut shares, centre_column - half_width, centre_column + half_width, weight);
            }
        }
        let parts = shares.iter().enumerate().filter(|(_, share)| **share > 0.0);
        // Strip weights sum to one only up to rounding; a covered cell must end exactly black.
        covered.extend(parts.map(|(column, &share)| CoveredCell {
            column,
            row,
            share: if share > 1.0 - 1e-9 { 1.0 } else { share },
        }));
    }
    covered
}

/// Adds `weight` times the covered part of each cell between `from` and `to`, at most one turn, around the seam.
fn add_interval(cells: &mut [f64], from: f64, to: f64, weight: f64) {
    let width = cells.len() as i64;
    for column in from.floor() as i64..to.ceil() as i64 {
        let part = to.min((column + 1) as f64) - from.max(column as f64);
        cells[column.rem_euclid(width) as usize] += weight * part.max(0.0);
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use gnomon_picture::RgbImage;

    use super::*;

    fn constant(width: u32, height: u32) -> Equirect {
        Equirect::new(RgbImage::filled(width, height, Vec3::ONE))
    }

    #[test]
    fn every_grid_size_keeps_the_flux() {
        for (width, height) in [(1, 1), (3, 2), (64, 32), (100, 41), (512, 256)] {
            let grid = SphereGrid::from_map(&constant(97, 33), width, height);
            assert!((grid.total() - 4.0 * PI).abs() < 1e-5, "{width} x {height}: {}", grid.total());
        }
    }

    #[test]
    fn a_cone_of_a_constant_map_holds_its_solid_angle_anywhere() {
        let grid = SphereGrid::from_map(&constant(256, 128), 256, 128);
        for (column, row) in [(0, 64), (255, 3), (100, 0), (31, 127), (128, 90)] {
            for radius in [0.1, 0.3, 0.8] {
                let flux = grid.cone_flux(column, &grid.cone(row, radius));
                let solid_angle = TAU * (1.0 - f64::cos(radius));
                assert!(
                    (flux / solid_angle - 1.0).abs() < 0.08,
                    "({column}, {row}) {radius}: {}",
                    flux / solid_angle
                );
            }
        }
    }

    #[test]
    fn coverage_adds_up_to_the_cone_on_fine_coarse_and_single_cell_grids() {
        for (width, height) in [(1024_usize, 512_usize), (64, 32), (4, 2), (1, 1)] {
            for centre in [DVec3::Y, DVec3::NEG_Z, DVec3::new(0.3, -0.8, 0.5).normalize()] {
                let radius = 0.06;
                let covered = cone_coverage(width, height, centre, radius);
                let theta = |y: usize| PI * y as f64 / height as f64;
                let sum: f64 = covered
                    .iter()
                    .map(|part| {
                        part.share * TAU / width as f64 * (theta(part.row).cos() - theta(part.row + 1).cos())
                    })
                    .sum();
                let solid_angle = TAU * (1.0 - radius.cos());
                assert!((sum / solid_angle - 1.0).abs() < 0.03, "{width} {centre}: {}", sum / solid_angle);
                assert!(covered.iter().all(|part| part.share <= 1.0));
            }
        }
    }

    #[test]
    fn a_removed_cone_leaves_nothing_inside() {
        let mut grid = SphereGrid::from_map(&constant(256, 128), 256, 128);
        grid.remove_cone(grid.direction(3, 40), 0.3);
        assert!(grid.cone_flux(3, &grid.cone(40, 0.2)).abs() < 1e-12);
        let left = 4.0 * PI - TAU * (1.0 - f64::cos(0.3));
        assert!((grid.total() - left).abs() < 1e-3);
    }
}
