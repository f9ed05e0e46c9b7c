//! Banks' thin threads along the tangent (Banks 1994; Heidrich 2001, eq. 4): the glossy part is `<n' | h>^s`, n' being the normal of the
//! thread in the plane of tangent and light. It depends on the angles of light and view to the tangent alone (Zoeckler, Stalling and Hege
//! 1996): with the view turned about the thread into that plane, n' and h are half the sum of both angles apart.

use std::f32::consts::PI;

use glam::Vec3;

use super::{ReflectanceModel, power_lobe};
use crate::sampling::cosine_power;
use crate::tables::{Coordinates, Factor, Term, Tint};
use crate::{BASE_COLOR, Layers, Parameter, SHININESS, SPECULAR, SPECULAR_COLOR, Surface, Tables};

/// See the module.
#[derive(Clone, Copy, Debug)]
pub struct Threads;

/// Sides of the table: the lobe is a ridge along its diagonal.
const SIDE: usize = 128;
/// A sharper ridge would fall between its texels.
const MAX_SHININESS: f32 = 500.0;

impl ReflectanceModel for Threads {
    const NAME: &'static str = "banks";
    const SUMMARY: &'static str = "tables: Lambert and thin threads along the tangent, an exponent as shape";
    const REQUIRED: &'static [&'static Parameter] = &[&SHININESS, &SPECULAR];
    const OPTIONAL: &'static [&'static Parameter] = &[&BASE_COLOR, &SPECULAR_COLOR];
    const SHAPE: Option<&'static Parameter> = None;
    const IS_TABULATED: bool = true;
    const NEEDS_TANGENT: bool = true;

    fn concerning(surface: Surface) -> Surface {
        power_lobe::concerning(surface)
    }

    fn tables(surface: &Surface) -> Option<Tables> {
        let shininess = SHININESS.clamped(surface).min(MAX_SHININESS);
        let threads = Factor::new(Coordinates::Tangent, 0.0, [SIDE; 2], |light, view| {
            Vec3::splat(cosine_power((0.5 * PI * (light + view - 1.0)).cos(), shininess))
        });
        // The model has no physical scale: `specular` is the most that it reflects.
        let terms = vec![Term { tint: Tint::Color, factors: vec![threads] }];
        Some(Tables::new(terms, 0.0).normalized(1.0))
    }

    fn strength(layers: &Layers) -> Vec3 {
        power_lobe::strength(layers)
    }
}
