//! glTF features, one small document each.
#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests fail the test")]

mod documents;

use glam::{Vec2, Vec3, Vec4};
use gnomon_scene::{AlphaMode, Projection};
use gnomon_scene_files::{LoadOptions, load};
use serde_json::{Value, json};

use self::documents::{add_accessor, pixel, read, refusal, triangle};

#[test]
fn a_triangle_without_normals_or_material_is_flat_rough_white_metal() {
    let scene = read(&triangle(|_| ())).scene;
    assert_eq!(scene.meshes[0].normals, [Vec3::Z; 3]);
    let surface = scene.materials[scene.meshes[0].material.unwrap().0].surface;
    assert_eq!((surface.metallic, surface.roughness, surface.base_color), (1.0, 1.0, Vec3::ONE));
    assert!(scene.warnings.is_empty());
}

#[test]
fn specular_is_one_unless_the_extension_says_otherwise() {
    let surface = |material: Value| {
        let scene = read(&triangle(|d| {
            d["materials"] = json!([material]);
            d["meshes"][0]["primitives"][0]["material"] = json!(0);
        }))
        .scene;
        scene.materials[0].surface
    };
    assert_eq!(surface(json!({})).specular, 1.0);
    assert_eq!(surface(json!({})).ior, 1.5);
    let lambert = surface(json!({"extensions": {"KHR_materials_specular": {"specularFactor": 0.0}}}));
    assert_eq!(lambert.specular, 0.0);
    let tinted = surface(json!({"extensions": {
        "KHR_materials_specular": {"specularColorFactor": [1.5, 0.5, 0.25]}, "KHR_materials_ior": {"ior": 1.33}}}));
    assert_eq!(tinted.specular, 1.0);
    assert_eq!(tinted.specular_color, Vec3::new(1.5, 0.5, 0.25));
    assert_eq!(tinted.ior, 1.33);
}

#[test]
fn materials_keep_factors_alpha_and_emission() {
    let scene = read(&triangle(|d| {
        d["materials"] = json!([
            {"name": "glow", "emissiveFactor": [1.0, 0.5, 0.0], "doubleSided": true, "alphaMode": "MASK",
             "pbrMetallicRoughness": {"baseColorFactor": [0.1, 0.2, 0.3, 0.4], "metallicFactor": 0.25, "roughnessFactor": 0.75},
             "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 4.0}}},
            {"alphaMode": "BLEND"}
        ]);
    }))
    .scene;
    let material = &scene.materials[0];
    assert_eq!(material.name, "glow");
    assert_eq!(material.emissive, Vec3::new(4.0, 2.0, 0.0));
    assert_eq!(material.alpha_mode, AlphaMode::Mask { cutoff: 0.5 });
    assert_eq!((material.alpha, material.double_sided), (0.4, true));
    assert_eq!(material.surface.base_color, Vec3::new(0.1, 0.2, 0.3));
    assert_eq!((material.surface.metallic, material.surface.roughness), (0.25, 0.75));
    // Nothing of it lets anything through.
    assert_eq!(scene.materials[1].alpha_mode, AlphaMode::Opaque);
}

#[test]
fn texture_transforms_turn_counter_clockwise_scale_first_and_move_last() {
    let scene = read(&triangle(|d| {
        d["images"] = json!([{"uri": pixel([255; 4])}]);
        d["samplers"] = json!([{"wrapS": 33071, "wrapT": 33648, "magFilter": 9728}]);
        d["textures"] = json!([{"source": 0, "sampler": 0}]);
        d["materials"] = json!([{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0, "texCoord": 0,
            "extensions": {"KHR_texture_transform": {
                "offset": [0.1, 0.2], "rotation": std::f32::consts::FRAC_PI_2, "scale": [2.0, 3.0], "texCoord": 1}}}}}]);
    }))
    .scene;
    let texture = scene.materials[0].base_color_texture.unwrap();
    assert_eq!(texture.set, 1, "the extension's set goes before the texture's");
    // Counter-clockwise as the picture is seen: (1, 0), to the right, turns up, which is -v.
    let near = |uv: Vec2, expected: Vec2| assert!((texture.transform(uv) - expected).length() < 1e-6, "{uv}");
    near(Vec2::ZERO, Vec2::new(0.1, 0.2));
    near(Vec2::new(1.0, 0.0), Vec2::new(0.1, 0.2 - 2.0));
    near(Vec2::new(0.0, 1.0), Vec2::new(0.1 + 3.0, 0.2));
    let texels = &scene.textures[0];
    assert_eq!(texels.wrap, [gnomon_scene::Wrap::ClampToEdge, gnomon_scene::Wrap::MirroredRepeat]);
    assert!(texels.nearest);
}

