use std::f64::consts::PI;

use glam::{DVec2, DVec3, Vec2, Vec3};
use gnomon_envmap::Equirect;

/// Most tiles across and down. Finer ones follow the cosine better and cost more at every shading point: at 11 degrees what is
/// left of its variation inside a tile is small beside that of shadows.
const TILES: [usize; 2] = [32, 16];

/// How much a channel counts in drawing directions: all alike, as noise in blue is noise. (Luminance would leave
/// blue light to few samples.)
pub(crate) const IMPORTANCE: Vec3 = Vec3::splat(1.0 / 3.0);

/// Draws directions in proportion to the brightness of the *interpolated* map, and roughly to the cosine at a surface.
///
/// The picture is cut into cells between texel centres, on which [`Equirect::lookup`] is bilinear; the first and last
/// row of cells reach from a pole to the nearest centres. Cells are gathered in tiles. A tile is chosen by its flux
/// times a bound of the cosine over it; a cell of the tile by its mean brightness times its solid angle; and the place in
/// the cell by the bilinear brightness itself (Pharr, Jakob and Humphreys, "Physically Based Rendering", 4th edition,
/// A.5.2). So the pdf is the brightness looked up, times factors of row and tile, and is positive wherever the map is and
/// the surface is lit from.
pub(crate) struct EnvironmentSampler<'a> {
    map: &'a Equirect,
    /// Of its radiance.
    factor: Vec3,
    /// Brightness at the nodes: `height + 2` rows (the poles, and every row of texel centres) of `width`.
    nodes: Vec<f32>,
    /// `height + 1` rows of `width`: summed mean brightness of the cells from the left edge to the end of this one.
    along_row: Vec<f64>,
    /// A column of `height + 1` for every column of tiles: summed flux of its cells from the top to the end of this row.
    down_tiles: Vec<f64>,
    grid: TileGrid,
    /// Bounds of every tile, row by row, each row filled up to whole groups.
    tiles: Vec<Tiles>,
}

/// Patches of cells seen from a surface, eight side by side: `flux * max(0, n . axis + sine)` is positive unless all of a patch
/// is under the horizon. Absent tiles have no flux.
#[derive(Clone, Copy, Default)]
struct Tiles {
    /// Direction of the middle, by component.
    axis: [[f32; LANES]; 3],
    /// Sine of the angle from the axis to the farthest corner, a little more.
    sine: [f32; LANES],
    /// Flux.
    flux: [f32; LANES],
}

/// Tiles that are weighed at once; the compiler makes vector instructions of loops over them.
const LANES: usize = 8;

impl Tiles {
    fn cosine_bound(&self, lane: usize, n: Vec3) -> f32 {
        let [x, y, z] = &self.axis;
        (n.x * x[lane] + n.y * y[lane] + n.z * z[lane] + self.sine[lane]).max(0.0)
    }

    fn weights(&self, n: Vec3) -> [f32; LANES] {
        std::array::from_fn(|lane| self.flux[lane] * self.cosine_bound(lane, n))
    }
}

/// How cells are gathered in tiles.
struct TileGrid {
    columns: usize,
    rows: usize,
    /// Tile column of every cell column, tile row of every cell row.
    column_of: Vec<usize>,
    row_of: Vec<usize>,
}

impl TileGrid {
    fn new(cell_columns: usize, cell_rows: usize) -> Self {
        let (columns, rows) = (TILES[0].min(cell_columns), TILES[1].min(cell_rows));
        Self {
            columns,
            rows,
            column_of: (0..cell_columns).map(|x| x * columns / cell_columns).collect(),
            row_of: (0..cell_rows).map(|y| y * rows / cell_rows).collect(),
        }
    }

    /// Groups of tiles in a row.
    fn groups(&self) -> usize {
        self.columns.div_ceil(LANES)
    }
}

/// Cells `[start, end)` of tile `index`, where cell `i` of `cells` belongs to tile `i * tiles / cells`.
fn span(index: usize, tiles: usize, cells: usize) -> (usize, usize) {
    ((index * cells).div_ceil(tiles), ((index + 1) * cells).div_ceil(tiles))
}

