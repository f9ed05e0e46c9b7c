//! OBJ and MTL files as programs write them: nothing is lost for one line, and what was meant is read.
#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests fail the test")]

mod summary;

use glam::{Vec2, Vec3};
use gnomon_scene::{AlphaMode, Material, Scene, Wrap};
use proptest::prelude::*;

use self::summary::{picture, png, scene_of};

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\n";

fn obj(text: &str) -> Scene {
    scene_of(&[("a.obj", text.as_bytes())])
}

/// The material of a triangle that uses `m` of a library.
fn material(library: &str) -> (Scene, Material) {
    let faces = format!("mtllib a.mtl\n{TRIANGLE}usemtl m\nf 1/1 2/2 3/3\n");
    let mask = png(image::GrayImage::from_fn(4, 2, |x, _| image::Luma([if x < 2 { 0 } else { 255 }])).into());
    let files: [(&str, &[u8]); 6] = [
        ("a.obj", faces.as_bytes()),
        ("a.mtl", library.as_bytes()),
        ("tex.png", &picture()),
        ("my tex.png", &picture()),
        ("a #1.png", &picture()),
        ("mask.png", &mask),
    ];
    let scene = scene_of(&files);
    let used = scene.meshes[0].material.unwrap();
    (scene.clone(), scene.materials[used.0].clone())
}

fn warns(scene: &Scene, part: &str) -> bool {
    scene.warnings.iter().any(|warning| warning.contains(part))
}

#[test]
fn lines_end_and_join_however_a_system_has_it() {
    let text = "# from C:\\models\\\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 \\\n  2 \\\n 3\n";
    let plain = obj(text);
    assert_eq!((plain.triangle_count(), plain.warnings.len()), (1, 0));
    let utf16 = |unit: fn(u16) -> [u8; 2]| -> Vec<u8> {
        std::iter::once(0xfeff).chain(text.encode_utf16()).flat_map(unit).collect()
    };
    let files = [
        text.replace('\n', "\r").into_bytes(),
        text.replace('\n', "\r\n").into_bytes(),
        format!("\u{feff}{text}").into_bytes(),
        utf16(u16::to_le_bytes),
        utf16(u16::to_be_bytes),
        text.replace(' ', "\t").into_bytes(),
    ];
    for file in files {
        assert_eq!(scene_of(&[("a.obj", &file)]), plain);
    }
    assert_eq!(obj("v 0 0 0\nv 1,0 0 0\nv 0 1,0 0\nf 1 2 3\n").bounds(), plain.bounds());
    assert_eq!(
        obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3 \\").triangle_count(),
        1,
        "a file that ends in a join"
    );
}

#[test]
fn attributes_that_are_none_or_not_there_lose_no_face() {
    for faces in
        ["f 1/0 2/0 3/0", "f 1/0/0 2/0/0 3/0/0", "f 1/9 2/9 3/9", "f 1//7 2//7 3//7", "f 1/-9 2/-9 3/-9"]
    {
        let scene = obj(&format!("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\n{faces}\n"));
        assert_eq!((scene.triangle_count(), scene.meshes[0].normals[0]), (1, Vec3::Z), "{faces}");
        assert_eq!(
            warns(&scene, "that are not there"),
            !faces.contains("/0"),
            "{faces}: {:?}",
            scene.warnings
        );
    }
    let scene = obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn -1.#IND 1.#QNAN 0\nvn\nvn 0 0 1\nf 1//1 2//2 3//3\n");
    assert_eq!(scene.meshes[0].normals, [Vec3::Z; 3]);
    assert!(
        warns(&scene, "1 texture coordinates and normals are no numbers")
            && warns(&scene, "2 normals were zero")
    );
    let scene =
        obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2\np 1\ncurv 0 1 1 2\nsurf 0 1 0 1 1 2 3\nf 1 2\nf 1 2 3\n");
    assert_eq!(scene.triangle_count(), 1);
    assert!(warns(&scene, "3 points, lines and faces") && warns(&scene, "2 curves and surfaces"));
}

#[test]
fn vertex_colours_go_to_1_or_to_255() {
    let bytes = obj("v 0 0 0 255 188 0\nv 1 0 0 0 0 0\nv 0 1 0 0 0 0\nf 1 2 3\n");
    let floats = obj("v 0 0 0 1 0.7372549 0\nv 1 0 0 0 0 0\nv 0 1 0 0 0 0\nf 1 2 3\n");
    assert!((bytes.meshes[0].colors[0] - floats.meshes[0].colors[0]).length() < 1e-5);
    assert!((bytes.meshes[0].colors[0].y - 0.5029).abs() < 1e-3);
}

