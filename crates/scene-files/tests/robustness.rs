//! No bytes whatever may bring a loader down: random ones, and truncated or mutated copies of good files.
#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests fail the test")]

use std::path::Path;
use std::sync::LazyLock;

use gnomon_scene::Camera;
use gnomon_scene_files::{LoadOptions, load};
use proptest::prelude::*;

const OBJ: &[u8] = b"mtllib none.mtl\nv 0 0 0 0.5 0.5 0.5\nv 1 0 0\nv 0 1 0\nvt 0 1\nvn 0 0 1\nusemtl a\nf 1/1/1 2/1/1 -1/1/1\nf 1 2 3 1\n";

const PLY_ASCII: &[u8] = b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0 255 0 0\n1 0 0 0 255 0\n0 1 0 0 0 255\n3 0 1 2\n";

static PLY_BINARY: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let mut bytes = b"ply\nformat binary_big_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n".to_vec();
    for x in [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0] {
        bytes.extend(x.to_be_bytes());
    }
    bytes.push(3);
    for i in 0..3_u32 {
        bytes.extend(i.to_be_bytes());
    }
    bytes
});

/// A skinned, morphed, animated, textured triangle with a sparse accessor and a camera.
static GLB: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let mut binary: Vec<u8> = Vec::new();
    for x in [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0] {
        binary.extend(x.to_le_bytes());
    }
    for i in [0_u16, 1, 2, 0] {
        binary.extend(i.to_le_bytes());
    }
    binary.extend([0; 12]);
    binary.extend([255, 0, 0, 0].repeat(3));
    let png_start = binary.len();
    let mut png = std::io::Cursor::new(Vec::new());
    image::RgbaImage::from_pixel(2, 2, image::Rgba([9, 8, 7, 6]))
        .write_to(&mut png, image::ImageFormat::Png)
        .unwrap();
    binary.extend(png.into_inner());
    let png_length = binary.len() - png_start;
    binary.resize(binary.len().next_multiple_of(4), 0);
    let mut json = serde_json::json!({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1]}],
        "nodes": [{"mesh": 0, "skin": 0, "children": [2]}, {"camera": 0, "translation": [0, 0, 3]}, {"rotation": [0, 0, 0, 1]}],
        "skins": [{"joints": [2]}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.1}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 4, "JOINTS_0": 2, "WEIGHTS_0": 3},
                                    "indices": 1, "material": 0, "targets": [{"POSITION": 0, "NORMAL": 0}]}], "weights": [0.5]}],
        "animations": [{"channels": [{"sampler": 0, "target": {"node": 2, "path": "translation"}},
                                     {"sampler": 1, "target": {"node": 0, "path": "weights"}},
                                     {"sampler": 2, "target": {"node": 2, "path": "rotation"}}],
                        "samplers": [{"input": 5, "output": 0}, {"input": 5, "output": 5, "interpolation": "STEP"},
                                     {"input": 6, "output": 7, "interpolation": "CUBICSPLINE"}]}],
        "materials": [{"normalTexture": {"index": 0}, "alphaMode": "MASK"}],
        "textures": [{"source": 0}], "images": [{"bufferView": 4, "mimeType": "image/png"}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "sparse": {"count": 1,
                "indices": {"bufferView": 1, "byteOffset": 2, "componentType": 5123}, "values": {"bufferView": 0}}},
            {"bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR"},
            {"bufferView": 2, "componentType": 5121, "count": 3, "type": "VEC4"},
            {"bufferView": 3, "componentType": 5121, "normalized": true, "count": 3, "type": "VEC4"},
            {"componentType": 5126, "count": 3, "type": "VEC2"},
            // Times and weights: three times 0, and one key of a spline.
            {"componentType": 5126, "count": 3, "type": "SCALAR"},
            {"bufferView": 0, "byteOffset": 12, "componentType": 5126, "count": 1, "type": "SCALAR"},
            {"bufferView": 3, "componentType": 5121, "normalized": true, "count": 3, "type": "VEC4"}],
        "bufferViews": [
            {"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 8},
            {"buffer": 0, "byteOffset": 44, "byteLength": 12}, {"buffer": 0, "byteOffset": 56, "byteLength": 12},
            {"buffer": 0, "byteOffset": png_start, "byteLength": png_length}],
        "buffers": [{"byteLength": binary.len()}]
    })
    .to_string()
    .into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut glb = b"glTF\x02\0\0\0".to_vec();
    glb.extend((28 + json.len() as u32 + binary.len() as u32).to_le_bytes());
    glb.extend((json.len() as u32).to_le_bytes());
    glb.extend(b"JSON");
    glb.extend(json);
    glb.extend((binary.len() as u32).to_le_bytes());
    glb.extend(b"BIN\0");
    glb.extend(binary);
    glb
});

