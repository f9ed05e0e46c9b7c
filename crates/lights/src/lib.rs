//! Environment map in; area lights and a residual map out (`techniques`: Arbree 2005, Annen 2008).

mod light;

pub use light::{DistantLight, LightSet, LightShape};