/// The map as a surface with a given normal samples it.
#[derive(Clone, Copy)]
pub(crate) struct Aim {
    n: Vec3,
    row_weights: [f32; TILES[1]],
    /// Sum of the weights of all tiles: an upper bound of the irradiance, and a little more.
    pub(crate) total: f64,
}

impl<'a> EnvironmentSampler<'a> {
    /// Unshadowed irradiance on a surface with the unit normal `n`.
    pub(crate) fn irradiance(&self, n: Vec3) -> DVec3 {
        self.map.irradiance(n) * self.factor.as_dvec3()
    }

    /// Samples a map whose radiance counts so many times, channel by channel.
    pub(crate) fn new(map: &'a Equirect, factor: Vec3) -> Self {
        let nodes = node_brightness(map, factor);
        let (width, height) = (map.width() as usize, map.height() as usize);
        let grid = TileGrid::new(width, height + 1);
        let mut along_row = Vec::with_capacity(width * (height + 1));
        let mut down_tiles = vec![0.0; grid.columns * (height + 1)];
        for row in 0..=height {
            let (upper, lower) = (&nodes[row * width..][..width], &nodes[(row + 1) * width..][..width]);
            let mut sum = 0.0;
            for x in 0..width {
                let right = (x + 1) % width;
                let corners = [upper[x], upper[right], lower[x], lower[right]];
                sum += 0.25 * corners.iter().map(|&corner| f64::from(corner)).sum::<f64>();
                along_row.push(sum);
            }
            let solid_angle = cell_solid_angle(row, width, height);
            for column in 0..grid.columns {
                let (start, end) = span(column, grid.columns, width);
                let flux = solid_angle * between(&along_row[row * width..][..width], start, end);
                let above = if row == 0 { 0.0 } else { down_tiles[column * (height + 1) + row - 1] };
                down_tiles[column * (height + 1) + row] = above + flux;
            }
        }
        let mut tiles = vec![Tiles::default(); grid.rows * grid.groups()];
        for (row, groups) in tiles.chunks_exact_mut(grid.groups()).enumerate() {
            let (start, end) = span(row, grid.rows, height + 1);
            let v = [cell_rows(start, height).0 as f32, cell_rows(end - 1, height).1 as f32];
            for column in 0..grid.columns {
                let flux = between(&down_tiles[column * (height + 1)..][..height + 1], start, end);
                let (left, right) = span(column, grid.columns, width);
                let u = [left, right].map(|x| ((x as f64 + 0.5) / width as f64) as f32);
                let (axis, sine) = bounding_cone(u, v);
                let (group, lane) = (&mut groups[column / LANES], column % LANES);
                for (components, component) in group.axis.iter_mut().zip(axis.to_array()) {
                    components[lane] = component;
                }
                group.sine[lane] = sine;
                group.flux[lane] = flux as f32;
            }
        }
        Self { map, factor, nodes, along_row, down_tiles, grid, tiles }
    }

    pub(crate) fn radiance(&self, direction: Vec3) -> Vec3 {
        self.map.lookup(direction) * self.factor
    }

    /// Weighs the tiles for a surface with the unit normal `n`.
    pub(crate) fn aim(&self, n: Vec3) -> Aim {
        let mut row_weights = [0.0; TILES[1]];
        for (weight, row) in row_weights.iter_mut().zip(self.tiles.chunks_exact(self.grid.groups())) {
            let mut sums = [0.0; LANES];
            for group in row {
                for (sum, weight) in sums.iter_mut().zip(group.weights(n)) {
                    *sum += weight;
                }
            }
            *weight = sums.iter().sum();
        }
        Aim { n, row_weights, total: row_weights.iter().map(|&weight| f64::from(weight)).sum() }
    }

