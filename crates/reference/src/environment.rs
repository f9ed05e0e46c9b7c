use std::f64::consts::PI;

use glam::{DVec2, Vec2, Vec3};
use gnomon_envmap::Equirect;
use gnomon_image::LUMINANCE;

/// Draws directions in proportion to the luminance of the *interpolated* map.
///
/// The picture is cut into cells between texel centres, on which [`Equirect::lookup`] is bilinear; the first and last
/// row of cells reach from a pole to the nearest centres. A cell is chosen by its mean luminance times its solid angle, and
/// the place in it by the bilinear luminance itself (Pharr, Jakob and Humphreys, "Physically Based Rendering", 4th
/// edition, A.5.2). So the pdf is the luminance looked up, times a factor that only the row sets, and is positive
/// exactly where the map is.
pub(crate) struct EnvironmentSampler<'a> {
    map: &'a Equirect,
    /// Luminance at the nodes: `height + 2` rows (the poles, and every row of texel centres) of `width`.
    nodes: Vec<f32>,
    /// Cumulative cell weights in every row of cells, `height + 1` rows of `width`, each ending at 1 (or 0: a black row).
    columns: Vec<f64>,
    /// Cumulative row weights, ending at 1.
    rows: Vec<f64>,
    /// Luminous flux of the interpolated map, by cells.
    total: f64,
}

impl<'a> EnvironmentSampler<'a> {
    pub(crate) fn new(map: &'a Equirect) -> Self {
        let nodes = node_luminances(map);
        let (width, height) = (map.width() as usize, map.height() as usize);
        let mut columns = Vec::with_capacity(width * (height + 1));
        let mut rows = Vec::with_capacity(height + 1);
        let mut total = 0.0;
        for row in 0..=height {
            let (upper, lower) = (&nodes[row * width..][..width], &nodes[(row + 1) * width..][..width]);
            let start = columns.len();
            let mut sum = 0.0;
            for x in 0..width {
                let right = (x + 1) % width;
                sum += f64::from(upper[x])
                    + f64::from(upper[right])
                    + f64::from(lower[x])
                    + f64::from(lower[right]);
                columns.push(sum);
            }
            if sum > 0.0 {
                columns[start..].iter_mut().for_each(|weight| *weight /= sum);
            }
            total += 0.25 * sum * cell_solid_angle(row, width, height);
            rows.push(total);
        }
        if total > 0.0 {
            rows.iter_mut().for_each(|weight| *weight /= total);
        }
        Self { map, nodes, columns, rows, total }
    }

    /// Luminous flux [luminance x sr] of the interpolated map.
    pub(crate) fn luminous_flux(&self) -> f64 {
        self.total
    }

    pub(crate) fn radiance(&self, direction: Vec3) -> Vec3 {
        self.map.lookup(direction)
    }

