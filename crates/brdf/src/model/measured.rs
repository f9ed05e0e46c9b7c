//! A measured or simulated reflectance whose tables are read from a file: [`crate::Lobe::tables`] are the material's.

use glam::Vec3;

use super::{ReflectanceModel, power_lobe};
use crate::{BASE_COLOR, Layers, Parameter, SPECULAR, SPECULAR_COLOR, Surface};

/// See the module.
#[derive(Clone, Copy, Debug)]
pub struct Measured;

impl ReflectanceModel for Measured {
    const NAME: &'static str = "measured";
    const SUMMARY: &'static str = "tables of a file that the scene file names, over Lambert";
    const REQUIRED: &'static [&'static Parameter] = &[];
    const OPTIONAL: &'static [&'static Parameter] = &[&BASE_COLOR, &SPECULAR, &SPECULAR_COLOR];
    const SHAPE: Option<&'static Parameter> = None;
    const IS_TABULATED: bool = true;
    const NEEDS_TANGENT: bool = true;

    fn concerning(surface: Surface) -> Surface {
        power_lobe::concerning(surface)
    }

    fn strength(layers: &Layers) -> Vec3 {
        power_lobe::strength(layers)
    }
}
