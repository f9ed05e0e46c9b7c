use std::f64::consts::{PI, TAU};

use glam::Vec3;
use gnomon_picture::RgbImage;
use rayon::prelude::*;

use crate::Equirect;
use crate::fft::Fft;

/// Widths that the finest level may have.
const BASE_WIDTHS: std::ops::RangeInclusive<u32> = 16..=1024;
/// Widths to which the map is resized before it is filtered.
const SOURCE_WIDTHS: std::ops::RangeInclusive<u32> = 128..=256;
/// Rows of directions inside an output texel over which its radiance is averaged.
const SUBROWS: u32 = 2;
/// The kernel is averaged over texels no further than this many rows from its centre; beyond, it is smooth.
const NEAR_ROWS: f64 = 3.0;

/// Radiance reflected by a GGX surface seen along its normal, for growing roughness: the first factor of the split-sum
/// approximation (Karis 2013, *Real Shading in Unreal Engine 4*), in which normal, view and reflection are one direction `n`:
///
/// `L'(n) = integral of L(l) D(n.h) (n.l) dl / integral of D(n.h) (n.l) dl`, `h` halfway between `n` and `l`.
#[derive(Clone, Debug)]
pub struct PrefilteredMap {
    levels: Vec<Equirect>,
}

impl PrefilteredMap {
    /// Filters a map into `level_count` levels (at least 1), each half as wide as the one before. The first is the map itself,
    /// resized to `base_width`, which is taken to the next power of two in 16..=1024; the last is for alpha = 1, and alpha
    /// doubles from the second on, as the texels do. There are no more levels than halvings down to 4 x 2.
    ///
    /// Each level is a complete convolution over the texels of the map, resized to what the lobe can resolve: deterministic,
    /// a constant stays constant, and a level's flux is the map's within 1 %.
    pub fn new(map: &Equirect, base_width: u32, level_count: u32) -> Self {
        let width = base_width.clamp(*BASE_WIDTHS.start(), *BASE_WIDTHS.end()).next_power_of_two();
        let count = level_count.clamp(1, width.ilog2() - 1);
        let mut levels = vec![map.resized(width, width / 2)];
        let mut spectra: Option<Spectra> = None;
        for level in 1..count {
            let level_width = width >> level;
            let wanted =
                (2 * level_width).clamp(*SOURCE_WIDTHS.start(), *SOURCE_WIDTHS.end()).max(level_width);
            let spectra = match &mut spectra {
                Some(spectra) if spectra.width == wanted as usize => spectra,
                other => other.insert(Spectra::new(&map.resized(wanted, wanted / 2))),
            };
            levels.push(spectra.convolve(level_width, f64::from(alpha_of_level(level, count - 1))));
        }
        Self { levels }
    }

    /// The levels, by growing roughness.
    pub fn levels(&self) -> &[Equirect] {
        &self.levels
    }

    /// Roughness (perceptual, the square root of alpha) that a level stands for.
    pub fn roughness(&self, level: usize) -> f32 {
        alpha_of_level(level as u32, self.levels.len() as u32 - 1).sqrt()
    }

    /// Radiance about a unit direction for a roughness in 0..1, linear between levels.
    pub fn lookup(&self, direction: Vec3, roughness: f32) -> Vec3 {
        let last = self.levels.len() - 1;
        let at = prefiltered_level(roughness * roughness, last as f32);
        let below = (at as usize).min(last);
        let above = (below + 1).min(last);
        let from = self.levels[below].lookup(direction);
        from.lerp(self.levels[above].lookup(direction), at - below as f32)
    }
}

/// GGX alpha of a level, 0 for the first and 1 for the last.
fn alpha_of_level(level: u32, last: u32) -> f32 {
    if level == 0 { 0.0 } else { (level as f32 - last as f32).exp2() }
}

/// The level, with a fraction, of which linear interpolation between levels has the lobe's height for `alpha`: that goes with
/// `1 / alpha^2`, so that interpolation in alpha would show highlights several times too bright.
pub fn prefiltered_level(alpha: f32, last: f32) -> f32 {
    let first = (1.0 - last).exp2();
    let clamped = alpha.clamp(0.0, 1.0);
    if last < 1.0 {
        return 0.0;
    }
    if clamped < first {
        let ratio = clamped / first;
        return ratio * ratio;
    }
    let below = (clamped / first).log2().floor();
    let ratio = first * below.exp2() / clamped;
    (1.0 + below + 4.0 / 3.0 * (1.0 - ratio * ratio)).min(last)
}

/// `D(n.h) (n.l)` up to a constant factor, for `h` halfway between `n` and `l`: with `c = n.l`, `(n.h)^2 = (1 + c) / 2`, so that
/// Walter et al. 2007 (equation 33) becomes `1 / ((1 - c) / 2 + alpha^2 (1 + c) / 2)^2`, without loss of digits near `c = 1`.
fn kernel(one_minus_c: f64, alpha_squared: f64) -> f64 {
    let c = 1.0 - one_minus_c;
    if c <= 0.0 {
        return 0.0;
    }
    let d = 0.5 * one_minus_c + alpha_squared * 0.5 * (1.0 + c);
    c / (d * d)
}

/// Radiance of each row as a Fourier series along it, weighted by solid angle.
struct Spectra {
    width: usize,
    fft: Fft,
    /// By row: real and imaginary parts of red + i green, then of blue.
    rows: Vec<[Vec<f64>; 4]>,
    /// Solid angle of a texel, by row.
    angles: Vec<f64>,
}

