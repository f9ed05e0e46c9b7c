//! Shadow buffers with fewer samples than the picture.

use crate::common::edge::white;
use crate::common::*;
use glam::{Vec2, Vec3};
use gnomon_brdf::{Model, Surface};
use gnomon_lights::FitOptions;
use gnomon_metrics::compare;
use gnomon_picture::RgbImage;
use gnomon_renderer::{RenderError, RenderSettings, Renderer};
use gnomon_scene::{Camera, Material, Projection, Scene};
use gnomon_testing::tolerances;

fn settings(shadow_sampling: u32) -> RenderSettings {
    RenderSettings::default().with(|s| {
        s.techniques.supersample = 1;
        s.techniques.shadow_sampling = shadow_sampling;
        s.techniques.sharp_shadow_sampling = shadow_sampling;
        s.techniques.shadow_contrast = 1.0;
    })
}

#[test]
fn a_sixteenth_of_the_samples_adds_little_error() {
    let Some((gpu, scene, camera, map, truth)) = of_mitsuba("three_boxes", "galileo", "three_boxes_galileo")
    else {
        return;
    };
    let options = FitOptions { light_count: Some(60), ..Default::default() };
    let set = gnomon_lights::fit::by_name("partition", &options).unwrap().fit(&map).unwrap();
    let size = [truth.width(), truth.height()];
    let of = |settings: RenderSettings| {
        let frame = render(&gpu, settings, &scene, &map, &set, &camera, size);
        compare(&frame.radiance, &truth, None).unwrap().relative_rmse
    };
    let uniform = |shadow_sampling| {
        of(settings(shadow_sampling)
            .with(|s| s.techniques.supersample = RenderSettings::default().techniques.supersample))
    };
    let (full, sixteenth, coarsest) = (uniform(1), uniform(4), uniform(32));
    // The default: wide lights at a 64th of the samples, sharp ones at a sixteenth, more where light changes.
    let usual = of(RenderSettings::default());
    println!(
        "all samples {full:.4}, a sixteenth {sixteenth:.4}, 1/1024 {coarsest:.4}, the default {usual:.4}"
    );
    for error in [sixteenth, usual] {
        assert!(error <= (1.0 + tolerances::SIXTEENTH_ADDED_ERROR) * full, "{error} against {full}");
    }
    // The same gate must fail for a buffer that is too coarse.
    assert!(coarsest > (1.0 + tolerances::SIXTEENTH_ADDED_ERROR) * full, "{coarsest} against {full}");
}

#[test]
fn unshadowed_pictures_do_not_depend_on_sampling() {
    let Some(gpu) = gpu_or_skip() else { return };
    let map = constant_map(Vec3::new(1.0, 0.5, 0.25));
    let camera = Camera::look_at(Vec3::new(0.0, 1.0, 4.0), Vec3::ZERO, 0.8);
    let scene = scene_of(vec![sphere()], white());
    let picture = |compositing: &str, sampling| {
        let settings = settings(sampling).with(|s| {
            s.techniques.shadows = "none".to_owned();
            s.techniques.compositing = compositing.to_owned();
        });
        let set = one_disk(Vec3::new(0.3, 0.9, 0.2).normalize(), 0.1);
        render(&gpu, settings, &scene, &map, &set, &camera, [67, 41]).radiance
    };
    for compositing in ["ratio", "subtractive"] {
        let full = picture(compositing, 1);
        for sampling in [2, 8, 32] {
            let error = compare(&picture(compositing, sampling), &full, None).unwrap().relative_rmse;
            assert!(error < 1e-5, "{compositing}, {sampling}: {error}");
        }
    }
    // Additive light is what the buffer holds, so there it does depend on it.
    let error = compare(&picture("additive", 8), &picture("additive", 1), None).unwrap().relative_rmse;
    assert!(error > 1e-4, "{error}");
}

/// A plate above a ground under one light from the side, seen from straight above: beside the plate's lit edge lies its shadow.
fn plate_over_ground() -> Scene {
    scene_of(
        vec![
            horizontal(Vec2::splat(-2.0), Vec2::splat(2.0), 0.0),
            horizontal(Vec2::splat(-0.5), Vec2::splat(0.5), 0.4),
        ],
        white(),
    )
}

/// Pictures of `scene` at a sampling, by hard shadows under one light.
fn under_one_light(scene: &Scene, camera: &Camera, sampling: u32) -> Option<RgbImage> {
    let gpu = gpu_or_skip()?;
    let settings = settings(sampling).with(|s| {
        s.techniques.shadows = "hard".to_owned();
        s.techniques.compositing = "additive".to_owned();
        s.techniques.shadow_resolution = 1024;
    });
    let set = one_disk(Vec3::new(1.0, 1.0, 0.0).normalize(), 0.01);
    Some(render(&gpu, settings, scene, &no_light(), &set, camera, [128, 128]).radiance)
}

