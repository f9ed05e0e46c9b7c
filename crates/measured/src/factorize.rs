//! Separable factorisation (Kautz and McCool 1999): values as a matrix over half vectors and differences, and its singular vectors of the
//! largest values as tables. Terms after the first have signs.

use std::f32::consts::{FRAC_PI_2, PI, TAU};

use glam::Vec3;
use gnomon_brdf::Tables;
use gnomon_brdf::tables::{Coordinates, Factor, Table, Term, Tint, unspread_place};

use crate::Measurement;

/// Columns over the half vector's angle, closest below this scale.
const HALF_COLUMNS: usize = 64;
const HALF_SCALE: f32 = 0.12;
/// Rows over its azimuth, of what is not isotropic.
const HALF_AZIMUTHS: usize = 32;
/// Columns over the difference's angle and rows over half a turn of its azimuth.
const DIFFERENCE: [usize; 2] = [32, 24];
/// Cosines of directions that are taken from the measurement: nearer to the surface it is divided by too little.
const LEAST_COSINE: f32 = 0.05;
/// Steps of the iteration that finds singular vectors, and further vectors that it goes on with: what is beyond the last term by a third
/// is a millionth by then.
const STEPS: usize = 16;
const SPARE: usize = 4;

/// Directions whose half vector and difference have these angles [rad].
fn directions([theta_h, phi_h]: [f32; 2], [theta_d, phi_d]: [f32; 2]) -> [Vec3; 2] {
    let polar =
        |theta: f32, phi: f32| Vec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos());
    let wi = polar(theta_d, phi_d);
    let wo = Vec3::new(-wi.x, -wi.y, wi.z);
    let rotation = glam::Quat::from_rotation_z(phi_h) * glam::Quat::from_rotation_y(theta_h);
    [rotation * wo, rotation * wi]
}

/// The angles of rows and columns of the matrix, and how much each counts: the root of its share of pairs of directions, times the cosine, as
/// the product of both directions' cosines is about that of both angles' squares.
struct Places {
    angles: Vec<[f32; 2]>,
    weights: Vec<f64>,
}

fn half_vectors(rows: usize) -> Places {
    let step = 1.0 / (HALF_COLUMNS - 1) as f32;
    let angle = |place: f32| FRAC_PI_2 * unspread_place(place.clamp(0.0, 1.0), HALF_SCALE);
    let mut places = Places { angles: Vec::new(), weights: Vec::new() };
    for row in 0..rows {
        for column in 0..HALF_COLUMNS {
            let place = column as f32 * step;
            let width = angle(place + 0.5 * step) - angle(place - 0.5 * step);
            let theta = angle(place);
            places.angles.push([theta, TAU * row as f32 / rows as f32]);
            let weight = (theta.max(0.25 * width).sin() * width).sqrt() * theta.cos().max(LEAST_COSINE);
            places.weights.push(f64::from(weight));
        }
    }
    places
}

fn differences() -> Places {
    let [columns, rows] = DIFFERENCE;
    let mut places = Places { angles: Vec::new(), weights: Vec::new() };
    for row in 0..rows {
        for column in 0..columns {
            let theta = FRAC_PI_2 * column as f32 / (columns - 1) as f32;
            places.angles.push([theta, PI * row as f32 / rows as f32]);
            let least: f32 = FRAC_PI_2 * 0.25 / columns as f32;
            let cosine = theta.cos().max(LEAST_COSINE);
            places.weights.push(f64::from((theta.max(least).sin() * cosine).sqrt() * cosine));
        }
    }
    places
}

/// Values over half vectors (rows) and differences, three channels. Where a direction is under the surface, the value of the largest difference
/// that is not stands.
fn matrix(measurement: &Measurement, halves: &Places, differences: &Places) -> [Vec<f64>; 3] {
    let count = differences.angles.len();
    let columns = DIFFERENCE[0];
    let mut channels = [0, 1, 2].map(|_| vec![0.0; halves.angles.len() * count]);
    for (row, &half) in halves.angles.iter().enumerate() {
        // Along the surface itself nothing is measured.
        let half = [half[0].min(FRAC_PI_2 - 1.2 * LEAST_COSINE), half[1]];
        for of_azimuth in 0..DIFFERENCE[1] {
            let mut last = Vec3::ZERO;
            for column in 0..columns {
                let place = of_azimuth * columns + column;
                let [wo, wi] = directions(half, differences.angles[place]);
                if wo.z.min(wi.z) > LEAST_COSINE {
                    last = measurement.value(wo, wi);
                }
                for (channel, values) in channels.iter_mut().enumerate() {
                    values[row * count + place] = f64::from(last[channel]);
                }
            }
        }
    }
    channels
}

