//! Extensions of glTF: those that are read, those that are shown without, compressed files and damaged ones.
#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests fail the test")]

mod documents;

use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::{Affine3A, Quat, Vec3};
use gnomon_brdf::Model;
use gnomon_scene::{AlphaMode, AreaLightShape, MeshId, Scene, Spread};
use gnomon_scene_files::{LoadOptions, load, load_bytes};
use serde_json::{Value, json};

use self::documents::{add_accessor, bytes, pixel, read, refusal, triangle};

fn with_material(material: Value) -> Value {
    triangle(|d| {
        d["materials"] = json!([material]);
        d["meshes"][0]["primitives"][0]["material"] = json!(0);
    })
}

/// Units of KHR_lights_punctual: candela of points and spots, lux of suns; extents of the light's extras.
#[test]
fn punctual_lights_have_an_extent_and_their_intensity() {
    let lights = |change: &dyn Fn(&mut Value)| {
        read(&triangle(|d| {
            d["extensionsUsed"] = json!(["KHR_lights_punctual"]);
            d["extensions"] = json!({"KHR_lights_punctual": {"lights": [
                {"type": "point", "color": [1.0, 0.5, 0.0], "intensity": 20.0, "extras": {"radius": 0.25}},
                {"type": "spot", "intensity": 3.0, "spot": {"innerConeAngle": 0.2, "outerConeAngle": 0.6}},
                {"type": "directional", "intensity": 7.0, "extras": {"angle": 0.02}},
            ]}});
            let light = |light: usize| json!({"KHR_lights_punctual": {"light": light}});
            d["nodes"] = json!([
                {"mesh": 0, "children": [1], "translation": [1.0, 2.0, 3.0], "scale": [2.0, 2.0, 2.0]},
                {"translation": [0.0, 1.0, 0.0], "extensions": light(0)},
                {"rotation": [-1.0, 0.0, 0.0, 1.0], "extensions": light(1)},
                {"rotation": [0.0, 1.0, 0.0, 1.0], "extensions": light(2)},
            ]);
            d["scenes"][0]["nodes"] = json!([0, 2, 3]);
            change(d);
        }))
        .scene
    };
    let scene = lights(&|_| ());
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    let [point, spot, sun] = scene.placed_lights()[..] else { panic!("three lights") };
    assert_eq!(point.center, Vec3::new(1.0, 4.0, 3.0));
    assert_eq!(point.shape, AreaLightShape::Sphere { radius: 0.25 });
    let intensity = point.radiance * point.shape.facing_irradiance();
    assert!(intensity.abs_diff_eq(Vec3::new(20.0, 10.0, 0.0), 1e-4), "{intensity}");
    assert_eq!(spot.spread, Spread::Cone { inner: 0.2, outer: 0.6 });
    assert!((spot.radiance.x * spot.shape.facing_irradiance() - 3.0).abs() < 1e-5);
    assert!(spot.normal.abs_diff_eq(Vec3::NEG_Y, 1e-6), "it shines along -z: {}", spot.normal);
    assert!((sun.radiance.x * std::f32::consts::PI * 0.01_f32.sin().powi(2) - 7.0).abs() < 1e-4);
    assert!(sun.normal.abs_diff_eq(Vec3::NEG_X, 1e-6), "{}", sun.normal);
    // What is out of range leaves one out with a word, and a light that is not there is an error.
    for (pointer, value, word) in [
        ("/extensions/KHR_lights_punctual/lights/0/extras/radius", json!(-1), "extras.radius"),
        ("/extensions/KHR_lights_punctual/lights/0/intensity", json!(-1), "at least 0"),
        ("/extensions/KHR_lights_punctual/lights/1/spot/outerConeAngle", json!(0.1), "quarter turn"),
        ("/extensions/KHR_lights_punctual/lights/2/type", json!("ambient"), "unknown type"),
    ] {
        let scene = lights(&|d| *d.pointer_mut(pointer).unwrap() = value.clone());
        assert_eq!(scene.lights.len(), 2, "{pointer}");
        assert!(scene.warnings.len() == 1 && scene.warnings[0].contains(word), "{:?}", scene.warnings);
    }
    let hidden = lights(&|d| {
        d["nodes"][0]["extensions"] = json!({"KHR_node_visibility": {"visible": false}});
    });
    assert_eq!(hidden.lights.len(), 2);
}

