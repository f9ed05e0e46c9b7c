//! What is seen of an environment that is larger than light needs.

use glam::{Vec2, Vec3};
use gnomon_envmap::{Equirect, LoadOptions, Projection};
use gnomon_lights::LightSet;
use gnomon_picture::{RgbImage, exr};
use gnomon_renderer::RenderSettings;
use gnomon_scene::{Camera, Material};

use crate::common::{gpu_or_skip, horizontal, no_light, render, scene_of};

/// Brighter than a half float holds.
const BRIGHT: f32 = 3e6;

#[test]
fn the_camera_sees_the_backdrop_and_light_comes_from_the_map() {
    let Some(gpu) = gpu_or_skip() else { return };
    let image = RgbImage::filled(4100, 4, Vec3::new(BRIGHT, 0.5 * BRIGHT, 0.0));
    let options = LoadOptions { projection: Some(Projection::Equirect), layer: None };
    let large = gnomon_envmap::from_bytes("large", &exr::encode(&image).unwrap(), options).unwrap().map;
    // The map itself is black, so that what is seen can only be the backdrop.
    let map = Equirect::new(no_light().into_radiance()).with_backdrop(large.backdrop().unwrap().clone());
    let floor = horizontal(Vec2::splat(-5.0), Vec2::splat(5.0), 0.0);
    let camera: Camera = "eye=0,1,0;target=0,1,-4;fov=60".parse().unwrap();
    let set = LightSet::new("none", Vec::new(), no_light());
    let scene = scene_of(vec![floor], Material::default());
    let frame = render(&gpu, RenderSettings::default(), &scene, &map, &set, &camera, [32, 24]);
    let (sky, floor) = (frame.radiance.get(16, 2), frame.radiance.get(16, 22));
    assert!((sky - Vec3::new(BRIGHT, 0.5 * BRIGHT, 0.0)).abs().max_element() < BRIGHT / 256.0, "{sky}");
    assert_eq!(floor, Vec3::ZERO);
}