#[test]
fn light_does_not_cross_depth_edges() {
    let camera = Camera {
        projection: Projection::Orthographic { half_width: 1.0 },
        ..Camera::look_at(Vec3::new(0.0, 3.0, 1e-3), Vec3::ZERO, 1.0)
    };
    let scene = plate_over_ground();
    let Some(full) = under_one_light(&scene, &camera, 1) else { return };
    let lit = full.get(64, 64).x;
    assert!(lit > 0.0);
    for sampling in [2, 4, 8, 16] {
        let Some(coarse) = under_one_light(&scene, &camera, sampling) else { return };
        // Right at the plate's edges, 32 samples from the picture's: on one side the lit plate meets its shadow 0.4 m below.
        let mut edges = 0;
        for (x, y) in [31..34, 95..98].into_iter().flatten().flat_map(|x| (48..80).map(move |y| (x, y))) {
            let (left, right) = (full.get(x - 1, y).x, full.get(x, y).x);
            if (left - right).abs() > 0.5 * lit {
                edges += 1;
                for (got, want) in [(coarse.get(x - 1, y).x, left), (coarse.get(x, y).x, right)] {
                    assert!(
                        (got - want).abs() <= tolerances::SAMPLING_BLEED * lit,
                        "{sampling}: {got}, {want}"
                    );
                }
            }
        }
        assert!(edges > 0);
    }
}

#[test]
fn light_does_not_cross_normal_edges() {
    // A roof of two slopes, one facing the light and one turned from it, seen from above: the ridge must stay sharp.
    let slope = |side: f32| {
        let mut mesh = horizontal(Vec2::splat(-1.0), Vec2::splat(1.0), 0.0);
        for position in &mut mesh.positions {
            *position = Vec3::new(side * (0.5 * position.x + 0.5), -(0.5 * position.x + 0.5), position.z);
        }
        mesh.normals = vec![Vec3::new(side, 1.0, 0.0).normalize(); 4];
        mesh
    };
    let camera = Camera {
        projection: Projection::Orthographic { half_width: 0.8 },
        ..Camera::look_at(Vec3::new(0.0, 3.0, 1e-3), Vec3::ZERO, 1.0)
    };
    let scene = scene_of(vec![slope(1.0), slope(-1.0)], white());
    let Some(full) = under_one_light(&scene, &camera, 1) else { return };
    let lit = full.texels().iter().map(|texel| texel.x).fold(0.0, f32::max);
    let dark = full.texels().iter().filter(|texel| texel.x < 0.01 * lit).count();
    assert!(lit > 0.0 && dark > 4000, "{lit}, {dark}");
    for sampling in [4, 16] {
        let Some(coarse) = under_one_light(&scene, &camera, sampling) else { return };
        for (got, want) in coarse.texels().iter().zip(full.texels()) {
            let (got, want) = (got.x, want.x);
            assert!((got - want).abs() <= tolerances::SAMPLING_BLEED * lit, "{sampling}: {got}, {want}");
        }
    }
}

/// A highlight is as wide as a tile or two of the sphere: without regard for its width the coarser buffer loses it.
#[test]
fn highlights_stay_as_narrow_as_they_are() {
    let phong = Surface { model: Model::Phong, shininess: 40.0, specular: 1.0, ..Default::default() };
    let surface = Surface { base_color: Vec3::splat(0.1), ..phong };
    let scene = scene_of(vec![sphere()], Material { surface, ..Default::default() });
    let camera = Camera::look_at(Vec3::new(0.0, 1.0, 4.0), Vec3::ZERO, 0.8);
    let Some(full) = under_one_light(&scene, &camera, 1) else { return };
    for sampling in [4, 16] {
        let Some(coarse) = under_one_light(&scene, &camera, sampling) else { return };
        let pairs = || coarse.texels().iter().zip(full.texels());
        let squares =
            |of: fn(Vec3, Vec3) -> Vec3| pairs().map(|(a, b)| of(*a, *b).length_squared()).sum::<f32>();
        // Over the highlight's own root mean square: most of the picture is dark.
        let error = (squares(|a, b| a - b) / squares(|_, b| b)).sqrt();
        println!("sampling {sampling}: {error:.4}");
        assert!(error < tolerances::SAMPLING_HIGHLIGHT, "{sampling}: {error}");
    }
}

#[test]
fn tiles_larger_than_the_picture_and_empty_scenes_are_drawn() {
    let Some(gpu) = gpu_or_skip() else { return };
    let map = constant_map(Vec3::ONE);
    let camera = Camera::look_at(Vec3::new(0.0, 1.0, 4.0), Vec3::ZERO, 0.8);
    let set = one_disk(Vec3::Y, 0.1);
    for scene in [Scene::default(), scene_of(vec![sphere()], white())] {
        for size in [[1, 1], [33, 17]] {
            let frame = render(&gpu, settings(32), &scene, &map, &set, &camera, size);
            let texels = frame.radiance.texels();
            // Where facets turn away from the light their smooth normals still see it: those are black.
            assert!(texels.iter().all(|texel| texel.is_finite() && texel.min_element() >= 0.0));
            assert!(texels.iter().filter(|texel| texel.min_element() > 0.0).count() >= texels.len() * 9 / 10);
        }
    }
}

#[test]
fn sampling_out_of_range_is_refused() {
    let Some(gpu) = gpu_or_skip() else { return };
    for sampling in [0, 3, 64] {
        let error = Renderer::new(&gpu, settings(sampling)).err().unwrap();
        assert!(matches!(error, RenderError::Option(_)), "{error}");
    }
}
