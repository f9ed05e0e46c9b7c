//! Interpolation, skins and morph targets of small documents against closed forms, and damaged ones.
#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests fail the test")]

mod documents;

use glam::Vec3;
use gnomon_scene::{Ground, Scene, SceneError};
use gnomon_scene_files::LoadOptions;
use serde_json::{Value, json};

use self::documents::{add_accessor, attempt, bytes, read, refusal, triangle};

/// The triangle, with a clip of one channel that moves node 0.
fn moving(path: &str, interpolation: &str, times: &[f32], values: &[f32], shape: &str) -> Value {
    triangle(|d| {
        let width = if shape == "SCALAR" { 1 } else { usize::from(shape.as_bytes()[3] - b'0') };
        let input = add_accessor(d, &bytes(times), 5126, times.len(), "SCALAR");
        let output = add_accessor(d, &bytes(values), 5126, values.len() / width, shape);
        d["animations"] = json!([{
            "name": "clip",
            "channels": [{"sampler": 0, "target": {"node": 0, "path": path}}],
            "samplers": [{"input": input, "output": output, "interpolation": interpolation}]
        }]);
    })
}

/// World positions of the first instance's corners.
fn corners(scene: &Scene) -> Vec<Vec3> {
    scene.world_vertices(&scene.pose(), &scene.instances()[0]).positions
}

fn at(scene: &mut Scene, seconds: f32) -> Vec<Vec3> {
    scene.animate(0, seconds).unwrap();
    corners(scene)
}

fn near(found: Vec3, expected: Vec3) {
    assert!(found.distance(expected) < 1e-5, "{found}, not {expected}");
}

#[test]
fn translations_interpolate_as_specified() {
    let times = [1.0, 3.0];
    let ends = [0.0, 0.0, 0.0, 4.0, 0.0, -8.0];
    let x = |scene: &mut Scene, time: f32| at(scene, time)[0].x;
    let mut linear = read(&moving("translation", "LINEAR", &times, &ends, "VEC3")).scene;
    assert_eq!((linear.animations[0].name.as_str(), linear.animations[0].duration()), ("clip", 3.0));
    let mut step = read(&moving("translation", "STEP", &times, &ends, "VEC3")).scene;
    // In-tangent, value, out-tangent; units a second.
    let spline =
        [[9.0, 9.0, 9.0], [0.0; 3], [2.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [4.0, 0.0, -8.0], [9.0; 3]].concat();
    let mut spline = read(&moving("translation", "CUBICSPLINE", &times, &spline, "VEC3")).scene;
    for (time, straight, stepped) in [
        (-5.0, 0.0, 0.0),
        (0.5, 0.0, 0.0),
        (1.5, 1.0, 0.0),
        (2.5, 3.0, 0.0),
        (3.0, 4.0, 4.0),
        (1e9, 4.0, 4.0),
    ] {
        assert_eq!((x(&mut linear, time), x(&mut step, time)), (straight, stepped), "at {time} s");
        // Hermite: h01 4 + 2 s (h10 2 - h11 1), s being the share of the way.
        let s = ((time - 1.0) / 2.0).clamp(0.0, 1.0);
        let hermite = 4.0 * (3.0 * s * s - 2.0 * s * s * s)
            + 2.0 * (2.0 * (s * s * s - 2.0 * s * s + s) - (s * s * s - s * s));
        assert!((x(&mut spline, time) - hermite).abs() < 1e-5, "at {time} s");
    }
    linear.rest();
    near(corners(&linear)[0], Vec3::ZERO);
}

#[test]
fn rotations_take_the_shorter_arc_at_constant_speed() {
    let half = std::f32::consts::FRAC_1_SQRT_2;
    for sign in [1.0, -1.0] {
        // A quarter turn about z, also as the opposite quaternion, which is the same rotation.
        let values = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, sign * half, sign * half];
        let mut scene = read(&moving("rotation", "LINEAR", &[0.0, 9.0], &values, "VEC4")).scene;
        for third in 0..=3 {
            let angle = (30.0 * third as f32).to_radians();
            near(at(&mut scene, 3.0 * third as f32)[1], Vec3::new(angle.cos(), angle.sin(), 0.0));
        }
    }
    // What is no unit quaternion is made one; splines are normalized after interpolation.
    let values = [0.0, 0.0, 0.0, 5.0, 0.0, 0.0, 0.1, 0.1];
    let mut scene = read(&moving("rotation", "STEP", &[0.0, 1.0], &values, "VEC4")).scene;
    near(at(&mut scene, 1.0)[1], Vec3::Y);
    let key = |z: f32, w: f32| [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, z, w, 0.0, 0.0, 0.0, 0.0];
    let values = [key(0.0, 1.0), key(half, half)].concat();
    let mut scene = read(&moving("rotation", "CUBICSPLINE", &[0.0, 1.0], &values, "VEC4")).scene;
    let angle = 45_f32.to_radians();
    near(at(&mut scene, 0.5)[1], Vec3::new(angle.cos(), angle.sin(), 0.0));
}

