use super::cost::CostModel;
use super::expected_error::expected_error;
use super::{FrameTimes, LevelOfDetail, LodRange};

/// Share of the budget that settings are chosen for.
const AIM: f64 = 0.97;
/// Shares of the budget between which nothing is changed.
const DEAD_BAND: (f64, f64) = (0.92, 1.03);
/// Frames that a choice stays, so that its own times are known before the next one. A change of the number of lights needs a new fit.
const HOLD: u32 = 8;
/// Frames over budget before there is less detail.
const FRAMES_OVER: u32 = 3;
/// Frames under budget before there is more, at first and at most: doubled whenever more turned out to be too much.
const PATIENCE: (u32, u32) = (4, 512);
/// A frame counts once towards [`PATIENCE`] for every such share of the budget that is left below the dead band.
const LEFT: f64 = 0.03;
/// Frames within which less detail after more counts as that.
const REGRET: u32 = 40;
/// Maps and samples change only for an added error this many times smaller.
const WORTHWHILE: f64 = 0.9;
/// More detail is predicted to take at most so many times as long as now: predictions far from what was measured are rough.
const LEAP: f64 = 3.0;
/// Maps and shadow buffers become at most so many times finer a side at once: what hardly shows in the time of coarse ones is hardly known.
const FINER: u32 = 4;

/// What a controller makes of its budget.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LodState {
    /// It is still finding settings.
    Settling,
    /// The budget is met: the time is in the band, or just below it where one more light would be too much.
    Met,
    /// All settings are at their best and the time is below the budget.
    Best,
    /// Even the least detail takes longer than the budget.
    BudgetTooLow,
}

/// Why there is no controller.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum LodError {
    /// A budget that is no time.
    #[error("frame budget {0} ms is out of range: give a number above 0")]
    Budget(f64),
    /// A range without settings.
    #[error(
        "level of detail: the range is empty, or a map's or a shadow buffer's side is no power of two; give least detail first, and at \
         least 1 light"
    )]
    Range,
}

/// Chooses each frame's level of detail so that frames take a given time.
///
/// Among the settings that are predicted to fit, it takes those of least expected error; the number of lights then fills what the
/// coarser knobs leave. It changes nothing within a dead band, and asks for more detail the later the more often that went wrong.
#[derive(Clone, Debug)]
pub struct LodController {
    budget_ms: f64,
    range: LodRange,
    level: LevelOfDetail,
    cost: CostModel,
    state: LodState,
    /// Frames since the last change, and since the last one to more detail.
    since_change: u32,
    since_more: u32,
    over: u32,
    under: u32,
    patience: u32,
}

impl LodController {
    /// Starts at the least detail of `range`.
    ///
    /// # Errors
    /// A budget that is not above 0 and finite, a range that holds nothing.
    pub fn new(budget_ms: f64, range: LodRange) -> Result<Self, LodError> {
        check(budget_ms, &range)?;
        Ok(Self {
            budget_ms,
            range,
            level: range.least,
            cost: CostModel::default(),
            state: LodState::Settling,
            since_change: 0,
            since_more: u32::MAX,
            over: 0,
            under: 0,
            patience: PATIENCE.0,
        })
    }

    /// Another budget [ms] or range from the next frame on.
    ///
    /// # Errors
    /// As [`LodController::new`].
    pub fn retarget(&mut self, budget_ms: f64, range: LodRange) -> Result<(), LodError> {
        check(budget_ms, &range)?;
        (self.budget_ms, self.range, self.patience) = (budget_ms, range, PATIENCE.0);
        self.level = clamped(self.level, &range);
        Ok(())
    }

    /// What the next frame is to be drawn with.
    pub fn level(&self) -> LevelOfDetail {
        self.level
    }

    /// What has become of the budget.
    pub fn state(&self) -> LodState {
        self.state
    }

    /// Takes in the times of a frame that was drawn with `level`, and gives what the next one is to be drawn with.
    pub fn next(&mut self, level: LevelOfDetail, times: &FrameTimes) -> LevelOfDetail {
        if self.cost.observe(level, times) {
            // Another scene: what went wrong in the one before says nothing.
            self.patience = PATIENCE.0;
        }
        self.since_change = self.since_change.saturating_add(1);
        self.since_more = self.since_more.saturating_add(1);
        let Some(now) = self.cost.total(self.level) else { return self.level };
        let share = now / self.budget_ms;
        self.over = if share > DEAD_BAND.1 { self.over.saturating_add(1) } else { 0 };
        let left = ((DEAD_BAND.0 - share) / LEFT).ceil().max(0.0) as u32;
        self.under = if left > 0 { self.under.saturating_add(left) } else { 0 };
        if self.since_change < HOLD {
            return self.level;
        }
        if self.over == 0 && self.under == 0 {
            self.state = if self.level == self.range.best { LodState::Best } else { LodState::Met };
        } else if self.over >= FRAMES_OVER || self.under >= self.patience {
            let chosen = self.choose(now);
            if chosen == self.level {
                self.state = self.state_at_rest();
            } else {
                self.change_to(chosen);
            }
        }
        self.level
    }

