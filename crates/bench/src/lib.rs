//! Experiments: the evaluations of the papers that this project implements, made again on this machine.
//!
//! A [`Suite`] is the evaluation of one paper or of one property such as motion, an [`Experiment`] one figure or table of it: a file in the suite's folder and a
//! line in its list. An experiment is given a [`Lab`] (adapter, data, truth pictures, how much time there is) and returns a
//! [`gnomon_report::Section`]. Rivals are timed by [`timing::interleaved`], so that none has the machine for itself while
//! another shares it, and every time stands beside an error against ray-traced truth.

mod columns;
pub mod convolution;
mod data;
mod drawn;
mod error;
mod experiment;
mod lab;
pub mod motion;
mod pictures;
mod setup;
pub mod subtractive;
pub mod timing;
mod truth;

pub use data::{DataFolder, Environment, Stage};
pub use error::BenchError;
pub use experiment::{Experiment, Suite, suites};
pub use lab::{Effort, Lab, LabOptions};
pub use setup::{Setup, TimedRenderer};
pub use truth::Truth;
