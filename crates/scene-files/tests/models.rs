//! Real models: everything loads, with the counts that their sources state.
#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests fail the test")]

use std::collections::BTreeMap;
use std::path::Path;

use glam::Vec3;
use gnomon_scene::{Ground, Projection, Scene, builtin};
use gnomon_scene_files::{LoadOptions, LoadedScene, load};
use gnomon_testing::data_file;

fn open(path: &Path) -> LoadedScene {
    load(path, &LoadOptions::default()).unwrap_or_else(|error| panic!("{error}"))
}

/// What [`gnomon_scene::Mesh`] promises.
fn check(scene: &Scene) {
    for mesh in &scene.meshes {
        let count = mesh.positions.len();
        assert_eq!(mesh.normals.len(), count);
        assert!(mesh.normals.iter().all(|normal| normal.is_normalized()));
        assert!([0, count].contains(&mesh.tangents.len()));
        assert!([0, count].contains(&mesh.colors.len()));
        assert!(mesh.uvs.iter().all(|set| [0, count].contains(&set.len())));
        assert!(mesh.triangles.iter().flatten().all(|&index| (index as usize) < count));
        assert!(mesh.material.is_none_or(|material| material.0 < scene.materials.len()));
        assert!(mesh.tangents.iter().all(|t| t.truncate().is_normalized() && t.w.abs() == 1.0));
    }
    for (index, node) in scene.nodes.iter().enumerate() {
        assert!(node.parent.is_none_or(|parent| parent.0 < index));
        assert!(node.meshes.iter().all(|mesh| mesh.0 < scene.meshes.len()));
    }
}

/// Counts of the PLY and OBJ files as their headers and `data/README.md` state them; of glTF files, a third of the index
/// counts in their JSON.
#[test]
fn every_model_loads_with_its_triangles() {
    let counts = [
        ("models/stanford_bunny_35947v.ply", 69_451),
        ("models/stanford_bunny_res3.ply", 3_851),
        ("models/happy_buddha_res3.ply", 67_240),
        ("models/horse_48485v.ply", 96_966),
        ("models/footbones.ply", 4_204),
        ("models/triceratops.obj", 5_660),
        ("models/teapot.obj", 6_320),
        ("models/spot.obj", 5_856),
        ("models/three_boxes_38tri.obj", 38),
        ("models/BrainStem.glb", 61_666),
        ("models/AnimatedMorphCube.glb", 12),
        ("models/BoxAnimated.glb", 254),
        ("models/CornellBox.glb", 36),
        ("models/Fox.glb", 576),
        ("models/NormalTangentTest.glb", 7_774),
        ("models/RiggedSimple.glb", 188),
        ("models/RobotExpressive.glb", 3_234),
        ("models/SimpleSkin.gltf", 8),
        ("models/sparse_morph_cube.glb", 12),
        ("scenes/three_boxes.glb", 38),
        ("scenes/bunny_on_ground.glb", 69_453),
    ];
    for (name, count) in counts {
        let Some(path) = data_file(name) else { return };
        let loaded = open(&path);
        check(&loaded.scene);
        assert_eq!(loaded.scene.triangle_count(), count, "{name}");
        // The floor of the Cornell box is its own, and ends with its walls.
        let on_ground = ["three_boxes", "bunny_on_ground"].iter().any(|own| name.contains(own));
        assert_eq!(loaded.ground, if on_ground { Ground::None } else { Ground::Fade }, "{name}");
    }
}

#[test]
fn scenes_that_bring_a_ground_keep_it() {
    for name in ["bunny_on_ground", "fence", "metals", "plaza", "room", "shelf", "three_boxes", "tree"] {
        let Some(path) = data_file(&format!("scenes/{name}.glb")) else { return };
        assert_eq!(open(&path).ground, Ground::None, "{name}");
    }
}