const TOML: &[u8] = b"ground = \"plane\"\n[camera]\neye = [1, 2, 3]\ntarget = [0, 0, 0]\nfov = 40\n[environment]\nbuiltin = \"sky\"\n[material.a]\nroughness = 0.5\n[[model]]\nbuiltin = \"three-boxes\"\nrotation = [0, 10, 0]\nscale = 2\nmaterial = \"a\"\n[[light]]\nshape = \"rectangle\"\nsize = [2, 1]\nposition = [0, 3, 0]\ntarget = [1, 0, 0]\nradiance = [5, 4, 3]\n";

/// A U, textured, with colours, comments and lines that are left out.
const OBJ_ODD: &[u8] = b"mtllib \"a b.mtl\" c.mtl\nusemtl Material #25\nv 0 0 0 255 0 9\r\nv 3,0 0 0\rv 3 3 0\nv 2 3 0\nv 2 1 0\nv 1 1 0\nv 1 3 0\nv 0 3 0\nvt 0 1\nvn -1.#IND 0 0\nf 1/1/0 2/7 3//1 4 5 6 7 \\\n 8\nl 1 2\ncurv 0 1 1 2\n";

/// Texture coordinates of corners, colours of faces, surplus numbers, a comment among the rows.
const PLY_ODD: &[u8] = b"ply\nformat ascii 1.0\ncomment TextureFile none.png\nwritten by hand\nelement face 2\nproperty list uchar int64 vertex_indices\nproperty list uchar float texcoord\nproperty int texnumber\nproperty float red\nproperty float green\nproperty float blue\nelement vertex 4\nproperty double x\nproperty double y\nproperty double z\nend_header\n4 0 1 2 3 8 0 0 1 0 1 1 0 1 0 255 9 0 7 7\ncomment here\n3 0 1 2 6 0 0 1 0 1 1 1 0 0 255\n500000 0 4500000\n500001 0 4500000\n500000.25 0.25 4500000\n500000 1 4500000\n";

const STL_ASCII: &[u8] = b"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n";

/// Two coloured triangles.
static STL_BINARY: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let mut bytes = b"solid COLOR=\x10\x20\x30\xff".to_vec();
    bytes.resize(80, b' ');
    bytes.extend(2_u32.to_le_bytes());
    for color in [0x001f_u16, 0x8000] {
        for x in [0.0_f32, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0] {
            bytes.extend(x.to_le_bytes());
        }
        bytes.extend(color.to_le_bytes());
    }
    bytes
});

