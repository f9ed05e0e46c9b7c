//! Environment map in; area lights and a residual map out (`techniques`: Arbree 2005, Annen 2008).
//!
//! [`fit`] holds the fits; each gives a [`LightSet`]: uniform [`DistantLight`]s plus the residual map.

mod clamp;
mod document;
pub mod fit;
pub mod form_factor;
mod light;
mod light_set;
mod preview;

pub use clamp::clamped;
pub use document::{DerivedEntry, DocumentError, LightDocument, LightEntry, ShapeEntry};
pub use fit::{FitError, FitOptions, LightFit};
pub use light::{DistantLight, LightShape};
pub use light_set::{FluxShares, LightSet};
pub use preview::preview;
