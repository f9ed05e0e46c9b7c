//! What the heights of a surface hide from each other and scatter to each other (Heidrich, "Realistic and Hardware-Accelerated Shading and
//! Lighting", 2001, section 3), worked out once for a height field, whatever surface it lies on and whatever lights it.
//!
//! Directions are unit vectors in the field's own space: x along its rows to the right, y down its columns, z up, all in metres where the
//! field lies as it mostly does. On a surface that stretches or shears it, directions are brought there by the gradients of its texture
//! coordinates: what hides what on a height field does not change under such a map.

mod ellipse;
mod field;
mod horizon;
mod prepared;
mod scatter;

pub use ellipse::Ellipse;
pub use field::Field;
pub use horizon::{Horizons, horizon_between};
pub use prepared::{Prepared, Shape};
pub use scatter::{Bounces, Scattering};