#[test]
fn a_normal_map_brings_tangents() {
    let scene = read(&triangle(|d| {
        d["images"] = json!([{"uri": pixel([128, 128, 255, 255])}]);
        d["textures"] = json!([{"source": 0}]);
        d["materials"] = json!([{"normalTexture": {"index": 0, "scale": 0.5}}]);
        d["meshes"][0]["primitives"][0]["material"] = json!(0);
    }))
    .scene;
    assert_eq!(scene.materials[0].normal_scale, 0.5);
    // u runs along +x; v runs along +y, so the picture hangs upside down: the bitangent N x T w points to -y.
    assert_eq!(scene.meshes[0].tangents, [Vec4::new(1.0, 0.0, 0.0, -1.0); 3]);
}

#[test]
fn strips_and_fans_keep_their_orientation() {
    let square: [f32; 12] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0];
    let bytes: Vec<u8> = square.iter().flat_map(|x| x.to_le_bytes()).collect();
    for (mode, indices) in [(5, [0_u8, 1, 2, 3]), (6, [0, 1, 3, 2])] {
        let document = triangle(|d| {
            let positions = add_accessor(d, &bytes, 5126, 4, "VEC3");
            let indices = add_accessor(d, &indices, 5121, 4, "SCALAR");
            d["meshes"][0]["primitives"] =
                json!([{"attributes": {"POSITION": positions}, "indices": indices, "mode": mode}]);
        });
        let scene = read(&document).scene;
        assert_eq!(scene.triangle_count(), 2);
        assert_eq!(scene.meshes[0].normals, [Vec3::Z; 6], "mode {mode}");
    }
}

#[test]
fn sparse_and_normalized_accessors_read_as_specified() {
    let scene = read(&triangle(|d| {
        let colors = add_accessor(d, &[255, 0, 51, 255, 0, 0, 0, 0, 0, 255, 0, 102], 5121, 3, "VEC4");
        d["accessors"][colors]["normalized"] = json!(true);
        let values: Vec<u8> = [5.0_f32, 6.0, 7.0].iter().flat_map(|x| x.to_le_bytes()).collect();
        let (places, values) =
            (add_accessor(d, &[2], 5121, 1, "SCALAR"), add_accessor(d, &values, 5126, 1, "VEC3"));
        let view = |d: &Value, accessor: usize| d["accessors"][accessor]["bufferView"].clone();
        d["accessors"][0]["sparse"] = json!({"count": 1,
            "indices": {"bufferView": view(d, places), "componentType": 5121},
            "values": {"bufferView": view(d, values)}});
        d["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(colors);
    }))
    .scene;
    assert_eq!(scene.meshes[0].positions[2], Vec3::new(5.0, 6.0, 7.0));
    assert_eq!(scene.meshes[0].positions[1], Vec3::X);
    assert_eq!(scene.meshes[0].colors[0], Vec4::new(1.0, 0.0, 0.2, 1.0));
    assert_eq!(scene.meshes[0].colors[2], Vec4::new(0.0, 1.0, 0.0, 0.4));
}

#[test]
fn morph_targets_have_their_default_weights() {
    let scene = read(&triangle(|d| {
        let offsets: Vec<u8> = [0.0_f32, 0.0, 4.0].repeat(3).iter().flat_map(|x| x.to_le_bytes()).collect();
        let target = add_accessor(d, &offsets, 5126, 3, "VEC3");
        d["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": target}]);
        d["meshes"][0]["weights"] = json!([0.25]);
        d["scenes"][0]["nodes"] = json!([0, 1]);
        d["nodes"] = json!([{"mesh": 0}, {"mesh": 0, "weights": [1.0]}]);
    }))
    .scene;
    assert_eq!(scene.meshes.len(), 1, "both show the same mesh");
    let pose = scene.pose();
    let z: Vec<f32> =
        scene.instances().iter().map(|i| scene.world_vertices(&pose, i).positions[0].z).collect();
    assert_eq!(z, [1.0, 4.0]);
}

