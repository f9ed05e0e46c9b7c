//! Every shader of the project as WGSL, the resolver that puts modules together, and the structs shared with Rust.
//!
//! Nothing here needs a GPU: all entry points are parsed and validated by naga in the tests.

pub mod layout;
mod models;
mod modules;
pub mod twin;

pub use modules::{ENTRIES, Entry, ShaderError, Slot, modules, resolve};
