//! What a frame's time buys.

mod scenes;

use crate::Suite;

/// Every experiment.
pub(crate) const SUITE: Suite = Suite {
    name: "budget",
    title: "Error against time: the default, less and more of it, and 1000 hard shadow maps",
    experiments: &[&scenes::Scenes],
};
