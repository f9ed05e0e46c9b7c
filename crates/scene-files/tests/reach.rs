//! How far clips reach: what ground and camera must hold, what cannot be shown at all, and files that only take long.
#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests fail the test")]

mod documents;

use std::time::{Duration, Instant};

use glam::Vec3;
use gnomon_scene::{Animation, Bounds, Ground, Scene};
use gnomon_scene_files::{LoadOptions, load};
use gnomon_testing::data_file;
use serde_json::{Value, json};

use self::documents::{add_accessor, attempt, bytes, read, triangle};

/// Adds a clip of one linear channel that moves a node at 0 s and 1 s.
fn add_clip(document: &mut Value, (node, path): (usize, &str), values: &[f32]) {
    let shape = if path == "weights" { "SCALAR" } else { "VEC3" };
    let count = if path == "weights" { values.len() } else { values.len() / 3 };
    let input = add_accessor(document, &bytes(&[0.0, 1.0]), 5126, 2, "SCALAR");
    let output = add_accessor(document, &bytes(values), 5126, count, shape);
    document["animations"] = json!([{
        "channels": [{"sampler": 0, "target": {"node": node, "path": path}}],
        "samplers": [{"input": input, "output": output}]
    }]);
}

fn moving(path: &str, values: &[f32]) -> Scene {
    read(&triangle(|d| add_clip(d, (0, path), values))).scene
}

fn close(found: Bounds, min: Vec3, max: Vec3) {
    assert!(found.min.distance(min) < 1e-5 && found.max.distance(max) < 1e-5, "{found:?}");
}

#[test]
fn a_clip_reaches_wherever_one_of_its_poses_does() {
    // From the triangle's place to 3 m lower and 4 m higher is nothing that its first, its last or its present pose tells.
    let mut scene = moving("translation", &[0.0, -3.0, 0.0, 0.0, 4.0, 0.0]);
    scene.animate(0, 0.6).unwrap();
    let reach = scene.bounds_of_clip(0).unwrap().unwrap();
    close(reach, Vec3::new(0.0, -3.0, 0.0), Vec3::new(1.0, 5.0, 0.0));
    close(scene.bounds().unwrap(), Vec3::ZERO, Vec3::new(1.0, 1.0, 0.0));
    assert!(scene.bounds_of_clip(1).is_err());
    // A ground does not count, and what lies beyond all bounds does not either.
    scene.add_ground(Ground::Plane);
    assert_eq!(scene.bounds_of_clip(0).unwrap(), Some(reach));
    let mut scene = moving("translation", &[0.0, 0.0, 0.0, 3e38, 0.0, 0.0]);
    close(scene.bounds_of_clip(0).unwrap().unwrap(), Vec3::ZERO, Vec3::new(1.0, 1.0, 0.0));
    let mut empty = Scene { animations: vec![Animation::default().into()], ..Scene::default() };
    assert_eq!(empty.bounds_of_clip(0).unwrap(), None);
}

#[test]
fn the_ground_lies_under_a_reach_by_its_node_alone() {
    let scene = moving("scale", &[0.0, 0.0, 0.0, 1.0, 1.0, 1.0]);
    let near = Bounds { min: Vec3::new(-1.0, -2.0, -1.0), max: Vec3::new(1.0, 1.0, 1.0) };
    let far = Bounds { min: Vec3::new(5.0, -7.0, 5.0), max: Vec3::new(35.0, 9.0, 45.0) };
    // Also under models that are a point at rest.
    let mut point = scene.clone();
    point.animate(0, 0.0).unwrap();
    for rest in [scene, point] {
        let [near, far] = [near, far].map(|reach| {
            let mut scene = rest.clone();
            scene.add_ground_under(Ground::Plane, gnomon_scene::CAMERA_HEIGHT, Some(reach), false);
            let ground = scene.ground.unwrap();
            let corners = scene.world_vertices(&scene.pose(), scene.instances().last().unwrap());
            let half = 4.0 * 0.5 * (reach.max - reach.min).with_y(0.0).length();
            for (corner, normal) in corners.positions.iter().zip(&corners.normals) {
                assert_eq!((corner.y, *normal), (reach.min.y, Vec3::Y));
                let offset = (*corner - reach.center()).abs();
                assert!((offset.x / half - 1.0).abs() < 1e-5 && (offset.z / half - 1.0).abs() < 1e-5);
            }
            (scene.meshes, scene.nodes[ground.0].meshes.clone())
        });
        assert!(near == far, "another reach is another mesh");
    }
}

