//! Visibility as a stage: inline or through a buffer, and what the two hard shadow maps compare.

use crate::common::*;
use glam::{Affine3A, Mat3, Vec2, Vec3};
use gnomon_lights::LightSet;
use gnomon_lights::fit::{FitOptions, by_name};
use gnomon_metrics::compare;
use gnomon_renderer::shadow::{self, Footprint, Prefilter, VisibilityPath};
use gnomon_renderer::{Gpu, RenderSettings, Renderer};
use gnomon_scene::{AreaLight, AreaLightShape, Camera, Material, Node, NodeId, Projection, Scene, builtin};

/// A byte rounds visibility by at most 1/510, at random from light to light.
const BUFFERED_RELATIVE_RMSE: f64 = 1e-3;
/// Sums are rounded to halves once a batch, by at most 1/2048: with 1 MiB for shadows there are some twenty of them.
const TURNS_RELATIVE_RMSE: f64 = 2e-3;

fn add_disk(scene: &mut Scene, radius: f32, height: f32) {
    let down = Mat3::from_cols(Vec3::X, Vec3::NEG_Z, Vec3::Y);
    let parent_from_node = Affine3A::from_mat3_translation(down, Vec3::Y * height);
    scene.nodes.push(Node { parent_from_node, ..Node::default() });
    let shape = AreaLightShape::Disk { radius };
    scene.lights.push(AreaLight {
        node: NodeId(scene.nodes.len() - 1),
        shape,
        radiance: Vec3::splat(4.0 / radius),
        spread: Default::default(),
    });
}

#[test]
fn visibility_through_a_buffer_gives_the_same_picture() {
    let Some(gpu) = gpu_or_skip() else { return };
    let mut scene = builtin::by_name("three-boxes").unwrap();
    add_disk(&mut scene, 0.3, 3.0);
    let map = gnomon_envmap::builtin::sized("room", 128, 64).unwrap();
    let options = FitOptions { light_count: Some(10), ..FitOptions::default() };
    let set = by_name("partition", &options).unwrap().fit(&map).unwrap();
    let variants = [
        ("convolution", Prefilter::SummedAreaTable, Footprint::Isotropic),
        ("convolution", Prefilter::MipChain, Footprint::Anisotropic),
    ];
    let defaults = shadow::names().map(|(name, _)| (name, Prefilter::MipChain, Footprint::Isotropic));
    let camera = scene.cameras[0].clone();
    for (name, prefilter, footprints) in defaults.chain(variants) {
        let settings = |visibility, shadow_memory| {
            RenderSettings::default().with(|s| {
                s.techniques.shadows = name.to_owned();
                s.techniques.shadow_settings.convolution.prefilter = prefilter;
                s.techniques.shadow_settings.convolution.footprints = footprints;
                s.techniques.visibility = visibility;
                s.techniques.shadow_memory = shadow_memory;
                s.techniques.shadow_resolution = 64;
                s.techniques.supersample = 1;
                s.lighting.ambient_cells = 8;
            })
        };
        let mut renderer = Renderer::new(&gpu, settings(VisibilityPath::Inline, 64)).unwrap();
        renderer.set_scene(&scene).unwrap();
        renderer.set_lighting(&map, &set).unwrap();
        let inline = renderer.render(&camera, 64, 48).unwrap().radiance;
        let inline_batches = renderer.shadow_batches();
        // Planned for the picture at hand, whatever that is; and with lights that take turns.
        for (memory, sizes) in [(64, [[40, 30], [64, 48]]), (1, [[80, 60], [64, 48]])] {
            renderer.set_settings(settings(VisibilityPath::Buffered, memory), &set).unwrap();
            renderer.render(&camera, sizes[0][0], sizes[0][1]).unwrap();
            let buffered = renderer.render(&camera, sizes[1][0], sizes[1][1]).unwrap().radiance;
            let error = compare(&buffered, &inline, None).unwrap().relative_rmse;
            println!("{name} {prefilter:?} {footprints:?} {memory} MiB: {error:.1e}");
            let most = if memory == 1 { TURNS_RELATIVE_RMSE } else { BUFFERED_RELATIVE_RMSE };
            assert!(error <= most, "{name}: {error}");
            let whole_shares = ["none", "hard", "hard-linear"].contains(&name);
            assert!(!whole_shares || memory == 1 || error == 0.0, "{name}: {error}");
        }
        let takes_turns = renderer.shadow_batches() > inline_batches;
        assert!(takes_turns || name != "convolution" || prefilter == Prefilter::MipChain, "{name}");
    }
}

/// A floor seen from above under a light `height` up whose map begins `near` away from it, and a square in the air.
fn far_receiver(height: f32, near: f32, square: f32) -> (Scene, Camera) {
    let floor = horizontal(Vec2::splat(-1.5), Vec2::splat(1.5), 0.0);
    let square = horizontal(Vec2::splat(-0.5), Vec2::splat(0.5), square);
    // So small and so far aside that its shadow misses the middle.
    let speck = horizontal(Vec2::splat(0.01), Vec2::splat(0.012), height - near);
    let mut scene = scene_of(vec![floor, square, speck], Material::default());
    add_disk(&mut scene, 0.001, height);
    let camera = Camera::look_at(Vec3::new(0.0, 0.05, 0.0), Vec3::ZERO, 1.0);
    (scene, Camera { projection: Projection::Orthographic { half_width: 0.2 }, ..camera })
}

fn is_lit(gpu: &Gpu, shadows: &str, bias: f32, (scene, camera): &(Scene, Camera)) -> bool {
    let settings = RenderSettings::default().with(|s| {
        s.techniques.shadows = shadows.to_owned();
        s.techniques.shadow_settings.hard.depth_bias = bias;
        s.techniques.shadow_settings.hard_linear.depth_bias = bias;
        s.techniques.supersample = 1;
    });
    let set = LightSet::new("test", Vec::new(), no_light());
    let picture = render(gpu, settings, scene, &no_light(), &set, camera, [8, 8]).radiance;
    let (low, high) = picture
        .texels()
        .iter()
        .fold((f32::INFINITY, 0.0_f32), |(low, high), texel| (low.min(texel.x), high.max(texel.x)));
    assert!(low == 0.0 && high == 0.0 || low > 0.0, "{low} {high}");
    low > 0.0
}

/// Far from a light a z-buffer's depths lie close together: the same bias lets light through that linear depths stop.
#[test]
fn a_far_receiver_tells_the_two_hard_shadow_maps_apart() {
    let Some(gpu) = gpu_or_skip() else { return };
    let (height, near, bias) = (10.0, 0.2, 0.002);
    // What a z-buffer stores, but for a constant and a factor that is nearly 1.
    let stored = |distance: f32| -near / distance;
    for above_floor in [0.25, 0.5, 0.75, 1.25, 2.0, 5.0] {
        let scene = far_receiver(height, near, above_floor);
        let hidden = stored(height) - stored(height - above_floor) < bias;
        assert_eq!(is_lit(&gpu, "hard", bias, &scene), hidden, "z-buffer, {above_floor} m");
        assert!(!is_lit(&gpu, "hard-linear", bias, &scene), "linear, {above_floor} m");
    }
    let scene = far_receiver(height, near, 0.5);
    assert!(!is_lit(&gpu, "hard", 0.0002, &scene), "a smaller bias resolves it");
}
