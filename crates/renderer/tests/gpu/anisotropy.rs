//! Anisotropic lobes whose direction a texture gives, against the ray tracer.

use std::sync::Arc;

use crate::common::*;
use crate::finish::{SIZE, camera, error, fitted, settings, traced};
use glam::{Affine2, Vec2, Vec3};
use gnomon_brdf::{Model, Surface};
use gnomon_scene::{Material, Scene, Texture, TextureId, TextureRef, Wrap, tangents};
use gnomon_testing::tolerances;

/// A ball of brushed metal; a texture turns its direction four times around it.
fn brushed(is_turned: bool) -> Scene {
    let mut ball = sphere();
    // Columns and rows as `sphere` has them.
    ball.uvs[0] = (0..ball.positions.len())
        .map(|i| Vec2::new((i % 97) as f32 / 96.0, (i / 97) as f32 / 48.0))
        .collect();
    let surface = Surface {
        model: Model::AnisotropicGgx,
        base_color: Vec3::new(1.0, 0.7, 0.3),
        metallic: 1.0,
        roughness: 0.5,
        anisotropy: 0.7,
        ..Surface::default()
    };
    let texture = TextureRef { texture: TextureId(0), set: 0, uv_from_mesh: Affine2::IDENTITY };
    let anisotropy_texture = is_turned.then_some(texture);
    let material = Material { surface, anisotropy_texture, ..Material::default() };
    let mut scene = scene_of(vec![tangents::generated(ball, 0)], material);
    let direction = |i: u32| {
        let angle = 4.0 * std::f32::consts::TAU * i as f32 / 256.0;
        let [x, y] = [angle.cos(), angle.sin()].map(|value| (127.5 + 127.5 * value + 0.5) as u8);
        [x, y, 255, 255]
    };
    let rgba8 = (0..256).map(direction).collect();
    let texture = Texture { width: 256, height: 1, rgba8, wrap: [Wrap::Repeat; 2], nearest: false };
    scene.textures.push(Arc::new(texture));
    scene
}

#[test]
fn a_texture_turns_the_lobe_as_the_ray_tracer_has_it() {
    let Some(gpu) = gpu_or_skip() else { return };
    let map = &gnomon_envmap::builtin::by_name("studio").unwrap().resized(512, 256);
    let seen = render(&gpu, settings(), &brushed(true), map, &fitted(map), &camera(), SIZE).radiance;
    let own = error(&seen, &traced(&brushed(true), map, 256));
    let straight = error(&seen, &traced(&brushed(false), map, 256));
    println!("turned {own:.4}, not turned {straight:.4}");
    assert!(own <= tolerances::ANISOTROPY && straight > 2.0 * own, "{own} {straight}");
}
