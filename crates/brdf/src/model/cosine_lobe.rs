//! The generalised cosine lobe (Lafortune et al. 1997): a power of `Cx wo.x wi.x + Cy wo.y wi.y + Cz wo.z wi.z` in one table. `(-1, -1, 1)`
//! is Phong's; a smaller Cz leans it to the horizon, unequal Cx and Cy make it anisotropic, a positive one reflects back.

use glam::Vec3;

use super::tabulated::{COLUMNS, cosine_of};
use super::{ReflectanceModel, power_lobe};
use crate::sampling::cosine_power;
use crate::tables::{Coordinates, Factor, Term, Tint};
use crate::{AXES, BASE_COLOR, Layers, Parameter, SHININESS, SPECULAR, SPECULAR_COLOR, Surface, Tables};

/// See the module.
#[derive(Clone, Copy, Debug)]
pub struct CosineLobe;

impl ReflectanceModel for CosineLobe {
    const NAME: &'static str = "cosine-lobe";
    const SUMMARY: &'static str = "tables: Lambert and Lafortune's generalised cosine lobe";
    const REQUIRED: &'static [&'static Parameter] = &[&AXES, &SHININESS, &SPECULAR];
    const OPTIONAL: &'static [&'static Parameter] = &[&BASE_COLOR, &SPECULAR_COLOR];
    const SHAPE: Option<&'static Parameter> = None;
    const IS_TABULATED: bool = true;
    const NEEDS_TANGENT: bool = true;

    fn concerning(surface: Surface) -> Surface {
        power_lobe::concerning(surface)
    }

    fn tables(surface: &Surface) -> Option<Tables> {
        let shininess = SHININESS.clamped(surface);
        let scale = 1.0 / (1.0 + shininess).sqrt();
        let coordinates = Coordinates::CosineLobe(surface.axes);
        let lobe = Factor::new(coordinates, scale, [2 * COLUMNS, 1], |angle, _| {
            Vec3::splat(cosine_power(cosine_of(angle), shininess))
        });
        // `specular` is the most that it reflects.
        Some(Tables::new(vec![Term { tint: Tint::Color, factors: vec![lobe] }], 0.0).normalized(1.0))
    }

    fn strength(layers: &Layers) -> Vec3 {
        power_lobe::strength(layers)
    }
}