    /// A direction drawn by `u` in `[0, 1)^2`; `None` where nothing shines on the surface.
    pub(crate) fn sample(&self, aim: &Aim, u: DVec2) -> Option<Vec3> {
        let (width, height) = (self.map.width() as usize, self.map.height() as usize);
        let (tile_row, v) = choose_weighted(aim.row_weights.iter().copied(), u.y)?;
        let groups = &self.tiles[tile_row * self.grid.groups()..][..self.grid.groups()];
        let (tile_column, u) = choose_weighted(groups.iter().flat_map(|group| group.weights(aim.n)), u.x)?;
        let (top, bottom) = span(tile_row, self.grid.rows, height + 1);
        let (row, v) =
            choose_between(&self.down_tiles[tile_column * (height + 1)..][..height + 1], top, bottom, v)?;
        let (left, right) = span(tile_column, self.grid.columns, width);
        let (x, u) = choose_between(&self.along_row[row * width..][..width], left, right, u)?;

        let right = (x + 1) % width;
        let node = |row: usize, x: usize| f64::from(self.nodes[row * width + x]);
        let [w00, w10, w01, w11] = [node(row, x), node(row, right), node(row + 1, x), node(row + 1, right)];
        let v = sample_linear(v, w00 + w10, w01 + w11);
        let u = sample_linear(u, w00 + v * (w01 - w00), w10 + v * (w11 - w10));
        let (top, bottom) = cell_rows(row, height);
        let place = DVec2::new((x as f64 + 0.5 + u) / width as f64, top + v * (bottom - top));
        Some(Equirect::direction_from_uv(place.as_vec2()))
    }

    /// Density of [`EnvironmentSampler::sample`] [1/sr] at a direction where the map's radiance is `radiance`.
    pub(crate) fn pdf(&self, aim: &Aim, direction: Vec3, radiance: Vec3) -> f64 {
        let brightness = f64::from(radiance.dot(IMPORTANCE));
        let sin_theta = f64::from(Vec2::new(direction.x, direction.z).length());
        if brightness <= 0.0 || sin_theta <= 0.0 || aim.total <= 0.0 {
            return 0.0;
        }
        let (width, height) = (self.map.width() as usize, self.map.height() as usize);
        let uv = Equirect::uv_from_direction(direction).as_dvec2();
        let row = ((uv.y * height as f64 + 0.5).floor() as usize).min(height);
        // Column 0 starts at the first texel centre; what lies left of it belongs to the last.
        let x = (uv.x * width as f64 - 0.5).floor();
        let column = if x < 0.0 { width - 1 } else { (x as usize).min(width - 1) };
        let tile_column = self.grid.column_of[column];
        let group = &self.tiles[self.grid.row_of[row] * self.grid.groups() + tile_column / LANES];
        let (top, bottom) = cell_rows(row, height);
        // Uniform in v inside the cell: the density per steradian falls as the cell's mean sine over the sine here.
        let area = (bottom - top) / width as f64 * 2.0 * PI * PI;
        let chance = f64::from(group.cosine_bound(tile_column % LANES, aim.n)) / aim.total;
        brightness * chance * cell_solid_angle(row, width, height) / (area * sin_theta)
    }
}

/// Middle of the patch between two u and two v, and the sine of the angle to its farthest point, a little more.
fn bounding_cone(u: [f32; 2], v: [f32; 2]) -> (Vec3, f32) {
    let axis = Equirect::direction_from_uv(Vec2::new(0.5 * (u[0] + u[1]), 0.5 * (v[0] + v[1])));
    // Nowhere in the patch is farther from its middle than its corners.
    let farthest = v.map(|v| axis.dot(Equirect::direction_from_uv(Vec2::new(u[0], v))));
    let cosine = farthest[0].min(farthest[1]);
    // Past a quarter turn every surface may be lit from the patch.
    let sine = if cosine > 0.0 { (1.0 - cosine * cosine).max(0.0).sqrt() } else { 1.0 };
    (axis, sine + 1e-3)
}

/// Part of a cumulative sum that entries `[start, end)` add.
fn between(cumulative: &[f64], start: usize, end: usize) -> f64 {
    cumulative[end - 1] - if start == 0 { 0.0 } else { cumulative[start - 1] }
}

/// Interpolated brightness at the poles and at every texel centre.
fn node_brightness(map: &Equirect, factor: Vec3) -> Vec<f32> {
    let (width, height) = (map.width(), map.height());
    let texel = |x: u32, y: u32| (map.radiance().get(x, y) * factor).dot(IMPORTANCE).max(0.0);
    // At a pole the lookup is halfway between a texel and the one half a turn away.
    let pole = |x: u32, y: u32| 0.5 * (texel(x, y) + texel((x + width / 2) % width, y));
    let mut nodes = Vec::with_capacity(width as usize * (height as usize + 2));
    nodes.extend((0..width).map(|x| pole(x, 0)));
    for y in 0..height {
        nodes.extend((0..width).map(|x| texel(x, y)));
    }
    nodes.extend((0..width).map(|x| pole(x, height - 1)));
    nodes
}

