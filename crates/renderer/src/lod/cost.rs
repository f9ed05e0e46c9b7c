use super::{FrameTimes, LevelOfDetail, PASSES};

/// Frames whose middle time counts: one that was interrupted, or compiled a pipeline, does not.
const WINDOW: usize = 5;
/// Least share of the mismatch that a frame corrects. The first frames at a level correct more, so that together they count alike, and
/// so does one where the cost has plainly changed.
const GAIN: f64 = 0.06;
/// A ratio of measured to predicted time this far from 1 is a plain change.
const STEP: f64 = 1.25;
/// Levels that are remembered, and by how much the next older one counts less.
const MEMORY: usize = 8;
const FORGETTING: f64 = 0.8;
/// Weight of what is assumed about a pass before two levels tell more: that each term is what it is assumed to be, within about its own
/// size, where times scatter by a tenth.
const ASSUMED: f64 = 0.01;
/// Terms assumed to be less than this share of their pass are held to that as loosely as if they were that much.
const LEAST_ASSUMED: f64 = 0.02;
/// Errors of passes shorter than this share of the frame count as if they were that long.
const LEAST_SHARE: f64 = 0.02;

/// How a pass's time depends on the level of detail: the sum of two terms, and how many times the second's coefficient the first's is taken
/// for before anything else is known.
#[derive(Clone, Copy)]
enum Scaling {
    /// The same at every level.
    Constant,
    /// Per light, and per light and 256 x 256 texels of its map.
    Texels { per_light: f64 },
    /// Per light and side of the shadow buffer's samples, in 32 of the picture's: the coarser they are, the more samples at edges have sums
    /// of their own. And per light for a sum at every sample of the picture.
    Samples { per_light: f64 },
}

/// In the order of [`FrameTimes::to_array`].
const SCALINGS: [Scaling; PASSES] = [
    Scaling::Constant,
    Scaling::Texels { per_light: 0.25 },
    Scaling::Texels { per_light: 0.05 },
    Scaling::Samples { per_light: 0.02 },
    Scaling::Constant,
];

impl Scaling {
    fn terms(self, level: LevelOfDetail) -> [f64; 2] {
        let lights = f64::from(level.lights);
        match self {
            Self::Constant => [1.0, 0.0],
            Self::Texels { .. } => [lights, lights * (f64::from(level.shadow_resolution) / 256.0).powi(2)],
            Self::Samples { .. } => {
                let side = f64::from(level.shadow_sampling);
                [lights * side / 32.0, lights / (side * side)]
            }
        }
    }

    /// What part of the time at a level each term is assumed to be.
    fn shares(self, level: LevelOfDetail) -> [f64; 2] {
        let [first, second] = self.terms(level);
        match self {
            Self::Constant => [1.0, 0.0],
            Self::Texels { per_light } | Self::Samples { per_light } => {
                let sum = (per_light * first + second).max(f64::MIN_POSITIVE);
                [per_light * first / sum, second / sum]
            }
        }
    }
}

/// Predicts the time of a frame at any level of detail from those that were measured, and follows when a scene becomes dearer.
///
/// Each pass has one coefficient for each of its terms: the least squares of relative errors over the levels that were drawn last,
/// then scaled to the present one. Where a pass's time changes at one level, it is taken to have changed at all of them.
#[derive(Clone, Debug, Default)]
pub(super) struct CostModel {
    /// [ms] per unit of each term.
    coefficients: [[f64; 2]; PASSES],
    /// The latest last.
    memory: Vec<Remembered>,
    /// The level that was drawn last, for how many frames, and the times of at most [`WINDOW`] of them.
    level: Option<LevelOfDetail>,
    frames: usize,
    recent: Vec<[f64; PASSES]>,
}

/// What the passes took at one level [ms].
#[derive(Clone, Debug)]
struct Remembered {
    level: LevelOfDetail,
    times: [f64; PASSES],
}

