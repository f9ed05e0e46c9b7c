//! Shadow rays against the tracer and closed forms.

use crate::common::*;
use glam::{Vec2, Vec3};
use gnomon_lights::{FitOptions, LightSet};
use gnomon_metrics::compare;
use gnomon_picture::RgbImage;
use gnomon_reference::{ReferenceOptions, ResidualShadows};
use gnomon_renderer::{Gpu, RenderSettings};
use gnomon_scene::{Camera, Material, Mesh, Projection, Scene, builtin};
use gnomon_testing::tolerances;

fn settings(shadows: &str) -> RenderSettings {
    RenderSettings::default().with(|s| {
        s.techniques.shadows = shadows.to_owned();
        s.techniques.compositing = "additive".to_owned();
        s.techniques.shadow_settings.rays.samples = 64;
        s.techniques.supersample = 2;
        s.techniques.shadow_sampling = 1;
        s.techniques.sharp_shadow_sampling = 1;
    })
}

fn drawn(gpu: &Gpu, shadows: &str, scene: &Scene, set: &LightSet, camera: &Camera) -> RgbImage {
    render(gpu, settings(shadows), scene, &no_light(), set, camera, [96, 72]).radiance
}

#[test]
fn rays_see_what_the_tracer_sees() {
    let Some(gpu) = gpu_or_skip() else { return };
    let map = gnomon_envmap::builtin::sized("room", 128, 64).unwrap();
    let options = FitOptions { light_count: Some(16), ..Default::default() };
    let set = gnomon_lights::fit::by_name("partition", &options).unwrap().fit(&map).unwrap();
    let scene = builtin::by_name("three-boxes").unwrap();
    let camera = &scene.cameras[0];
    let traced = ReferenceOptions { width: 96, height: 72, samples_per_pixel: 2048, ..Default::default() };
    let lights = LightSet::new("none", set.lights.clone(), no_light());
    let dark = no_light();
    let truth =
        gnomon_reference::render_lights(&scene, camera, &lights, ResidualShadows::Cast, &dark, &traced)
            .unwrap()
            .mean;
    let mean = |picture: &RgbImage| picture.texels().iter().map(|texel| texel.element_sum()).sum::<f32>();
    let of = |shadows| {
        let picture = drawn(&gpu, shadows, &scene, &lights, camera);
        (compare(&picture, &truth, None).unwrap().relative_rmse, mean(&picture) / mean(&truth) - 1.0)
    };
    let ((rays, bias), (maps, _)) = (of("rays"), of("pcss"));
    println!("rays {rays:.4}, bias {bias:+.5}, maps {maps:.4}");
    assert!(rays <= tolerances::SHADOW_RAYS && rays < 0.5 * maps, "{rays}, maps {maps}");
    assert!(bias.abs() <= tolerances::SHADOW_RAYS_BIAS, "{bias}");
}

/// A cube of 2 m about the origin, of planes without thickness.
fn cube() -> Mesh {
    let mut mesh = Mesh::default();
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let first = mesh.positions.len() as u32;
            let mut normal = Vec3::ZERO;
            normal[axis] = side;
            for (s, t) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
                let mut corner = normal;
                corner[(axis + 1) % 3] = s;
                corner[(axis + 2) % 3] = t;
                mesh.positions.push(corner);
                mesh.normals.push(normal);
            }
            mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        }
    }
    mesh
}

#[test]
fn no_light_enters_a_closed_room_of_planes() {
    let Some(gpu) = gpu_or_skip() else { return };
    let map = constant_map(Vec3::ONE);
    let options = FitOptions { light_count: Some(48), ..Default::default() };
    let set = gnomon_lights::fit::by_name("partition", &options).unwrap().fit(&map).unwrap();
    let camera = Camera::look_at(Vec3::new(0.9, 0.8, 0.9), Vec3::new(-0.5, -0.6, -0.4), 1.6);
    let closed = scene_of(vec![cube()], Material::default());
    let mut open = closed.clone();
    std::sync::Arc::make_mut(&mut open.meshes[0]).triangles.truncate(10);
    let brightest = |shadows, scene: &Scene| {
        let picture = drawn(&gpu, shadows, scene, &set, &camera);
        picture.texels().iter().map(|texel| texel.max_element()).fold(0.0, f32::max)
    };
    let (rays, maps, window) =
        (brightest("rays", &closed), brightest("pcss", &closed), brightest("rays", &open));
    println!("rays {rays}, maps {maps}, without a wall {window}");
    assert_eq!(rays, 0.0);
    assert!(window > 0.1, "{window}");
}

