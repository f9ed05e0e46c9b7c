//! Light rigs: the lights of an environment and the map that they leave, as other programs read them.
//!
//! [`targets`] lists the programs, one file each; [`write`] writes a rig and its maps. A target says what it cannot express, so that a
//! fit can be chosen that it can: [`Target::fit`].

mod rig;
mod target;
mod write;

pub use rig::{FarShape, Outline, Rig, Sun};
pub use target::{Reflections, Target, by_extension, by_name, targets};
pub use write::{RigError, Written, write};