impl CostModel {
    /// Takes a frame in; frames whose times are not finite or negative tell nothing. Whether the cost has plainly changed.
    pub fn observe(&mut self, level: LevelOfDetail, times: &FrameTimes) -> bool {
        let times = times.to_array();
        if times.iter().any(|time| !time.is_finite() || *time < 0.0) {
            return false;
        }
        if self.level != Some(level) {
            (self.level, self.frames) = (Some(level), 0);
            self.recent.clear();
        }
        if self.recent.len() == WINDOW {
            self.recent.remove(0);
        }
        self.recent.push(times);
        self.frames = self.frames.saturating_add(1);
        if self.recent.len() < WINDOW {
            return false;
        }
        let middle = std::array::from_fn(|pass| {
            let mut times: Vec<f64> = self.recent.iter().map(|times| times[pass]).collect();
            times.sort_by(f64::total_cmp);
            times[WINDOW / 2]
        });
        let is_step = self.remember(level, middle);
        for (pass, scaling) in SCALINGS.into_iter().enumerate() {
            self.coefficients[pass] = fitted(scaling, pass, &self.memory);
        }
        is_step
    }

    /// Takes the middle times of the last frames into what is known of their level. Whether they plainly differ from it.
    fn remember(&mut self, level: LevelOfDetail, middle: [f64; PASSES]) -> bool {
        if self.frames == WINDOW {
            self.memory.retain(|known| known.level != level);
            self.memory.push(Remembered { level, times: middle });
            let excess = self.memory.len().saturating_sub(MEMORY);
            self.memory.drain(..excess);
            return false;
        }
        let Some(known) = self.memory.last().map(|known| known.times) else { return false };
        let gain = (1.0 / (self.frames - WINDOW + 1) as f64).max(GAIN);
        let mut stepped = 0.0;
        for pass in 0..PASSES {
            let is_step = !(known[pass] / STEP..=known[pass] * STEP).contains(&middle[pass]);
            let time = if is_step { middle[pass] } else { known[pass] + gain * (middle[pass] - known[pass]) };
            let ratio = if is_step && known[pass] > 0.0 { time / known[pass] } else { 1.0 };
            stepped += (ratio - 1.0).abs() * known[pass];
            for other in &mut self.memory {
                other.times[pass] = if other.level == level { time } else { ratio * other.times[pass] };
            }
        }
        stepped > (STEP - 1.0) * known.iter().sum::<f64>()
    }

    /// Predicted time of a frame [ms]; `None` before the first frames.
    pub fn total(&self, level: LevelOfDetail) -> Option<f64> {
        let predicted = (0..PASSES).map(|pass| predict(SCALINGS[pass], self.coefficients[pass], level));
        (!self.memory.is_empty()).then(|| predicted.sum())
    }

    /// Most lights, at the other settings of `level`, that are predicted to fit into `budget_ms`, as a real number.
    pub fn lights_within(&self, level: LevelOfDetail, budget_ms: f64) -> Option<f64> {
        // All terms but the constant ones are in proportion to the number of lights.
        let none = self.total(LevelOfDetail { lights: 0, ..level })?;
        let one = self.total(LevelOfDetail { lights: 1, ..level })? - none;
        Some(if one > 0.0 {
            (budget_ms - none) / one
        } else if none <= budget_ms {
            f64::INFINITY
        } else {
            -1.0
        })
    }
}

/// Coefficients of a pass, none negative, that agree with the latest of `memory` and best with the rest.
fn fitted(scaling: Scaling, pass: usize, memory: &[Remembered]) -> [f64; 2] {
    let Some(latest) = memory.last() else { return [0.0; 2] };
    let (present, shares) = (scaling.terms(latest.level), scaling.shares(latest.level));
    let time = latest.times[pass];
    // Normal equations; each term in units of the present one, so that both coefficients are times.
    let unit =
        |terms: [f64; 2]| [terms[0] / present[0].max(1.0), terms[1] / present[1].max(f64::MIN_POSITIVE)];
    let assumed = shares.map(|share| ASSUMED / share.max(LEAST_ASSUMED).powi(2));
    let mut matrix = [[assumed[0], 0.0], [0.0, assumed[1]]];
    let mut right: [f64; 2] = std::array::from_fn(|i| assumed[i] * shares[i] * time);
    let scale = |known: &Remembered| known.times[pass].max(LEAST_SHARE * known.times.iter().sum::<f64>());
    let reference = scale(latest);
    for (age, known) in memory.iter().rev().enumerate() {
        let (terms, scale) = (unit(scaling.terms(known.level)), scale(known));
        if scale <= 0.0 {
            continue;
        }
        let weight = FORGETTING.powi(age as i32) * (reference / scale).powi(2);
        for i in 0..2 {
            right[i] += weight * terms[i] * known.times[pass];
            for j in 0..2 {
                matrix[i][j] += weight * terms[i] * terms[j];
            }
        }
    }
    let [[a, b], [_, d]] = matrix;
    let determinant = a * d - b * b;
    let mut times =
        [right[0] * d - right[1] * b, right[1] * a - right[0] * b].map(|value| value / determinant);
    if times[0] < 0.0 {
        times = [0.0, (right[1] / d).max(0.0)];
    } else if times[1] < 0.0 {
        times = [(right[0] / a).max(0.0), 0.0];
    }
    let sum = times[0] + times[1];
    let correction = if sum > 0.0 { time / sum } else { 0.0 };
    std::array::from_fn(|i| if present[i] > 0.0 { correction * times[i] / present[i] } else { 0.0 })
}

