//! Scenes far from the origin, and files that do not say what their axes are.
#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests fail the test")]

mod summary;

use std::path::Path;

use glam::{DVec3, Vec3};
use gnomon_scene::{Camera, Scene};
use gnomon_scene_files::{Axes, LoadOptions, UpAxis, load};

use self::summary::{Summary, open, scene_of};

/// A survey's place [m].
const PLACE: DVec3 = DVec3::new(500_000.125, 4_500_000.25, 310.5);

/// A pyramid of a few centimetres.
const CORNERS: [[f64; 3]; 4] = [[0.0, 0.0, 0.0], [0.07, 0.0, 0.0], [0.0, 0.05, 0.0], [0.01, 0.02, 0.03]];
const FACES: [[usize; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];

fn places(at: DVec3) -> [DVec3; 4] {
    CORNERS.map(|corner| DVec3::from_array(corner) + at)
}

fn obj(at: DVec3) -> Vec<u8> {
    let corners = places(at).map(|p| format!("v {} {} {}\n", p.x, p.y, p.z)).concat();
    // Nobody's vertex at the origin moves nothing.
    let faces = FACES.map(|[a, b, c]| format!("f {} {} {}\n", a + 1, b + 1, c + 1)).concat();
    format!("{corners}v 0 0 0\n{faces}").into_bytes()
}

fn ply(at: DVec3) -> Vec<u8> {
    let mut bytes = b"ply\nformat binary_big_endian 1.0\nelement vertex 4\nproperty double x\nproperty double y\nproperty double z\n\
        element face 4\nproperty list uchar int vertex_indices\nend_header\n"
        .to_vec();
    places(at).iter().for_each(|p| bytes.extend(p.to_array().iter().flat_map(|x| x.to_be_bytes())));
    for face in FACES {
        bytes.push(3);
        bytes.extend(face.iter().flat_map(|&i| (i as u32).to_be_bytes()));
    }
    bytes
}

fn stl(at: DVec3) -> Vec<u8> {
    let facet = |face: [usize; 3]| {
        let corners =
            face.map(|i| places(at)[i]).map(|p| format!("vertex {} {} {}\n", p.x, p.y, p.z)).concat();
        format!("facet normal 0 0 0\nouter loop\n{corners}endloop\nendfacet\n")
    };
    format!("solid\n{}endsolid\n", FACES.map(facet).concat()).into_bytes()
}

/// A group, a placed mesh and a camera in it.
fn gltf(group: DVec3, at: DVec3) -> Vec<u8> {
    let corners: Vec<u8> = CORNERS.iter().flatten().flat_map(|x| (*x as f32).to_le_bytes()).collect();
    let indices: Vec<u8> = FACES.iter().flatten().map(|&i| i as u8).collect();
    let data = |bytes: &[u8]| {
        use base64::Engine;
        format!("data:;base64,{}", base64::engine::general_purpose::STANDARD.encode(bytes))
    };
    let ends = |pick: fn(f64, f64) -> f64| {
        [0, 1, 2].map(|axis| CORNERS.iter().map(|c| c[axis]).reduce(pick).unwrap())
    };
    serde_json::json!({
        "asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}],
        "nodes": [
            {"translation": group.to_array(), "children": [1, 2]},
            {"mesh": 0, "translation": at.to_array()},
            {"camera": 0, "translation": (at + DVec3::Z).to_array()}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.1}}],
        "animations": [{"channels": [{"sampler": 0, "target": {"node": 1, "path": "translation"}}],
                        "samplers": [{"input": 2, "output": 3}]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": ends(f64::min), "max": ends(f64::max)},
            {"bufferView": 1, "componentType": 5121, "count": 12, "type": "SCALAR"},
            {"bufferView": 2, "componentType": 5126, "count": 1, "type": "SCALAR"},
            {"bufferView": 3, "componentType": 5126, "count": 1, "type": "VEC3"}],
        "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 1, "byteLength": 12},
                        {"buffer": 2, "byteLength": 4}, {"buffer": 3, "byteLength": 12}],
        "buffers": [{"uri": data(&corners), "byteLength": 48}, {"uri": data(&indices), "byteLength": 12},
                    {"uri": data(&[0; 4]), "byteLength": 4},
                    {"uri": data(&at.as_vec3().to_array().map(f32::to_le_bytes).concat()), "byteLength": 12}]
    })
    .to_string()
    .into_bytes()
}

