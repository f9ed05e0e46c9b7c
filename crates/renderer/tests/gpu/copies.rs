//! Copies of a mesh that share its vertices against as many meshes.

use std::sync::Arc;

use crate::common::*;
use glam::{Affine3A, Quat, Vec2, Vec3};
use gnomon_brdf::Surface;
use gnomon_metrics::compare;
use gnomon_renderer::layers::{Layer, LayerValues, RenderedLayer};
use gnomon_renderer::{Change, Gpu, RenderSettings, Renderer, SceneChange};
use gnomon_scene::{AlphaMode, Camera, Material, MaterialId, Mesh, MeshId, Node, Scene};
use gnomon_testing::tolerances;

/// A ground and spheres on it, squeezed, turned and mirrored; one mesh, or as many as there are. `turn` moves them.
fn spheres(are_shared: bool, material: Material, turn: f32) -> Scene {
    let sphere = Arc::new(Mesh { material: Some(MaterialId(1)), ..sphere() });
    let ground = horizontal(Vec2::splat(-4.0), Vec2::splat(4.0), 0.0);
    let ground = Arc::new(Mesh { material: Some(MaterialId(0)), ..ground });
    let mut scene = Scene {
        meshes: vec![ground, Arc::clone(&sphere)],
        materials: vec![Material::default(), material],
        nodes: vec![Node { meshes: vec![MeshId(0)], ..Node::default() }],
        ..Scene::default()
    };
    for copy in 0..5 {
        let (angle, side) = (1.3 * copy as f32 + turn, if copy % 2 == 0 { 1.0 } else { -1.0 });
        let place = Affine3A::from_translation(Vec3::new(1.2 * angle.cos(), 0.7, 1.2 * angle.sin()))
            * Affine3A::from_quat(Quat::from_rotation_z(0.4 * copy as f32))
            * Affine3A::from_scale(0.5 * Vec3::new(side, 0.4 + 0.2 * copy as f32, 0.8));
        if !are_shared && copy > 0 {
            scene.meshes.push(Arc::new(Mesh::clone(&sphere)));
        }
        let mesh = MeshId(if are_shared { 1 } else { copy + 1 });
        scene.nodes.push(Node { meshes: vec![mesh], parent_from_node: place, ..Node::default() });
    }
    scene
}

fn camera() -> Camera {
    Camera::look_at(Vec3::new(0.8, 1.9, 4.2), Vec3::new(0.0, 0.4, 0.0), 0.9)
}

fn renderer(gpu: &Gpu, settings: &RenderSettings, scene: &Scene) -> Renderer {
    let mut renderer = Renderer::new(gpu, settings.clone()).unwrap();
    renderer.set_scene(scene).unwrap();
    let lights = one_disk(Vec3::new(0.3, 1.0, 0.2).normalize(), 0.3);
    renderer.set_lighting(&constant_map(Vec3::splat(0.1)), &lights).unwrap();
    renderer
}

#[test]
fn copies_look_like_meshes_of_their_own() {
    let Some(gpu) = gpu_or_skip() else { return };
    let surface = Surface { base_color: Vec3::ONE, metallic: 1.0, roughness: 0.1, ..Surface::default() };
    let metal = Material { surface, ..Material::default() };
    let blend = Material { alpha: 0.6, alpha_mode: AlphaMode::Blend, ..Material::default() };
    for (shadows, material) in
        [("pcss", &blend), ("rays", &blend), ("wedges", &Material::default()), ("pcss", &metal)]
    {
        let settings = RenderSettings::default().with(|s| s.techniques.shadows = shadows.to_owned());
        let [one, many] = [true, false].map(|are_shared| {
            let mut renderer = renderer(&gpu, &settings, &spheres(are_shared, material.clone(), 0.0));
            // A pose moves them.
            let scene = spheres(are_shared, material.clone(), 0.3);
            let change = Change { scene: Some(SceneChange::Pose(&scene)), ..Default::default() };
            renderer.change(change).unwrap();
            renderer.render(&camera(), 48, 36).unwrap().radiance
        });
        let error = compare(&one, &many, None).unwrap().relative_rmse;
        println!("{shadows}, {:?}, metallic {}: {error:.6}", material.alpha_mode, material.surface.metallic);
        assert!(error <= tolerances::SHARED_VERTICES, "{shadows}: {error}");
    }
}

#[test]
fn layers_tell_copies_apart_and_how_they_move() {
    let Some(gpu) = gpu_or_skip() else { return };
    let layers = [Layer::Object, Layer::Motion, Layer::Normal];
    let [one, many] = [true, false].map(|are_shared| {
        let mut renderer =
            renderer(&gpu, &RenderSettings::default(), &spheres(are_shared, Material::default(), 0.0));
        renderer.remember_for_motion(&camera()).unwrap();
        let scene = spheres(are_shared, Material::default(), 0.1);
        let change = Change { scene: Some(SceneChange::Pose(&scene)), ..Default::default() };
        renderer.change(change).unwrap();
        renderer.render_layers(&camera(), 48, 36, &layers).unwrap().1
    });
    let differences: Vec<usize> = one
        .layers
        .iter()
        .zip(&many.layers)
        .map(|(one, many)| {
            let values = |layer: &RenderedLayer| match &layer.values {
                LayerValues::Floats(floats) => floats.clone(),
                LayerValues::Labels(labels) => labels.iter().map(|&label| label as f32).collect(),
            };
            let (one, many) = (values(one), values(many));
            assert!(one.iter().any(|value| *value != one[0]), "nothing is seen");
            one.iter().zip(&many).filter(|(a, b)| (*a - *b).abs() > 1e-3).count()
        })
        .collect();
    println!("{differences:?} values differ");
    // At an edge a rounding decides what is seen.
    assert!(differences.iter().all(|&count| count <= 3), "{differences:?}");
}
