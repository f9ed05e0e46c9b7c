//! Simpler meshes in the shadow maps of wide lights.

use crate::common::*;
use gnomon_envmap::Equirect;
use gnomon_lights::{FitOptions, LightSet};
use gnomon_metrics::compare;
use gnomon_picture::RgbImage;
use gnomon_reference::ReferenceOptions;
use gnomon_renderer::{Gpu, RenderSettings};
use gnomon_scene::Scene;
use gnomon_testing::tolerances;

fn fit(method: &str, count: usize, map: &Equirect) -> LightSet {
    let options = FitOptions { light_count: Some(count), ..Default::default() };
    gnomon_lights::fit::by_name(method, &options).unwrap().fit(map).unwrap()
}

fn terrain_under_sky() -> (Scene, Equirect) {
    let scene = gnomon_scene::builtin::by_name("terrain").unwrap();
    (scene, gnomon_envmap::builtin::sized("sky", 256, 128).unwrap())
}

/// A terrain that shadows itself.
fn terrain(gpu: &Gpu, shadows: &str, lights: (&str, usize), deviation: f32) -> RgbImage {
    let (scene, map) = terrain_under_sky();
    let set = fit(lights.0, lights.1, &map);
    let settings = RenderSettings::default().with(|s| {
        s.techniques.shadows = shadows.to_owned();
        s.techniques.caster_deviation = deviation;
    });
    render(gpu, settings, &scene, &map, &set, &scene.cameras[0], [120, 90]).radiance
}

#[test]
fn simpler_casters_do_not_show() {
    let Some(gpu) = gpu_or_skip() else { return };
    let mut worst_coarse = 0.0f64;
    for shadows in ["pcss", "convolution", "moments", "hard"] {
        let whole = terrain(&gpu, shadows, ("optimized", 16), 0.0);
        let difference = |deviation| {
            let picture = terrain(&gpu, shadows, ("optimized", 16), deviation);
            compare(&picture, &whole, None).unwrap().relative_rmse
        };
        let simpler = difference(RenderSettings::default().techniques.caster_deviation);
        let coarse = difference(8.0);
        println!("{shadows}: simpler {simpler:.5}, far too coarse {coarse:.5}");
        assert!(simpler > 0.0 && simpler < tolerances::SIMPLER_CASTERS, "{shadows}: {simpler}");
        assert!(coarse > 1.5 * simpler, "{shadows}: {coarse} {simpler}");
        worst_coarse = worst_coarse.max(coarse);
    }
    // The gate must fail for meshes that are too coarse.
    assert!(worst_coarse > tolerances::SIMPLER_CASTERS, "{worst_coarse}");
}

/// Chords over a hollow lie above it: receivers there must not take them for blockers.
#[test]
fn a_terrain_s_hollows_do_not_shadow_themselves() {
    let Some(gpu) = gpu_or_skip() else { return };
    let (scene, map) = terrain_under_sky();
    let options = ReferenceOptions { width: 120, height: 90, samples_per_pixel: 128, ..Default::default() };
    let truth = gnomon_reference::render(&scene, &scene.cameras[0], &map, &options).unwrap().mean;
    let error = |deviation| {
        let picture = terrain(&gpu, "pcss", ("optimized", 16), deviation);
        compare(&picture, &truth, None).unwrap().relative_rmse
    };
    let [whole, simpler] = [0.0, 0.5].map(error);
    println!("all triangles {whole:.4}, simpler casters {simpler:.4}");
    assert!(simpler <= whole + tolerances::SIMPLER_CASTERS_ERROR, "{simpler} against {whole}");
}

#[test]
fn lights_without_width_see_every_triangle() {
    let Some(gpu) = gpu_or_skip() else { return };
    let [whole, simpler] = [0.0, 8.0].map(|deviation| terrain(&gpu, "hard", ("samples", 8), deviation));
    assert_eq!(whole.texels(), simpler.texels());
}

#[test]
fn simpler_casters_are_as_near_to_mitsuba() {
    let Some((gpu, scene, camera, map, truth)) =
        of_mitsuba("bunny_on_ground", "stpeters", "bunny_flat_stpeters")
    else {
        return;
    };
    let set = fit("optimized", 48, &map);
    let error = |deviation| {
        let settings = RenderSettings::default().with(|s| s.techniques.caster_deviation = deviation);
        let size = [truth.width(), truth.height()];
        let frame = render(&gpu, settings, &scene, &map, &set, &camera, size);
        compare(&frame.radiance, &truth, None).unwrap().relative_rmse
    };
    let [whole, simpler] = [0.0, RenderSettings::default().techniques.caster_deviation].map(error);
    println!("all triangles {whole:.4}, simpler casters {simpler:.4}");
    assert!(simpler <= whole + tolerances::SIMPLER_CASTERS_ERROR, "{simpler} against {whole}");
}
