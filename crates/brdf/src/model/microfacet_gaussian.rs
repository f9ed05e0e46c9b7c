//! Torrance and Sparrow's microfacets with Gaussian angles and Fresnel's exact reflectance, in Heidrich's two tables:
//! `F(cos theta) D(cos delta)` and `G(cos alpha, cos beta) / (4 cos alpha cos beta)` (Heidrich 2001, section 1.1).

use glam::Vec3;

use super::microfacet_beckmann::smith_table;
use super::tabulated::{COLUMNS, FRESNEL_ROWS, cosine_of, half_scale};
use super::{ReflectanceModel, power_lobe};
use crate::tables::{Coordinates, Factor, Term, Tint};
use crate::{
    BASE_COLOR, EXTINCTION, INDEX, Parameter, SLOPE, SPECULAR, SPECULAR_COLOR, Surface, Tables, d_gaussian,
    f_exact, gaussian_masking_slope,
};

/// See the module.
#[derive(Clone, Copy, Debug)]
pub struct MicrofacetGaussian;

impl ReflectanceModel for MicrofacetGaussian {
    const NAME: &'static str = "microfacet-gaussian";
    const SUMMARY: &'static str =
        "tables: Lambert and microfacets of Gaussian angles with exact Fresnel, of metals too";
    const REQUIRED: &'static [&'static Parameter] = &[&SLOPE];
    const OPTIONAL: &'static [&'static Parameter] =
        &[&INDEX, &EXTINCTION, &BASE_COLOR, &SPECULAR, &SPECULAR_COLOR];
    const SHAPE: Option<&'static Parameter> = None;
    const IS_TABULATED: bool = true;

    fn concerning(surface: Surface) -> Surface {
        power_lobe::concerning(surface)
    }

    fn tables(surface: &Surface) -> Option<Tables> {
        let slope = SLOPE.clamped(surface);
        let facets = Factor::new(
            Coordinates::HalfAndDifference,
            half_scale(slope),
            [COLUMNS, FRESNEL_ROWS],
            |delta, theta| {
                f_exact(surface.index, surface.extinction, cosine_of(theta))
                    * d_gaussian(cosine_of(delta), slope)
            },
        );
        let factors = vec![facets, smith_table(gaussian_masking_slope(slope))];
        Some(Tables::new(vec![Term { tint: Tint::Color, factors }], 0.0))
    }

    fn strength(layers: &crate::Layers) -> Vec3 {
        power_lobe::strength(layers)
    }
}
