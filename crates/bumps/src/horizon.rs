use glam::Vec2;
use gnomon_scene::Wrap;
use rayon::prelude::*;

use crate::Field;

/// Horizons of all texels in evenly spread azimuths, the first along x, the next ones towards y (Max 1988).
#[derive(Clone, Debug)]
pub struct Horizons {
    azimuths: usize,
    /// Texel after texel, tangents of the horizon's elevation, at least 0.
    slopes: Vec<f32>,
}

impl Horizons {
    /// Of the bilinear field, along lines through it, each swept once with the upper hull of what lies ahead (Timonen and Westerholm 2010):
    /// a step costs the same however far the horizon is.
    pub fn new(field: &Field<'_>, azimuths: usize) -> Self {
        let [width, height] = field.size();
        let by_azimuth: Vec<Vec<f32>> =
            (0..azimuths).into_par_iter().map(|i| sweep(field, i, azimuths)).collect();
        let texels = 0..width * height;
        let slopes = texels.flat_map(|texel| by_azimuth.iter().map(move |slopes| slopes[texel])).collect();
        Self { azimuths, slopes }
    }

    /// Number of azimuths.
    pub fn azimuths(&self) -> usize {
        self.azimuths
    }

    /// Tangents of the horizon's elevation around a texel.
    pub fn of(&self, texel: usize) -> &[f32] {
        &self.slopes[texel * self.azimuths..][..self.azimuths]
    }

    /// Tangent of the horizon's elevation in a direction, between two azimuths.
    pub fn towards(&self, texel: usize, direction: Vec2) -> f32 {
        horizon_between(self.of(texel), direction)
    }
}

/// Of values in evenly spread azimuths the one in a direction, linear between neighbours.
pub fn horizon_between(values: &[f32], direction: Vec2) -> f32 {
    let turns = direction.y.atan2(direction.x) / std::f32::consts::TAU;
    let place = (turns - turns.floor()) * values.len() as f32;
    let first = place as usize % values.len();
    let share = place - place.floor();
    values[first] + share * (values[(first + 1) % values.len()] - values[first])
}

/// The horizon in one azimuth, texel after texel.
fn sweep(field: &Field<'_>, azimuth: usize, azimuths: usize) -> Vec<f32> {
    let [width, height] = field.size();
    let (sine, cosine) = (std::f32::consts::TAU * azimuth as f32 / azimuths as f32).sin_cos();
    let direction = Vec2::new(cosine, sine) / field.spacing;
    // Lines step from column to column, or from row to row, whichever they cross more of.
    let by_rows = direction.y.abs() > direction.x.abs();
    let (along, across) = if by_rows { (direction.y, direction.x) } else { (direction.x, direction.y) };
    let (steps, lanes) = if by_rows { (height, width) } else { (width, height) };
    let wraps = field.map.wrap();
    let (wrap, wrap_across) = if by_rows { (wraps[1], wraps[0]) } else { (wraps[0], wraps[1]) };
    let texel = |step: i64, lane: i64| {
        let step = if along > 0.0 { step } else { steps as i64 - 1 - step };
        if by_rows { field.texel(lane, step) } else { field.texel(step, lane) }
    };
    let drift = across / along.abs();
    let step_length = 1.0 / along.abs();
    // Beyond a whole turn of a map that repeats nothing rises higher.
    let ahead = if wrap == Wrap::ClampToEdge { 0 } else { steps };
    // Lines that pass through every texel of the map.
    let drifted = drift * (steps as f32 - 1.0);
    let first = (-drifted).min(0.0).floor() as i64 - 1;
    let count = (lanes as i64 + (-drifted).max(0.0).ceil() as i64 + 1 - first) as usize;
    let mut of_lines = vec![0.0; count * steps];
    let mut hull: Vec<Vec2> = Vec::new();
    for line in 0..count {
        hull.clear();
        for step in (0..steps + ahead).rev() {
            let lane = (first + line as i64) as f32 + drift * step as f32;
            if wrap_across == Wrap::ClampToEdge && (lane < -0.5 || lane > lanes as f32 - 0.5) {
                continue;
            }
            let (low, share) = (lane.floor(), lane - lane.floor());
            let (step_at, low) = (step as i64, low as i64);
            let below = texel(step_at, low);
            let here =
                Vec2::new(step as f32 * step_length, below + share * (texel(step_at, low + 1) - below));
            let slope = |to: Vec2| (to.y - here.y) / (to.x - here.x);
            while let [.., second, top] = hull[..]
                && slope(second) >= slope(top)
            {
                hull.pop();
            }
            if step < steps {
                of_lines[line * steps + step] = hull.last().map_or(0.0, |&top| slope(top).max(0.0));
            }
            hull.push(here);
        }
    }
    let mut slopes = vec![0.0; width * height];
    for step in 0..steps {
        for lane in 0..lanes {
            let place = lane as f32 - drift * step as f32 - first as f32;
            let (line, share) = (place as usize, place - place.floor());
            let (one, next) =
                (of_lines[line * steps + step], of_lines[(line + 1).min(count - 1) * steps + step]);
            let step = if along > 0.0 { step } else { steps - 1 - step };
            let index = if by_rows { step * width + lane } else { lane * width + step };
            slopes[index] = one + share * (next - one);
        }
    }
    slopes
}