#[test]
fn integers_stand_for_shares_of_their_range() {
    let mut document = moving("rotation", "LINEAR", &[0.0], &[0.0; 4], "VEC4");
    let values: Vec<u8> = [0_i16, 0, 32_767, 0].iter().flat_map(|x| x.to_le_bytes()).collect();
    let accessor = add_accessor(&mut document, &values, 5122, 1, "VEC4");
    document["accessors"][accessor]["normalized"] = json!(true);
    document["animations"][0]["samplers"][0]["output"] = json!(accessor);
    near(at(&mut read(&document).scene, 0.0)[1], Vec3::NEG_X);
}

/// The triangle with two morph targets, +z and a stretch along x, the second sparse; weights 1 and 0 at rest.
fn morphing(change: impl FnOnce(&mut Value)) -> Value {
    triangle(|d| {
        let up = add_accessor(d, &bytes(&[0.0, 0.0, 2.0].repeat(3)), 5126, 3, "VEC3");
        let place = add_accessor(d, &[1], 5121, 1, "SCALAR");
        let value = add_accessor(d, &bytes(&[1.0, 0.0, 0.0]), 5126, 1, "VEC3");
        let views = [place, value].map(|accessor| d["accessors"][accessor]["bufferView"].clone());
        let stretch = add_accessor(d, &[], 5126, 3, "VEC3");
        let sparse = d["accessors"][stretch].as_object_mut().unwrap();
        sparse.remove("bufferView");
        sparse.insert(
            "sparse".to_owned(),
            json!({"count": 1,
            "indices": {"bufferView": views[0], "componentType": 5121}, "values": {"bufferView": views[1]}}),
        );
        d["buffers"].as_array_mut().unwrap().pop();
        d["bufferViews"].as_array_mut().unwrap().pop();
        d["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": up}, {"POSITION": stretch}]);
        d["meshes"][0]["weights"] = json!([1.0]);
        change(d);
    })
}

#[test]
fn morph_weights_are_animated() {
    let mut scene = read(&morphing(|d| {
        let input = add_accessor(d, &bytes(&[0.0, 2.0]), 5126, 2, "SCALAR");
        let output = add_accessor(d, &[0, 255, 255, 51], 5121, 4, "SCALAR");
        d["accessors"][output]["normalized"] = json!(true);
        d["animations"] = json!([{"channels": [{"sampler": 0, "target": {"node": 0, "path": "weights"}}],
            "samplers": [{"input": input, "output": output}]}]);
    }))
    .scene;
    assert_eq!(scene.nodes[0].weights, [1.0, 0.0]);
    near(corners(&scene)[1], Vec3::new(1.0, 0.0, 2.0));
    near(at(&mut scene, 0.0)[1], Vec3::new(2.0, 0.0, 0.0));
    near(at(&mut scene, 1.0)[1], Vec3::new(1.6, 0.0, 1.0));
    near(at(&mut scene, 2.0)[1], Vec3::new(1.2, 0.0, 2.0));
    scene.rest();
    near(corners(&scene)[1], Vec3::new(1.0, 0.0, 2.0));
}

#[test]
fn flat_normals_follow_their_morph_targets() {
    // The third corner comes forward by 1: the plane leans from +z towards -y.
    let scene = read(&triangle(|d| {
        let lean = add_accessor(d, &bytes(&[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]), 5126, 3, "VEC3");
        d["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": lean}]);
        d["nodes"][0]["weights"] = json!([1.0]);
    }))
    .scene;
    let vertices = scene.world_vertices(&scene.pose(), &scene.instances()[0]);
    near(vertices.normals[0], Vec3::new(0.0, -1.0, 1.0).normalize());
}

