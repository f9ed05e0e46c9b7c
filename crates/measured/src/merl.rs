//! MERL's files (Matusik et al. 2003): 90 x 90 x 180 values a channel, by the half vector's angle (its root is even), the difference's
//! angle and half a turn of its azimuth (Rusinkiewicz 1998).

use std::f32::consts::{FRAC_2_PI, PI};

use glam::Vec3;
use gnomon_brdf::tables::Coordinates;

use crate::error::{MeasuredError, invalid};

/// Steps of theta of the half vector, theta and azimuth of the difference.
const SIZE: [usize; 3] = [90, 90, 180];
const COUNT: usize = SIZE[0] * SIZE[1] * SIZE[2];
/// What red, green and blue are stored divided by.
const SCALES: [f64; 3] = [1.0 / 1500.0, 1.15 / 1500.0, 1.66 / 1500.0];

/// An isotropic measurement.
#[derive(Clone, Debug)]
pub struct Merl {
    /// Theta of the half vector, then theta of the difference, then its azimuth.
    values: Vec<Vec3>,
}

impl Merl {
    /// A file.
    ///
    /// # Errors
    /// [`MeasuredError::Invalid`] for another size, and for values that are no numbers.
    pub fn parse(bytes: &[u8]) -> Result<Self, MeasuredError> {
        let Some((head, rest)) = bytes.split_at_checked(12) else {
            return Err(invalid("a MERL file begins with three sizes of 4 bytes; this one is shorter"));
        };
        let size = [0, 1, 2].map(|i| [head[4 * i], head[4 * i + 1], head[4 * i + 2], head[4 * i + 3]]);
        let size = size.map(i32::from_le_bytes);
        if size != SIZE.map(|side| side as i32) {
            let [a, b, c] = size;
            return Err(invalid(format!(
                "a MERL file is of 90 x 90 x 180 values, this one of {a} x {b} x {c}"
            )));
        }
        if rest.len() != 3 * 8 * COUNT {
            let (found, expected) = (bytes.len(), 12 + 3 * 8 * COUNT);
            return Err(invalid(format!("a MERL file has {expected} bytes, this one {found}")));
        }
        let number = |i: usize| {
            let at = &rest[8 * i..8 * i + 8];
            f64::from_le_bytes([at[0], at[1], at[2], at[3], at[4], at[5], at[6], at[7]])
        };
        let mut values = Vec::with_capacity(COUNT);
        for i in 0..COUNT {
            let channels = [0, 1, 2].map(|channel| SCALES[channel] * number(channel * COUNT + i));
            if !channels.iter().all(|value| value.abs() < 1e9) {
                return Err(invalid(format!("value {i} of the MERL file is no reflectance: {channels:?}")));
            }
            // Below 0 where nothing was measured.
            values.push(Vec3::from_array(channels.map(|value| value.max(0.0) as f32)));
        }
        Ok(Self { values })
    }

    /// The stored value in steps of theta of the half vector, theta and azimuth of the difference; 0 where nothing was measured. `None`
    /// outside.
    pub fn stored(&self, half: usize, difference: usize, azimuth: usize) -> Option<Vec3> {
        let inside = half < SIZE[0] && difference < SIZE[1] && azimuth < SIZE[2];
        inside.then(|| self.values[(half * SIZE[1] + difference) * SIZE[2] + azimuth])
    }

    /// Reflectance [1/sr] between two directions above the surface, interpolated.
    pub(crate) fn value(&self, wo: Vec3, wi: Vec3) -> Vec3 {
        let [half, _] = Coordinates::Half.arguments(wo, wi);
        let [difference, azimuth] = Coordinates::Difference.arguments(wo, wi);
        // The steps' own values stand for their lower ends, as the authors look them up: the middle of a step is half a step on.
        let places = [half.sqrt() * SIZE[0] as f32, difference * SIZE[1] as f32, azimuth * SIZE[2] as f32];
        let mut sum = Vec3::ZERO;
        for corner in 0..8usize {
            let mut weight = 1.0;
            let mut index = [0; 3];
            for axis in 0..3 {
                let place = places[axis] - 0.5;
                let low = place.floor();
                let above = (corner >> axis) & 1;
                weight *= if above == 1 { place - low } else { 1.0 - (place - low) };
                let step = low as i64 + above as i64;
                let count = SIZE[axis] as i64;
                index[axis] =
                    if axis == 2 { step.rem_euclid(count) } else { step.clamp(0, count - 1) } as usize;
            }
            sum += weight * self.values[(index[0] * SIZE[1] + index[1]) * SIZE[2] + index[2]];
        }
        sum
    }

    /// Angles of the half vector, of the difference and its azimuth that a stored value stands for [rad]: the middle of its step.
    pub fn angles(half: usize, difference: usize, azimuth: usize) -> [f32; 3] {
        let middle = |i: usize, axis: usize| (i as f32 + 0.5) / SIZE[axis] as f32;
        [middle(half, 0).powi(2) / FRAC_2_PI, middle(difference, 1) / FRAC_2_PI, middle(azimuth, 2) * PI]
    }
}