#[test]
fn libraries_and_materials_are_found_by_any_name() {
    let red = b"newmtl red\nKd 1 0 0\nnewmtl Material #25\nKd 0 1 0\nnewmtl  Material #26  \nKd 0 0 1\nnewmtl \"two  words\"\nKd 1 1 0\n";
    let blue = b"newmtl blue\nKd 0 0 0.5\nnewmtl red\nKd 0 0 0\n";
    for (line, files) in [
        ("mtllib a.mtl b.mtl", ["a.mtl", "b.mtl"]),
        ("mtllib my lib.mtl b #2.mtl", ["my lib.mtl", "b #2.mtl"]),
        ("mtllib \"my lib.mtl\" \"b.mtl\"", ["my lib.mtl", "b.mtl"]),
        ("mtllib a.mtl # first\nmtllib C:\\out\\b.mtl   ", ["a.mtl", "b.mtl"]),
    ] {
        for (name, color) in [
            ("red", Vec3::X),
            ("red  # comment", Vec3::X),
            ("\"red\"", Vec3::X),
            ("Material #25", Vec3::Y),
            ("Material  #26 ", Vec3::Z),
            ("two words", Vec3::new(1.0, 1.0, 0.0)),
            ("blue", 0.5 * Vec3::Z),
        ] {
            // Libraries may come last.
            let text = format!("{TRIANGLE}usemtl {name}\nf 1 2 3\n{line}\n");
            let scene = scene_of(&[("a.obj", text.as_bytes()), (files[0], red), (files[1], blue)]);
            let used = scene.meshes[0].material.unwrap();
            assert_eq!(
                scene.materials[used.0].surface.base_color, color,
                "{line}: {name}: {:?}",
                scene.warnings
            );
            assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
        }
    }
    let scene =
        obj(&format!("mtllib x.mtl y.mtl\n{TRIANGLE}f 1 2 3\nusemtl\nf 1 2 3\nusemtl none\nf 1 2 3\n"));
    assert_eq!(scene.triangle_count(), 3);
    assert!(warns(&scene, "x.mtl: ") && warns(&scene, "y.mtl: ") && warns(&scene, "'none' is not defined"));
    assert_eq!(scene.warnings.len(), 3, "{:?}", scene.warnings);
    let (scene, material) = material("newmtl m\nKd 1 0 0\nnewmtl m\nKd 0 1 0\n");
    assert!(warns(&scene, "defined twice") && material.surface.base_color == Vec3::Y);
}

#[test]
fn statements_that_cannot_be_understood_are_left_out() {
    for (kd, color, part) in [
        ("Kd spectral paint.rfl", Vec3::splat(0.5), "line 2 is left out: spectral"),
        ("Kd", Vec3::splat(0.5), "1 numbers expected"),
        ("Kd red", Vec3::splat(0.5), "'red' is no number"),
        ("KD 0,25 0.5 1.#QNAN", Vec3::new(0.25, 0.5, 0.0), ""),
        ("Kd 0.3", Vec3::splat(0.3), ""),
        ("map_Kd", Vec3::splat(0.5), "it names no picture"),
    ] {
        let (scene, material) = material(&format!("newmtl m\n{kd}\n"));
        assert_eq!(material.surface.base_color, color, "{kd}");
        assert!(
            if part.is_empty() { scene.warnings.is_empty() } else { warns(&scene, part) },
            "{:?}",
            scene.warnings
        );
    }
    // White of Rec. 709.
    let white = material("newmtl m\nKd xyz 0.9505 1 1.089\n").1.surface.base_color;
    assert!(white.distance(Vec3::ONE) < 1e-3, "{white}");
    for (lines, alpha, is_told) in [
        ("d 0.5", 0.5, false),
        ("d -halo 0.5", 0.5, false),
        ("Tr 0.25", 0.75, false),
        ("Tr 0", 1.0, false),
        ("Tr 1", 1.0, false),
        ("d 1\nTr 1", 1.0, false),
        ("Tr 1\nd 1.0", 1.0, false),
        ("Tr 0\nd 0.2", 0.2, false),
        ("d 0", 1.0, true),
    ] {
        let (scene, material) = material(&format!("newmtl m\n{lines}\n"));
        let mode = if alpha < 1.0 { AlphaMode::Blend } else { AlphaMode::Opaque };
        assert_eq!((material.alpha, material.alpha_mode), (alpha, mode), "{lines}");
        assert_eq!(warns(&scene, "shown opaque"), is_told, "{lines}");
    }
}