/// The triangle on two joints, nodes 1 and 2: joint 1 keeps the first corner, joint 2 the second, both the third.
/// `weights` are those of the corners for joints (0, 1).
fn skinned(weights: [[f32; 2]; 3], change: impl FnOnce(&mut Value)) -> Value {
    triangle(|d| {
        let joints = add_accessor(d, &[0, 1, 0, 0].repeat(3), 5121, 3, "VEC4");
        let weights: Vec<f32> = weights.iter().flat_map(|[a, b]| [*a, *b, 0.0, 0.0]).collect();
        let weights = add_accessor(d, &bytes(&weights), 5126, 3, "VEC4");
        let attributes = d["meshes"][0]["primitives"][0]["attributes"].as_object_mut().unwrap();
        attributes.insert("JOINTS_0".to_owned(), json!(joints));
        attributes.insert("WEIGHTS_0".to_owned(), json!(weights));
        // The mesh's own place counts for nothing.
        d["nodes"] =
            json!([{"mesh": 0, "skin": 0, "translation": [50, 0, 0]}, {}, {"translation": [0, 0, 6]}]);
        d["scenes"][0]["nodes"] = json!([0, 1, 2]);
        d["skins"] = json!([{"joints": [1, 2]}]);
        change(d);
    })
}

const WEIGHTS: [[f32; 2]; 3] = [[1.0, 0.0], [0.0, 1.0], [0.5, 0.5]];

#[test]
fn joints_bend_meshes_and_their_nodes_do_not_move_them() {
    let scene = read(&skinned(WEIGHTS, |_| ())).scene;
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    let expected = [Vec3::ZERO, Vec3::new(1.0, 0.0, 6.0), Vec3::new(0.0, 1.0, 3.0)];
    corners(&scene).into_iter().zip(expected).for_each(|(found, expected)| near(found, expected));
    let bounds = scene.bounds().unwrap();
    assert_eq!((bounds.min, bounds.max), (Vec3::ZERO, Vec3::new(1.0, 1.0, 6.0)));
    // A bind matrix undoes the joint's place.
    let undone = read(&skinned(WEIGHTS, |d| {
        let mut matrices = [glam::Mat4::IDENTITY; 2].map(|m| m.to_cols_array());
        matrices[1][14] = -6.0;
        let accessor = add_accessor(d, &bytes(&matrices.concat()), 5126, 2, "MAT4");
        d["skins"][0]["inverseBindMatrices"] = json!(accessor);
    }))
    .scene;
    near(corners(&undone)[1], Vec3::X);
}

#[test]
fn more_than_four_joints_bend_a_vertex() {
    let scene = read(&skinned([[0.25, 0.0]; 3], |d| {
        let joints = add_accessor(d, &[1, 1, 1, 0].repeat(3), 5121, 3, "VEC4");
        let weights = add_accessor(d, &bytes(&[0.25, 0.25, 0.25, 0.0].repeat(3)), 5126, 3, "VEC4");
        let attributes = d["meshes"][0]["primitives"][0]["attributes"].as_object_mut().unwrap();
        attributes.insert("JOINTS_1".to_owned(), json!(joints));
        attributes.insert("WEIGHTS_1".to_owned(), json!(weights));
    }))
    .scene;
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    near(corners(&scene)[0], Vec3::new(0.0, 0.0, 4.5));
}

#[test]
fn joint_weights_are_repaired_with_a_warning() {
    let scene = read(&skinned([[3.0, 3.0], [-1.0, 4.0], [0.0, 0.0]], |_| ())).scene;
    near(corners(&scene)[0], Vec3::new(0.0, 0.0, 3.0));
    near(corners(&scene)[1], Vec3::new(1.0, 0.0, 6.0));
    near(corners(&scene)[2], Vec3::new(50.0, 1.0, 0.0));
    let warnings = scene.warnings.join("\n");
    assert!(warnings.contains("weights of 2 vertices were made to sum to 1"), "{warnings}");
    assert!(warnings.contains("1 vertices have no joint weights"), "{warnings}");
    let scene = read(&skinned([[f32::NAN, 1.0], [f32::INFINITY, 1.0], [1e38, 1e38]], |_| ())).scene;
    assert!(corners(&scene).iter().all(|corner| corner.is_finite()));
    assert_eq!(scene.warnings.len(), 1, "{:?}", scene.warnings);
}

