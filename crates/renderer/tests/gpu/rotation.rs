//! A turned environment: lights, coefficients and maps together.

use crate::common::gpu_or_skip;
use glam::{Affine3A, Mat4, Quat, Vec3};
use gnomon_envmap::{Equirect, builtin};
use gnomon_lights::LightSet;
use gnomon_lights::fit::{FitOptions, by_name};
use gnomon_metrics::relative_rmse;
use gnomon_picture::RgbImage;
use gnomon_reference::ReferenceOptions;
use gnomon_renderer::{Change, Gpu, Reflections, RenderSettings, Renderer};
use gnomon_scene::{Camera, Material, Mesh, Scene};
use gnomon_testing::tolerances::{ROTATED_REFERENCE_RMSE, ROTATED_SCENE_RMSE, ROTATED_TEXELS_RMSE};

const SIZE: [u32; 2] = [64, 48];
const YAW: f32 = 1.9;

/// Three boxes of which each looks up the environment in another way: matte by the irradiance map, glossy by the prefiltered map, Phong by
/// the radiance cache.
fn scene() -> Scene {
    let mut scene = gnomon_scene::builtin::by_name("three-boxes").unwrap();
    let mesh = scene.nodes[0].meshes[0];
    let boxes = scene.meshes[mesh.0].clone();
    let third = boxes.triangles.len() / 3;
    scene.nodes[0].meshes.clear();
    for (i, reflectance) in
        ["lambert", "metallic-roughness:metallic=0.6,roughness=0.35", "phong:shininess=20,specular=0.4"]
            .iter()
            .enumerate()
    {
        let mut material = Material::default();
        reflectance.parse::<gnomon_scene::ReflectanceSettings>().unwrap().apply(&mut material.surface);
        scene.materials.push(material);
        let mut part = Mesh::clone(&boxes);
        part.triangles = boxes.triangles[i * third..(i + 1) * third].to_vec();
        part.material = Some(gnomon_scene::MaterialId(scene.materials.len() - 1));
        scene.meshes.push(part.into());
        scene.nodes[0].meshes.push(gnomon_scene::MeshId(scene.meshes.len() - 1));
    }
    scene
}

fn maps() -> Vec<(&'static str, Equirect)> {
    let mut maps = vec![("room", builtin::by_name("room").unwrap().resized(256, 128))];
    if let Some(path) = gnomon_testing::data_file("env/probulator_grace_256x128.hdr") {
        maps.push(("grace", gnomon_envmap::load(path, Default::default()).unwrap().map));
    }
    maps
}

fn lights(map: &Equirect) -> LightSet {
    let options = FitOptions { light_count: Some(24), ..FitOptions::default() };
    by_name("rectangles", &options).unwrap().fit(map).unwrap()
}

fn renderer(gpu: &Gpu, scene: &Scene, [ambient, unshadowed, shadows, compositing]: [&str; 4]) -> Renderer {
    let settings = RenderSettings::default().with(|s| {
        s.techniques.supersample = 2;
        s.techniques.shadow_sampling = 1;
        s.techniques.shadow_resolution = 128;
        s.lighting.ambient = ambient.to_owned();
        s.techniques.unshadowed = unshadowed.to_owned();
        s.techniques.shadows = shadows.to_owned();
        s.techniques.compositing = compositing.to_owned();
    });
    let mut renderer = Renderer::new(gpu, settings).unwrap();
    renderer.set_scene(scene).unwrap();
    renderer
}

fn picture(renderer: &mut Renderer, camera: &Camera) -> RgbImage {
    renderer.render(camera, SIZE[0], SIZE[1]).unwrap().radiance
}

/// Everything but the environment, turned.
fn turned(scene: &Scene, camera: &Camera, by: Quat) -> (Scene, Camera) {
    let (mut scene, mut camera) = (scene.clone(), camera.clone());
    for root in scene.nodes.iter_mut().filter(|node| node.parent.is_none()) {
        root.parent_from_node = Affine3A::from_quat(by) * root.parent_from_node;
    }
    camera.world_from_camera = Mat4::from_quat(by) * camera.world_from_camera;
    (scene, camera)
}