#[test]
fn extensions_that_only_add_are_accepted_with_a_word() {
    for (name, words) in
        [("KHR_materials_transmission", "shown opaque"), ("KHR_materials_volume", "not drawn")]
    {
        for key in ["extensionsUsed", "extensionsRequired"] {
            let scene = read(&triangle(|d| d[key] = json!([name]))).scene;
            let [warning] = scene.warnings.as_slice() else { panic!("{:?}", scene.warnings) };
            assert!(warning.starts_with(name) && warning.contains(words), "{key}: {warning}");
        }
    }
    let silent = [
        "KHR_materials_unlit",
        "KHR_materials_anisotropy",
        "KHR_materials_clearcoat",
        "KHR_materials_sheen",
        "KHR_materials_variants",
        "EXT_mesh_gpu_instancing",
    ];
    assert!(read(&triangle(|d| d["extensionsRequired"] = json!(silent))).scene.warnings.is_empty());
    let basisu = json!({"extensions": {"KHR_texture_basisu": {"source": 0}}});
    let document = triangle(|d| {
        d["extensionsRequired"] = json!(["KHR_texture_basisu"]);
        d["images"] = json!([{"uri": "a.ktx2"}]);
        d["textures"] = json!([basisu]);
        d["materials"] = json!([{"emissiveTexture": {"index": 0}}]);
    });
    assert!(read(&document).scene.warnings[0].contains("ktxdecompress"));
}

