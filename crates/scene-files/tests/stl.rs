//! STL files.
#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests fail the test")]

mod summary;

use glam::{Vec3, Vec4};
use gnomon_scene::Ground;
use gnomon_scene_files::{LoadOptions, load};

use self::summary::{open, scene_of};

const PLACES: [[f32; 9]; 2] =
    [[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 0.0, 0.0, 2.0, 0.0, 1.0, 0.0]];

fn binary(header: &[u8], attributes: [u16; 2]) -> Vec<u8> {
    let mut bytes = header.to_vec();
    bytes.resize(80, 0);
    bytes.extend(2_u32.to_le_bytes());
    for (places, attribute) in PLACES.iter().zip(attributes) {
        // A normal of zeros, as many programs write.
        bytes.extend([0; 12]);
        bytes.extend(places.iter().flat_map(|x| x.to_le_bytes()));
        bytes.extend(attribute.to_le_bytes());
    }
    bytes
}

#[test]
fn text_and_binary_say_the_same() {
    let facet = |places: &[f32; 9]| {
        let corners: String =
            places.chunks(3).map(|p| format!("   vertex {:e} {} {}\n", p[0], p[1], p[2])).collect();
        format!(" facet normal 0 0 0\n  outer loop\n{corners}  endloop\n endfacet\n")
    };
    let text = format!("solid vertex of facet\n{}{}endsolid vertex\n", facet(&PLACES[0]), facet(&PLACES[1]));
    let plain = scene_of(&[("a.stl", text.as_bytes())]);
    let mesh = &plain.meshes[0];
    assert_eq!(mesh.triangles, [[0, 1, 2], [3, 4, 5]]);
    assert_eq!(mesh.positions[4], Vec3::new(0.0, 0.0, 2.0));
    assert_eq!([mesh.normals[0], mesh.normals[3]], [Vec3::Z, Vec3::NEG_X]);
    assert!(plain.materials[0].double_sided && plain.warnings.is_empty());
    // Several solids, letters of any size, lines of any end, all on one line.
    let two = format!("solid\n{}endsolid\nsolid b\n{}endsolid b\n", facet(&PLACES[0]), facet(&PLACES[1]));
    let one_line =
        format!("solid x\n{}", format!("{}{}", facet(&PLACES[0]), facet(&PLACES[1])).replace('\n', " "));
    let commented = format!("# by Ann\n{}", text.replace('\n', " # note\n # note\n"));
    for text in [
        commented,
        text.to_uppercase(),
        text.replace('\n', "\r\n"),
        two,
        one_line,
        format!("\u{feff} {text}"),
    ] {
        assert_eq!(scene_of(&[("a.stl", text.as_bytes())]), plain, "{text}");
    }
    for header in ["", "solid facet"] {
        let mut bytes = binary(header.as_bytes(), [0, 0]);
        assert_eq!(scene_of(&[("a.STL", &bytes)]), plain);
        if header.is_empty() {
            bytes.extend(b"more");
            assert_eq!(scene_of(&[("a.stl", &bytes)]), plain);
        }
    }
}

#[test]
fn colours_are_those_of_visicam_or_of_materialise() {
    let red = Vec4::new(1.0, 0.0, 0.0, 1.0);
    let scene = scene_of(&[("a.stl", &binary(b"", [0x8000 | 31 << 10, 0]))]);
    let colors = |scene: &gnomon_scene::Scene| [scene.meshes[0].colors[0], scene.meshes[0].colors[5]];
    assert_eq!(colors(&scene), [red, Vec4::new(0.5, 0.5, 0.5, 1.0)]);
    assert_eq!(scene.materials[0].surface.base_color, Vec3::ONE);
    let scene = scene_of(&[("a.stl", &binary(b"x COLOR=\xff\xff\x00\xff MATERIAL=", [31, 0x8000]))]);
    assert_eq!(colors(&scene), [red, Vec4::new(1.0, 1.0, 0.0, 1.0)]);
    assert!(scene_of(&[("a.stl", &binary(b"", [31, 5]))]).meshes[0].colors.is_empty());
}

#[test]
fn damaged_files_say_what_is_wrong() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.stl");
    let whole = binary(b"", [0, 0]);
    for (bytes, part) in [
        (&whole[..whole.len() - 1], "promises 2 triangles, but has room for 1"),
        (b"hello", "neither text nor long enough"),
        (b"solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0\n", "line 4: 3 numbers expected, 2 found"),
        (b"solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 x\n", "line 4: 'x' is no number"),
        (b"solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n", "ends within a facet"),
    ] {
        std::fs::write(&path, bytes).unwrap();
        let error = load(&path, &LoadOptions::default()).unwrap_err().to_string();
        assert!(error.contains(part) && error.contains("a.stl"), "{error}");
    }
    std::fs::write(&path, b"solid nothing\nendsolid nothing\n").unwrap();
    let loaded = open(&path);
    assert!(loaded.scene.warnings[0].contains("no triangles") && loaded.ground == Ground::Fade);
}
