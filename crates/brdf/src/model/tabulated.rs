//! What tabulated models have in common.

use std::f32::consts::FRAC_PI_2;

use glam::Vec3;

use crate::tables::{Coordinates, Factor};

/// Columns of a round lobe's table; an elliptical one has half as many more, for two widths.
pub const COLUMNS: usize = 64;
/// Rows over the angle theta, where Fresnel's reflectance bends at grazing incidence.
pub const FRESNEL_ROWS: usize = 48;
/// Rows over a quarter turn about the normal.
pub const AZIMUTHS: usize = 48;
/// Sides of a table of two cosines.
pub const COSINES: usize = 48;

/// Scale of a table of half vectors about as wide as a slope.
pub fn half_scale(slope: f32) -> f32 {
    slope.min(1.0)
}

/// Fresnel's reflectance of a table's second argument, or of its first one.
pub fn cosine_of(argument: f32) -> f32 {
    (argument * FRAC_PI_2).cos().max(0.0)
}

/// A table over half vectors that is symmetric about both tangents, for an ellipse of these half axes: `value` takes the cosine of delta,
/// sine and cosine of the azimuth.
pub fn elliptical([along, across]: [f32; 2], value: impl Fn(f32, f32, f32) -> f32) -> Factor {
    let stretch = (along / across).sqrt();
    let rows = if along == across { 1 } else { AZIMUTHS };
    let columns = if along == across { COLUMNS } else { COLUMNS + COLUMNS / 2 };
    let scale = half_scale((along * across).sqrt());
    Factor::new(Coordinates::HalfQuadrant(stretch), scale, [columns, rows], |delta, azimuth| {
        let (sin, cos) = (FRAC_PI_2 * azimuth).sin_cos();
        let length = (sin / stretch).hypot(cos);
        Vec3::splat(value(cosine_of(delta), sin / stretch / length, cos / length))
    })
}

/// Half the axis of an ellipse of slopes towards an azimuth in the first quadrant, as masking takes it (Heitz 2014, eq. 80).
fn slope_towards([along, across]: [f32; 2], azimuth: f32) -> f32 {
    let (sin, cos) = (FRAC_PI_2 * azimuth).sin_cos();
    (along * cos).hypot(across * sin)
}

/// Smith's masking of one direction over twice its cosine, for `G1 G1 / (4 cos cos)`: finite at the horizon, where it tends to `pole`.
pub fn masking(
    coordinates: Coordinates,
    slopes: [f32; 2],
    pole: impl Fn(f32) -> f32,
    g1: impl Fn(f32, f32) -> f32,
) -> Factor {
    let rows = if slopes[0] == slopes[1] { 1 } else { AZIMUTHS };
    let scale = slopes[0].max(slopes[1]).min(1.0);
    Factor::new(coordinates, scale, [COSINES, rows], |cosine, azimuth| {
        let slope = slope_towards(slopes, azimuth);
        let value = if cosine > 1e-6 { g1(cosine, slope) / cosine } else { pole(slope) };
        Vec3::splat(0.5 * value)
    })
}