#[test]
fn what_is_not_lit_emits_its_color_and_reflects_nothing() {
    let unlit = |alpha_mode: &str| {
        let mut document = with_material(json!({
            "pbrMetallicRoughness": {"baseColorFactor": [0.5, 1, 1, 1], "baseColorTexture": {"index": 0}},
            "alphaMode": alpha_mode, "extensions": {"KHR_materials_unlit": {}}
        }));
        document["images"] = json!([{"uri": pixel([255, 0, 255, 255])}]);
        document["textures"] = json!([{"source": 0}]);
        let colors = add_accessor(&mut document, &bytes(&[1.0, 1.0, 0.25].repeat(3)), 5126, 3, "VEC3");
        document["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(colors);
        read(&document).scene
    };
    let scene = unlit("OPAQUE");
    let point = scene.surface_at(MeshId(0), 0, Vec3::splat(1.0 / 3.0));
    // Factor, texture and vertex colour.
    assert!(point.emissive.distance(Vec3::new(0.5, 0.0, 0.25)) < 1e-6, "{}", point.emissive);
    assert_eq!(point.surface.base_color, Vec3::ZERO);
    assert!(point.surface.is_matte());
    assert_eq!(scene.materials[0].base_color_texture, None);
    assert!(unlit("MASK").materials[0].base_color_texture.is_some());
}

#[test]
fn a_clear_coat_has_its_own_textures() {
    let mut document = with_material(json!({"extensions": {"KHR_materials_clearcoat": {
        "clearcoatFactor": 0.5, "clearcoatRoughnessFactor": 0.8, "clearcoatTexture": {"index": 0},
        "clearcoatRoughnessTexture": {"index": 0}, "clearcoatNormalTexture": {"index": 0, "scale": 0.5}
    }}}));
    document["images"] = json!([{"uri": pixel([51, 102, 255, 255])}]);
    document["textures"] = json!([{"source": 0}]);
    let scene = read(&document).scene;
    let surface = scene.surface_at(MeshId(0), 0, Vec3::splat(1.0 / 3.0)).surface;
    assert!((surface.clearcoat - 0.1).abs() < 1e-6 && (surface.clearcoat_roughness - 0.32).abs() < 1e-6);
    assert_eq!(scene.materials[0].clearcoat_normal_scale, 0.5);
    // What has no strength has no textures, and damaged numbers are taken at the end of their range.
    let coat = |factors: Value| {
        let scene = read(&with_material(json!({"extensions": {"KHR_materials_clearcoat": factors}}))).scene;
        let surface = scene.materials[0].surface;
        [surface.clearcoat, surface.clearcoat_roughness]
    };
    assert_eq!(coat(json!({})), [0.0, 0.0]);
    assert_eq!(coat(json!({"clearcoatFactor": 7, "clearcoatRoughnessFactor": -1})), [1.0, 0.0]);
}

#[test]
fn anisotropy_is_a_model_and_its_texture_a_direction() {
    let open = |anisotropy: Value| {
        let mut document = with_material(json!({
            "pbrMetallicRoughness": {"roughnessFactor": 0.5, "metallicRoughnessTexture": {"index": 0}},
            "extensions": {"KHR_materials_anisotropy": anisotropy}
        }));
        document["images"] = json!([{"uri": pixel([0, 128, 204, 255])}]);
        document["textures"] = json!([{"source": 0}]);
        let uvs = add_accessor(&mut document, &bytes(&[0.0, 0.0, 1.0, 0.0, 0.0, 1.0]), 5126, 3, "VEC2");
        document["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(uvs);
        read(&document).scene
    };
    let scene = open(
        json!({"anisotropyStrength": 0.5, "anisotropyRotation": 0.25, "anisotropyTexture": {"index": 0}}),
    );
    let surface = scene.materials[0].surface;
    assert_eq!((surface.model, surface.anisotropy_rotation), (Model::AnisotropicGgx, 0.25));
    // Strength and roughness are those of the textures' means.
    assert!(
        (surface.anisotropy - 0.4).abs() < 1e-6 && (surface.roughness - 0.251).abs() < 1e-3,
        "{surface:?}"
    );
    // The texel points against u.
    let tangent = scene.surface_at(MeshId(0), 0, Vec3::splat(1.0 / 3.0)).tangent;
    let straight = open(json!({"anisotropyStrength": 0.5}));
    let along_u = straight.surface_at(MeshId(0), 0, Vec3::splat(1.0 / 3.0)).tangent;
    assert!(tangent.truncate().dot(along_u.truncate()) < -0.99, "{tangent} {along_u}");
    let none = open(json!({"anisotropyTexture": {"index": 0}}));
    assert_eq!(none.materials[0].surface.model, Model::MetallicRoughness);
    assert_eq!(none.materials[0].anisotropy_texture, None);
}

#[test]
fn sheen_has_its_own_textures_but_under_a_coat() {
    let open = |clearcoat: f32| {
        let mut document = with_material(json!({"extensions": {
            "KHR_materials_clearcoat": {"clearcoatFactor": clearcoat},
            "KHR_materials_sheen": {
                "sheenColorFactor": [1, 0.5, 0], "sheenRoughnessFactor": 0.5,
                "sheenColorTexture": {"index": 0}, "sheenRoughnessTexture": {"index": 0}
            }
        }}));
        document["images"] = json!([{"uri": pixel([188, 188, 0, 51])}]);
        document["textures"] = json!([{"source": 0}]);
        read(&document).scene
    };
    for (clearcoat, warnings) in [(0.0, 0), (0.5, 1)] {
        let scene = open(clearcoat);
        assert_eq!(scene.warnings.len(), warnings, "{:?}", scene.warnings);
        assert_eq!(scene.materials[0].has_sheen_textures(), clearcoat == 0.0);
        let surface = scene.surface_at(MeshId(0), 0, Vec3::splat(1.0 / 3.0)).surface;
        // sRGB 188 is 0.503 in linear light.
        assert!(
            surface.sheen_color.distance(Vec3::new(0.503, 0.2515, 0.0)) < 1e-3,
            "{}",
            surface.sheen_color
        );
        assert!((surface.sheen_roughness - 0.1).abs() < 1e-6);
    }
}

#[test]
fn specular_glossiness_has_the_same_matte_part_and_reflectance() {
    let gloss = |factors: Value, picture: Option<[u8; 4]>| {
        let mut document =
            with_material(json!({"extensions": {"KHR_materials_pbrSpecularGlossiness": factors}}));
        if let Some(picture) = picture {
            document["images"] = json!([{"uri": pixel(picture)}]);
            document["textures"] = json!([{"source": 0}]);
        }
        let scene = read(&document).scene;
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
        scene.surface_at(MeshId(0), 0, Vec3::splat(1.0 / 3.0)).surface
    };
    let near = |found: Vec3, expected: [f32; 3]| {
        assert!(found.distance(Vec3::from_array(expected)) < 4e-3, "{found}, not {expected:?}");
    };
    let factors = json!({"diffuseFactor": [0.8, 0.1, 0.1, 1], "specularFactor": [0.2, 0.04, 0.3], "glossinessFactor": 0.25});
    let surface = gloss(factors, None);
    near(surface.layers().diffuse, [0.8, 0.1, 0.1]);
    near(surface.layers().lobe.tint.truncate(), [0.2, 0.04, 0.3]);
    assert_eq!((surface.layers().lobe.tint.w, surface.roughness), (1.0, 0.75));
    // Black reflects nothing at all.
    assert!(gloss(json!({"specularFactor": [0, 0, 0]}), None).is_matte());
    // A texture: sRGB 188 is 0.5 in linear light; glossiness 51 of 255.
    let factors = json!({"specularFactor": [1, 0.5, 0], "glossinessFactor": 0.5, "specularGlossinessTexture": {"index": 0}});
    let surface = gloss(factors, Some([188, 188, 255, 51]));
    near(surface.layers().lobe.tint.truncate(), [0.503, 0.2515, 0.0]);
    assert!((surface.roughness - 0.9).abs() < 4e-3, "{}", surface.roughness);
    assert!((surface.layers().lobe.tint.w - 1.0).abs() < 1e-6);
}

#[test]
fn a_variant_is_shown_by_its_name() {
    let document = triangle(|d| {
        d["extensions"] =
            json!({"KHR_materials_variants": {"variants": [{"name": "day"}, {"name": "night"}]}});
        d["materials"] = json!([{"name": "plain"}, {"name": "blue"}]);
        d["meshes"][0]["primitives"][0]["material"] = json!(0);
        d["meshes"][0]["primitives"][0]["extensions"] =
            json!({"KHR_materials_variants": {"mappings": [{"material": 1, "variants": [1]}]}});
    })
    .to_string();
    let files = std::collections::HashMap::from([("a.gltf".into(), document.into_bytes())]);
    let shown = |name: &str, text: &str, variant: Option<&str>| {
        let options = LoadOptions { variant: variant.map(str::to_owned), ..LoadOptions::default() };
        let bytes = if text.is_empty() { &files[Path::new("a.gltf")] } else { text.as_bytes() };
        let loaded =
            load_bytes(Path::new(name), bytes, &files, &options).map_err(|error| error.to_string())?;
        Ok::<_, String>((loaded.scene.material(MeshId(0)).name.clone(), loaded.variant))
    };
    assert_eq!(shown("a.gltf", "", None), Ok(("plain".to_owned(), None)));
    assert_eq!(shown("a.gltf", "", Some("day")), Ok(("plain".to_owned(), Some("day".to_owned()))));
    assert_eq!(shown("a.gltf", "", Some("night")), Ok(("blue".to_owned(), Some("night".to_owned()))));
    let error = shown("a.gltf", "", Some("dusk")).unwrap_err();
    assert!(error.contains("no material variant 'dusk' (there are: day, night)"), "{error}");
    // In a scene file, whose word the caller's goes before.
    let scene = "variant = \"night\"\n[[model]]\nfile = \"a.gltf\"\n[[model]]\nbuiltin = \"column\"";
    assert_eq!(shown("s.toml", scene, None), Ok(("blue".to_owned(), Some("night".to_owned()))));
    assert_eq!(shown("s.toml", scene, Some("day")), Ok(("plain".to_owned(), Some("day".to_owned()))));
    let error = shown("s.toml", "variant = \"a\"\n[[model]]\nbuiltin = \"column\"", None).unwrap_err();
    assert!(error.contains("no material variant 'a' (there are none)"), "{error}");
}

#[test]
fn instances_share_their_mesh() {
    const COUNT: usize = 10_000;
    let document = triangle(|d| {
        let places: Vec<f32> = (0..COUNT).flat_map(|i| [i as f32, 0.0, 2.0]).collect();
        let translation = add_accessor(d, &bytes(&places), 5126, COUNT, "VEC3");
        // A quarter turn about z in shorts that are not said to be normalized.
        let turn: Vec<u8> =
            [0_i16, 0, 23_170, 23_170].repeat(COUNT).iter().flat_map(|x| x.to_le_bytes()).collect();
        let rotation = add_accessor(d, &turn, 5122, COUNT, "VEC4");
        let scale = add_accessor(d, &bytes(&[2.0, 1.0, 1.0].repeat(COUNT)), 5126, COUNT, "VEC3");
        d["nodes"] = json!([{"mesh": 0, "translation": [0, 5, 0], "extensions": {"EXT_mesh_gpu_instancing":
            {"attributes": {"TRANSLATION": translation, "ROTATION": rotation, "SCALE": scale, "_ID": translation}}}}]);
    });
    let scene = read(&document).scene;
    assert_eq!((scene.meshes.len(), scene.instances().len()), (1, COUNT));
    assert!(Arc::strong_count(&scene.meshes[0]) == 1 && scene.warnings.is_empty());
    let place = scene.instances()[7].world_from_mesh;
    let expected = Affine3A::from_scale_rotation_translation(
        Vec3::new(2.0, 1.0, 1.0),
        Quat::from_rotation_z(std::f32::consts::FRAC_PI_2),
        Vec3::new(7.0, 5.0, 2.0),
    );
    assert!(place.abs_diff_eq(expected, 1e-5), "{place:?}");
    let mut uneven = document;
    uneven["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["SCALE"] = json!(0);
    assert!(refusal(&uneven).contains("different lengths"));
}

#[test]
fn hidden_nodes_show_nothing() {
    let scene = read(&triangle(|d| {
        let hidden = json!({"KHR_node_visibility": {"visible": false}});
        d["nodes"] =
            json!([{"mesh": 0, "children": [1]}, {"extensions": hidden, "children": [2]}, {"mesh": 0}]);
    }))
    .scene;
    assert_eq!(scene.triangle_count(), 1);
}

#[test]
fn pointers_to_nodes_move_them() {
    let clip = |pointer: &str| {
        read(&triangle(|d| {
            let input = add_accessor(d, &bytes(&[0.0, 1.0]), 5126, 2, "SCALAR");
            let output = add_accessor(d, &bytes(&[0.0, 0.0, 0.0, 4.0, 0.0, 0.0]), 5126, 2, "VEC3");
            let target =
                json!({"path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": pointer}}});
            d["animations"] = json!([{"channels": [{"sampler": 0, "target": target}],
                                      "samplers": [{"input": input, "output": output}]}]);
        }))
        .scene
    };
    let mut scene = clip("/nodes/0/translation");
    scene.animate(0, 0.5).unwrap();
    assert_eq!(scene.world_from_nodes()[0].translation.x, 2.0);
    for pointer in ["/materials/0/emissiveFactor", "/nodes/0", "/nodes/x/scale", ""] {
        let scene = clip(pointer);
        assert!(scene.animations[0].channels.is_empty());
        assert!(scene.warnings[0].contains("which stays here"), "{:?}", scene.warnings);
    }
}

#[test]
fn blending_lets_light_through_by_alpha() {
    let alpha_of = |factor: f32, texel: u8| {
        let mut document = with_material(json!({"alphaMode": "BLEND",
            "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, factor], "baseColorTexture": {"index": 0}}}));
        document["images"] = json!([{"uri": pixel([255, 255, 255, texel])}]);
        document["textures"] = json!([{"source": 0}]);
        let scene = read(&document).scene;
        let opacity = scene.opacity_at(MeshId(0), 0, Vec3::splat(1.0 / 3.0));
        (scene.materials[0].alpha_mode, (100.0 * opacity).round(), scene.warnings.len())
    };
    assert_eq!(alpha_of(1.0, 255), (AlphaMode::Opaque, 100.0, 0));
    assert_eq!(alpha_of(0.6, 255), (AlphaMode::Blend, 60.0, 0));
    assert_eq!(alpha_of(0.6, 128), (AlphaMode::Blend, 30.0, 0));
    assert_eq!(alpha_of(1.0, 200), (AlphaMode::Blend, 78.0, 0));
}

/// A mirrored node's bitangent is that of mirrored vertices.
#[test]
fn mirrored_reliefs_are_mirrored() {
    let scene = |scale: Value| {
        let mut document = with_material(json!({"normalTexture": {"index": 0}}));
        document["images"] = json!([{"uri": pixel([128, 255, 128, 255])}]);
        document["textures"] = json!([{"source": 0}]);
        document["nodes"][0]["scale"] = scale;
        read(&document).scene
    };
    for (scale, side) in [(json!([1, 1, 1]), -1.0), (json!([-1, 1, 1]), 1.0), (json!([-1, 1, -1]), -1.0)] {
        let scene = scene(scale);
        let vertices = scene.world_vertices(&scene.pose(), &scene.instances()[0]);
        assert_eq!(vertices.tangents[0].w, side);
        // The relief leans along y, which no mirror at x turns.
        let point = scene.surface_in_world(MeshId(0), &vertices, 0, Vec3::splat(1.0 / 3.0));
        assert!(point.shading_normal.y < -0.99, "{}", point.shading_normal);
    }
}

fn compressed(name: &str) -> Vec<u8> {
    std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/compressed").join(name)).unwrap()
}

fn opened(name: &str, bytes: &[u8]) -> Result<Scene, String> {
    let files = std::collections::HashMap::new();
    let options = LoadOptions { memory_limit: 1 << 28, ..LoadOptions::default() };
    load_bytes(Path::new(name), bytes, &files, &options).map(|l| l.scene).map_err(|error| error.to_string())
}

/// glTF-Transform made these files of one, and one more that it decompressed again.
#[test]
fn compressed_files_hold_what_was_compressed() {
    let scene = |name: &str| {
        let scene = opened(name, &compressed(name)).unwrap();
        assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
        scene
    };
    let (mut packed, mut unpacked) = (scene("meshopt.glb"), scene("meshopt_plain.glb"));
    for scene in [&mut packed, &mut unpacked] {
        scene.animate(0, 0.4).unwrap();
    }
    assert_eq!(packed.meshes, unpacked.meshes);
    assert_eq!(packed.world_from_nodes(), unpacked.world_from_nodes());
    // Draco orders triangles anew, leaves out those without area, and rounds.
    let (draco, plain) = (scene("draco.glb"), scene("plain.glb"));
    let corners = |scene: &Scene| {
        let mesh = &scene.meshes[0];
        let corner = |&index: &u32| {
            let i = index as usize;
            (mesh.positions[i], mesh.normals[i], mesh.uvs[0][i])
        };
        mesh.triangles.iter().flatten().map(corner).collect::<Vec<_>>()
    };
    let (found, wanted) = (corners(&draco), corners(&plain));
    assert_eq!(draco.triangle_count(), 747);
    for (position, normal, uv) in &found {
        let is_near = |other: &(Vec3, Vec3, glam::Vec2)| {
            other.0.distance(*position) < 1e-3
                && other.1.distance(*normal) < 0.02
                && other.2.distance(*uv) < 1e-3
        };
        assert!(wanted.iter().any(is_near), "{position} {normal} {uv}");
    }
    let area = |scene: &Scene| -> f32 {
        let corner = |index: u32| scene.meshes[0].positions[index as usize];
        let doubled = |&[a, b, c]: &[u32; 3]| (corner(b) - corner(a)).cross(corner(c) - corner(a)).length();
        scene.meshes[0].triangles.iter().map(doubled).sum()
    };
    assert!((area(&draco) / area(&plain) - 1.0).abs() < 1e-3);
}

/// Two hundred mutants of each: text and bytes at random places, the same ones every time.
#[test]
fn mutants_end_well() {
    let mut seed = 0x9e37_79b9_7f4a_7c15_u64;
    let mut random = move |below: usize| {
        seed ^= seed << 13;
        seed ^= seed >> 7;
        seed ^= seed << 17;
        (seed % below as u64) as usize
    };
    let document = with_material(json!({
        "pbrMetallicRoughness": {"baseColorTexture": {"index": 0, "texCoord": 0}}, "alphaMode": "BLEND",
        "extensions": {"KHR_materials_unlit": {}, "KHR_materials_pbrSpecularGlossiness": {"diffuseFactor": [1, 1, 1, 0.5]}}
    }));
    let mut document = document;
    document["images"] = json!([{"uri": pixel([1, 2, 3, 4])}]);
    document["textures"] = json!([{"source": 0, "extensions": {"EXT_texture_webp": {"source": 0}}}]);
    document["nodes"] =
        json!([{"mesh": 0, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 0}}}}]);
    let seeds = [
        ("a.gltf", document.to_string().into_bytes()),
        ("a.glb", compressed("draco.glb")),
        ("a.glb", compressed("meshopt.glb")),
    ];
    for (name, seed) in seeds {
        assert!(opened(name, &seed).is_ok());
        for _ in 0..200 {
            let mut mutant = seed.clone();
            for _ in 0..1 + random(4) {
                let place = random(mutant.len());
                match random(4) {
                    0 => mutant[place] = random(256) as u8,
                    1 => mutant[place] ^= 1 << random(8),
                    2 => mutant[place] = b"0123456789-{}[]\",:"[random(18)],
                    _ => {
                        let length = random(16).min(mutant.len() - place);
                        let from = random(mutant.len() - length);
                        mutant.copy_within(from..from + length, place);
                    }
                }
            }
            let start = Instant::now();
            if let Err(error) = opened(name, &mutant) {
                assert!(!error.contains('\n') && error.len() < 1_000, "{error}");
            }
            assert!(start.elapsed() < Duration::from_secs(5), "{:?}", start.elapsed());
        }
    }
}

#[test]
fn field_cases_with_extensions_load() {
    let Some(folder) = gnomon_testing::data_file("field") else { return };
    let open = |name: &str| load(&folder.join(name), &LoadOptions::default()).unwrap().scene;
    let case = open("gltf_instancing_optional/case.glb");
    assert_eq!(case.triangle_count(), open("gltf_instancing_optional/plain.glb").triangle_count());
    let surface = |name: &str| open(name).materials[0].surface.layers();
    assert_eq!(
        surface("gltf_specgloss_only/case.glb").diffuse,
        surface("gltf_specgloss_only/plain.glb").diffuse
    );
    assert!(open("gltf_specgloss_only/case.glb").materials[0].surface.is_matte());
    assert!(open("gltf_unlit_required/case.glb").materials[0].emissive_texture.is_some());
    assert_eq!(open("gltf_variants_required/case.glb").variants, ["a"]);
}
