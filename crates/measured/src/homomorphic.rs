//! Homomorphic factorisation (McCool, Ang and Ahmad 2001): the logarithm of the reflectance as a sum of functions of light, half vector and
//! view, by least squares with a smoothness term. One product of positive tables.

use glam::{Vec2, Vec3};
use gnomon_brdf::tables::{Coordinates, Factor, Table, Term, Tint, spread_place};
use gnomon_brdf::{Tables, sample_cosine_hemisphere};

use crate::Measurement;

/// Texels over the half vector's angle and over the cosine of light or view, and where they lie.
const HALF: usize = 64;
const HALF_SCALE: f32 = 0.12;
const COSINES: usize = 32;
const COSINE_SCALE: f32 = 0.5;
/// Pairs of directions, half of them with half vectors near the normal.
const PAIRS: u32 = 40_000;
/// Weight of the squared second differences of neighbouring texels, against a mean pair a texel.
const SMOOTHNESS: f64 = 1e-3;

/// The same of an isotropic measurement; light and view share their table, so that it is reciprocal.
pub fn homomorphic(measurement: &Measurement) -> Tables {
    let count = HALF + COSINES;
    let mut normal = vec![0.0f64; count * count];
    let mut right = [0, 1, 2].map(|_| vec![0.0f64; count]);
    let mut brightest = 0.0f32;
    let mut pairs = Vec::new();
    for i in 0..PAIRS {
        // Roberts 2018, R4.
        let u = [0.856_674_9, 0.733_891_9, 0.628_706_7, 0.538_597_3_f64]
            .map(|step| ((f64::from(i) + 1.0) * step).fract() as f32);
        let wo = sample_cosine_hemisphere(Vec2::new(u[0], u[1]));
        let wi = if i % 2 == 0 {
            sample_cosine_hemisphere(Vec2::new(u[2], u[3]))
        } else {
            // The half vector's angle goes with the square of an even number.
            let h = sample_cosine_hemisphere(Vec2::new(u[2].powi(4), u[3]));
            2.0 * h.dot(wo) * h - wo
        };
        if wo.z > 0.05 && wi.z > 0.05 {
            let value = measurement.value(wo, wi);
            brightest = brightest.max(value.max_element());
            pairs.push((wo, wi, value));
        }
    }
    // Nothing is darker than noise.
    let least = (1e-5 * brightest).max(1e-9);
    for (wo, wi, value) in &pairs {
        let mut terms = Vec::with_capacity(6);
        let mut add = |first: usize, columns: usize, place: f32| {
            let place = place.clamp(0.0, 1.0) * (columns - 1) as f32;
            let low = (place as usize).min(columns - 2);
            let along = f64::from(place - low as f32);
            terms.extend([(first + low, 1.0 - along), (first + low + 1, along)]);
        };
        add(0, HALF, spread_place(Coordinates::Half.arguments(*wo, *wi)[0], HALF_SCALE));
        add(HALF, COSINES, spread_place(wi.z, COSINE_SCALE));
        add(HALF, COSINES, spread_place(wo.z, COSINE_SCALE));
        for &(i, a) in &terms {
            for &(j, b) in &terms {
                normal[i * count + j] += a * b;
            }
            for (channel, right) in right.iter_mut().enumerate() {
                right[i] += a * f64::from(value[channel].max(least).ln());
            }
        }
    }
    let smoothness = SMOOTHNESS * pairs.len() as f64 / count as f64;
    for (first, length) in [(0, HALF), (HALF, COSINES)] {
        for middle in first + 1..first + length - 1 {
            for (i, a) in [(middle - 1, 1.0), (middle, -2.0), (middle + 1, 1.0)] {
                for (j, b) in [(middle - 1, 1.0), (middle, -2.0), (middle + 1, 1.0)] {
                    normal[i * count + j] += smoothness * a * b;
                }
            }
        }
    }
    // Both functions are known up to a constant that the other takes.
    (0..count).for_each(|i| normal[i * count + i] += 1e-6 * pairs.len().max(1) as f64);
    let logarithms = right.map(|right| solved(normal.clone(), right));
    let table = |first: usize, columns: usize| {
        let value =
            |i: usize| Vec3::from_array([0, 1, 2].map(|channel| logarithms[channel][first + i].exp() as f32));
        Table::of_rows(columns, (0..columns).map(value).collect())
    };
    let factors = [
        (Coordinates::Half, HALF_SCALE, table(0, HALF)),
        (Coordinates::Light, COSINE_SCALE, table(HALF, COSINES)),
        (Coordinates::View, COSINE_SCALE, table(HALF, COSINES)),
    ];
    let factors = factors
        .into_iter()
        .filter_map(|(coordinates, scale, table)| Some(Factor { coordinates, scale, table: table? }));
    Tables::new(vec![Term { tint: Tint::Color, factors: factors.collect() }], 0.0)
}

/// The solution of a symmetric, positive definite system by Cholesky's decomposition.
fn solved(mut a: Vec<f64>, mut b: Vec<f64>) -> Vec<f64> {
    let n = b.len();
    for j in 0..n {
        for k in 0..j {
            let factor = a[j * n + k];
            (j..n).for_each(|i| a[i * n + j] -= factor * a[i * n + k]);
        }
        let root = a[j * n + j].max(1e-300).sqrt();
        (j..n).for_each(|i| a[i * n + j] /= root);
    }
    for i in 0..n {
        let below: f64 = (0..i).map(|k| a[i * n + k] * b[k]).sum();
        b[i] = (b[i] - below) / a[i * n + i];
    }
    for i in (0..n).rev() {
        let above: f64 = (i + 1..n).map(|k| a[k * n + i] * b[k]).sum();
        b[i] = (b[i] - above) / a[i * n + i];
    }
    b
}
