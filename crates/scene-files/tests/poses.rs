//! Animated models against an independent evaluation of their files (`expected/evaluate_poses.py`, NumPy, double
//! precision; it says of itself how it compares with Blender).
#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests fail the test")]

use glam::Vec3;
use gnomon_scene::Scene;
use gnomon_scene_files::{LoadOptions, load};
use gnomon_testing::data_file;
use gnomon_testing::tolerances::POSE_ERROR;
use serde_json::Value;

fn vector(value: &Value) -> Vec3 {
    Vec3::from_array([0, 1, 2].map(|axis| value[axis].as_f64().unwrap() as f32))
}

/// All corners of all triangles in world space, in node order.
fn corners(scene: &Scene) -> Vec<Vec3> {
    let pose = scene.pose();
    let of = |instance| {
        let vertices = scene.world_vertices(&pose, &instance);
        let indices = scene.meshes[instance.mesh.0].triangles.iter().flatten();
        indices.map(|&index| vertices.positions[index as usize]).collect::<Vec<_>>()
    };
    scene.instances().into_iter().flat_map(of).collect()
}

/// Largest distance of the scene's pose from an expected one, over the model's size.
fn error(scene: &Scene, stride: usize, expected: &Value) -> f32 {
    let (min, max) = (vector(&expected["min"]), vector(&expected["max"]));
    let bounds = scene.bounds().unwrap();
    let mut worst = (bounds.min - min).abs().max_element().max((bounds.max - max).abs().max_element());
    let found = corners(scene);
    let wanted = expected["corners"].as_array().unwrap();
    assert_eq!(found.iter().step_by(stride).count(), wanted.len());
    for (found, wanted) in found.iter().step_by(stride).zip(wanted) {
        let distance = found.distance(vector(wanted));
        // Maximum that keeps NaN.
        worst = if distance <= worst { worst } else { distance };
    }
    worst / (max - min).length()
}

#[test]
fn poses_are_those_of_an_independent_evaluation() {
    let expected: Value = serde_json::from_str(include_str!("expected/poses.json")).unwrap();
    for entry in expected.as_array().unwrap() {
        let name = entry["model"].as_str().unwrap();
        let Some(path) = data_file(&format!("models/{name}")) else { return };
        let mut scene = load(&path, &LoadOptions::default()).unwrap().scene;
        let clip = entry["clip"].as_u64().unwrap() as usize;
        let stride = entry["stride"].as_u64().unwrap() as usize;
        assert_eq!(corners(&scene).len() as u64, entry["count"].as_u64().unwrap(), "{name}");
        let duration = entry["duration"].as_f64().unwrap() as f32;
        assert!((scene.animations[clip].duration() - duration).abs() < 1e-6, "{name}");
        let mut apart = 0.0_f32;
        for pose in entry["poses"].as_array().unwrap() {
            match pose["time"].as_f64() {
                Some(time) => scene.animate(clip, time as f32).unwrap(),
                None => scene.rest(),
            }
            let error = error(&scene, stride, pose);
            assert!(error <= POSE_ERROR, "{name}, clip {clip}, time {}: {error}", pose["time"]);
            // A planted fault: the pose of another time is not taken for this one.
            if let Some(time) = pose["time"].as_f64() {
                scene.animate(clip, (time as f32 + 0.3 * duration).rem_euclid(duration.max(1e-3))).unwrap();
                apart = apart.max(self::error(&scene, stride, pose));
            }
        }
        assert!(apart > 10.0 * POSE_ERROR || duration == 0.0, "{name}, clip {clip}: nothing moves");
    }
}

#[test]
fn what_stands_beside_a_model_follows_its_pose() {
    let Some(path) = data_file("models/Fox.glb") else { return };
    let mut scene = load(&path, &LoadOptions::default()).unwrap().scene;
    assert_eq!(
        scene.animations.iter().map(|clip| clip.name.as_str()).collect::<Vec<_>>(),
        ["Survey", "Walk", "Run"]
    );
    let rest = scene.clone();
    scene.animate(2, 0.5).unwrap();
    let running = scene.bounds().unwrap();
    assert_ne!(rest.bounds(), Some(running));
    let camera = gnomon_scene::default_camera(&scene, 1.0);
    assert_ne!(gnomon_scene::default_camera(&rest, 1.0), camera);
    scene.add_ground(gnomon_scene::Ground::Plane);
    assert_eq!(scene.bounds().unwrap().min.y, running.min.y);
    let ground = scene.nodes.last().unwrap().clone();
    scene.rest();
    assert_eq!(scene.nodes.last(), Some(&ground), "the ground stays");
    assert_eq!(scene.bounds_without_ground(), rest.bounds());
}

/// Two models in one scene keep their own skins, nodes and clips.
#[test]
fn appended_models_dance_as_they_do_alone() {
    let names = ["models/Fox.glb", "models/RobotExpressive.glb"];
    let [Some(fox), Some(robot)] = names.map(data_file) else { return };
    let [fox, robot] = [fox, robot].map(|path| load(&path, &LoadOptions::default()).unwrap().scene);
    let mut both = fox.clone();
    let place = glam::Affine3A::from_translation(Vec3::new(200.0, 3.0, 0.0));
    both.append(robot.clone(), gnomon_scene::Node { parent_from_node: place, ..Default::default() });
    assert_eq!(both.animations.len(), fox.animations.len() + robot.animations.len());
    both.animate_all(&[(1, 0.3), (3, 1.1)]).unwrap();
    let alone = |mut scene: Scene, clip: usize, time: f32| {
        scene.animate(clip, time).unwrap();
        corners(&scene)
    };
    let moved = alone(robot, 0, 1.1).into_iter().map(|corner| place.transform_point3(corner));
    let wanted: Vec<Vec3> = alone(fox, 1, 0.3).into_iter().chain(moved).collect();
    let found = corners(&both);
    assert_eq!(found.len(), wanted.len());
    let worst = found.iter().zip(&wanted).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
    assert!(worst < 1e-4 * 200.0, "{worst}");
}
