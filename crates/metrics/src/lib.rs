//! How far a picture is from the truth.
//!
//! [`compare`] measures everything at once: relative errors of the linear radiance, peak signal-to-noise ratio and
//! FLIP of what a display would show. A mean alone hides a missing shadow (a few pixels, all wrong); the error-weighted percentiles, the regions
//! and [`penumbra`] are there because they do not.

mod color_map;
mod compare;
mod difference;
mod display;
mod flip;
mod mask;
pub mod penumbra;
mod sampled;
mod weighted;
mod z_test;

pub use color_map::magma;
pub use compare::{
    Comparison, FlipSummary, MetricsError, WorstPixel, compare, compare_displayed, relative_rmse,
};
pub use difference::{flip_difference, signed_difference};
pub use display::{DISPLAY_MAPPING, Exposure};
pub use flip::{FlipMap, PIXELS_PER_DEGREE, flip};
pub use mask::{Mask, Region, RegionError};
pub use sampled::{PixelSample, SampledError};
pub use weighted::error_weighted_percentile;
pub use z_test::{ZTest, z_test};