/// Top and bottom of a row of cells, in v.
fn cell_rows(row: usize, height: usize) -> (f64, f64) {
    let h = height as f64;
    (((row as f64 - 0.5) / h).max(0.0), ((row as f64 + 0.5) / h).min(1.0))
}

/// Solid angle [sr] of a cell: `2 pi / width (cos theta_top - cos theta_bottom)`.
fn cell_solid_angle(row: usize, width: usize, height: usize) -> f64 {
    let (top, bottom) = cell_rows(row, height);
    let (middle, half) = (0.5 * PI * (top + bottom), 0.5 * PI * (bottom - top));
    2.0 * PI / width as f64 * 2.0 * middle.sin() * half.sin()
}

/// Entry of `[start, end)` drawn by `u` in proportion to what it adds to a cumulative sum, and where in its share `u` lies,
/// `[0, 1)`; `None` if all add 0.
fn choose_between(cumulative: &[f64], start: usize, end: usize, u: f64) -> Option<(usize, f64)> {
    let below = if start == 0 { 0.0 } else { cumulative[start - 1] };
    let target = below + u * (cumulative[end - 1] - below);
    let index = start + cumulative[start..end].partition_point(|&sum| sum <= target);
    if index >= end {
        return None;
    }
    let below = if index == 0 { 0.0 } else { cumulative[index - 1] };
    Some((index, ((target - below) / (cumulative[index] - below)).clamp(0.0, BELOW_ONE)))
}

/// Index drawn by `u` in proportion to weights, and where in its share `u` lies, `[0, 1)`; `None` if all are 0.
pub(crate) fn choose_weighted(weights: impl Iterator<Item = f32> + Clone, u: f64) -> Option<(usize, f64)> {
    let mut rest = u * weights.clone().map(f64::from).sum::<f64>();
    let mut last = None;
    for (index, weight) in weights.enumerate().filter(|&(_, weight)| weight > 0.0) {
        let weight = f64::from(weight);
        if rest < weight {
            return Some((index, (rest / weight).min(BELOW_ONE)));
        }
        rest -= weight;
        last = Some((index, BELOW_ONE));
    }
    last
}

/// Largest number below 1.
const BELOW_ONE: f64 = 1.0 - f64::EPSILON / 2.0;