#[test]
fn maps_are_found_by_any_name_with_their_options() {
    for map in [
        "map_Kd tex.png",
        "map_kd tex.png   ",
        "MAP_KD \"tex.png\" # wood",
        "map_Kd -s 1 1 1 my tex.png",
        "map_Kd my tex.png -blendu off",
        "map_Kd -o 0 0 0 -blendu on -blendv on -mm 0 1 -texres 512 -cc off tex.png",
        "map_Kd a #1.png",
        "map_Kd C:\\Users\\ann\\tex.png",
        "map_Kd .\\tex.png",
        "map_Kd /home/ann/tex.png",
    ] {
        let (scene, material) = material(&format!("newmtl m\nKd 0 0 0\n{map}\n"));
        let texture = material.base_color_texture.unwrap_or_else(|| panic!("{map}: {:?}", scene.warnings));
        assert_eq!(texture.uv_from_mesh, glam::Affine2::IDENTITY, "{map}");
        assert_eq!(
            (material.surface.base_color, scene.warnings.len()),
            (Vec3::ONE, 0),
            "{:?}",
            scene.warnings
        );
    }
    let (scene, placed) = material(
        "newmtl m\nmap_Kd -s 3 2 1 -o 0.25 0.5 -clamp on -t 1 1 1 tex.png\nmap_Bump tex.png\nmap_Ks tex.png\n",
    );
    let texture = placed.base_color_texture.unwrap();
    // 3 u + 1/4, and 2 v + 1/2 from the bottom.
    assert_eq!(texture.transform(Vec2::new(0.5, 1.0 - 0.125)), Vec2::new(1.75, 1.0 - 0.75));
    assert_eq!(scene.textures[texture.texture.0].wrap, [Wrap::ClampToEdge; 2]);
    assert!(warns(&scene, "no effect here: -t, map_Ks"), "{:?}", scene.warnings);
    let (scene, bent) = material("newmtl m\nnorm -bm 0.5 tex.png\nmap_Ke tex.png\n");
    assert_eq!((bent.normal_scale, bent.emissive, scene.textures.len()), (0.5, Vec3::ONE, 1));
    assert!(bent.normal_texture.is_some() && !scene.meshes[0].tangents.is_empty());
}

#[test]
fn holes_are_cut_by_map_d() {
    // The mask is dark on its left half.
    for (lines, first) in [
        ("map_d mask.png", [255, 255, 255]),
        ("map_Kd tex.png\nmap_d mask.png", [255, 0, 0]),
        ("map_Kd -s 2 2 tex.png\nmap_d -s 2 2 mask.png", [255, 0, 0]),
        ("map_d -imfchan l mask.png", [255, 255, 255]),
    ] {
        let (scene, material) = material(&format!("newmtl m\nKd 0.2 0.6 0.2\n{lines}\n"));
        assert_eq!(material.surface.base_color, Vec3::new(0.2, 0.6, 0.2), "{lines}");
        assert_eq!(material.alpha_mode, AlphaMode::Mask { cutoff: 0.5 }, "{lines}");
        let texture = &scene.textures[material.base_color_texture.unwrap().texture.0];
        let alphas: Vec<u8> = texture.rgba8[..4].iter().map(|texel| texel[3]).collect();
        assert_eq!((alphas.as_slice(), scene.textures.len()), (&[0, 0, 255, 255][..], 1), "{lines}");
        assert_eq!(texture.rgba8[0][..3], first, "{lines}");
    }
    let (scene, opaque) = material("newmtl m\nmap_d -imfchan m mask.png\n");
    assert_eq!(opaque.alpha_mode, AlphaMode::Opaque, "its alpha has no holes");
    assert!(scene.warnings.is_empty());
    let (scene, opaque) = material("newmtl m\nmap_Kd tex.png\nmap_d -s 2 1 1 mask.png\n");
    assert!(opaque.alpha_mode == AlphaMode::Opaque && warns(&scene, "has no holes"));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// A library is text that may hold anything: the model is never lost for it.
    #[test]
    fn no_library_loses_the_model(edits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..8)) {
        let mut library = b"newmtl m\nKd 0.8 0.1 0.1\nNs 10\nKs xyz 1 1 1\nd -halo 0.5\nmap_Kd -s 3 2 1 -o 0.1 tex.png\n\
            map_d -imfchan l mask.png\nnewmtl \"b c\" # d\nnorm -bm 0.5 tex.png\nTr 1\nillum 2\n".to_vec();
        for (place, value) in &edits {
            let place = place.index(library.len());
            library[place] = *value;
        }
        let faces = format!("mtllib a.mtl\n{TRIANGLE}usemtl m\nf 1/1 2/2 3/3\n");
        let scene = scene_of(&[("a.obj", faces.as_bytes()), ("a.mtl", &library), ("tex.png", &picture())]);
        prop_assert_eq!(scene.triangle_count(), 1);
        prop_assert!(scene.warnings.iter().all(|warning| !warning.contains('\n')));
    }
}

/// White is as high as `-bm` hundredths of the picture's width on the surface.
#[test]
fn bump_maps_are_heights() {
    let (scene, material) = material("newmtl m\nmap_bump -bm 2 -s 4 4 mask.png\n");
    let height = material.height.unwrap();
    // Four times along a metre.
    assert!((height.scale - 0.02 * 0.25).abs() < 1e-7, "{height:?}");
    let map = &scene.height_maps[height.map.0];
    assert_eq!((map.size(), map.range()), ([4, 2], [0.0, 1.0]));
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    let (scene, material) = self::material("newmtl m\nbump none.png\n");
    assert!(material.height.is_none() && warns(&scene, "heights are left out"), "{:?}", scene.warnings);
}