/// Triangles as corner positions in units of 10 micrometres, each turned to start at its smallest corner.
fn triangles(scene: &Scene) -> BTreeMap<[[i64; 3]; 3], usize> {
    let mut set = BTreeMap::new();
    for instance in scene.instances() {
        let (mesh, world_from_mesh) = (&scene.meshes[instance.mesh.0], instance.world_from_mesh);
        for triangle in &mesh.triangles {
            let mut corners = triangle.map(|index| {
                let p = world_from_mesh.transform_point3(mesh.positions[index as usize]);
                p.to_array().map(|x| (f64::from(x) * 1e5).round() as i64)
            });
            let smallest = (0..3).min_by_key(|&i| corners[i]).unwrap();
            corners.rotate_left(smallest);
            *set.entry(corners).or_default() += 1;
        }
    }
    set
}

/// Largest distance between corresponding corners of two triangle sets in the same order.
fn differ(a: &Scene, b: &Scene) -> i64 {
    let (a, b) = (triangles(a), triangles(b));
    assert_eq!(a.len(), b.len());
    a.keys()
        .zip(b.keys())
        .flat_map(|(a, b)| (0..9).map(|i| (a[i / 3][i % 3] - b[i / 3][i % 3]).abs()))
        .max()
        .unwrap()
}

#[test]
fn the_built_in_boxes_are_those_of_the_files() {
    let boxes = builtin::by_name("three-boxes").unwrap();
    for name in ["models/three_boxes_38tri.obj", "scenes/three_boxes.glb"] {
        let Some(path) = data_file(name) else { return };
        let file = open(&path).scene;
        // Diagonals of the faces and rounding to six digits may differ: corners must not.
        let corners = |scene: &Scene| {
            let mut corners: Vec<_> = triangles(scene).into_keys().flatten().collect();
            corners.sort_unstable();
            corners.dedup();
            corners
        };
        let (ours, theirs) = (corners(&boxes), corners(&file));
        assert_eq!(ours.len(), 28);
        for (a, b) in ours.iter().zip(&theirs) {
            assert!((0..3).all(|i| (a[i] - b[i]).abs() <= 1), "{name}: {a:?} {b:?}");
        }
        let area = |scene: &Scene| surface_area(scene);
        assert!((area(&boxes) - area(&file)).abs() < 1e-3);
    }
    let Some(obj) = data_file("models/three_boxes_38tri.obj") else { return };
    let Some(glb) = data_file("scenes/three_boxes.glb") else { return };
    assert!(differ(&open(&obj).scene, &open(&glb).scene) <= 1, "the files are twins");
}

fn surface_area(scene: &Scene) -> f32 {
    let area = |t: &[[i64; 3]; 3]| {
        let [a, b, c] = t.map(|p| Vec3::from_array(p.map(|x| x as f32 * 1e-5)));
        0.5 * (b - a).cross(c - a).length()
    };
    triangles(scene).keys().map(area).sum()
}

#[test]
fn cameras_are_those_of_the_reference_renders() {
    let Some(renders) = data_file("reference/renders.json") else { return };
    let renders: serde_json::Value = serde_json::from_slice(&std::fs::read(renders).unwrap()).unwrap();
    let boxes = builtin::by_name("three-boxes").unwrap();
    for (image, name) in [(0, "scenes/three_boxes.glb"), (2, "scenes/bunny_on_ground.glb")] {
        let Some(path) = data_file(name) else { return };
        let loaded = open(&path);
        let camera = &renders["images"][image]["camera"];
        let vector = |key: &str| -> Vec3 {
            Vec3::from_array([0, 1, 2].map(|i| camera[key][i].as_f64().unwrap() as f32))
        };
        let fov = camera["fov_x_deg"].as_f64().unwrap() as f32;
        let mut cameras = vec![loaded.scene.camera(None).unwrap()];
        if image == 0 {
            cameras.push(boxes.camera(None).unwrap());
        }
        for found in cameras {
            let Projection::Perspective { fov_x } = found.projection else { panic!("perspective") };
            assert!((fov_x.to_degrees() - fov).abs() < 1e-4, "{name}: {}", fov_x.to_degrees());
            assert!((found.eye() - vector("origin")).length() < 1e-6);
            let forward = -found.world_from_camera.z_axis.truncate();
            assert!((forward - (vector("target") - vector("origin")).normalize()).length() < 1e-6);
            assert!(found.world_from_camera.x_axis.y.abs() < 1e-6, "level");
        }
        // The node's name stands in for the camera's; numbers do too.
        assert!(loaded.scene.camera(Some("camera")).is_ok());
        assert!(loaded.scene.camera(Some("0")).is_ok());
        let error = loaded.scene.camera(Some("other")).unwrap_err().to_string();
        assert!(error.contains("there are: camera"), "{error}");
    }
}

