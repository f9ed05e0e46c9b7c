//! Shadow techniques beside convolution, against closed forms.

use crate::common::edge::*;
use crate::common::*;
use glam::{Vec2, Vec3};
use gnomon_lights::LightSet;
use gnomon_metrics::penumbra;
use gnomon_renderer::shadow::ShadowSettings;
use gnomon_renderer::{Renderer, shadow};
use gnomon_scene::Camera;
use gnomon_testing::tolerances;

const RIVALS: [&str; 5] = ["hard", "hard-linear", "pcf", "pcss", "moments"];
/// Place x [m] where a profile rises through one half.
fn half_lit_at(profile: &[f32]) -> f32 {
    let pixel = profile.windows(2).position(|pair| pair[0] < 0.5 && pair[1] >= 0.5).unwrap();
    let t = (0.5 - profile[pixel]) / (profile[pixel + 1] - profile[pixel]);
    (pixel as f32 + 0.5 + t) / PIXELS as f32 - 0.5
}

#[test]
fn the_edge_lies_where_it_is_and_both_sides_are_whole() {
    let Some(gpu) = gpu_or_skip() else { return };
    let (edge, height) = (0.057, 0.4);
    let scene = edge_over_ground(edge, height);
    let set = one_disk(Vec3::Y, 5_f32.to_radians());
    for name in RIVALS {
        let profile = profile(&gpu, settings(name), &scene, &set, height);
        let at = half_lit_at(&profile);
        let (umbra, lit) = (profile[2], profile[PIXELS as usize - 3]);
        println!("{name}: edge at {at:.4} m, umbra {umbra:.4}, lit {lit:.4}");
        assert!(
            (at - edge).abs() <= tolerances::SHADOW_EDGE_TEXELS * TEXEL,
            "{name}: edge at {at}, not {edge}"
        );
        assert!(
            umbra <= tolerances::UMBRA && (lit - 1.0).abs() <= tolerances::UMBRA,
            "{name}: {umbra}, {lit}"
        );
    }
}

#[test]
fn penumbrae_of_a_disk_widen_with_the_distance_of_the_blocker() {
    let Some(gpu) = gpu_or_skip() else { return };
    let radius = f32::to_radians(10.0);
    let set = one_disk(Vec3::Y, radius);
    let mut moments = settings("moments");
    moments.techniques.shadow_settings.moments.footprint_scale = 1.2;
    moments.techniques.shadow_settings.moments.intensity_scale = 1.0;
    for settings in [settings("pcss"), moments] {
        let name = &settings.techniques.shadows;
        for height in [0.3, 0.6, 1.2] {
            let expected = 2.0 * height * radius.tan();
            let width = mean_width(&gpu, &settings, &set, height, penumbra::disk_penumbra_width);
            println!("{name} at {height} m: {width:.4} m, closed form {expected:.4} m");
            let relative = (width / expected - 1.0).abs();
            assert!(relative <= tolerances::PENUMBRA_WIDTH, "{name} at {height}: {width}, not {expected}");
        }
    }
}

#[test]
fn the_penumbra_of_a_rectangle_follows_its_side_across_the_edge() {
    let Some(gpu) = gpu_or_skip() else { return };
    let height = 0.6;
    // A uniform rectangle's visibility rises linearly: 80 % of it between the two levels.
    let width = |profile: &[f32]| penumbra::width_between(profile, 0.1, 0.9).map(|width| width / 0.8);
    for half in [Vec2::new(0.25, 0.05), Vec2::new(0.1, 0.3)] {
        let expected = 2.0 * height * half.x;
        let found = mean_width(&gpu, &settings("pcss"), &rectangle_above(half), height, width);
        println!("half sides {half}: {found:.4} m, closed form {expected:.4} m");
        assert!((found / expected - 1.0).abs() <= tolerances::PENUMBRA_WIDTH, "{found}, not {expected}");
    }
}

/// The checks above see a kernel that ignores the blocker's distance.
#[test]
fn a_kernel_of_fixed_width_fails_the_penumbra_check() {
    let Some(gpu) = gpu_or_skip() else { return };
    let radius = f32::to_radians(10.0);
    let set = one_disk(Vec3::Y, radius);
    let mut fixed = settings("pcf");
    fixed.techniques.shadow_settings.pcf.radius = 0.6 * radius.tan() / TEXEL;
    fixed.techniques.shadow_settings.pcf.samples = 64;
    let relative = |height: f32| {
        let width = mean_width(&gpu, &fixed, &set, height, penumbra::disk_penumbra_width);
        width / (2.0 * height * radius.tan()) - 1.0
    };
    assert!(
        relative(0.6).abs() <= tolerances::PENUMBRA_WIDTH,
        "right where it was made for: {}",
        relative(0.6)
    );
    assert!(relative(0.3).abs() > 2.0 * tolerances::PENUMBRA_WIDTH, "too wide below: {}", relative(0.3));
}

#[test]
fn no_lights_and_wrong_settings_are_defined() {
    let Some(gpu) = gpu_or_skip() else { return };
    let camera = Camera::look_at(Vec3::new(0.0, 3.0, 1.0), Vec3::ZERO, 1.0);
    let none = LightSet::new("test", Vec::new(), constant_map(Vec3::ONE));
    let scene = edge_over_ground(0.0, 1.0);
    let frame = |name| {
        let settings = settings(name).with(|s| s.lighting.ambient = "unshadowed".to_owned());
        let frame = render(&gpu, settings, &scene, &constant_map(Vec3::ONE), &none, &camera, [8, 8]);
        frame.radiance
    };
    let unshadowed = frame("none");
    for name in RIVALS {
        assert_eq!(frame(name), unshadowed, "{name}");
    }

    let wrong = |name: &str, change: fn(&mut ShadowSettings)| {
        let mut settings = settings(name);
        change(&mut settings.techniques.shadow_settings);
        Renderer::new(&gpu, settings).err().map(|error| error.to_string())
    };
    assert!(wrong("pcss", |s| s.pcss.search_samples = 0).unwrap().contains("1 to 1024"));
    assert!(wrong("pcss", |s| s.pcss.filter_samples = 2000).unwrap().contains("2000"));
    assert!(wrong("pcf", |s| s.pcf.radius = f32::NAN).unwrap().contains("radius"));
    assert!(wrong("pcf", |s| s.pcf.samples = 0).is_some());
    assert!(wrong("moments", |s| s.moments.moment_bias = -1.0).unwrap().contains("moments-moment-bias"));
    assert!(wrong("hard", |s| s.hard.depth_bias = f32::INFINITY).is_some());
    assert!(wrong("hard-linear", |s| s.hard_linear.depth_bias = -0.1).is_some());
    assert!(RIVALS.iter().all(|rival| shadow::names().any(|(name, _)| name == *rival)));
}