    /// Settings of least expected error among those that are predicted to fit; the cheapest if none is. The maps and samples of now
    /// stay if that is nearly as good.
    fn choose(&self, now: f64) -> LevelOfDetail {
        let budget = (AIM * self.budget_ms).min(LEAP * now);
        let here = self.filled(self.level, budget);
        let best = self
            .coarse_settings()
            .filter_map(|level| self.filled(level, budget))
            .min_by(|a, b| expected_error(*a).total_cmp(&expected_error(*b)));
        // Where nothing is to be had with the maps and samples of now, any gain will do.
        let worthwhile = if here == Some(self.level) { 1.0 } else { WORTHWHILE };
        match (here, best) {
            (Some(here), Some(best)) if expected_error(best) < worthwhile * expected_error(here) => best,
            (Some(here), _) => here,
            (None, Some(best)) => best,
            (None, None) => self.range.least,
        }
    }

    /// Every size of map with every share of samples that is not too far from now.
    fn coarse_settings(&self) -> impl Iterator<Item = LevelOfDetail> + use<> {
        let LodRange { least, best } = self.range;
        let powers =
            |from: u32, to: u32| (from.trailing_zeros()..=to.trailing_zeros()).map(|power| 1_u32 << power);
        let finest_map = best.shadow_resolution.min(self.level.shadow_resolution.saturating_mul(FINER));
        let finest_sampling = best.shadow_sampling.max(self.level.shadow_sampling / FINER);
        powers(least.shadow_resolution, finest_map).flat_map(move |shadow_resolution| {
            powers(finest_sampling, least.shadow_sampling).map(move |shadow_sampling| LevelOfDetail {
                shadow_resolution,
                shadow_sampling,
                ..least
            })
        })
    }

    /// The most lights that a budget holds with the other settings of `level`; `None` where not even the least number does.
    fn filled(&self, level: LevelOfDetail, budget_ms: f64) -> Option<LevelOfDetail> {
        let lights = self.cost.lights_within(level, budget_ms)?;
        let (least, most) = (self.range.least.lights, self.range.best.lights);
        (lights >= f64::from(least))
            .then(|| LevelOfDetail { lights: lights.min(f64::from(most)) as u32, ..level })
    }

    fn change_to(&mut self, level: LevelOfDetail) {
        let is_more = self.cost.total(level) > self.cost.total(self.level);
        if is_more {
            self.since_more = 0;
        } else if self.since_more < REGRET {
            self.patience = (2 * self.patience).min(PATIENCE.1);
        }
        (self.level, self.state, self.since_change) = (level, LodState::Settling, 0);
        (self.over, self.under) = (0, 0);
    }

    /// The state where nothing better than now is known.
    fn state_at_rest(&self) -> LodState {
        if self.over == 0 {
            return if self.level == self.range.best { LodState::Best } else { LodState::Met };
        }
        if self.level == self.range.least { LodState::BudgetTooLow } else { LodState::Settling }
    }
}

fn check(budget_ms: f64, range: &LodRange) -> Result<(), LodError> {
    if !(budget_ms > 0.0 && budget_ms.is_finite()) {
        return Err(LodError::Budget(budget_ms));
    }
    let LodRange { least, best } = range;
    let in_order = (1..=best.lights).contains(&least.lights)
        && least.shadow_resolution <= best.shadow_resolution
        && best.shadow_sampling <= least.shadow_sampling;
    let are_powers = [least, best]
        .iter()
        .all(|at| at.shadow_resolution.is_power_of_two() && at.shadow_sampling.is_power_of_two());
    if in_order && are_powers { Ok(()) } else { Err(LodError::Range) }
}

fn clamped(level: LevelOfDetail, LodRange { least, best }: &LodRange) -> LevelOfDetail {
    LevelOfDetail {
        lights: level.lights.clamp(least.lights, best.lights),
        shadow_resolution: level.shadow_resolution.clamp(least.shadow_resolution, best.shadow_resolution),
        shadow_sampling: level.shadow_sampling.clamp(best.shadow_sampling, least.shadow_sampling),
    }
}