#[test]
fn reference_scenes_are_lambert_flat_and_as_described() {
    let Some(path) = data_file("scenes/bunny_on_ground.glb") else { return };
    let scene = open(&path).scene;
    for material in &scene.materials {
        assert_eq!(material.surface.specular, 0.0);
        assert_eq!(material.surface.base_color, Vec3::splat(0.5));
        assert!(material.double_sided);
    }
    let mesh = &scene.meshes[0];
    assert_eq!(mesh.positions.len(), 3 * mesh.triangles.len(), "flat: nothing is shared");
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|i| mesh.positions[i as usize]);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        for &index in triangle {
            assert!(normal == Vec3::ZERO || mesh.normals[index as usize].dot(normal) > 0.999);
        }
    }
    // renders.json: "quad y=0.032987, x in [-.4168,.3832], z in [-.4,.4]".
    let bounds = scene.bounds().unwrap();
    assert!((bounds.min - Vec3::new(-0.4168, 0.032_987, -0.4)).length() < 1e-5, "{bounds:?}");
}

#[test]
fn obj_and_ply_twins_of_real_files_have_vertex_normals_where_the_file_does() {
    let Some(path) = data_file("models/triceratops.obj") else { return };
    let scene = open(&path).scene;
    assert_eq!(scene.meshes[0].positions.len(), 2_832, "smooth: vertices are shared");
    let Some(path) = data_file("models/spot.obj") else { return };
    let spot = open(&path).scene;
    assert_eq!(spot.meshes[0].uvs[0].len(), spot.meshes[0].positions.len());
    let Some(path) = data_file("models/horse_48485v.ply") else { return };
    let horse = open(&path).scene;
    assert!(!horse.meshes[0].colors.is_empty());
    assert_eq!(horse.materials[0].surface.base_color, Vec3::ONE);
}

/// World bounds of skinned models with every vertex moved by its joints as section 3.7.3.3 of the specification has
/// it, evaluated apart from this crate (NumPy, double precision).
#[test]
fn skinned_models_stand_in_their_rest_pose() {
    for (name, min, max) in [
        (
            "models/Fox.glb",
            Vec3::new(-12.592_719, -0.121_744, -88.095_01),
            Vec3::new(12.592_717, 78.907_2, 66.624_86),
        ),
        (
            "models/BrainStem.glb",
            Vec3::new(-1.252_14, -0.000_555_6, -0.341_388),
            Vec3::new(1.162_522, 1.834_357, 0.255_720),
        ),
        ("models/SimpleSkin.gltf", Vec3::new(-0.5, 0.0, 0.0), Vec3::new(0.5, 2.0, 0.0)),
    ] {
        let Some(path) = data_file(name) else { return };
        let bounds = open(&path).scene.bounds().unwrap();
        let tolerance = 1e-4 * (max - min).max_element();
        assert!((bounds.min - min).abs().max_element() < tolerance, "{name}: {bounds:?}");
        assert!((bounds.max - max).abs().max_element() < tolerance, "{name}: {bounds:?}");
    }
}