/// `count` pairs of vectors whose outer products sum to about the matrix of so many columns, the largest first.
fn singular_vectors(matrix: &[f64], columns: usize, count: usize) -> Vec<(Vec<f64>, Vec<f64>)> {
    let rows = matrix.len() / columns;
    let wanted = (count + SPARE).min(rows).min(columns);
    // Any start will do that no singular vector is perpendicular to.
    let mut right: Vec<Vec<f64>> = (0..wanted)
        .map(|k| (0..columns).map(|i| 1.0 / (1.0 + k as f64) + ((i * (k + 1)) as f64 * 0.7).cos()).collect())
        .collect();
    let times = |v: &[f64]| -> Vec<f64> { matrix.chunks(columns).map(|row| dot(row, v)).collect() };
    let transposed = |u: &[f64]| -> Vec<f64> {
        let mut v = vec![0.0; columns];
        for (row, &weight) in matrix.chunks(columns).zip(u) {
            v.iter_mut().zip(row).for_each(|(v, value)| *v += weight * value);
        }
        v
    };
    for _ in 0..STEPS {
        orthonormalize(&mut right);
        right = right.iter().map(|v| transposed(&times(v))).collect();
    }
    orthonormalize(&mut right);
    right.into_iter().take(count).map(|v| (times(&v), v)).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Gram and Schmidt; a vector that the ones before it span becomes 0.
fn orthonormalize(vectors: &mut [Vec<f64>]) {
    for k in 0..vectors.len() {
        let (before, from) = vectors.split_at_mut(k);
        let vector = &mut from[0];
        let length = dot(vector, vector).sqrt();
        for other in before.iter() {
            let along = dot(vector, other);
            vector.iter_mut().zip(other).for_each(|(value, other)| *value -= along * other);
        }
        let left = dot(vector, vector).sqrt();
        let scale = if left > 1e-12 * length { 1.0 / left } else { 0.0 };
        vector.iter_mut().for_each(|value| *value *= scale);
    }
}

/// Tables of a measurement in so many terms, at most [`crate::MAX_TERMS`]: best in the mean over all pairs of directions.
pub fn factorize(measurement: &Measurement, terms: usize) -> Tables {
    let halves = half_vectors(if measurement.is_isotropic() { 1 } else { HALF_AZIMUTHS });
    let differences = differences();
    let (rows, columns) = (halves.angles.len(), differences.angles.len());
    let terms = terms.clamp(1, crate::MAX_TERMS);
    let pairs = matrix(measurement, &halves, &differences).map(|mut values| {
        for (value, place) in values.iter_mut().zip(0..) {
            *value *= halves.weights[place / columns] * differences.weights[place % columns];
        }
        singular_vectors(&values, columns, terms)
    });
    let gathered = |count: usize, weights: &[f64], vector: &dyn Fn(usize) -> Option<f64>| -> Vec<f32> {
        (0..count).map(|i| (vector(i).unwrap_or(0.0) / weights[i]) as f32).collect()
    };
    let table =
        |count: usize, width: usize, weights: &[f64], vector: &dyn Fn(usize, usize) -> Option<f64>| {
            let channels = [0, 1, 2].map(|channel| gathered(count, weights, &|i| vector(channel, i)));
            let values = (0..count).map(|i| Vec3::new(channels[0][i], channels[1][i], channels[2][i]));
            Table::of_rows(width, values.collect())
        };
    let made = (0..terms).filter_map(|term| {
        let left = |channel: usize, i: usize| pairs[channel].get(term).map(|(u, _)| u[i]);
        let right = |channel: usize, i: usize| pairs[channel].get(term).map(|(_, v)| v[i]);
        let half = table(rows, HALF_COLUMNS, &halves.weights, &left)?;
        let difference = table(columns, DIFFERENCE[0], &differences.weights, &right)?;
        let factors = vec![
            Factor { coordinates: Coordinates::Half, scale: HALF_SCALE, table: half },
            Factor { coordinates: Coordinates::Difference, scale: 0.0, table: difference },
        ];
        Some(Term { tint: Tint::Color, factors })
    });
    Tables::new(made.collect(), 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_are_those_that_tables_are_looked_up_with() {
        for (half, difference) in
            [([0.3, 1.0], [0.4, 2.0]), ([0.7, 5.0], [0.1, 0.5]), ([0.01, 0.0], [1.0, 3.0])]
        {
            let [wo, wi] = directions(half, difference);
            let found = Coordinates::Half.arguments(wo, wi);
            assert!((found[0] * FRAC_PI_2 - half[0]).abs() < 1e-4 && (found[1] * TAU - half[1]).abs() < 1e-3);
            let found = Coordinates::Difference.arguments(wo, wi);
            assert!((found[0] * FRAC_PI_2 - difference[0]).abs() < 1e-4, "{found:?}");
            assert!((found[1] * PI - difference[1]).abs() < 1e-3, "{found:?} {difference:?}");
        }
    }

    /// A matrix of rank two is found exactly, its larger part first.
    #[test]
    fn singular_vectors_of_two_products() {
        let (rows, columns) = (20, 30);
        let u = |k: usize, i: usize| ((i * (k + 2)) as f64).sin();
        let v = |k: usize, j: usize| ((j * (k + 3)) as f64).cos();
        let value = |i: usize, j: usize| 5.0 * u(0, i) * v(0, j) + u(1, i) * v(1, j);
        let matrix: Vec<f64> =
            (0..rows * columns).map(|place| value(place / columns, place % columns)).collect();
        let found = singular_vectors(&matrix, columns, 3);
        let sum = |i: usize, j: usize| found.iter().map(|(u, v)| u[i] * v[j]).sum::<f64>();
        for (place, entry) in matrix.iter().enumerate() {
            assert!((sum(place / columns, place % columns) - entry).abs() < 1e-9);
        }
        let length = |k: usize| dot(&found[k].0, &found[k].0).sqrt();
        assert!(length(0) > 2.0 * length(1) && length(2) < 1e-9, "{} {} {}", length(0), length(1), length(2));
    }
}