#[test]
fn skins_that_refer_to_nothing_are_refused() {
    type Change = fn(&mut Value);
    let cases: [(&str, Change); 6] = [
        ("refers to joint 1, but its skin has 1", |d| d["skins"][0]["joints"] = json!([1])),
        ("fewer bind matrices than joints", |d| {
            let one = add_accessor(d, &bytes(&glam::Mat4::IDENTITY.to_cols_array()), 5126, 1, "MAT4");
            d["skins"][0]["inverseBindMatrices"] = json!(one);
        }),
        ("bind matrix that is not finite", |d| {
            let two = add_accessor(d, &bytes(&[f32::NAN; 32]), 5126, 2, "MAT4");
            d["skins"][0]["inverseBindMatrices"] = json!(two);
        }),
        ("refers to node 9", |d| d["skins"][0]["joints"] = json!([1, 9])),
        ("refers to skin 4", |d| d["nodes"][0]["skin"] = json!(4)),
        ("loop", |d| {
            d["nodes"][1]["children"] = json!([2]);
            d["nodes"][2]["children"] = json!([1]);
        }),
    ];
    for (reason, change) in cases {
        let error = refusal(&skinned(WEIGHTS, change));
        assert!(error.contains(reason), "{error}");
    }
    let scene = read(&skinned(WEIGHTS, |d| d["scenes"][0]["nodes"] = json!([0, 1]))).scene;
    // A joint that the scene does not list bends all the same.
    assert_eq!(corners(&scene), corners(&read(&skinned(WEIGHTS, |_| ())).scene));
}

#[test]
fn damaged_clips_are_left_out_and_the_model_is_shown() {
    let fine = || moving("translation", "LINEAR", &[0.0, 1.0], &[0.0, 0.0, 0.0, 1.0, 1.0, 1.0], "VEC3");
    let vector = |times: &[f32], values: &[f32]| moving("translation", "LINEAR", times, values, "VEC3");
    let changed = |change: fn(&mut Value)| {
        let mut document = fine();
        change(&mut document);
        document
    };
    let cases = [
        ("times are not finite", vector(&[0.0, f32::NAN], &[0.0; 6])),
        ("times are not finite", vector(&[f32::INFINITY], &[0.0; 3])),
        ("decrease", vector(&[1.0, 0.5], &[0.0; 6])),
        ("no keys", vector(&[], &[])),
        ("2 values where its times want 3", vector(&[0.0, 1.0, 2.0], &[0.0; 6])),
        (
            "2 values where its times want 6",
            moving("translation", "CUBICSPLINE", &[0.0, 1.0], &[0.0; 6], "VEC3"),
        ),
        ("values are not finite", vector(&[0.0], &[0.0, f32::NAN, 0.0])),
        ("no quaternion", moving("rotation", "LINEAR", &[0.0], &[0.0; 4], "VEC4")),
        ("type VEC3 where 4", moving("rotation", "LINEAR", &[0.0], &[0.0; 3], "VEC3")),
        ("no morph targets", moving("weights", "LINEAR", &[0.0], &[0.0], "SCALAR")),
        ("moves 'pointer'", moving("pointer", "LINEAR", &[0.0], &[0.0], "SCALAR")),
        ("interpolation 'BEZIER' is unknown", moving("scale", "BEZIER", &[0.0], &[0.0; 3], "VEC3")),
        ("refers to sampler 3", changed(|d| d["animations"][0]["channels"][0]["sampler"] = json!(3))),
        ("has no sampler", changed(|d| d["animations"][0]["channels"][0] = json!({"target": {"node": 0}}))),
        ("refers to node 7", changed(|d| d["animations"][0]["channels"][0]["target"]["node"] = json!(7))),
        ("lacks times", changed(|d| d["animations"][0]["samplers"][0] = json!({"output": 0}))),
        ("refers to accessor 99", changed(|d| d["animations"][0]["samplers"][0]["output"] = json!(99))),
        ("reaches beyond", changed(|d| d["accessors"][2]["count"] = json!(1000))),
    ];
    for (reason, document) in &cases {
        let mut scene = read(document).scene;
        let found = scene.warnings.join("\n");
        assert!(found.contains("left out") && found.contains(reason), "{reason}: {found}");
        assert_eq!((scene.animations.len(), scene.animations[0].channels.len()), (1, 0));
        assert_eq!(scene.animations[0].duration(), 0.0);
        near(at(&mut scene, 1.0)[1], Vec3::X);
    }
    // A channel without a target moves nothing, which is no fault.
    let scene =
        read(&changed(|d| d["animations"][0]["channels"][0]["target"] = json!({"path": "scale"}))).scene;
    assert!(scene.warnings.is_empty() && scene.animations[0].channels.is_empty());
    let mut scene = read(&fine()).scene;
    assert!(scene.warnings.is_empty());
    near(at(&mut scene, 0.5)[0], Vec3::splat(0.5));
}

