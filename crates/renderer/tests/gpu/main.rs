//! Everything that needs a GPU, as one program: it links once.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]
#![allow(clippy::print_stdout, reason = "measured errors are read with --nocapture")]

mod analytic;
mod anisotropy;
mod asynchronous;
mod backdrop;
mod blending;
mod bumps;
mod casters;
mod catcher;
mod change;
mod common;
mod compositing;
mod copies;
mod debug_views;
mod embedding;
mod filters;
mod finish;
mod gloss;
mod layers;
mod level_of_detail;
mod lights;
mod masks;
mod motion;
mod rays;
mod reflectance;
mod rivals;
mod rotation;
mod sampling;
mod truth;
mod unshadowed;
mod visibility;
mod wedges;
