//! Microfacets of Gaussian slopes, elliptical ones too (Beckmann; Ward 1992 for the ellipse), with Fresnel's exact reflectance. Round ones
//! are Heidrich's two tables (2001, section 1.1); elliptical ones `D(delta, phi)`, `F(theta)` and Smith's masking of either direction.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use super::tabulated::{COLUMNS, COSINES, FRESNEL_ROWS, cosine_of, elliptical, half_scale, masking};
use super::{ReflectanceModel, power_lobe};
use crate::tables::{Coordinates, Factor, Term, Tint};
use crate::{
    ASPECT, BASE_COLOR, EXTINCTION, INDEX, Layers, Parameter, SLOPE, SPECULAR, SPECULAR_COLOR, Surface,
    Tables, d_beckmann, f_exact, g1_smith_beckmann,
};

/// See the module.
#[derive(Clone, Copy, Debug)]
pub struct MicrofacetBeckmann;

/// Cosine over slope, times this, is Smith's masking near the horizon: [`g1_smith_beckmann`] of small cosines.
const GRAZING: f32 = 3.535;

/// `G(cos alpha, cos beta) / (4 cos alpha cos beta)` of slopes alike in all directions. It is finite at grazing angles, however tall.
pub fn smith_table(slope: f32) -> Factor {
    let over_cosine = move |cosine: f32| {
        if cosine > 1e-6 { g1_smith_beckmann(cosine, slope) / cosine } else { GRAZING / slope }
    };
    Factor::new(Coordinates::Cosines, slope.min(1.0), [COSINES; 2], |light, view| {
        Vec3::splat(0.25 * over_cosine(light) * over_cosine(view))
    })
}

/// `exp(-tan^2 delta (cos^2 phi / along^2 + sin^2 phi / across^2)) / (pi along across cos^4 delta)`.
pub fn elliptical_gaussian(slopes: [f32; 2]) -> Factor {
    let [along, across] = slopes;
    elliptical(slopes, |cosine, sin, cos| {
        let c2 = cosine.max(MIN_COSINE).powi(2);
        let exponent = (1.0 - c2) / c2 * ((cos / along).powi(2) + (sin / across).powi(2));
        (-exponent).exp() * FRAC_1_PI / (along * across * c2 * c2)
    })
}

/// Least cosine of delta: where the fourth power of a smaller one would be lost, the exponential is 0.
const MIN_COSINE: f32 = 1e-2;

/// Slopes along the tangent and across it.
pub fn slopes(surface: &Surface) -> [f32; 2] {
    let slope = SLOPE.clamped(surface);
    [slope, (slope * ASPECT.clamped(surface)).clamp(SLOPE.range[0], SLOPE.range[1])]
}

impl ReflectanceModel for MicrofacetBeckmann {
    const NAME: &'static str = "microfacet-beckmann";
    const SUMMARY: &'static str = "tables: Lambert and microfacets of Gaussian slopes, anisotropic too, with exact Fresnel, of metals too";
    const REQUIRED: &'static [&'static Parameter] = &[&SLOPE];
    const OPTIONAL: &'static [&'static Parameter] =
        &[&ASPECT, &INDEX, &EXTINCTION, &BASE_COLOR, &SPECULAR, &SPECULAR_COLOR];
    const SHAPE: Option<&'static Parameter> = None;
    const IS_TABULATED: bool = true;
    const NEEDS_TANGENT: bool = true;

    fn concerning(surface: Surface) -> Surface {
        power_lobe::concerning(surface)
    }

    fn tables(surface: &Surface) -> Option<Tables> {
        let slopes = slopes(surface);
        let [along, across] = slopes;
        let fresnel = |theta: f32| f_exact(surface.index, surface.extinction, cosine_of(theta));
        let factors = if along == across {
            let size = [COLUMNS, FRESNEL_ROWS];
            let facets =
                Factor::new(Coordinates::HalfAndDifference, half_scale(along), size, |delta, theta| {
                    fresnel(theta) * d_beckmann(cosine_of(delta), along)
                });
            vec![facets, smith_table(along)]
        } else {
            let g1 = |coordinates| masking(coordinates, slopes, |slope| GRAZING / slope, g1_smith_beckmann);
            let fresnel =
                Factor::new(Coordinates::Difference, 0.0, [FRESNEL_ROWS, 1], |theta, _| fresnel(theta));
            vec![elliptical_gaussian(slopes), fresnel, g1(Coordinates::Light), g1(Coordinates::View)]
        };
        Some(Tables::new(vec![Term { tint: Tint::Color, factors }], 0.0))
    }

    fn strength(layers: &Layers) -> Vec3 {
        power_lobe::strength(layers)
    }
}