#[test]
fn the_hierarchy_is_kept_and_meshes_are_shared() {
    let scene = read(&triangle(|d| {
        d["nodes"] = json!([
            {"name": "root", "translation": [1, 0, 0], "children": [2, 1]},
            {"mesh": 0, "scale": [2, 2, 2]},
            {"mesh": 0, "matrix": [0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 0, 5, 0, 1]}
        ]);
    }))
    .scene;
    assert_eq!(scene.nodes.len(), 3);
    assert_eq!(scene.meshes.len(), 1);
    assert_eq!(scene.nodes[1].parent.map(|id| id.0), Some(0));
    let world = scene.world_from_nodes();
    // The matrix turns by a quarter about z and lifts by 5.
    assert!((world[1].transform_point3(Vec3::X) - Vec3::new(1.0, 6.0, 0.0)).length() < 1e-6);
    assert!((world[2].transform_point3(Vec3::X) - Vec3::new(3.0, 0.0, 0.0)).length() < 1e-6);
}

#[test]
fn cameras_take_the_nodes_place_without_its_scale() {
    let document = triangle(|d| {
        d["nodes"] = json!([{"name": "view", "camera": 0, "scale": [3, 3, 3], "translation": [0, 0, 7]},
                            {"camera": 1}]);
        d["scenes"][0]["nodes"] = json!([0, 1]);
        d["cameras"] = json!([
            {"type": "perspective", "perspective": {"yfov": 1.0, "aspectRatio": 2.0, "znear": 0.1}},
            {"type": "orthographic", "name": "plan", "orthographic": {"xmag": 3.0, "ymag": 1.0, "zfar": 9.0, "znear": 0.1}}
        ]);
    });
    let scene = read(&document).scene;
    let view = scene.camera(Some("view")).unwrap();
    let Projection::Perspective { fov_x } = view.projection else { panic!("perspective") };
    assert!(((0.5 * fov_x).tan() - 2.0 * 0.5_f32.tan()).abs() < 1e-6);
    assert_eq!(view.world_from_camera, glam::Mat4::from_translation(Vec3::new(0.0, 0.0, 7.0)));
    assert_eq!(scene.camera(Some("plan")).unwrap().projection, Projection::Orthographic { half_width: 3.0 });
    assert_eq!(scene.camera(None).unwrap().name, "view");
}

#[test]
fn scenes_without_meshes_are_empty_scenes() {
    let scene = read(&json!({"asset": {"version": "2.0"}})).scene;
    assert_eq!((scene.triangle_count(), scene.cameras.len()), (0, 0));
    assert_eq!(scene.bounds(), None);
    assert!(scene.warnings[0].contains("nothing will be seen of it"), "{:?}", scene.warnings);
}

#[test]
fn unknown_required_extensions_are_named() {
    let names = ["VENDOR_magic", "KHR_texture_transform"];
    let error = refusal(&triangle(|d| d["extensionsRequired"] = json!(names)));
    assert!(error.contains("requires the extension VENDOR_magic"), "{error}");
    assert!(!error.contains("KHR_texture_transform"), "{error}");
    let loaded = read(&triangle(|d| d["extensionsUsed"] = json!(["VENDOR_magic"])));
    assert!(loaded.scene.warnings[0].contains("VENDOR_magic"));
}