#[test]
fn extreme_clips_are_defined() {
    // Equal times: the later key counts from then on.
    let mut scene = read(&moving(
        "scale",
        "LINEAR",
        &[0.0, 1.0, 1.0, 2.0],
        &[[1.0; 3], [2.0; 3], [5.0; 3], [6.0; 3]].concat(),
        "VEC3",
    ))
    .scene;
    near(at(&mut scene, 0.5)[1], Vec3::new(1.5, 0.0, 0.0));
    near(at(&mut scene, 1.0)[1], Vec3::new(5.0, 0.0, 0.0));
    let huge = [-3e38, 3e38];
    let mut scene =
        read(&moving("translation", "LINEAR", &huge, &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0], "VEC3")).scene;
    near(at(&mut scene, 0.0)[0], Vec3::new(0.5, 0.0, 0.0));
    near(at(&mut scene, f32::MAX)[0], Vec3::X);
    // Finite keys that no picture can hold.
    let mut scene =
        read(&moving("translation", "LINEAR", &[0.0, 1.0], &[0.0, 0.0, 0.0, 3e38, 0.0, 0.0], "VEC3")).scene;
    let error = scene.animate(0, 1.0).unwrap_err().to_string();
    assert!(error.contains("beyond all bounds"), "{error}");
    near(corners(&scene)[0], Vec3::ZERO);
    let tangents = [[0.0; 3], [0.0; 3], [3e38; 3], [3e38; 3], [0.0; 3], [0.0; 3]].concat();
    let mut scene = read(&moving("translation", "CUBICSPLINE", &[0.0, 9.0], &tangents, "VEC3")).scene;
    assert!(scene.animate(0, 4.0).is_err());
    near(at(&mut scene, 9.0)[0], Vec3::ZERO);
    for offsets in [f32::NAN, 1e30] {
        let scene = read(&morphing(|d| {
            let broken = add_accessor(d, &bytes(&[offsets; 9]), 5126, 3, "VEC3");
            d["meshes"][0]["primitives"][0]["targets"][0]["POSITION"] = json!(broken);
        }))
        .scene;
        assert!(scene.warnings[0].contains("offsets of morph targets"), "{:?}", scene.warnings);
        near(corners(&scene)[1], Vec3::X);
    }
}

#[test]
fn poses_that_do_not_exist_are_refused() {
    let mut scene =
        read(&moving("translation", "LINEAR", &[0.0, 1.0], &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0], "VEC3")).scene;
    for (clip, seconds, reason) in [
        (1, 0.0, "no animation 1: it has 1"),
        (0, f32::NAN, "no time NaN"),
        (0, f32::INFINITY, "no time inf"),
    ] {
        let error = scene.animate(clip, seconds).unwrap_err();
        assert!(matches!(error, SceneError::Request(_)) && error.to_string().contains(reason), "{error}");
    }
    let mut still = gnomon_scene::builtin::by_name("three-boxes").unwrap();
    assert!(still.animate(0, 0.0).unwrap_err().to_string().contains("it has none"));
    still.rest();
    still.add_ground(Ground::None);
    // Memory: a clip counts against the scene's budget.
    let document = moving("scale", "LINEAR", &vec![0.0; 3000], &vec![1.0; 9000], "VEC3");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("clip.gltf");
    std::fs::write(&path, serde_json::to_vec(&document).unwrap()).unwrap();
    let length = usize::try_from(std::fs::metadata(&path).unwrap().len()).unwrap();
    let options = LoadOptions { memory_limit: 8 * length, ..LoadOptions::default() };
    assert!(gnomon_scene_files::load(&path, &options).is_ok());
    let options = LoadOptions { memory_limit: 5 * length + 60_000, ..options };
    assert!(matches!(
        gnomon_scene_files::load(&path, &options),
        Err(gnomon_scene_files::SceneFileError::TooLarge { .. })
    ));
    assert!(attempt(&document).is_ok());
}

#[test]
fn cameras_ride_on_animated_nodes() {
    let values = [0.0, 0.0, 0.0, 0.0, 0.0, 8.0];
    let mut document = moving("translation", "LINEAR", &[0.0, 1.0], &values, "VEC3");
    document["nodes"][0]["children"] = json!([1]);
    document["nodes"].as_array_mut().unwrap().push(json!({"camera": 0, "translation": [1, 0, 0]}));
    document["cameras"] = json!([{"type": "orthographic", "orthographic": {"xmag": 3.0, "ymag": 1.0, "zfar": 9.0, "znear": 0.1}}]);
    let mut scene = read(&document).scene;
    scene.animate(0, 0.5).unwrap();
    near(scene.cameras[0].eye(), Vec3::new(1.0, 0.0, 4.0));
    scene.rest();
    near(scene.cameras[0].eye(), Vec3::X);
}
