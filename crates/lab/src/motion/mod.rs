//! Everything that moves: what motion costs, and how far behind it anything lags.

mod animation;
mod environment;

use crate::Suite;

/// Every experiment.
pub(crate) const SUITE: Suite = Suite {
    name: "motion",
    title: "Motion: what it costs that everything may change in every frame",
    experiments: &[&animation::Animation, &environment::TurningEnvironment],
};