#[test]
fn a_turned_environment_is_a_scene_turned_the_other_way() {
    let Some(gpu) = gpu_or_skip() else { return };
    let scene = scene();
    let camera = &scene.cameras[0];
    for (name, map) in maps() {
        let set = lights(&map);
        // What depth is measured along depends on the world's axes where a ground blocks the light: a scene turned about another than +y
        // has other shadow maps, but not without them.
        let tilted = Quat::from_scaled_axis(Vec3::new(0.7, -1.3, 0.4));
        // Of a fit little stays ambient; of none everything does.
        let none = LightSet::new("none", Vec::new(), map.clone());
        let yaw = Quat::from_rotation_y(YAW);
        let cases = [
            (["cells", "auto", "convolution", "ratio"], &set, yaw),
            (["unshadowed", "auto", "none", "additive"], &none, tilted),
            (["occlusion", "sh", "convolution", "ratio"], &set, yaw),
            (["unshadowed", "auto", "none", "ratio"], &set, tilted),
            (["unshadowed", "cache", "none", "ratio"], &set, tilted),
            (["unshadowed", "sh", "none", "ratio"], &set, tilted),
        ];
        // One captured map is enough for what does not depend on maps.
        let count = if name == "room" { cases.len() } else { 2 };
        for (names, set, rotation) in cases.into_iter().take(count) {
            let case = format!("{name} {}", names.join(" "));
            let mut live = renderer(&gpu, &scene, names);
            live.set_lighting(&map, set).unwrap();
            let still = picture(&mut live, camera);
            live.set_environment_rotation(rotation).unwrap();
            let shown = picture(&mut live, camera);
            let (other, view) = turned(&scene, camera, rotation.inverse());
            let mut other = renderer(&gpu, &other, names);
            other.set_lighting(&map, set).unwrap();
            let error = relative_rmse(&shown, &picture(&mut other, &view)).unwrap();
            let planted = relative_rmse(&still, &shown).unwrap();
            assert!(error < ROTATED_SCENE_RMSE, "{case}: {error}");
            assert!(planted > 10.0 * ROTATED_SCENE_RMSE, "{case}: the turn shows, {planted}");
            live.set_environment_rotation(Quat::IDENTITY).unwrap();
            assert!(picture(&mut live, camera) == still, "{name}: and back again, to the last bit");
        }
    }
}

#[test]
fn a_turned_lookup_is_a_resampled_map() {
    let Some(gpu) = gpu_or_skip() else { return };
    let scene = scene();
    let camera = &scene.cameras[0];
    let options = ReferenceOptions {
        width: SIZE[0],
        height: SIZE[1],
        samples_per_pixel: 256,
        reflections: false,
        ..ReferenceOptions::default()
    };
    for (name, map) in maps() {
        let set = lights(&map);
        // A whole number of texels, so that resampling changes none of them.
        let yaw = 77.0 * std::f32::consts::TAU / map.width() as f32;
        // What is seen in a reflection is lit by samples of the sky, which are others of another map.
        let in_direct_light = || {
            let mut renderer = renderer(&gpu, &scene, ["cells", "auto", "convolution", "ratio"]);
            let settings = renderer.settings().clone();
            let settings = Some(settings.with(|s| s.paths.reflections = Reflections::Off));
            renderer.change(Change { settings, ..Change::default() }).unwrap();
            renderer
        };
        let mut live = in_direct_light();
        live.set_environment_rotation(Quat::from_rotation_y(yaw)).unwrap();
        live.set_lighting(&map, &set).unwrap();
        let shown = picture(&mut live, camera);
        let mut resampled = in_direct_light();
        // Cells of the ambient rest follow the map's own frame: lights and residual are turned, the cells made anew.
        resampled.set_lighting(&map.rotated(yaw), &set.rotated(yaw)).unwrap();
        let texels = relative_rmse(&shown, &picture(&mut resampled, camera)).unwrap();
        let truth = gnomon_reference::render(&scene, camera, &map.rotated(yaw), &options).unwrap().mean;
        let error = relative_rmse(&shown, &truth).unwrap();
        assert!(texels < ROTATED_TEXELS_RMSE, "{name}: {texels}");
        assert!(error < ROTATED_REFERENCE_RMSE, "{name}: {error}");
    }
}

#[test]
fn turns_that_are_none_are_refused() {
    let Some(gpu) = gpu_or_skip() else { return };
    let mut renderer = renderer(&gpu, &scene(), ["cells", "auto", "convolution", "ratio"]);
    for bad in [
        Quat::from_xyzw(0.0, 0.0, 0.0, 0.0),
        Quat::from_xyzw(1.0, 1.0, 0.0, 0.0),
        Quat::from_xyzw(f32::NAN, 0.0, 0.0, 1.0),
    ] {
        assert!(renderer.set_environment_rotation(bad).is_err());
    }
    assert!(renderer.set_environment_rotation(Quat::from_xyzw(0.0, 1.0004, 0.0, 0.0)).is_ok());
}
