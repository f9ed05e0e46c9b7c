use glam::{Vec2, Vec3, Vec4};
use gnomon_brdf::{Lobe, Model, Tables};

use crate::Measurement;

/// How far tables are from what they stand for, over pairs of directions above 6 degrees of elevation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitError {
    /// Root of the mean square of the error over that of the value, both times both cosines: what is bright counts.
    pub relative_l2: f64,
    /// Mean error over the mean value, both times both cosines.
    pub mean: f64,
}

/// Views, and lights for each.
const VIEWS: u32 = 64;
const LIGHTS: u32 = 400;
/// Cosines of what is compared.
const LEAST_COSINE: f32 = 0.1;

/// The error of tables.
pub fn fit_error(measurement: &Measurement, tables: &Tables) -> FitError {
    let lobe = Lobe { model: Model::Measured, shape: 0.0, tint: Vec4::ONE, tables: Some(tables) };
    let number = |i: u32, step: f64| ((f64::from(i) + 1.0) * step).fract() as f32;
    let (mut error2, mut value2, mut error, mut value) = (0.0, 0.0, 0.0, 0.0);
    for i in 0..VIEWS {
        let wo =
            gnomon_brdf::sample_cosine_hemisphere(Vec2::new(number(i, 0.754_877_7), number(i, 0.569_840_3)));
        for j in 0..LIGHTS {
            let k = i * LIGHTS + j;
            let wi = lobe.sample(wo, Vec2::new(number(k, 0.754_877_7), number(k, 0.569_840_3)));
            let pdf = f64::from(lobe.pdf(wo, wi));
            if wi.z.min(wo.z) < LEAST_COSINE || pdf <= 0.0 {
                continue;
            }
            let true_value = measurement.value(wo, wi);
            let difference: Vec3 = lobe.value(wo, wi) - true_value;
            let weight = f64::from(wi.z) / pdf;
            error2 += weight * f64::from(difference.length_squared());
            value2 += weight * f64::from(true_value.length_squared());
            error += weight * f64::from(difference.abs().element_sum());
            value += weight * f64::from(true_value.element_sum());
        }
    }
    FitError { relative_l2: (error2 / value2.max(1e-30)).sqrt(), mean: error / value.max(1e-30) }
}