    /// A direction drawn by `u` in `[0, 1)^2`; `None` for a black map.
    pub(crate) fn sample(&self, u: DVec2) -> Option<Vec3> {
        if self.total <= 0.0 {
            return None;
        }
        let (width, height) = (self.map.width() as usize, self.map.height() as usize);
        let (row, v) = choose(&self.rows, u.y);
        let (x, u) = choose(&self.columns[row * width..][..width], u.x);
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
    pub(crate) fn pdf(&self, direction: Vec3, radiance: Vec3) -> f64 {
        let luminance = f64::from(radiance.dot(LUMINANCE));
        let sin_theta = f64::from(Vec2::new(direction.x, direction.z).length());
        if luminance <= 0.0 || sin_theta <= 0.0 || self.total <= 0.0 {
            return 0.0;
        }
        let (width, height) = (self.map.width() as usize, self.map.height() as usize);
        let v = f64::from(Equirect::uv_from_direction(direction).y);
        let row = ((v * height as f64 + 0.5).floor() as usize).min(height);
        let (top, bottom) = cell_rows(row, height);
        // Uniform in v inside the cell: the density per steradian falls as the cell's mean sine over the sine here.
        let area = (bottom - top) / width as f64 * 2.0 * PI * PI;
        luminance * cell_solid_angle(row, width, height) / (area * sin_theta * self.total)
    }
}

/// Interpolated luminance at the poles and at every texel centre.
fn node_luminances(map: &Equirect) -> Vec<f32> {
    let (width, height) = (map.width(), map.height());
    let luminance = |x: u32, y: u32| map.radiance().get(x, y).dot(LUMINANCE).max(0.0);
    // At a pole the lookup is halfway between a texel and the one half a turn away.
    let pole = |x: u32, y: u32| 0.5 * (luminance(x, y) + luminance((x + width / 2) % width, y));
    let mut nodes = Vec::with_capacity(width as usize * (height as usize + 2));
    nodes.extend((0..width).map(|x| pole(x, 0)));
    for y in 0..height {
        nodes.extend((0..width).map(|x| luminance(x, y)));
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

/// Index drawn from a cumulative distribution that ends at 1, and where in its step `u` lies, `[0, 1)`.
pub(crate) fn choose(cumulative: &[f64], u: f64) -> (usize, f64) {
    let index = cumulative.partition_point(|&weight| weight <= u).min(cumulative.len() - 1);
    let below = if index == 0 { 0.0 } else { cumulative[index - 1] };
    let step = cumulative[index] - below;
    (index, if step > 0.0 { ((u - below) / step).clamp(0.0, 1.0 - f64::EPSILON) } else { 0.5 })
}

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
    use gnomon_image::RgbImage;

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
            let sampler = EnvironmentSampler::new(&map);
            let total = integrate(|d| {
                let radiance = map.lookup(d);
                let pdf = sampler.pdf(d, radiance);
                assert_eq!(pdf > 0.0, radiance.dot(LUMINANCE) > 0.0);
                pdf
            });
            assert!((total - 1.0).abs() < 1e-3, "{width} x {height}: {total}");
        }
    }

    /// Importance sampling estimates the luminous flux without variance but for the sine inside a cell.
    #[test]
    fn samples_follow_the_pdf() {
        let map = map(16, 8);
        let sampler = EnvironmentSampler::new(&map);
        // Shares of the samples in 8 x 4 bins against the integrals of the pdf over them.
        let bin = |d: Vec3| {
            let uv = Equirect::uv_from_direction(d);
            (uv.y * 3.999) as usize * 8 + (uv.x * 7.999) as usize
        };
        let count = 1 << 16;
        let mut shares = [0.0; 32];
        let sequence = crate::sampler::Sequence::new(3, 0, 0);
        for index in 0..count {
            let u = sequence.pair(index, crate::sampler::Decision::LightDirection);
            shares[bin(sampler.sample(u).unwrap())] += 1.0 / f64::from(count);
        }
        let mut expected = [0.0; 32];
        let steps = f64::from(1120 * 1120);
        integrate(|d| {
            let sin_theta = f64::from(Vec2::new(d.x, d.z).length());
            expected[bin(d)] += sampler.pdf(d, map.lookup(d)) * sin_theta * 2.0 * PI * PI / steps;
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
        let sampler = EnvironmentSampler::new(&black);
        assert_eq!(sampler.sample(DVec2::splat(0.5)), None);
        assert_eq!(sampler.pdf(Vec3::X, Vec3::ZERO), 0.0);
        assert_eq!(sampler.luminous_flux(), 0.0);
    }

    #[test]
    fn a_single_texel_is_uniform() {
        let map = Equirect::new(RgbImage::filled(1, 1, Vec3::ONE));
        let sampler = EnvironmentSampler::new(&map);
        assert!((sampler.luminous_flux() - 4.0 * PI).abs() < 1e-6);
        for i in 0..32 {
            let u = DVec2::new(f64::from(i) / 32.0, f64::from(i * 7 % 32) / 32.0);
            assert!(sampler.sample(u).unwrap().is_normalized());
        }
    }
}
