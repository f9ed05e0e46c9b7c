//! The evaluation of subtractive shadows (DeCoro and Rusinkiewicz 2008, Figs 3 to 5), and the search for the best setting of all.

mod best;
mod common;
mod curves;
mod equal_time;
mod lights;
mod sampling;

use crate::Suite;

/// Every experiment.
pub(crate) const SUITE: Suite = Suite {
    name: "subtractive",
    title: "Subtractive shadows and other compositing rules (DeCoro and Rusinkiewicz 2008)",
    experiments: &[&lights::Lights, &equal_time::EqualTime, &sampling::Sampling, &best::Best],
};
