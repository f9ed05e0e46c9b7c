//! How long the fits take, and how far off the light of point samples is.

use std::f64::consts::PI;
use std::time::Instant;

use glam::DVec3;
use gnomon_envmap::Equirect;
use gnomon_lights::fit::{FitError, FitOptions, LightFit, Method, Sampler, Samples, methods, samplers};
use gnomon_picture::LUMINANCE;
use rayon::prelude::*;

/// Time of one fit on one map.
#[derive(Clone, Debug, PartialEq)]
pub struct FitTiming {
    /// Name of the fit.
    pub method: &'static str,
    /// Name of the sampler, where the fit has one.
    pub sampler: Option<&'static str>,
    /// How many lights it found.
    pub lights: usize,
    /// Median wall time over the repeats [ms].
    pub median_ms: f64,
    /// Least wall time over the repeats [ms].
    pub least_ms: f64,
}

/// Runs every registered fit, and point samples with every sampler, `repeats` times (at least once) with default options,
/// after one run to warm up.
///
/// # Errors
/// A map that cannot be fitted.
pub fn time_fits(map: &Equirect, repeats: usize) -> Result<Vec<FitTiming>, FitError> {
    let time = |method: &Method, sampler: Option<Sampler>| {
        let fit = method.build(&FitOptions { sampler, ..FitOptions::default() })?;
        let lights = fit.fit(map)?.lights.len();
        let mut times = Vec::new();
        for _ in 0..repeats.max(1) {
            let start = Instant::now();
            fit.fit(map)?;
            times.push(1000.0 * start.elapsed().as_secs_f64());
        }
        times.sort_by(f64::total_cmp);
        Ok::<_, FitError>(FitTiming {
            method: method.name,
            sampler: sampler.map(|sampler| sampler.name),
            lights,
            median_ms: times[times.len() / 2],
            least_ms: times[0],
        })
    };
    let mut timings = Vec::new();
    for method in methods() {
        if method.name == "samples" {
            for &sampler in samplers() {
                timings.push(time(method, Some(sampler))?);
            }
        } else {
            timings.push(time(method, None)?);
        }
    }
    Ok(timings)
}

/// Error of a sampler's light.
#[derive(Clone, Debug, PartialEq)]
pub struct SamplerError {
    /// Name of the sampler.
    pub sampler: &'static str,
    /// For each count, see [`sampler_errors`].
    pub relative_rmse: Vec<f64>,
}

/// Pairs of a receiver and an occluder whose irradiance is compared.
const RECEIVERS: usize = 256;

/// For every sampler and each of `counts`: root mean square error of irradiance (luminance) over receivers of evenly spread
/// orientation, each before a plane of another orientation that hides one half of the sphere, over the mean irradiance. Truth
/// is the sum over all texels; a black map has no error. Of random samplers, the first of all seeds.
///
/// # Errors
/// A map or a count that cannot be fitted.
pub fn sampler_errors(map: &Equirect, counts: &[usize]) -> Result<Vec<SamplerError>, FitError> {
    let truth = half_hidden_irradiance(&texels(map));
    let mean = truth.iter().sum::<f64>() / RECEIVERS as f64;
    let error = |sampler, &count: &usize| {
        let options =
            FitOptions { light_count: Some(count), sampler: Some(sampler), ..FitOptions::default() };
        let set = Samples::new(&options)?.fit(map)?;
        let points: Vec<(DVec3, f64)> =
            set.lights.iter().map(|light| (light.direction.as_dvec3(), luminance(light.flux()))).collect();
        let found = half_hidden_irradiance(&points);
        let square = truth.iter().zip(&found).map(|(truth, found)| (found - truth).powi(2)).sum::<f64>();
        Ok::<_, FitError>(if mean > 0.0 { (square / RECEIVERS as f64).sqrt() / mean } else { 0.0 })
    };
    samplers()
        .iter()
        .map(|&sampler| {
            let relative_rmse = counts.iter().map(|count| error(sampler, count)).collect::<Result<_, _>>()?;
            Ok(SamplerError { sampler: sampler.name, relative_rmse })
        })
        .collect()
}

/// Luminance of linear RGB.
fn luminance(rgb: DVec3) -> f64 {
    rgb.dot(LUMINANCE.as_dvec3())
}

/// Direction and luminous flux of every texel.
fn texels(map: &Equirect) -> Vec<(DVec3, f64)> {
    (0..map.height())
        .flat_map(|y| (0..map.width()).map(move |x| (x, y)))
        .map(|(x, y)| {
            let radiance = luminance(map.radiance().get(x, y).as_dvec3());
            (map.texel_direction(x, y).as_dvec3(), radiance * map.texel_solid_angle(y))
        })
        .collect()
}

/// Irradiance of each receiver from points of the environment with their fluxes.
fn half_hidden_irradiance(points: &[(DVec3, f64)]) -> Vec<f64> {
    let golden = PI * (3.0 - 5.0_f64.sqrt());
    // Two spirals over the sphere, the second in an order in which neighbours of the first are far apart.
    let direction = |i: usize| {
        let y = 1.0 - (2.0 * i as f64 + 1.0) / RECEIVERS as f64;
        let (sin, cos) = (golden * i as f64).sin_cos();
        DVec3::new((1.0 - y * y).sqrt() * sin, y, (1.0 - y * y).sqrt() * cos)
    };
    (0..RECEIVERS)
        .into_par_iter()
        .map(|i| {
            let (normal, open) = (direction(i), direction((101 * i + 37) % RECEIVERS));
            let seen = points.iter().filter(|(towards, _)| towards.dot(open) > 0.0);
            seen.map(|(towards, flux)| flux * towards.dot(normal).max(0.0)).sum()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use gnomon_picture::RgbImage;

    use super::*;

    #[test]
    fn a_uniform_sphere_gives_every_receiver_what_the_closed_form_says() {
        let map = Equirect::new(RgbImage::filled(256, 128, Vec3::ONE));
        // Receiver normal n, open half space h: pi (1 + n . h) / 2.
        let found = half_hidden_irradiance(&texels(&map));
        let mean = found.iter().sum::<f64>() / RECEIVERS as f64;
        assert!(found.iter().all(|e| (-1e-9..PI + 0.02).contains(e)) && (mean - 0.5 * PI).abs() < 0.2);
        let same = half_hidden_irradiance(&[(DVec3::Y, 2.0)]);
        assert!(same.iter().all(|e| *e <= 2.0) && same.iter().any(|e| *e > 1.0));
    }

    #[test]
    fn more_samples_err_less_and_a_black_map_not_at_all() {
        let map = Equirect::new(RgbImage::from_fn(64, 32, |x, y| {
            Vec3::splat(1.0 + ((x * 7 + y * 13) % 11) as f32 + if x < 9 { 50.0 } else { 0.0 })
        }));
        for SamplerError { sampler, relative_rmse } in sampler_errors(&map, &[4, 64, 1024]).unwrap() {
            assert!(relative_rmse.is_sorted_by(|a, b| a > b), "{sampler} {relative_rmse:?}");
            assert!(relative_rmse[2] < 0.03, "{sampler} {relative_rmse:?}");
        }
        let black = Equirect::new(RgbImage::filled(8, 4, Vec3::ZERO));
        let errors = sampler_errors(&black, &[7]).unwrap();
        assert!(errors.iter().all(|error| error.relative_rmse == [0.0]));
    }
}