/// In a room with one window, by as few rays as are usual. The planted fault is the same light of an open scene, whose sums stay as they are.
#[test]
fn in_an_interior_grain_is_evened_out() {
    let Some(gpu) = gpu_or_skip() else { return };
    let map = gnomon_envmap::builtin::sized("room", 128, 64).unwrap();
    let options = FitOptions { light_count: Some(48), ..Default::default() };
    let set = gnomon_lights::fit::by_name("partition", &options).unwrap().fit(&map).unwrap();
    let set =
        |omits_hidden| LightSet { omits_hidden, ..LightSet::new("cells", set.lights.clone(), no_light()) };
    let mut room = cube();
    room.triangles.truncate(10);
    let part = |middle: [f32; 3], half: [f32; 3]| {
        let mut part = cube();
        let placed = |corner: Vec3| Vec3::from(middle) + Vec3::from(half) * corner;
        part.positions.iter_mut().for_each(|corner| *corner = placed(*corner));
        part
    };
    let meshes = vec![
        room,
        // A wall about a window, and a table on two legs.
        part([-0.7, 0.0, 1.0], [0.3, 1.0, 0.02]),
        part([0.7, 0.0, 1.0], [0.3, 1.0, 0.02]),
        part([0.0, 0.8, 1.0], [0.4, 0.2, 0.02]),
        part([0.0, -0.6, 1.0], [0.4, 0.4, 0.02]),
        part([0.0, -0.4, 0.1], [0.4, 0.03, 0.3]),
        part([-0.3, -0.7, 0.0], [0.03, 0.3, 0.03]),
        part([0.3, -0.7, 0.2], [0.03, 0.3, 0.03]),
    ];
    let scene = scene_of(meshes, Material::default());
    let camera = Camera::look_at(Vec3::new(0.8, 0.3, 0.9), Vec3::new(-0.4, -0.6, -0.5), 1.4);
    let size = [96, 72];
    let traced = ReferenceOptions { width: 96, height: 72, samples_per_pixel: 1024, ..Default::default() };
    let dark = no_light();
    let truth =
        gnomon_reference::render_lights(&scene, &camera, &set(true), ResidualShadows::Cast, &dark, &traced)
            .unwrap()
            .mean;
    let of = |omits_hidden| {
        let settings = RenderSettings::default().with(|s| {
            s.techniques.shadows = "rays".to_owned();
            s.techniques.compositing = "additive".to_owned();
        });
        // Lights of an interior shine as the map tells: evenly, as the tracer has them.
        let even = constant_map(Vec3::ONE);
        let picture = render(&gpu, settings, &scene, &even, &set(omits_hidden), &camera, size).radiance;
        (compare(&picture, &truth, None).unwrap().relative_rmse, grain(&picture))
    };
    let ((evened, even_grain), (grainy, grain)) = (of(true), of(false));
    println!("evened out {evened:.4}, grain {even_grain:.4}; else {grainy:.4}, grain {grain:.4}");
    assert!(even_grain <= tolerances::GRAIN && even_grain < 0.7 * grain, "{even_grain}, else {grain}");
    assert!(evened < 1.02 * grainy, "{evened}, else {grainy}");
}

/// Of a wall in the picture's upper right, which light falls on evenly: how far blocks of 4 x 4 pixels, about what blotches measure, differ from
/// the mean of those around them, RMS over the mean.
fn grain(picture: &RgbImage) -> f32 {
    let block = |x: u32, y: u32| {
        let pixels = (0..16).map(|i| picture.get(4 * x + i % 4, 4 * y + i / 4).y);
        pixels.sum::<f32>() / 16.0
    };
    let (mut squares, mut sum, mut count) = (0.0_f32, 0.0_f32, 0.0_f32);
    for (x, y) in (13..22).flat_map(|x| (1..6).map(move |y| (x, y))) {
        let around = (block(x - 1, y) + block(x + 1, y) + block(x, y - 1) + block(x, y + 1)) / 4.0;
        squares += (block(x, y) - around).powi(2);
        sum += block(x, y);
        count += 1.0;
    }
    (squares / count).sqrt() / (sum / count)
}

#[test]
fn bars_thinner_than_any_texel_darken_by_their_coverage() {
    let Some(gpu) = gpu_or_skip() else { return };
    // Bars of 0.5 mm, 10 mm apart, 1 m above a floor, under a sun whose penumbrae are 80 mm wide, and under one before which there are more
    // bars than its rays are told of in advance.
    let mut meshes = vec![horizontal(Vec2::splat(-2.0), Vec2::splat(2.0), 0.0)];
    let bars = (-80..80).map(|i| 0.01 * i as f32);
    meshes.extend(bars.map(|x| horizontal(Vec2::new(x, -1.0), Vec2::new(x + 5e-4, 1.0), 1.0)));
    let scene = scene_of(meshes, Material::default());
    let [narrow, wide] = [0.04, 0.2].map(|radius| one_disk(Vec3::Y, radius));
    // Below the bars, so that none is seen.
    let camera = Camera {
        projection: Projection::Orthographic { half_width: 0.3 },
        ..Camera::look_at(Vec3::new(0.01, 0.9, 0.3), Vec3::ZERO, 1.0)
    };
    let bare = scene_of(vec![horizontal(Vec2::splat(-2.0), Vec2::splat(2.0), 0.0)], Material::default());
    let mean = |shadows, set: &LightSet, scene: &Scene| {
        let picture = drawn(&gpu, shadows, scene, set, &camera);
        picture.texels().iter().map(|texel| texel.x).sum::<f32>() / picture.texels().len() as f32
    };
    for (shadows, set) in [("rays", &narrow), ("rays", &wide), ("pcss", &narrow)] {
        let darkened = 1.0 - mean(shadows, set, &scene) / mean(shadows, set, &bare);
        println!("{shadows}: darkened by {darkened:.4}, coverage 0.05");
        assert!(shadows != "rays" || (darkened - 0.05).abs() < tolerances::THIN_BARS, "{darkened}");
    }
}
