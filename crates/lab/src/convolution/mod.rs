//! The evaluation of convolution soft shadows (Annen et al. 2008, section 5), and what this project adds to it.

mod ambient;
mod common;
mod cost;
mod failures;
mod lights;
mod maps;
mod order;
mod rivals;
mod variant;

use crate::Suite;

/// Every experiment.
pub(crate) const SUITE: Suite = Suite {
    name: "convolution",
    title: "Convolution soft shadows and their rivals (Annen et al. 2008)",
    experiments: &[
        &cost::Cost,
        &rivals::Rivals,
        &order::Order,
        &lights::Lights,
        &maps::Maps,
        &ambient::AmbientPart,
        &failures::Failures,
    ],
};
