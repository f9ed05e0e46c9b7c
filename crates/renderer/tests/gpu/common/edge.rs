//! A straight edge over a ground: the penumbra has a closed form.

use glam::{DVec2, DVec3, Vec2, Vec3};
use gnomon_brdf::Surface;
use gnomon_lights::{DistantLight, LightSet};
use gnomon_renderer::{Gpu, RenderSettings};
use gnomon_scene::{Camera, Material, Projection, Scene};

use super::*;

pub const PIXELS: u32 = 400;
pub const SHADOW_RESOLUTION: u32 = 512;
/// Half the side of the ground, of which the picture shows the middle metre.
pub const HALF: f32 = 2.0;
/// Width of a depth map's texel [m]; the frame adds a margin of two texels on each side.
pub const TEXEL: f32 = 2.0 * HALF / (SHADOW_RESOLUTION - 4) as f32;

pub fn settings(shadows: &str) -> RenderSettings {
    RenderSettings::default().with(|s| {
        s.techniques.shadows = shadows.to_owned();
        s.techniques.compositing = "additive".to_owned();
        s.techniques.shadow_resolution = SHADOW_RESOLUTION;
        s.techniques.supersample = 1;
        s.techniques.shadow_sampling = 1;
    })
}

/// White ground at y = 0 and, above the part of it with x < `edge`, an occluder at `height`.
pub fn edge_over_ground(edge: f32, height: f32) -> Scene {
    scene_of(
        vec![
            horizontal(Vec2::splat(-HALF), Vec2::splat(HALF), 0.0),
            horizontal(Vec2::splat(-HALF), Vec2::new(edge, HALF), height),
        ],
        white(),
    )
}

/// Visibility of the only light along x, from -0.5 m to 0.5 m on the ground, seen from below the occluder.
pub fn profile(gpu: &Gpu, settings: RenderSettings, scene: &Scene, set: &LightSet, height: f32) -> Vec<f32> {
    let camera = Camera {
        projection: Projection::Orthographic { half_width: 0.5 },
        ..Camera::look_at(Vec3::new(0.0, 0.5 * height, 0.0), Vec3::ZERO, 1.0)
    };
    let frame = render(gpu, settings, scene, &no_light(), set, &camera, [PIXELS, 5]);
    let light = &set.lights[0];
    let unshadowed = light.irradiance(Vec3::Y) * light.radiance.x / std::f32::consts::PI;
    // Looking down, the camera has world -x to its right.
    (0..PIXELS).rev().map(|x| frame.radiance.get(x, 2).x / unshadowed).collect()
}

/// A rectangle straight above, its sides along x and z, of half angles with tangents `half`.
pub fn rectangle_above(half: Vec2) -> LightSet {
    let half = DVec2::new(f64::from(half.x), f64::from(half.y));
    let frame = [DVec3::X, DVec3::Z, DVec3::Y];
    let unit = DistantLight::rectangle(frame, -half, half, DVec3::ONE);
    let light = DistantLight::rectangle(frame, -half, half, DVec3::splat(f64::from(unit.solid_angle)));
    LightSet::new("test", vec![light], no_light())
}

/// Mean penumbra width [m] over occluders whose edge falls on different places among the texels.
pub fn mean_width(
    gpu: &Gpu,
    settings: &RenderSettings,
    set: &LightSet,
    height: f32,
    of: fn(&[f32]) -> Option<f32>,
) -> f32 {
    let edges = [0.0, 0.013, 0.057];
    let width = |edge: f32| {
        let scene = edge_over_ground(edge, height);
        of(&profile(gpu, settings.clone(), &scene, set, height)).unwrap() / PIXELS as f32
    };
    edges.into_iter().map(width).sum::<f32>() / edges.len() as f32
}

/// White and diffuse.
pub fn white() -> Material {
    Material { surface: Surface { base_color: Vec3::ONE, ..Default::default() }, ..Default::default() }
}