#[test]
fn far_models_keep_their_digits() {
    type Writer = fn(DVec3) -> Vec<u8>;
    let files: [(&str, Writer); 4] =
        [("a.obj", obj), ("a.ply", ply), ("a.stl", stl), ("a.gltf", |at| gltf(DVec3::ZERO, at))];
    for (name, file) in files {
        let near = scene_of(&[(name, &file(DVec3::ZERO))]);
        assert_eq!(near.origin, DVec3::ZERO, "{name}");
        let far = scene_of(&[(name, &file(PLACE))]);
        assert!(far.origin.distance(PLACE) < 1.0, "{name}: {}", far.origin);
        let corner = far.bounds().unwrap().min.as_dvec3() + far.origin;
        assert!(corner.distance(PLACE) < 1e-6, "{name}: {corner}");
        Summary::of(&far).assert_like(&Summary::of(&near), name);
    }
}

#[test]
fn nodes_and_cameras_of_far_files_move_along() {
    let near = scene_of(&[("a.gltf", &gltf(DVec3::ZERO, DVec3::ZERO))]);
    let back = DVec3::new(0.25, 0.0, 0.0);
    for (group, at) in
        [(DVec3::ZERO, PLACE), (PLACE, DVec3::ZERO), (PLACE - back, back), (-PLACE, 2.0 * PLACE)]
    {
        let mut far = scene_of(&[("a.gltf", &gltf(group, at))]);
        Summary::of(&far).assert_like(&Summary::of(&near), &format!("{group}"));
        let eye = far.cameras[0].origin + far.cameras[0].eye().as_dvec3();
        assert!(
            far.cameras[0].origin == far.origin && eye.distance(PLACE + DVec3::Z) < 1e-6,
            "{group}: {eye}"
        );
        // The only key is the place at rest, in single precision: a metre of 9,000 km.
        far.animate(0, 0.0).unwrap();
        let corner = far.bounds().unwrap().min.as_dvec3() + far.origin;
        assert!(corner.distance(PLACE) < 1.0, "{group}: {corner}");
        far.rest();
        Summary::of(&far).assert_like(&Summary::of(&near), "at rest");
    }
}

/// A scene file that places far models, lights and a camera.
fn placed(folder: &Path, text: &str) -> Scene {
    std::fs::write(folder.join("far.obj"), obj(PLACE)).unwrap();
    std::fs::write(folder.join("near.obj"), obj(DVec3::ZERO)).unwrap();
    std::fs::write(folder.join("a.toml"), text).unwrap();
    open(&folder.join("a.toml")).scene
}

#[test]
fn scene_files_mean_file_coordinates() {
    let folder = tempfile::tempdir().unwrap();
    let placed = |text: &str| placed(folder.path(), text);
    let near = placed(
        "[camera]\neye = [1, 0, 0]\ntarget = [0, 0, 0]\nfov = 40\n[[model]]\nfile = \"near.obj\"\n[[light]]\nshape = \"sphere\"\n\
         radius = 0.1\nposition = [0, 1, 0]\nradiance = [1, 1, 1]\n",
    );
    assert_eq!(near.origin, DVec3::ZERO);
    let (x, y, z) = (PLACE.x, PLACE.y, PLACE.z);
    let camera = format!("[camera]\neye = [{}, {y}, {z}]\ntarget = [{x}, {y}, {z}]\nfov = 40\n", x + 1.0);
    let light = "[[light]]\nshape = \"sphere\"\nradius = 0.1\nradiance = [1, 1, 1]\n";
    for text in [
        format!("{camera}[[model]]\nfile = \"far.obj\"\n{light}position = [{x}, {}, {z}]\n", y + 1.0),
        format!(
            "{camera}[[model]]\nfile = \"near.obj\"\ntranslation = [{x}, {y}, {z}]\n{light}position = [{x}, {}, {z}]\n",
            y + 1.0
        ),
        // In the space of the model, and of the node that its file has.
        format!(
            "{camera}[[model]]\nfile = \"far.obj\"\nname = \"m\"\n{light}node = \"m\"\nposition = [{x}, {}, {z}]\n",
            y + 1.0
        ),
    ] {
        let far = placed(&text);
        assert!(far.origin.distance(PLACE) < 1.0, "{text}");
        Summary::of(&far).assert_like(&Summary::of(&near), &text);
        let from_corner = |scene: &Scene, place: Vec3| place - scene.bounds().unwrap().min;
        let light = |scene: &Scene| from_corner(scene, scene.placed_lights()[0].center);
        assert!(light(&far).distance(light(&near)) < 1e-5, "{text}: {}", light(&far));
        let eye = |scene: &Scene| from_corner(scene, scene.cameras[0].eye());
        assert!(eye(&far).distance(eye(&near)) < 1e-5, "{text}: {}", eye(&far));
    }
    // Turned, scaled and moved back.
    let back = placed(&format!(
        "[[model]]\nfile = \"far.obj\"\nrotation = [0, 90, 0]\nscale = 2\ntranslation = [{}, {}, {}]\n",
        -2.0 * z,
        -2.0 * y,
        2.0 * x
    ));
    assert_eq!(back.origin, DVec3::ZERO);
    let bounds = back.bounds().unwrap();
    let expected = (Vec3::new(0.0, 0.0, -0.14), Vec3::new(0.06, 0.1, 0.0));
    assert!(bounds.min.distance(expected.0) < 1e-5 && bounds.max.distance(expected.1) < 1e-5, "{bounds:?}");
}

