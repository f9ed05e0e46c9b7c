//! Environment maps: where radiance comes from, direction by direction.
//!
//! [`Equirect`] is the one form the rest of the project uses; every other projection is resampled into it with its
//! flux preserved. Axes, seam and sample positions are fixed in `CONVENTIONS.md`.

mod backdrop;
pub mod builtin;
mod cube;
mod equirect;
mod fft;
mod grade;
mod grid;
mod intake;
mod load;
mod overlap;
mod prefilter;
mod projection;
mod resample;
mod sh;
mod transfer;

pub use backdrop::Backdrop;
pub use cube::CubeMap;
pub use equirect::Equirect;
pub use grade::Grade;
pub use load::{CleanReport, EnvMapError, Environment, LoadOptions, from_bytes, from_picture, load};
pub use prefilter::{PrefilteredMap, prefiltered_level};
pub use projection::Projection;
pub use sh::{Sh9, sh9_basis};