fn seeds() -> [(&'static str, Vec<u8>); 9] {
    [
        ("odd.obj", OBJ_ODD.to_vec()),
        ("odd.ply", PLY_ODD.to_vec()),
        ("seed.stl", STL_ASCII.to_vec()),
        ("seed.STL", STL_BINARY.clone()),
        ("seed.obj", OBJ.to_vec()),
        ("seed.ply", PLY_ASCII.to_vec()),
        ("seed.PLY", PLY_BINARY.clone()),
        ("seed.glb", GLB.clone()),
        ("seed.toml", TOML.to_vec()),
    ]
}

/// Loads the bytes; whatever loads keeps what [`gnomon_scene::Scene`] promises.
fn attempt(folder: &Path, name: &str, bytes: &[u8]) {
    let path = folder.join(name);
    std::fs::write(&path, bytes).unwrap();
    let options = LoadOptions { memory_limit: 1 << 26, ..LoadOptions::default() };
    match load(&path, &options) {
        Ok(loaded) => {
            let mut scene = loaded.scene;
            for (clip, time) in (0..scene.animations.len()).flat_map(|clip| [(clip, 0.0), (clip, 0.7)]) {
                // It moves or says why not; either way the scene is whole.
                let _ = scene.animate(clip, time);
                let pose = scene.pose();
                for instance in scene.instances() {
                    scene.world_vertices(&pose, &instance);
                }
            }
            scene.rest();
            let scene = &scene;
            for mesh in &scene.meshes {
                assert!(
                    mesh.triangles.iter().flatten().all(|&index| (index as usize) < mesh.positions.len())
                );
                assert_eq!(mesh.normals.len(), mesh.positions.len());
                assert!(mesh.normals.iter().all(|normal| normal.is_normalized()));
                assert!(mesh.positions.iter().all(|position| position.is_finite()));
            }
            assert!(scene.lights.iter().all(|light| light.node.0 < scene.nodes.len()));
            for light in scene.placed_lights() {
                assert!(
                    light.normal.is_normalized() && light.center.is_finite() && light.radiance.is_finite()
                );
            }
            assert!(scene.bounds().is_none_or(|bounds| bounds.min.is_finite() && bounds.max.is_finite()));
            assert!(gnomon_scene::default_camera(scene, 1.5).world_from_camera.is_finite());
            assert!(scene.cameras.iter().all(|camera| camera.world_from_camera.is_finite()));
        }
        Err(error) => assert!(!error.to_string().contains('\n'), "{error}"),
    }
}

#[test]
fn the_seeds_themselves_load() {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in seeds() {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        let loaded = load(&path, &LoadOptions::default()).unwrap_or_else(|error| panic!("{error}"));
        assert!(loaded.scene.triangle_count() > 0, "{name}");
        if name.ends_with("glb") {
            let channels: usize = loaded.scene.animations.iter().map(|clip| clip.channels.len()).sum();
            assert_eq!((channels, loaded.scene.skins.len()), (3, 1), "{:?}", loaded.scene.warnings);
        }
    }
}

#[test]
fn every_truncation_ends_well() {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in seeds() {
        for length in 0..bytes.len() {
            attempt(folder.path(), name, &bytes[..length]);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn mutated_files_end_well(edits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6)) {
        let folder = tempfile::tempdir().unwrap();
        for (name, mut bytes) in seeds() {
            for (place, value) in &edits {
                let place = place.index(bytes.len());
                bytes[place] = *value;
            }
            attempt(folder.path(), name, &bytes);
        }
    }

    /// Digits for digits and signs: text formats stay readable and their numbers go wrong.
    #[test]
    fn wrong_numbers_end_well(edits in prop::collection::vec((any::<prop::sample::Index>(), 0..12_usize), 1..4)) {
        let folder = tempfile::tempdir().unwrap();
        for (name, mut bytes) in seeds() {
            let digits: Vec<usize> = (0..bytes.len()).filter(|&i| bytes[i].is_ascii_digit()).collect();
            for (place, symbol) in &edits {
                bytes[digits[place.index(digits.len())]] = b"0123456789-."[*symbol];
            }
            attempt(folder.path(), name, &bytes);
        }
    }

    #[test]
    fn random_bytes_end_well(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        let folder = tempfile::tempdir().unwrap();
        for (name, seed) in seeds() {
            attempt(folder.path(), name, &bytes);
            // Behind a good beginning.
            let mut tail = seed[..seed.len().min(60)].to_vec();
            tail.extend(&bytes);
            attempt(folder.path(), name, &tail);
        }
    }

    #[test]
    fn random_camera_descriptions_end_well(text in "[eyetargfov=;,.0-9 -]{0,60}") {
        if let Ok(camera) = text.parse::<Camera>() {
            prop_assert!(camera.world_from_camera.is_finite());
        }
    }
}
