//! Bump maps that shadow and light themselves (Heidrich 2001, section 3, Figs 9 and 13).

mod fields;
mod pictures;

use crate::Suite;

/// Every experiment.
pub(crate) const SUITE: Suite = Suite {
    name: "bumps",
    title: "Bumps that shade, shadow and light each other (Heidrich 2001, section 3)",
    experiments: &[&pictures::Pictures],
};