#[test]
fn a_described_camera_sees_a_far_scene_as_a_near_one() {
    let far = scene_of(&[("a.obj", &obj(PLACE))]);
    let text = format!(
        "eye={},{},{};target={},{},{};fov=40",
        PLACE.x + 1.0,
        PLACE.y,
        PLACE.z,
        PLACE.x,
        PLACE.y,
        PLACE.z
    );
    let camera = text.parse::<Camera>().unwrap().relative_to(far.origin);
    let near: Camera = "eye=1,0,0;target=0,0,0;fov=40".parse().unwrap();
    let shift = (PLACE - far.origin).as_vec3();
    assert!((camera.eye() - near.eye()).distance(shift) < 1e-6);
    assert!((camera.world_from_camera.z_axis - near.world_from_camera.z_axis).length() < 1e-6);
}

#[test]
fn files_that_do_not_say_are_meant_as_they_are_said_to_be() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    for (name, bytes) in
        [("a.obj", obj(DVec3::ZERO)), ("a.ply", ply(DVec3::ZERO)), ("a.stl", stl(DVec3::ZERO))]
    {
        std::fs::write(path(name), bytes).unwrap();
        let axes = Axes { up: Some(UpAxis::Z), unit: Some(0.3048) };
        let loaded = load(&path(name), &LoadOptions { axes, ..LoadOptions::default() }).unwrap();
        let bounds = loaded.scene.bounds().unwrap();
        let expected = 0.3048 * Vec3::new(0.07, 0.03, 0.05);
        assert!(
            (bounds.max - bounds.min).distance(expected) < 1e-6 && loaded.axes == axes,
            "{name}: {bounds:?}"
        );
        assert!((bounds.min.z + expected.z).abs() < 1e-6, "y goes back: {bounds:?}");
    }
    let height = |text: &str, axes: Axes| {
        std::fs::write(path("a.toml"), text).unwrap();
        let loaded = load(&path("a.toml"), &LoadOptions { axes, ..LoadOptions::default() }).unwrap();
        let bounds = loaded.scene.bounds().unwrap();
        ((bounds.max.y - bounds.min.y) * 1e5).round()
    };
    let nobody = Axes::default();
    assert_eq!(height("up = \"z\"\nunit = \"cm\"\n[[model]]\nfile = \"a.obj\"\n", nobody), 30.0);
    assert_eq!(height("up = \"z\"\n[[model]]\nfile = \"a.obj\"\nup = \"y\"\nunit = 0.1\n", nobody), 500.0);
    // Who loads goes before the file, but not before what it says of one model.
    let millimetres = Axes { unit: Some(0.001), ..nobody };
    assert_eq!(height("unit = \"cm\"\n[[model]]\nfile = \"a.stl\"\n", millimetres), 5.0);
    assert_eq!(height("[[model]]\nfile = \"a.stl\"\nunit = \"m\"\n", millimetres), 5000.0);
    for (text, part) in [
        ("unit = \"mile\"\n", "unit must be"),
        ("unit = -1\n", "unit must be"),
        ("up = \"x\"\n", "unknown variant"),
        ("[[model]]\nbuiltin = \"column\"\nunit = \"cm\"\n", "only a model of a file"),
    ] {
        std::fs::write(path("a.toml"), text).unwrap();
        let error = load(&path("a.toml"), &LoadOptions::default()).unwrap_err().to_string();
        assert!(error.contains(part), "{error}");
    }
    std::fs::write(path("a.gltf"), gltf(DVec3::ZERO, DVec3::ZERO)).unwrap();
    let loaded = load(&path("a.gltf"), &LoadOptions { axes: millimetres, ..LoadOptions::default() }).unwrap();
    assert!(
        loaded.scene.warnings[0].contains("'up' and 'unit' have no effect"),
        "{:?}",
        loaded.scene.warnings
    );
}
