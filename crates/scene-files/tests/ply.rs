//! PLY files as programs write them.
#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests fail the test")]

mod summary;

use glam::{DVec3, Vec2, Vec3, Vec4};
use gnomon_scene::{AlphaMode, Scene};

use self::summary::{Summary, picture, scene_of};

/// A text file of a square, by what its header says beside coordinates, its vertices and its faces.
fn square(comment: &str, vertex: &str, vertices: [&str; 4], face: &str, faces: &str) -> String {
    let places = ["0 0 0", "1 0 0", "1 1 0", "0 1 0"];
    let rows: String = places.iter().zip(vertices).map(|(place, more)| format!("{place} {more}\n")).collect();
    format!(
        "ply\nformat ascii 1.0\n{comment}element vertex 4\nproperty float x\nproperty float y\nproperty float z\n{vertex}\
         element face {}\nproperty list uchar int vertex_indices\n{face}end_header\n{rows}{faces}",
        faces.lines().filter(|line| !line.starts_with("comment")).count()
    )
}

fn ply(text: &str) -> Scene {
    scene_of(&[("a.ply", text.as_bytes()), ("tex.png", &picture()), ("b c.png", &picture())])
}

fn warns(scene: &Scene, part: &str) -> bool {
    scene.warnings.iter().any(|warning| warning.contains(part))
}

const NONE: [&str; 4] = [""; 4];
const FACES: &str = "3 0 1 2\n3 0 2 3\n";

#[test]
fn headers_and_rows_may_hold_more_than_they_should() {
    let plain = square("", "", NONE, "", FACES);
    let expected = ply(&plain);
    assert_eq!((expected.triangle_count(), expected.warnings.len()), (2, 0));
    for text in [
        plain.replace("0 0 0 \n", "0 0 0\ncomment a note\n\nobj_info 3 4\n"),
        plain.replace("3 0 2 3\n", "comment 1 2 3\n3 0 2 3"),
        plain.replace('\n', "\r\n"),
        plain.replace('\n', "\r"),
        format!("\u{feff}{plain}"),
        plain.replace("list uchar int", "list uint8 int64"),
        plain.replace("list uchar int", "list uchar uint64"),
        plain.replace("element vertex", "comment\nobj_info by hand\nelement vertex"),
        plain.replace("1 1 0 \n", "1,0\n 1 0\n"),
    ] {
        assert_eq!(ply(&text), expected, "{text}");
    }
    let text = plain.replace("element vertex", "written by Ann\nelement vertex");
    assert!(warns(&ply(&text), "header line 3 is left out: 'written by Ann'"));
    // MeshLab's colours of corners stand where the header has the face's colour.
    let colors = "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n";
    let text = square("", "", NONE, colors, "3 0 1 2 9 1 1 1 1 1 1 1 1 1\n3 0 2 3 9 1 1 1 1 1 1 1 1 1\n");
    let scene = ply(&text);
    assert_eq!(scene.meshes, expected.meshes);
    assert!(warns(&scene, "2 faces hold more numbers"));
    let scene = ply(&plain.replace("1 0 0 ", "1 0 0 7 8"));
    assert_eq!((&scene.meshes, scene.warnings.len()), (&expected.meshes, 1), "{:?}", scene.warnings);
    // A file whose rows share lines has no rows to be longer.
    let (header, body) = plain.split_once("end_header\n").unwrap();
    assert_eq!(ply(&format!("{header}end_header\n{}", body.replace('\n', " "))), expected);
}

#[test]
fn faces_may_come_before_their_vertices() {
    let text = "ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_indices\nelement vertex 4\nproperty float x\n\
                property float y\nproperty float z\nend_header\n4 0 1 2 3\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n";
    assert_eq!(ply(text).meshes, ply(&square("", "", NONE, "", "4 0 1 2 3\n")).meshes);
}

#[test]
fn a_binary_body_may_begin_with_a_line_end() {
    for end in ["\n", "\r\n", "\r"] {
        let header = square("", "", NONE, "", "3 0 1 2\n").replace("ascii", "binary_little_endian");
        let (header, _) = header.split_once("end_header\n").unwrap();
        let mut bytes = format!("{header}end_header\n").replace('\n', end).into_bytes();
        // The first byte of the first number is an LF.
        let x = f32::from_le_bytes([10, 0, 0x80, 0x3f]);
        for place in [[x, 0.0, 0.0], [2.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]] {
            bytes.extend(place.iter().flat_map(|x| x.to_le_bytes()));
        }
        bytes.push(3);
        bytes.extend([0_u32, 1, 2].iter().flat_map(|i| i.to_le_bytes()));
        assert_eq!(scene_of(&[("a.ply", &bytes)]).meshes[0].positions[0].x, x, "{end:?}");
    }
}

#[test]
fn polygons_are_cut_inside_their_outline() {
    let u = "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n\
             property list uchar int vertex_indices\nend_header\n0 0 0\n3 0 0\n3 3 0\n2 3 0\n2 1 0\n1 1 0\n1 3 0\n0 3 0\n\
             8 0 1 2 3 4 5 6 7\n";
    let summary = Summary::of(&ply(u));
    assert!(
        (summary.area - 7.0).abs() < 1e-6 && summary.normal.distance(7.0 * DVec3::Z) < 1e-5,
        "{summary:?}"
    );
}