#[test]
fn files_beside_the_document_are_found_and_others_refused() {
    let folder = tempfile::tempdir().unwrap();
    let mut document = triangle(|_| ());
    let uri = document["buffers"][0]["uri"].as_str().unwrap().to_owned();
    use base64::Engine;
    let bytes = base64::engine::general_purpose::STANDARD.decode(uri.split_once(',').unwrap().1).unwrap();
    std::fs::write(folder.path().join("a b.bin"), bytes).unwrap();
    let path = folder.path().join("document.gltf");
    let mut at = |uri: &str| {
        document["buffers"][0]["uri"] = json!(uri);
        std::fs::write(&path, serde_json::to_vec(&document).unwrap()).unwrap();
        load(&path, &LoadOptions::default())
    };
    assert_eq!(at("a%20b.bin").unwrap().scene.triangle_count(), 1);
    for (uri, reason) in [
        ("missing.bin", "cannot read"),
        ("/etc/hostname", "relative"),
        ("file:///etc/hostname", "relative"),
        ("https://example.com/a.bin", "relative"),
        ("a%2", "cannot read"),
        ("", "is no URI"),
        (".", "regular file"),
    ] {
        let error = at(uri).unwrap_err().to_string();
        assert!(error.contains(reason), "{uri}: {error}");
    }
}

#[test]
fn huge_promises_are_refused_before_anything_is_allocated() {
    let huge = 1_u64 << 40;
    let cases = [
        triangle(|d| d["accessors"][0]["count"] = json!(huge)),
        triangle(|d| {
            d["accessors"][0]["count"] = json!(huge);
            d["accessors"][0].as_object_mut().unwrap().remove("bufferView");
        }),
        triangle(|d| d["bufferViews"][0]["byteLength"] = json!(u64::MAX)),
        triangle(|d| d["bufferViews"][0]["byteStride"] = json!(u64::MAX)),
        triangle(|d| d["buffers"][0]["byteLength"] = json!(huge)),
        triangle(|d| d["accessors"][0]["byteOffset"] = json!(u64::MAX)),
        triangle(|d| d["nodes"][0]["scale"] = json!([1e30, 1e30, 1e30])),
    ];
    for document in &cases {
        let error = refusal(document);
        assert!(!error.contains('\n'), "{error}");
    }
}

/// Node chains as long as a file can hold are walked without recursion.
#[test]
fn deep_hierarchies_do_not_overflow_the_stack() {
    let document = triangle(|d| {
        let deep = 100_000;
        let mut nodes: Vec<Value> = (1..deep).map(|child| json!({"children": [child]})).collect();
        nodes.push(json!({"mesh": 0}));
        d["nodes"] = json!(nodes);
    });
    assert_eq!(read(&document).scene.triangle_count(), 1);
}

/// There is no ratified extension for heights: a material's extras hold them.
#[test]
fn heights_are_read_from_extras() {
    let material = |extras: Value| {
        let scene = read(&triangle(|d| {
            d["images"] = json!([{"uri": pixel([51; 4])}]);
            d["samplers"] = json!([{"wrapS": 33071}]);
            d["textures"] = json!([{"source": 0, "sampler": 0}]);
            d["materials"] = json!([{"extras": extras}]);
            d["meshes"][0]["primitives"][0]["material"] = json!(0);
        }))
        .scene;
        (scene.materials[0].height, scene)
    };
    let info =
        json!({"index": 0, "texCoord": 1, "extensions": {"KHR_texture_transform": {"scale": [2.0, 2.0]}}});
    let (height, scene) = material(json!({"gnomon_height": {"texture": info, "scale": 0.25}}));
    let height = height.unwrap();
    assert_eq!((height.scale, height.set, height.transform(Vec2::ONE)), (0.25, 1, Vec2::splat(2.0)));
    let wrap = scene.height_maps[height.map.0].wrap();
    assert_eq!(wrap, [gnomon_scene::Wrap::ClampToEdge, gnomon_scene::Wrap::Repeat]);
    assert_eq!(material(json!({"author": "someone"})).0, None);
    for broken in [json!({"scale": 1.0}), json!("bumps"), json!({"texture": {"index": 0}, "scale": 1e40})] {
        let (height, scene) = material(json!({"gnomon_height": broken}));
        assert!(height.is_none() && scene.warnings.len() == 1, "{:?}", scene.warnings);
    }
}