/// Inverts the cumulative of a density that runs linearly from `a` to `b` over `[0, 1]`.
fn sample_linear(u: f64, a: f64, b: f64) -> f64 {
    if a + b <= 0.0 {
        return u;
    }
    let root = (a * a + u * (b * b - a * a)).max(0.0).sqrt();
    if a + root > 0.0 { (u * (a + b) / (a + root)).min(1.0) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use gnomon_picture::RgbImage;

    use super::*;

    /// A map with a black half, a lone bright texel at the seam, one at a pole, and a gradient.
    fn map(width: u32, height: u32) -> Equirect {
        Equirect::new(RgbImage::from_fn(width, height, |x, y| match (x, y) {
            (0, 3) => Vec3::new(200.0, 100.0, 50.0),
            (2, 0) => Vec3::splat(40.0),
            _ if x > width / 2 => Vec3::ZERO,
            _ => Vec3::new(0.1, 0.02 * x as f32, 0.03 * y as f32),
        }))
    }

    /// Midpoint rule over a grid of directions, uniform in u and v: 1120 divides by twice 16, 8, 7 and 5, so that no cell
    /// of the maps below straddles a step.
    fn integrate(mut f: impl FnMut(Vec3) -> f64) -> f64 {
        let (columns, rows) = (1120, 1120);
        let mut sum = 0.0;
        for y in 0..rows {
            let v = (f64::from(y) + 0.5) / f64::from(rows);
            for x in 0..columns {
                let uv = Vec2::new((x as f32 + 0.5) / columns as f32, v as f32);
                sum += f(Equirect::direction_from_uv(uv)) * (PI * v).sin();
            }
        }
        sum * 2.0 * PI * PI / f64::from(columns * rows)
    }

    #[test]
    fn pdf_integrates_to_one_and_is_positive_where_the_map_is() {
        for (width, height) in [(16, 8), (7, 5), (1, 1), (2, 1)] {
            let map = if width > 2 { map(width, height) } else { map(16, 8) };
            let sampler = EnvironmentSampler::new(&map, Vec3::ONE);
            for n in [Vec3::Y, Vec3::new(-1.0, 2.0, 3.0).normalize(), Vec3::NEG_Z] {
                let aim = sampler.aim(n);
                let total = integrate(|d| {
                    let radiance = map.lookup(d);
                    let pdf = sampler.pdf(&aim, d, radiance);
                    // Positive wherever light reaches the surface.
                    assert!(pdf > 0.0 || radiance.dot(IMPORTANCE) == 0.0 || n.dot(d) < 1e-6);
                    pdf
                });
                assert!((total - 1.0).abs() < 1e-3, "{width} x {height}, n {n}: {total}");
            }
        }
    }

    #[test]
    fn samples_follow_the_pdf() {
        let map = map(16, 8);
        let sampler = EnvironmentSampler::new(&map, Vec3::ONE);
        let aim = sampler.aim(Vec3::new(0.3, 0.9, -0.2).normalize());
        // Shares of the samples in 8 x 4 bins against the integrals of the pdf over them.
        let bin = |d: Vec3| {
            let uv = Equirect::uv_from_direction(d);
            (uv.y * 3.999) as usize * 8 + (uv.x * 7.999) as usize
        };
        let count = 1 << 16;
        let mut shares = [0.0; 32];
        let sequence = crate::sampler::Sequence::new(3, 0, 0);
        for index in 0..count {
            let u = sequence.pair(index, crate::sampler::Decision::Direction);
            shares[bin(sampler.sample(&aim, u).unwrap())] += 1.0 / f64::from(count);
        }
        let mut expected = [0.0; 32];
        let steps = f64::from(1120 * 1120);
        integrate(|d| {
            let sin_theta = f64::from(Vec2::new(d.x, d.z).length());
            expected[bin(d)] += sampler.pdf(&aim, d, map.lookup(d)) * sin_theta * 2.0 * PI * PI / steps;
            0.0
        });
        for (index, (share, expected)) in shares.iter().zip(expected).enumerate() {
            // Quadrature at the edges of bins and stratified noise: both under 2e-3.
            assert!((share - expected).abs() < 2e-3, "bin {index}: {share} against {expected}");
        }
    }

    #[test]
    fn black_maps_have_no_samples() {
        let black = Equirect::new(RgbImage::filled(8, 4, Vec3::ZERO));
        let sampler = EnvironmentSampler::new(&black, Vec3::ONE);
        let aim = sampler.aim(Vec3::Y);
        assert_eq!(sampler.sample(&aim, DVec2::splat(0.5)), None);
        assert_eq!(sampler.pdf(&aim, Vec3::X, Vec3::ZERO), 0.0);
    }

    #[test]
    fn a_single_texel_is_uniform() {
        let map = Equirect::new(RgbImage::filled(1, 1, Vec3::ONE));
        let sampler = EnvironmentSampler::new(&map, Vec3::ONE);
        let aim = sampler.aim(Vec3::Y);
        for i in 0..32 {
            let u = (DVec2::new(f64::from(i), f64::from(i * 7 % 32)) + 0.5) / 32.0;
            let d = sampler.sample(&aim, u).unwrap();
            assert!(d.is_normalized() && sampler.pdf(&aim, d, Vec3::ONE) > 0.0);
        }
    }

    #[test]
    fn tiles_cover_all_cells_once() {
        for (tiles, cells) in [(32, 512), (16, 257), (7, 7), (1, 1), (16, 17), (32, 33)] {
            let mut next = 0;
            for index in 0..tiles {
                let (start, end) = span(index, tiles, cells);
                assert!(start == next && end > start);
                assert!((start..end).all(|cell| cell * tiles / cells == index));
                next = end;
            }
            assert_eq!(next, cells);
        }
    }
}
