//! Environment maps: where radiance comes from, direction by direction.
//!
//! [`Equirect`] is the one form the rest of the project uses; every other projection is resampled into it with its
//! flux preserved. Axes, seam and sample positions are fixed in `CONVENTIONS.md`.

mod equirect;

pub use equirect::Equirect;
