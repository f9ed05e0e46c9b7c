//! glTF as tools really write it: what is said badly is read as it is meant, and a picture that cannot be had takes no model with it.
#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests fail the test")]

mod documents;

use std::path::Path;

use glam::{Vec2, Vec3, Vec4};
use gnomon_scene::{Projection, Scene};
use gnomon_scene_files::{LoadOptions, load, load_bytes};
use serde_json::{Value, json};

use self::documents::{add_accessor, attempt, bytes, embedded, pixel, read, refusal, triangle};

fn loaded(name: &str, content: &[u8]) -> Result<Scene, String> {
    let files = std::collections::HashMap::new();
    let options = LoadOptions::default();
    load_bytes(Path::new(name), content, &files, &options).map(|l| l.scene).map_err(|error| error.to_string())
}

/// A GLB of a document's text and a binary chunk.
fn glb(json: &[u8], padding: u8) -> Vec<u8> {
    let mut json = json.to_vec();
    json.resize(json.len().next_multiple_of(4), padding);
    let mut glb = b"glTF\x02\0\0\0".to_vec();
    glb.extend((20 + json.len() as u32).to_le_bytes());
    glb.extend((json.len() as u32).to_le_bytes());
    glb.extend(b"JSON");
    glb.extend(json);
    glb
}

/// The triangle with a base colour texture of that picture.
fn textured(image: Value) -> Value {
    triangle(|d| {
        d["images"] = json!([image]);
        d["textures"] = json!([{"source": 0}]);
        d["materials"] = json!([{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]);
        d["meshes"][0]["primitives"][0]["material"] = json!(0);
    })
}

fn texel(document: &Value) -> Option<[u8; 4]> {
    read(document).scene.textures.first().map(|texture| texture.rgba8[0])
}

#[test]
fn a_picture_that_cannot_be_had_is_left_out_with_a_warning() {
    let data = |bytes: &[u8]| embedded(bytes);
    let webp = b"RIFF\x1a\0\0\0WEBPVP8L\x0d\0\0\0\x2f\0\0\0\x10\x07\x10\x11\x11\x88\x88\xfe\x07\0";
    for (image, reason) in [
        (json!({"uri": "https://example.com/a.png"}), "web address"),
        (json!({"uri": "C:\\work\\a.png"}), "not a path relative"),
        (json!({"uri": "missing.png"}), "cannot read"),
        (json!({"uri": data(b"")}), "no bytes"),
        (json!({"uri": data(b"GIF89a")}), "neither PNG"),
        (json!({"uri": data(b"\x89PNG\r\n\x1a\ncut")}), "image 0"),
        (json!({"uri": data(&[0xff, 0xd8, 0xff, 0xe0, 0, 4])}), "image 0"),
        (json!({"uri": data(webp)}), "EXT_texture_webp"),
        (json!({"uri": "data:image/png;base64,***"}), "base64"),
        (json!({"bufferView": 99}), "buffer view 99"),
        (json!({}), "neither a URI nor"),
        (Value::Null, "neither a URI nor"),
    ] {
        let scene = read(&textured(image.clone())).scene;
        assert_eq!((scene.triangle_count(), scene.textures.len()), (1, 0), "{image}");
        let warning = &scene.warnings[0];
        assert!(warning.starts_with("texture 0 is left out") && warning.contains(reason), "{warning}");
        assert_eq!(scene.materials[0].base_color_texture, None);
    }
    // A document that refers to nothing is damaged all the same.
    let mut document = textured(json!({"uri": pixel([1; 4])}));
    document["textures"][0]["source"] = json!(7);
    assert!(refusal(&document).contains("refers to image 7"));
}

#[test]
fn pictures_are_found_by_the_names_that_tools_write() {
    let folder = tempfile::tempdir().unwrap();
    let picture = image::RgbaImage::from_pixel(1, 1, image::Rgba([10, 20, 30, 255]));
    std::fs::create_dir(folder.path().join("sub")).unwrap();
    for name in ["50% grey.png", "a b.png", " c.png", "sub/t.png", "%41.png"] {
        picture.save_with_format(folder.path().join(name), image::ImageFormat::Png).unwrap();
    }
    let path = folder.path().join("document.gltf");
    for uri in [
        "50% grey.png",
        "50%25%20grey.png",
        "a b.png",
        "a%20b.png",
        " c.png",
        "sub\\t.png",
        "./sub%5Ct.png",
        "%41.png",
    ] {
        std::fs::write(&path, textured(json!({"uri": uri})).to_string()).unwrap();
        let scene = load(&path, &LoadOptions::default()).unwrap().scene;
        assert_eq!(scene.textures.len(), 1, "{uri}: {:?}", scene.warnings);
        assert!(scene.warnings.is_empty());
    }
}

#[test]
fn small_pictures_may_carry_notes() {
    // Longer than the texels by far.
    let mut png = Vec::new();
    let picture = image::RgbaImage::from_pixel(2, 2, image::Rgba([10, 20, 30, 40]));
    picture.write_to(&mut std::io::Cursor::new(&mut png), image::ImageFormat::Png).unwrap();
    let mut note = b"tEXtComment\0".to_vec();
    note.resize(100_000, b'x');
    let mut chunk = (note.len() as u32 - 4).to_be_bytes().to_vec();
    chunk.extend(&note);
    chunk.extend(crc32(&note).to_be_bytes());
    // After the header.
    png.splice(33..33, chunk);
    assert_eq!(texel(&textured(json!({"uri": embedded(&png)}))), Some([10, 20, 30, 40]));
}

fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| (crc >> 1) ^ (0xedb8_8320 & (crc & 1).wrapping_neg()))
    })
}

