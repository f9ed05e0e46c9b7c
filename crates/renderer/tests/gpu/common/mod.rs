//! What the picture tests share.

pub mod edge;

use std::sync::Arc;

use glam::{DVec3, Vec2, Vec3};
use gnomon_envmap::Equirect;
use gnomon_lights::{DistantLight, LightSet};
use gnomon_picture::RgbImage;
use gnomon_renderer::{Frame, Gpu, GpuOptions, RenderSettings, Renderer};
use gnomon_scene::{Camera, Material, MaterialId, Mesh, MeshId, Node, Scene};
use gnomon_scene_files::LoadOptions;

/// The best adapter, or `None` after printing why the test is skipped.
pub fn gpu_or_skip() -> Option<Gpu> {
    match Gpu::new(&GpuOptions::default()) {
        Ok(gpu) => Some(gpu),
        Err(error) => {
            gnomon_testing::skip(&error.to_string());
            None
        }
    }
}

/// Scene, camera and environment of one of Mitsuba's pictures, and the picture; none where the data or an adapter are absent.
pub fn of_mitsuba(
    scene: &str,
    environment: &str,
    truth: &str,
) -> Option<(Gpu, Scene, Camera, Equirect, RgbImage)> {
    let scene = gnomon_testing::data_file(&format!("scenes/{scene}.glb"))?;
    let map = gnomon_testing::data_file(&format!("reference/env_{environment}_latlong_512x256.exr"))?;
    let truth = gnomon_testing::data_file(&format!("reference/{truth}.exr"))?;
    let gpu = gpu_or_skip()?;
    let scene = gnomon_scene_files::load(&scene, &LoadOptions::default()).unwrap().scene;
    let camera = scene.cameras[0].clone();
    let map = gnomon_envmap::load(&map, Default::default()).unwrap().map;
    Some((gpu, scene, camera, map, gnomon_picture::read(&truth).unwrap().image))
}

pub fn render(
    gpu: &Gpu,
    settings: RenderSettings,
    scene: &Scene,
    map: &Equirect,
    set: &LightSet,
    camera: &Camera,
    [width, height]: [u32; 2],
) -> Frame {
    let mut renderer = Renderer::new(gpu, settings).unwrap();
    renderer.set_scene(scene).unwrap();
    renderer.set_lighting(map, set).unwrap();
    renderer.render(camera, width, height).unwrap()
}

pub fn constant_map(radiance: Vec3) -> Equirect {
    Equirect::new(RgbImage::filled(128, 64, radiance))
}

pub fn no_light() -> Equirect {
    constant_map(Vec3::ZERO)
}

/// One disk of radiance 1 and nothing else.
pub fn one_disk(direction: Vec3, angular_radius: f32) -> LightSet {
    let half_sine = f64::from(0.5 * angular_radius).sin();
    let solid_angle = 4.0 * std::f64::consts::PI * half_sine * half_sine;
    let light =
        DistantLight::disk(direction.as_dvec3(), f64::from(angular_radius), DVec3::splat(solid_angle));
    LightSet::new("test", vec![light], no_light())
}

/// A horizontal rectangle at height `y`, facing up.
pub fn horizontal(min: Vec2, max: Vec2, y: f32) -> Mesh {
    let corner = |x, z| Vec3::new(x, y, z);
    Mesh {
        positions: vec![
            corner(min.x, min.y),
            corner(min.x, max.y),
            corner(max.x, max.y),
            corner(max.x, min.y),
        ],
        normals: vec![Vec3::Y; 4],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Default::default()
    }
}

/// Meshes at the origin, all of one material.
pub fn scene_of(meshes: Vec<Mesh>, material: Material) -> Scene {
    let meshes: Vec<_> =
        meshes.into_iter().map(|mesh| Arc::new(Mesh { material: Some(MaterialId(0)), ..mesh })).collect();
    let nodes = (0..meshes.len()).map(|i| Node { meshes: vec![MeshId(i)], ..Node::default() }).collect();
    Scene { meshes, nodes, materials: vec![material], ..Default::default() }
}

/// A unit sphere with smooth normals.
pub fn sphere() -> Mesh {
    let (columns, rows) = (96u32, 48u32);
    let positions: Vec<Vec3> = (0..=rows)
        .flat_map(|y| (0..=columns).map(move |x| (x, y)))
        .map(|(x, y)| {
            Equirect::direction_from_uv(Vec2::new(x as f32 / columns as f32, y as f32 / rows as f32))
        })
        .collect();
    let at = |x, y| y * (columns + 1) + x;
    let triangles = (0..rows)
        .flat_map(|y| (0..columns).map(move |x| (x, y)))
        .flat_map(|(x, y)| {
            [[at(x, y), at(x + 1, y), at(x, y + 1)], [at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)]]
        })
        .collect();
    Mesh { normals: positions.clone(), positions, triangles, ..Default::default() }
}
