//! One file a command: its arguments, and what they mean.

mod check;
pub mod compare;
pub mod dataset;
pub mod decompose;
pub mod demo;
pub mod info;
pub mod inspect;
mod level_of_detail;
pub mod reference;
pub mod reflectance;
pub mod render;
mod sequence;
#[cfg(feature = "view")]
pub mod view;
