//! Convolution shadows with every way of filtering, against closed forms, and what each of their parts does.

use crate::common::edge::*;
use crate::common::*;
use glam::{Vec2, Vec3};
use gnomon_lights::LightSet;
use gnomon_metrics::penumbra;
use gnomon_renderer::shadow::{ConvolutionSettings, Footprint, Prefilter};
use gnomon_renderer::{Gpu, RenderSettings};
use gnomon_scene::{Camera, Mesh, Projection, Scene};
use gnomon_testing::tolerances;

/// Sets a part of the technique.
type Change = fn(&mut ConvolutionSettings);

fn convolution(change: impl Fn(&mut ConvolutionSettings)) -> RenderSettings {
    let mut settings = settings("convolution");
    change(&mut settings.techniques.shadow_settings.convolution);
    settings
}

fn filters() -> [(&'static str, RenderSettings); 3] {
    [
        ("mip", convolution(|_| {})),
        ("anisotropic mip", convolution(|s| s.footprints = Footprint::Anisotropic)),
        ("summed-area table", convolution(|s| s.prefilter = Prefilter::SummedAreaTable)),
    ]
}

#[test]
fn penumbrae_widen_with_the_distance_of_the_blocker() {
    let Some(gpu) = gpu_or_skip() else { return };
    let radius = f32::to_radians(10.0);
    let set = one_disk(Vec3::Y, radius);
    // A disk's footprint is isotropic: two ways to filter it are one.
    let [mip, _, table] = filters();
    let relative = |(name, settings): &(&str, RenderSettings), height: f32| {
        let expected = 2.0 * height * radius.tan();
        let width = mean_width(&gpu, settings, &set, height, penumbra::disk_penumbra_width);
        println!("{name} at {height} m: {width:.4} m, closed form {expected:.4} m");
        (width / expected - 1.0).abs()
    };
    for filter in [mip, table] {
        for height in [0.3, 0.6, 1.2] {
            let relative = relative(&filter, height);
            assert!(relative <= tolerances::PENUMBRA_WIDTH, "{} at {height}: {relative}", filter.0);
        }
    }
    let narrow = ("kernels too narrow", convolution(|s| s.footprint_scale = Some(1.0)));
    assert!(relative(&narrow, 0.6) > tolerances::PENUMBRA_WIDTH);
}

#[test]
fn the_penumbra_of_a_rectangle_follows_its_side_across_the_edge() {
    let Some(gpu) = gpu_or_skip() else { return };
    let height = 0.6;
    // A uniform rectangle's visibility rises linearly: 80 % of it between the two levels.
    let width = |profile: &[f32]| penumbra::width_between(profile, 0.1, 0.9).map(|width| width / 0.8);
    let [isotropic, anisotropic, table] = filters();
    for half in [Vec2::new(0.25, 0.08), Vec2::new(0.1, 0.3)] {
        let expected = 2.0 * height * half.x;
        let relative = |(name, settings): &(&str, RenderSettings)| {
            let found = mean_width(&gpu, settings, &rectangle_above(half), height, width);
            println!("{name}, half sides {half}: {found:.4} m, closed form {expected:.4} m");
            (found / expected - 1.0).abs()
        };
        // Four taps of bells have longer tails than a box.
        assert!(relative(&anisotropic) <= 2.0 * tolerances::PENUMBRA_WIDTH);
        assert!(relative(&table) <= tolerances::PENUMBRA_WIDTH);
        // One width for both sides fits neither.
        assert!(relative(&isotropic) > 2.0 * tolerances::PENUMBRA_WIDTH);
    }
}

/// An axis-aligned box, faces outwards.
fn cuboid(min: Vec3, max: Vec3) -> Mesh {
    let corner = |i: u32| {
        Vec3::new(
            if i & 1 == 0 { min.x } else { max.x },
            if i & 2 == 0 { min.y } else { max.y },
            if i & 4 == 0 { min.z } else { max.z },
        )
    };
    let faces = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let mut mesh = Mesh::default();
    for face in faces {
        let corners = face.map(corner);
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(corners);
        mesh.normals.extend([normal; 4]);
        mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    }
    mesh
}

/// Shares of the depth range behind a closed wall at which light may leak by at most [`tolerances::LIGHT_LEAK`] with M = 4.
const BEHIND: [f32; 9] = [0.01, 0.05, 0.1, 0.13, 0.16, 0.18, 0.2, 0.3, 0.7];

/// The same for the series alone, sharpened: nearer than the first of them 4 terms cannot tell the receiver from the wall.
const BEHIND_FOR_SERIES: [f32; 4] = [0.1, 0.13, 0.3, 0.7];

/// Visibility on the ground below the middle of a wall that is one shadow texel thick, `share` of the depth range above it. A column
/// at the rim makes the depth range 1 m.
fn leak(gpu: &Gpu, settings: &RenderSettings, set: &LightSet, share: f32) -> f32 {
    let wall = cuboid(Vec3::new(-1.2, share, -1.2), Vec3::new(1.2, share + TEXEL, 1.2));
    let column = cuboid(Vec3::new(1.8, 0.0, 1.8), Vec3::new(2.0, 1.0, 2.0));
    let scene = scene_of(
        vec![
            horizontal(Vec2::splat(-HALF), Vec2::splat(HALF), 0.0),
            wall,
            column,
            // Keeps the ground, of which nothing else lies below, within the depth range.
            cuboid(Vec3::new(-2.0, -0.001, -2.0), Vec3::new(-1.9, 0.001, -1.9)),
        ],
        white(),
    );
    let camera = Camera {
        projection: Projection::Orthographic { half_width: 0.1 },
        ..Camera::look_at(Vec3::new(0.0, 0.5 * share, 0.0), Vec3::ZERO, 1.0)
    };
    let frame = render(gpu, settings.clone(), &scene, &no_light(), set, &camera, [8, 8]);
    let light = &set.lights[0];
    let unshadowed = light.irradiance(Vec3::Y) * light.radiance.x / std::f32::consts::PI;
    frame.radiance.texels().iter().map(|texel| texel.x / unshadowed).fold(0.0, f32::max)
}

#[test]
fn no_light_leaks_through_a_wall_of_one_texel() {
    let Some(gpu) = gpu_or_skip() else { return };
    let set = one_disk(Vec3::Y, f32::to_radians(10.0));
    let tight = |name: &str, settings: &RenderSettings, shares: &[f32]| {
        for &share in shares {
            let visible = leak(&gpu, settings, &set, share);
            println!("{name}: {visible:.4} at {share} of the depth range behind");
            assert!(visible <= tolerances::LIGHT_LEAK, "{name} at {share}: {visible}");
        }
    };
    for (name, settings) in filters() {
        tight(name, &settings, &BEHIND);
    }
    let sharpened = convolution(|s| s.sharpening_a = Some(15.0));
    tight("sharpened", &sharpened, &BEHIND);
    for prefilter in [Prefilter::MipChain, Prefilter::SummedAreaTable] {
        let paper = convolution(|s| *s = ConvolutionSettings { prefilter, ..ConvolutionSettings::paper() });
        tight("the paper's method", &paper, &BEHIND_FOR_SERIES);
    }
    // Four times the terms, a quarter of the distance.
    let fine = convolution(|s| *s = ConvolutionSettings { order: 16, ..ConvolutionSettings::paper() });
    tight("the paper's method, 16 terms", &fine, &BEHIND_FOR_SERIES.map(|share| 0.25 * share));
    // The check sees light that comes through.
    let paper = convolution(|s| *s = ConvolutionSettings::paper());
    let visible = leak(&gpu, &paper, &set, 0.05);
    println!("the paper's method: {visible:.4} at 0.05");
    assert!(visible > tolerances::LIGHT_LEAK, "{visible}");
}

/// An occluder over x < `edge` so near the ground that no series of four terms resolves it, in a depth range of 1 m.
fn low_edge(edge: f32, height: f32) -> Scene {
    let mut scene = edge_over_ground(edge, height);
    let column = cuboid(Vec3::new(1.8, 0.0, 1.8), Vec3::new(1.99, 1.0, 1.99));
    // Keeps the ground, of which nothing else lies below, within the depth range.
    let below = cuboid(Vec3::new(-1.99, -0.001, -1.99), Vec3::new(-1.9, 0.001, -1.9));
    let more = scene_of(vec![column, below], white());
    let first = scene.meshes.len();
    scene.meshes.extend(more.meshes);
    scene.nodes[0].meshes.extend((first..scene.meshes.len()).map(gnomon_scene::MeshId));
    scene
}

#[test]
fn penumbrae_of_blockers_near_the_receiver_have_their_width() {
    let Some(gpu) = gpu_or_skip() else { return };
    let radius = f32::to_radians(20.0);
    let set = one_disk(Vec3::Y, radius);
    let width = |settings: &RenderSettings, height: f32| {
        let edges = [0.0, 0.013, 0.057];
        let widths = edges.map(|edge| {
            let profile = profile(&gpu, settings.clone(), &low_edge(edge, height), &set, height);
            penumbra::disk_penumbra_width(&profile).unwrap_or(0.0) / PIXELS as f32
        });
        widths.iter().sum::<f32>() / widths.len() as f32
    };
    for height in [0.05, 0.1, 0.15, 0.2] {
        // The disk's points add to irradiance by the fourth power of their cosine: on the plane through the edge 10 % and 90 % of it lie
        // 0.978 as far apart as of an even disk (integrated numerically for 20 degrees).
        let expected = 0.978 * 2.0 * height * radius.tan();
        // Of fewer points the spread along one direction depends on how they fall.
        let found = width(&convolution(|s| s.contact_samples = 16), height);
        println!("blocker at {height} m: {found:.4} m, closed form {expected:.4} m");
        assert!((found / expected - 1.0).abs() <= tolerances::PENUMBRA_WIDTH, "{height} m: {found}");
    }
    let found = width(&convolution(|s| *s = ConvolutionSettings::paper()), 0.05);
    assert!((found / (0.1 * radius.tan()) - 1.0).abs() > tolerances::PENUMBRA_WIDTH, "{found}");
}

/// A box of 0.4 m on the ground, light slanting in along x.
fn box_on_ground() -> (Scene, LightSet) {
    let ground = horizontal(Vec2::splat(-HALF), Vec2::splat(HALF), 0.0);
    let block = cuboid(Vec3::new(-0.4, 0.0, -0.4), Vec3::new(0.0, 0.4, 0.4));
    let set = one_disk(Vec3::new(-1.0, 1.0, 0.0).normalize(), f32::to_radians(5.0));
    (scene_of(vec![ground, block], white()), set)
}

#[test]
fn contact_shadows_touch() {
    let Some(gpu) = gpu_or_skip() else { return };
    let (scene, set) = box_on_ground();
    // The foot of the shadowed side is x = 0; from above, world -x is to the right.
    let camera = Camera {
        projection: Projection::Orthographic { half_width: 0.05 },
        ..Camera::look_at(Vec3::new(0.05, 1.0, 0.0), Vec3::new(0.05, 0.0, 0.0), 1.0)
    };
    let light = &set.lights[0];
    let unshadowed = light.irradiance(Vec3::Y) * light.radiance.x / std::f32::consts::PI;
    let foot = |settings: &RenderSettings| {
        let frame = render(&gpu, settings.clone(), &scene, &no_light(), &set, &camera, [50, 5]);
        let row: Vec<f32> = (0..50).map(|x| frame.radiance.get(x, 2).x / unshadowed).collect();
        row.into_iter().skip(1).take(48).fold(0.0, f32::max)
    };
    for (name, settings) in filters() {
        let brightest = foot(&settings);
        println!("{name}: at most {brightest:.4} within 0.1 m of the foot");
        assert!(brightest <= tolerances::LIGHT_LEAK, "{name}: {brightest}");
    }
    let mut biased = settings("hard");
    biased.techniques.shadow_settings.hard.depth_bias = 0.9;
    let lifted = foot(&biased);
    assert!(lifted > tolerances::LIGHT_LEAK, "a shadow that does not touch: {lifted}");
}

#[test]
fn every_part_can_be_switched_off() {
    let Some(gpu) = gpu_or_skip() else { return };
    let (scene, set) = box_on_ground();
    let camera = Camera::look_at(Vec3::new(1.5, 1.5, 1.5), Vec3::ZERO, 0.8);
    let picture = |settings| render(&gpu, settings, &scene, &no_light(), &set, &camera, [48, 36]).radiance;
    let whole = picture(convolution(|_| {}));
    let changes: [(&str, Change); 6] = [
        ("ringing suppression", |s| (s.black_point, s.white_point) = (0.0, 1.0)),
        ("sharpening", |s| s.sharpening_a = Some(15.0)),
        ("contacts", |s| s.contact_samples = 0),
        ("two steps", |s| s.plane_iterations = 0),
        ("one iteration", |s| s.plane_iterations = 2),
        ("order", |s| s.order = 7),
    ];
    for (name, change) in changes {
        let other = picture(convolution(change));
        assert!(other.texels().iter().all(|texel| texel.is_finite() && texel.min_element() >= 0.0), "{name}");
        assert_ne!(other, whole, "{name}");
    }
}