#[test]
fn textures_lie_by_vertices_or_by_corners() {
    // What the square shows with the picture once on it, v from the bottom: blue, white at its foot.
    let corner = |scene: &Scene, vertex: usize| scene.meshes[0].uvs[0][vertex];
    for (names, comment) in [
        ("s t", "TextureFile tex.png"),
        ("u v", "TEXTUREFILE b c.png"),
        ("texture_u texture_v", "TextureFile C:\\x\\tex.png"),
    ] {
        let properties: String = names.split(' ').map(|name| format!("property float {name}\n")).collect();
        let text =
            square(&format!("comment {comment}\n"), &properties, ["0 0", "1 0", "1 1", "0 1"], "", FACES);
        let scene = ply(&text);
        let texture = scene.materials[0].base_color_texture.unwrap_or_else(|| panic!("{:?}", scene.warnings));
        assert_eq!((texture.texture.0, scene.materials[0].surface.base_color), (0, Vec3::ONE));
        assert_eq!([corner(&scene, 0), corner(&scene, 2)], [Vec2::Y, Vec2::X]);
    }
    let by_vertices = ply(&square(
        "comment TextureFile tex.png\n",
        "property float s\nproperty float t\n",
        ["0 0", "1 0", "1 1", "0 1"],
        "",
        FACES,
    ));
    let by_corners = |more: &str, color: &str, faces: &str| {
        let face = format!("property list uchar float texcoord\n{more}");
        ply(&square(
            "comment TextureFile tex.png\ncomment TextureFile b c.png\n",
            color,
            ["255 0 0", "0 0 0", "0 0 0", "9 9 9"],
            &face,
            faces,
        ))
    };
    let red = "property uchar red\nproperty uchar green\nproperty uchar blue\n";
    let rows = ["3 0 1 2 6 0 0 1 0 1 1", "3 0 2 3 6 0 0 1 1 0 1"];
    let wedges = by_corners("", red, &format!("{}\n{}\n", rows[0], rows[1]));
    // The texture goes before colours.
    Summary::of(&wedges).assert_like(&Summary::of(&by_vertices), "corners");
    let polygon = by_corners("", red, "4 0 1 2 3 8 0 0 1 0 1 1 0 1\n");
    Summary::of(&polygon).assert_like(&Summary::of(&by_vertices), "corners of a polygon");
    let two = by_corners("property int texnumber\n", red, &format!("{} 1\n{} -1\n", rows[0], rows[1]));
    assert_eq!((two.meshes.len(), two.textures.len()), (2, 1));
    let textured =
        two.meshes.iter().map(|mesh| two.materials[mesh.material.unwrap().0].base_color_texture.is_some());
    assert_eq!(textured.collect::<Vec<_>>(), [true, false]);
    assert!(
        two.meshes[0].colors.is_empty() && !two.meshes[1].colors.is_empty(),
        "colours where no texture is"
    );
    let missing = ply(&square(
        "comment TextureFile none.png\n",
        "",
        NONE,
        "property list uchar float texcoord\n",
        &format!("{}\n", rows[0]),
    ));
    assert!(warns(&missing, "none.png"));
    let without = ply(&square("comment TextureFile tex.png\n", "", NONE, "", FACES));
    assert!(warns(&without, "there are no texture coordinates"));
}

#[test]
fn faces_and_vertices_have_colours_of_any_range() {
    let names = ["red", "green", "blue"];
    let properties =
        |scalar: &str| names.iter().map(|name| format!("property {scalar} {name}\n")).collect::<String>();
    let at_vertices = |scalar: &str, color: &str| {
        ply(&square("", &properties(scalar), [color; 4], "", FACES)).meshes[0].colors[0]
    };
    let at_faces = |scalar: &str, color: &str| {
        let faces = format!("3 0 1 2 {color}\n3 0 2 3 0 0 0\n");
        ply(&square("", "", NONE, &properties(scalar), &faces))
    };
    let expected = Vec4::new(1.0, 0.5029, 0.0, 1.0);
    for (scalar, color) in
        [("uchar", "255 188 0"), ("float", "255 188 0"), ("double", "255.0 188.0 0"), ("float", "1 0.5029 0")]
    {
        assert!((at_vertices(scalar, color) - expected).length() < 1e-3, "{scalar} {color}");
        let scene = at_faces(scalar, color);
        let mesh = &scene.meshes[0];
        assert!(
            mesh.triangles[0].iter().all(|&vertex| (mesh.colors[vertex as usize] - expected).length() < 1e-3)
        );
        assert!(mesh.triangles[1].iter().all(|&vertex| mesh.colors[vertex as usize] == Vec4::W));
        assert_eq!(scene.materials[0].surface.base_color, Vec3::ONE);
    }
}

#[test]
fn an_alpha_that_somebody_has_set_blends() {
    let properties =
        ["red", "green", "blue", "alpha"].map(|name| format!("property uchar {name}\n")).concat();
    let mode = |colors: [&str; 4]| ply(&square("", &properties, colors, "", FACES)).materials[0].alpha_mode;
    let [whole, half, none] = ["9 9 9 255", "9 9 9 128", "9 9 9 0"];
    assert_eq!(mode([whole; 4]), AlphaMode::Opaque);
    assert_eq!(mode([none; 4]), AlphaMode::Opaque);
    assert_eq!(mode([whole, half, whole, none]), AlphaMode::Blend);
}