/// The robot hangs in the air in its file's own pose, but not in its clips.
#[test]
fn a_robot_stands_on_the_ground_of_its_clip() {
    let Some(path) = data_file("models/RobotExpressive.glb") else { return };
    let rest = load(&path, &LoadOptions::default()).unwrap().scene;
    for (clip, animation) in rest.animations.iter().enumerate() {
        let mut scene = rest.clone();
        let reach = scene.bounds_of_clip(clip).unwrap().unwrap();
        scene.add_ground_under(Ground::Plane, gnomon_scene::CAMERA_HEIGHT, Some(reach), false);
        let size = reach.max.y - reach.min.y;
        let mut lowest = f32::INFINITY;
        for step in 0..=50 {
            scene.animate(clip, animation.duration() * step as f32 / 50.0).unwrap();
            let pose = scene.bounds_without_ground().unwrap();
            lowest = lowest.min(pose.min.y);
            assert!(pose.max.y <= reach.max.y + 0.03 * size, "{}", animation.name);
        }
        let height = scene.world_from_nodes()[scene.ground.unwrap().0].translation.y;
        assert!((lowest - height).abs() < 0.02 * size, "{}: {lowest}, not {height}", animation.name);
    }
}

#[test]
fn poses_of_which_squares_overflow_are_refused() {
    let skinned = |bind: f32, scale: f32| {
        read(&triangle(|d| {
            let joints = add_accessor(d, &[0; 12], 5121, 3, "VEC4");
            let weights = add_accessor(d, &bytes(&[1.0, 0.0, 0.0, 0.0].repeat(3)), 5126, 3, "VEC4");
            let attributes = d["meshes"][0]["primitives"][0]["attributes"].as_object_mut().unwrap();
            attributes.insert("JOINTS_0".to_owned(), json!(joints));
            attributes.insert("WEIGHTS_0".to_owned(), json!(weights));
            let mut matrix = (glam::Mat4::IDENTITY * bind).to_cols_array();
            matrix[15] = 1.0;
            let binds = add_accessor(d, &bytes(&matrix), 5126, 1, "MAT4");
            d["nodes"] = json!([{"mesh": 0, "skin": 0}, {}]);
            d["scenes"][0]["nodes"] = json!([0, 1]);
            d["skins"] = json!([{"joints": [1], "inverseBindMatrices": binds}]);
            add_clip(d, (1, "scale"), &[1.0, 1.0, 1.0, scale, scale, scale]);
        }))
        .scene
    };
    let morphed = |offset: f32, weight: f32| {
        read(&triangle(|d| {
            let offsets = add_accessor(d, &bytes(&[0.0, 0.0, offset].repeat(3)), 5126, 3, "VEC3");
            d["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": offsets}]);
            add_clip(d, (0, "weights"), &[0.0, weight]);
        }))
        .scene
    };
    for (mut scene, reason) in [
        (skinned(1e10, 1e7), "joint 0 of skin 0"),
        (morphed(1e12, 1e6), "1.0e18 m from the origin"),
        (morphed(1.0, 3e38), "morph weights"),
    ] {
        let error = scene.animate(0, 1.0).unwrap_err().to_string();
        assert!(error.contains(reason) && !error.contains('\n'), "{error}");
        assert!(scene.animate(0, 0.0).is_ok(), "at rest again");
    }
    // Large numbers that make small ones are no fault.
    for mut scene in [skinned(1e-6, 1e6), morphed(1e-3, 1e6)] {
        scene.animate(0, 1.0).unwrap();
    }
}

#[test]
fn a_mesh_without_nodes_keeps_its_default_weights() {
    let scene = read(&triangle(|d| {
        let up = add_accessor(d, &bytes(&[0.0, 0.0, 2.0].repeat(3)), 5126, 3, "VEC3");
        d["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": up}]);
        d["meshes"][0]["weights"] = json!([0.5]);
        for key in ["nodes", "scenes", "scene"] {
            d.as_object_mut().unwrap().remove(key);
        }
    }))
    .scene;
    close(scene.bounds().unwrap(), Vec3::new(0.0, 0.0, 1.0), Vec3::new(1.0, 1.0, 1.0));
}

#[test]
fn many_nodes_of_a_mesh_of_many_primitives_do_not_take_their_product() {
    const MANY: usize = 100_000;
    let document = |primitives: Vec<Value>, many: usize| {
        triangle(|d| {
            d["meshes"][0]["primitives"] = json!(primitives);
            d["nodes"] = json!(vec![json!({"mesh": 0}); many]);
            d["scenes"][0]["nodes"] = json!((0..many).collect::<Vec<_>>());
        })
    };
    let start = Instant::now();
    assert!(attempt(&document(vec![json!({"attributes": {}}); MANY], MANY)).is_ok());
    assert!(start.elapsed() < Duration::from_secs(8), "{:?}", start.elapsed());
    // What is shown that often does not fit, which is told before it is tried.
    let shown = vec![json!({"attributes": {"POSITION": 0}}); MANY / 10];
    let error = attempt(&document(shown, MANY)).unwrap_err().to_string();
    assert!(error.contains("MiB"), "{error}");
}