#[test]
fn a_webp_is_read_where_the_extension_names_it() {
    let mut webp = Vec::new();
    let picture = image::RgbaImage::from_pixel(1, 1, image::Rgba([10, 20, 30, 255]));
    picture.write_to(&mut std::io::Cursor::new(&mut webp), image::ImageFormat::WebP).unwrap();
    let document = |source: Value| {
        let mut document = textured(json!({"uri": embedded(&webp)}));
        document["images"].as_array_mut().unwrap().push(json!({"uri": pixel([1, 2, 3, 255])}));
        document["textures"] = json!([{"source": source, "extensions": {"EXT_texture_webp": {"source": 0}}}]);
        document["extensionsRequired"] = json!(["EXT_texture_webp"]);
        document
    };
    assert_eq!(texel(&document(Value::Null)), Some([10, 20, 30, 255]));
    assert_eq!(texel(&document(json!(1))), Some([1, 2, 3, 255]));
}

#[test]
fn documents_are_read_as_they_are_meant() {
    let plain = read(&triangle(|_| ())).scene;
    let text = triangle(|_| ()).to_string();
    let same = |name: &str, content: &[u8]| {
        let mut scene = loaded(name, content).unwrap_or_else(|error| panic!("{error}"));
        scene.nodes.iter_mut().for_each(|node| node.name.clear());
        scene.warnings.clear();
        assert_eq!(scene, plain, "{}", String::from_utf8_lossy(content));
    };
    same("a.glb", &glb(text.as_bytes(), 0));
    same("a.glb", &glb(text.as_bytes(), b' '));
    same("a.gltf", text.replace(r#"{"mesh":0}"#, r#"{"mesh":9,"name":"a","mesh":0,"name":"b"}"#).as_bytes());
    let nulls = r#"{"mesh":0,"children":null,"skin":null,"extensions":null,"weights":null,"matrix":null}"#;
    same("a.gltf", text.replace(r#"{"mesh":0}"#, nulls).as_bytes());
    same("a.gltf", text.replace(r#"{"mesh":0}"#, r#"{"mesh":0,"name":"\ud800x"}"#).as_bytes());
    let mut latin = text.replace(r#"{"mesh":0}"#, r#"{"mesh":0,"name":"?"}"#).into_bytes();
    *latin.iter_mut().find(|byte| **byte == b'?').unwrap() = 0xfc;
    same("a.gltf", &latin);
    same("a.gltf", text.replace(r#""version":"2.0""#, r#""version":2.0"#).as_bytes());
}

#[test]
fn a_null_node_is_an_empty_one() {
    let scene = read(&triangle(|d| {
        d["nodes"] = json!([null, {"mesh": 0, "children": [0, null]}]);
        d["scenes"] = json!([{"nodes": [1, null]}]);
    }))
    .scene;
    assert_eq!((scene.nodes.len(), scene.triangle_count()), (2, 1));
}

#[test]
fn scenes_may_list_their_nodes_children_too() {
    let listing = |nodes: Value| {
        triangle(|d| {
            d["nodes"] = json!([{"children": [1], "translation": [1, 0, 0]}, {"mesh": 0}]);
            d["scenes"] = json!([{"nodes": nodes}]);
        })
    };
    for nodes in [json!([0, 1]), json!([1, 0]), json!([0, 0])] {
        let scene = read(&listing(nodes)).scene;
        assert_eq!((scene.nodes.len(), scene.world_from_nodes()[1].translation.x), (2, 1.0));
    }
    // Unity's exporter leaves the node above all others out.
    let scene = read(&listing(json!([1]))).scene;
    assert_eq!((scene.triangle_count(), scene.world_from_nodes()[0].translation.x), (1, 0.0));
    assert!(scene.warnings[0].contains("lists node 1, but not its parent, node 0"), "{:?}", scene.warnings);
}

#[test]
fn what_is_no_gltf_2_says_so_plainly() {
    let first = json!({"asset": {"version": "1.0"}, "nodes": {"a": {}}, "meshes": {}});
    let mut older = first.clone();
    older["asset"] = json!({});
    for document in [&first, &older, &json!({"asset": {"version": 1}})] {
        let error = refusal(document);
        assert!(error.contains("this is glTF version 1") && error.contains("convert it to 2.0"), "{error}");
    }
    let error = loaded("a.glb", b"glTF\x01\0\0\0\x14\0\0\0\0\0\0\0\0\0\0\0").unwrap_err();
    assert!(error.contains("this is glTF version 1.0") && error.contains("convert it to 2.0"), "{error}");
    let text = triangle(|_| ()).to_string().replace(r#"{"mesh":0}"#, r#"{"mesh":0,"translation":[NaN,0,0]}"#);
    let error = loaded("a.gltf", text.as_bytes()).unwrap_err();
    assert!(error.contains("JSON has no NaN"), "{error}");
    let error = refusal(&triangle(|d| d["nodes"][0]["translation"] = json!([1, "x", 0])));
    assert!(error.contains("nodes[0].translation"), "{error}");
}

#[test]
fn joints_outside_of_the_scene_bend_all_the_same() {
    let scene = read(&triangle(|d| {
        let joints = add_accessor(d, &[0; 12], 5121, 3, "VEC4");
        let weights = add_accessor(d, &bytes(&[1.0, 0.0, 0.0, 0.0].repeat(3)), 5126, 3, "VEC4");
        d["meshes"][0]["primitives"][0]["attributes"]["JOINTS_0"] = json!(joints);
        d["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] = json!(weights);
        // The joint is the second child of a root that no scene lists; its sibling's mesh is not shown.
        d["nodes"] = json!([{"mesh": 0, "skin": 0}, {"translation": [0, 0, 5], "children": [2, 3]}, {"mesh": 0},
                            {"translation": [0, 2, 0]}]);
        d["skins"] = json!([{"joints": [3]}]);
    }))
    .scene;
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    assert_eq!(scene.triangle_count(), 1);
    let vertices = scene.world_vertices(&scene.pose(), &scene.instances()[0]);
    assert_eq!(vertices.positions[0], Vec3::new(0.0, 2.0, 5.0));
}

#[test]
fn indices_may_be_sparse() {
    let scene = read(&triangle(|d| {
        let base = add_accessor(d, &[0, 0, 0], 5121, 3, "SCALAR");
        let (places, values) =
            (add_accessor(d, &[1, 2], 5121, 2, "SCALAR"), add_accessor(d, &[1, 2], 5121, 2, "SCALAR"));
        let view = |d: &Value, accessor: usize| d["accessors"][accessor]["bufferView"].clone();
        d["accessors"][base]["sparse"] = json!({"count": 2,
            "indices": {"bufferView": view(d, places), "componentType": 5121},
            "values": {"bufferView": view(d, values)}});
        d["meshes"][0]["primitives"][0]["indices"] = json!(base);
    }))
    .scene;
    assert_eq!(scene.meshes[0].positions, [Vec3::ZERO, Vec3::X, Vec3::Y]);
}

#[test]
fn a_material_takes_the_coordinate_sets_that_it_needs() {
    let document = |sets: [usize; 3]| {
        triangle(|d| {
            for set in 0..4 {
                let uvs = add_accessor(d, &bytes(&[set as f32; 6]), 5126, 3, "VEC2");
                d["meshes"][0]["primitives"][0]["attributes"][format!("TEXCOORD_{set}")] = json!(uvs);
            }
            d["images"] = json!([{"uri": pixel([255; 4])}]);
            d["textures"] = json!([{"source": 0}]);
            d["materials"] = json!([{
                "pbrMetallicRoughness": {"baseColorTexture": {"index": 0, "texCoord": sets[0]}},
                "normalTexture": {"index": 0, "texCoord": sets[1]},
                "emissiveTexture": {"index": 0, "texCoord": sets[2]}
            }]);
            d["meshes"][0]["primitives"][0]["material"] = json!(0);
        })
    };
    for sets in [[0, 1, 0], [2, 2, 2], [0, 3, 3], [3, 1, 1], [2, 3, 2]] {
        let scene = read(&document(sets)).scene;
        assert!(scene.warnings.is_empty(), "{sets:?}: {:?}", scene.warnings);
        let material = &scene.materials[0];
        let used = [material.base_color_texture, material.normal_texture, material.emissive_texture];
        let values = used.map(|texture| scene.meshes[0].uvs[texture.unwrap().set][0]);
        assert_eq!(values, sets.map(|set| Vec2::splat(set as f32)), "{sets:?}");
    }
    let scene = read(&document([0, 1, 2])).scene;
    assert_eq!(scene.materials[0].emissive_texture, None);
    assert!(scene.warnings[0].contains("coordinate set 2 is left out"), "{:?}", scene.warnings);
}

#[test]
fn vertex_colors_are_clamped_and_whole_numbers_normalized() {
    let colors = |bytes: &[u8], component: u32, shape: &str| {
        let scene = read(&triangle(|d| {
            let colors = add_accessor(d, bytes, component, 3, shape);
            d["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(colors);
        }))
        .scene;
        (scene.meshes[0].colors.clone(), scene.warnings.len())
    };
    let (values, warnings) = colors(&[255, 0, 51, 0, 0, 0, 255, 255, 255], 5121, "VEC3");
    assert_eq!((values[0], warnings), (Vec4::new(1.0, 0.0, 0.2, 1.0), 1));
    let shorts: Vec<u8> = [65_535_u16, 0, 13_107, 0].repeat(3).iter().flat_map(|x| x.to_le_bytes()).collect();
    assert_eq!(colors(&shorts, 5123, "VEC4"), (vec![Vec4::new(1.0, 0.0, 0.2, 0.0); 3], 1));
    let floats = bytes(&[3.0, -1.0, 0.25, f32::NAN, 0.0, 0.0, 1.0, 1.0, 1.0]);
    let (values, warnings) = colors(&floats, 5126, "VEC3");
    assert_eq!((values[0], values[1], warnings), (Vec4::new(1.0, 0.0, 0.25, 1.0), Vec4::ONE, 1));
}

#[test]
fn cameras_show_what_they_show_in_pictures_of_any_shape() {
    let document = triangle(|d| {
        d["nodes"] = json!([{"camera": 0}, {"camera": 1}]);
        d["scenes"][0]["nodes"] = json!([0, 1]);
        d["cameras"] = json!([
            {"type": "perspective", "perspective": {"yfov": 1.0, "aspectRatio": 1.5, "znear": 0.1}},
            {"type": "orthographic", "orthographic": {"xmag": 3.0, "ymag": 2.0, "zfar": 9.0, "znear": 0.1}}
        ]);
    });
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("document.gltf");
    std::fs::write(&path, document.to_string()).unwrap();
    for (aspect, across) in [(0.5, 1.5), (1.5, 1.5), (2.5, 2.5)] {
        let scene = load(&path, &LoadOptions { aspect, ..LoadOptions::default() }).unwrap().scene;
        let Projection::Perspective { fov_x } = scene.cameras[0].projection else { panic!("perspective") };
        assert!(((0.5 * fov_x).tan() - across * 0.5_f32.tan()).abs() < 1e-6, "{aspect}");
        assert_eq!(scene.cameras[1].projection, Projection::Orthographic { half_width: 2.0 * across });
    }
}

/// Kinds of faults beside a document without them: same meshes, materials and textures.
#[test]
fn field_cases_are_the_scenes_that_they_should_be() {
    let Some(folder) = gnomon_testing::data_file("field") else { return };
    for case in [
        "datauri_kinds",
        "duplicate_key",
        "glb_nul_padding",
        "null_members",
        "null_node",
        "sparse_everywhere",
        "texcoord_set_2",
        "tiny_jpeg_icc",
        "tiny_png_exif_text",
        "uri_backslash",
        "uri_bare_percent",
        "uri_blanks_percent",
        "uri_http_texture",
        "vcolor_kinds",
        "vcolor_u8_not_normalized",
        "webp_ext_fallback",
        "webp_plain_source",
        "zero_byte_picture",
        "jpeg_cmyk",
        "jpeg_exif_rotated",
        "png_kinds",
    ] {
        let folder = folder.join(format!("gltf_{case}"));
        let open = |name: &str| load(&folder.join(name), &LoadOptions::default());
        let found = ["case.gltf", "case.glb"].into_iter().find(|name| folder.join(name).exists()).unwrap();
        let (found, plain) = (open(found).unwrap().scene, open("plain.glb").unwrap().scene);
        assert_eq!(found.triangle_count(), plain.triangle_count(), "{case}");
        let texels = |scene: &Scene| -> Vec<[u8; 4]> {
            scene.textures.iter().flat_map(|texture| texture.rgba8.iter().copied()).collect()
        };
        assert_eq!(texels(&found).len(), texels(&plain).len(), "{case}");
        let apart = |a: &[u8; 4], b: &[u8; 4]| (0..3).map(|c| a[c].abs_diff(b[c])).max().unwrap();
        assert!(texels(&found).iter().zip(&texels(&plain)).all(|(a, b)| apart(a, b) <= 3), "{case}");
        for (found, plain) in found.meshes.iter().zip(&plain.meshes) {
            assert_eq!((&found.positions, &found.normals), (&plain.positions, &plain.normals), "{case}");
            assert_eq!((found.colors.len(), found.material), (plain.colors.len(), plain.material), "{case}");
        }
        let surfaces = |scene: &Scene| scene.materials.iter().map(|m| m.surface).collect::<Vec<_>>();
        assert_eq!(surfaces(&found), surfaces(&plain), "{case}");
    }
    let one = folder.join("gltf_version_one/case.gltf");
    assert!(load(&one, &LoadOptions::default()).unwrap_err().to_string().contains("convert it to 2.0"));
    // Whatever else there is reads without a panic.
    for entry in std::fs::read_dir(&folder).unwrap() {
        for file in std::fs::read_dir(entry.unwrap().path()).into_iter().flatten() {
            let path = file.unwrap().path();
            if path.extension().is_some_and(|extension| extension == "glb" || extension == "gltf") {
                let _ = load(&path, &LoadOptions::default());
            }
        }
    }
    assert!(attempt(&triangle(|_| ())).is_ok());
}