fn predict(scaling: Scaling, coefficients: [f64; 2], level: LevelOfDetail) -> f64 {
    let terms = scaling.terms(level);
    coefficients[0] * terms[0] + coefficients[1] * terms[1]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn level(lights: u32, shadow_resolution: u32, shadow_sampling: u32) -> LevelOfDetail {
        LevelOfDetail { lights, shadow_resolution, shadow_sampling }
    }

    fn times(level: LevelOfDetail, factor: f64) -> FrameTimes {
        let lights = f64::from(level.lights);
        let texels = (f64::from(level.shadow_resolution) / 256.0).powi(2);
        let samples = 1.0 / f64::from(level.shadow_sampling).powi(2);
        FrameTimes {
            fixed: 2.0,
            shadow_maps: factor * lights * (0.05 + 0.02 * texels),
            shadow_filter: factor * lights * 0.03 * texels,
            light: factor * lights * (0.02 * f64::from(level.shadow_sampling) / 32.0 + 1.0 * samples),
            compose: 0.5,
        }
    }

    #[test]
    fn after_a_few_levels_it_predicts_another() {
        let mut model = CostModel::default();
        for (lights, resolution, sampling) in
            [(10, 128, 8), (40, 256, 4), (20, 256, 2), (30, 512, 4), (60, 64, 8)].into_iter().cycle().take(40)
        {
            let level = level(lights, resolution, sampling);
            for _ in 0..8 {
                model.observe(level, &times(level, 1.0));
            }
        }
        for unseen in [level(50, 128, 4), level(100, 256, 8), level(15, 512, 2)] {
            let (found, expected) = (model.total(unseen).unwrap(), times(unseen, 1.0).total());
            assert!((found / expected - 1.0).abs() < 0.1, "{unseen:?}: {found} {expected}");
            let lights = model.lights_within(unseen, found).unwrap();
            assert!((lights - f64::from(unseen.lights)).abs() < 1e-6);
        }
    }

    #[test]
    fn a_single_slow_frame_changes_nothing_and_a_dearer_scene_is_followed_at_once() {
        let mut model = CostModel::default();
        let level = level(30, 256, 4);
        for _ in 0..10 {
            assert!(!model.observe(level, &times(level, 1.0)));
        }
        let before = model.total(level).unwrap();
        assert!(!model.observe(level, &times(level, 50.0)));
        assert!((model.total(level).unwrap() / before - 1.0).abs() < 1e-6);
        model.observe(level, &times(level, 1.0));
        assert!((0..3).any(|_| model.observe(level, &times(level, 2.0))));
        let (found, expected) = (model.total(level).unwrap(), times(level, 2.0).total());
        assert!((found / expected - 1.0).abs() < 1e-6, "{found} {expected}");
    }

    #[test]
    fn times_that_are_none_tell_nothing_and_zeros_are_no_trouble() {
        let mut model = CostModel::default();
        let level = level(30, 256, 4);
        for bad in [f64::NAN, f64::INFINITY, -1.0] {
            assert!(!model.observe(level, &FrameTimes { light: bad, ..times(level, 1.0) }));
        }
        assert_eq!(model.total(level), None);
        for _ in 0..5 {
            model.observe(level, &FrameTimes::default());
        }
        assert_eq!(model.total(level), Some(0.0));
        assert_eq!(model.lights_within(level, 1.0), Some(f64::INFINITY));
        for _ in 0..5 {
            model.observe(level, &times(level, 1.0));
        }
        let found = model.total(level).unwrap();
        assert!((found / times(level, 1.0).total() - 1.0).abs() < 1e-6, "{found}");
    }
}