impl Spectra {
    fn new(source: &Equirect) -> Self {
        let width = source.width() as usize;
        let fft = Fft::new(width);
        let angles: Vec<f64> = (0..source.height()).map(|y| source.texel_solid_angle(y)).collect();
        let row = |(y, angle): (u32, &f64)| {
            let channel = |index: usize| -> Vec<f64> {
                let texel = |x: u32| f64::from(source.radiance().get(x, y)[index]) * angle;
                (0..source.width()).map(texel).collect()
            };
            let mut parts = [channel(0), channel(1), channel(2), vec![0.0; width]];
            let [red, green, blue, zero] = &mut parts;
            fft.transform(red, green);
            fft.transform(blue, zero);
            parts
        };
        let rows = (0..).zip(&angles).map(row).collect();
        Self { width, fft, rows, angles }
    }

    /// The map filtered for GGX `alpha`, `width` texels wide.
    fn convolve(&self, width: u32, alpha: f64) -> Equirect {
        let height = width / 2;
        let rows: Vec<Vec<Vec3>> =
            (0..height).into_par_iter().map(|y| self.convolve_row(y, width, alpha)).collect();
        Equirect::new(RgbImage::from_fn(width, height, |x, y| rows[y as usize][x as usize]))
    }

    fn convolve_row(&self, y: u32, width: u32, alpha: f64) -> Vec<Vec3> {
        let mut sums = [(); 4].map(|()| vec![0.0; self.width]);
        let mut weights = 0.0;
        for subrow in 0..SUBROWS {
            let theta = PI * f64::from(y * SUBROWS + subrow) / f64::from(width / 2 * SUBROWS)
                + 0.5 * PI / f64::from(width / 2 * SUBROWS);
            let mut sub = [(); 4].map(|()| vec![0.0; self.width]);
            let norm = self.accumulate(theta, alpha, &mut sub);
            let weight = theta.sin();
            weights += weight;
            for (sum, sub) in sums.iter_mut().zip(&sub) {
                sum.iter_mut().zip(sub).for_each(|(sum, sub)| *sum += sub * weight / norm);
            }
        }
        let [red, green, blue, zero] = &mut sums;
        // Parts exchanged: the inverse transform.
        self.fft.transform(green, red);
        self.fft.transform(zero, blue);
        let texels = self.width / width as usize;
        let scale = 1.0 / (weights * self.width as f64 * texels as f64);
        let mean = |x: usize, channel: &[f64]| {
            // Rounding can take black slightly below 0.
            (channel[x * texels..(x + 1) * texels].iter().sum::<f64>() * scale).max(0.0) as f32
        };
        (0..width as usize).map(|x| Vec3::new(mean(x, red), mean(x, green), mean(x, blue))).collect()
    }

    /// Adds the spectrum of the unnormalised convolution for directions at polar angle `theta`; returns its integral of
    /// the kernel.
    fn accumulate(&self, theta: f64, alpha: f64, sums: &mut [Vec<f64>; 4]) -> f64 {
        let mut norm = 0.0;
        let (mut even, mut odd) = (vec![0.0; self.width], vec![0.0; self.width]);
        for pair in (0..self.rows.len()).step_by(2) {
            // Kernels are real and even, so their spectra are real: two rows share one transform.
            let found = [
                self.kernel_row(pair, theta, alpha, &mut even),
                self.kernel_row(pair + 1, theta, alpha, &mut odd),
            ];
            if found == [false; 2] {
                continue;
            }
            self.fft.transform(&mut even, &mut odd);
            for (kernel, row) in [(&even, pair), (&odd, pair + 1)] {
                norm += kernel[0] * self.angles[row];
                for (sum, part) in sums.iter_mut().zip(&self.rows[row]) {
                    sum.iter_mut()
                        .zip(part)
                        .zip(kernel)
                        .for_each(|((sum, part), kernel)| *sum += part * kernel);
                }
            }
        }
        norm
    }

    /// The kernel around `theta` for the texels of a source row, by column distance; `false` and zeros if it does not
    /// reach there.
    fn kernel_row(&self, row: usize, theta: f64, alpha: f64, out: &mut [f64]) -> bool {
        let step = PI / self.rows.len() as f64;
        let centre = (row as f64 + 0.5) * step;
        let distance = (centre - theta).abs();
        if distance > 0.5 * PI + step {
            out.fill(0.0);
            return false;
        }
        // The lobe falls to a quarter at an angle of 2 alpha; a texel is to be no wider than a third of that.
        let near = distance < NEAR_ROWS * step;
        let parts = if near { (3.0 * step / (2.0 * alpha)).ceil().clamp(1.0, 8.0) as usize } else { 1 };
        let alpha_squared = alpha * alpha;
        out.fill(0.0);
        for part in 0..parts {
            let offset = |part: usize| (part as f64 + 0.5) / parts as f64 - 0.5;
            let other = centre + offset(part) * step;
            // 1 - c = 1 - cos(theta - other) + sin(theta) sin(other) (1 - cos(phi)).
            let base = 2.0 * (0.5 * (theta - other)).sin().powi(2);
            let spread = theta.sin() * other.sin();
            for (column, sum) in out[..=self.width / 2].iter_mut().enumerate() {
                for across in 0..parts {
                    let phi = TAU * (column as f64 + offset(across)) / self.width as f64;
                    *sum += kernel(base + spread * 2.0 * (0.5 * phi).sin().powi(2), alpha_squared);
                }
            }
        }
        let scale = 1.0 / (parts * parts) as f64;
        for column in 0..=self.width / 2 {
            out[column] *= scale;
            out[(self.width - column) % self.width] = out[column];
        }
        true
    }
}
