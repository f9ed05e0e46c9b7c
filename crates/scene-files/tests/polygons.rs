//! OBJ and PLY features, one small file each.
#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests fail the test")]

use glam::{Vec2, Vec3, Vec4};
use gnomon_scene::{AlphaMode, Scene};
use gnomon_scene_files::{LoadOptions, SceneFileError, formats, load};
use proptest::prelude::*;

fn attempt(name: &str, bytes: &[u8]) -> Result<Scene, SceneFileError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    load(&path, &LoadOptions::default()).map(|loaded| loaded.scene)
}

fn read(name: &str, bytes: &[u8]) -> Scene {
    attempt(name, bytes).unwrap_or_else(|error| panic!("{error}"))
}

/// A mesh as a PLY writer sees it.
#[derive(Clone, Debug)]
struct Polygons {
    positions: Vec<[f32; 3]>,
    colors: Vec<[u8; 3]>,
    faces: Vec<Vec<u32>>,
}

#[derive(Clone, Copy)]
enum Encoding {
    Ascii,
    Little,
    Big,
}

fn ply(mesh: &Polygons, encoding: Encoding) -> Vec<u8> {
    let format = match encoding {
        Encoding::Ascii => "ascii",
        Encoding::Little => "binary_little_endian",
        Encoding::Big => "binary_big_endian",
    };
    let mut bytes = format!(
        "ply\nformat {format} 1.0\ncomment made by a test\nelement vertex {}\nproperty float x\nproperty float y\n\
         property float z\nproperty list uchar short extra\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n\
         element face {}\nproperty ushort flags\nproperty list uchar int vertex_indices\nelement other 1\n\
         property double value\nend_header\n",
        mesh.positions.len(),
        mesh.faces.len()
    )
    .into_bytes();
    let mut word = |text: String, little: &[u8]| match encoding {
        Encoding::Ascii => bytes.extend(format!("{text} ").bytes()),
        Encoding::Little => bytes.extend(little),
        Encoding::Big => bytes.extend(little.iter().rev()),
    };
    for (position, color) in mesh.positions.iter().zip(&mesh.colors) {
        // Text is read in double precision: it says exactly what the bytes say.
        position.iter().for_each(|x| word(format!("{:?}", f64::from(*x)), &x.to_le_bytes()));
        word("2".to_owned(), &[2]);
        word("-7".to_owned(), &(-7_i16).to_le_bytes());
        word("7".to_owned(), &7_i16.to_le_bytes());
        color.iter().for_each(|c| word(c.to_string(), &[*c]));
    }
    for face in &mesh.faces {
        word("9".to_owned(), &9_u16.to_le_bytes());
        word(face.len().to_string(), &[face.len() as u8]);
        face.iter().for_each(|i| word(i.to_string(), &i.to_le_bytes()));
    }
    word("1.5".to_owned(), &1.5_f64.to_le_bytes());
    bytes
}

fn polygons() -> impl Strategy<Value = Polygons> {
    (3_usize..12).prop_flat_map(|count| {
        let position = prop::array::uniform3(-1e3_f32..1e3);
        let face = prop::collection::vec(0..count as u32, 3..6);
        (
            prop::collection::vec(position, count),
            prop::collection::vec(prop::array::uniform3(any::<u8>()), count),
            prop::collection::vec(face, 1..8),
        )
            .prop_map(|(positions, colors, faces)| Polygons { positions, colors, faces })
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// The three encodings of a PLY file say the same, and what they say is what was written.
    #[test]
    fn ply_encodings_are_twins(mesh in polygons()) {
        let scenes = [Encoding::Ascii, Encoding::Little, Encoding::Big].map(|e| read("mesh.ply", &ply(&mesh, e)));
        prop_assert_eq!(&scenes[0], &scenes[1]);
        prop_assert_eq!(&scenes[0], &scenes[2]);
        let triangles = Polygons { faces: mesh.faces.iter().map(|face| face[..3].to_vec()).collect(), ..mesh };
        let expected: Vec<Vec3> = triangles
            .faces
            .iter()
            .flatten()
            .map(|&i| Vec3::from_array(triangles.positions[i as usize]))
            .collect();
        let scene = read("mesh.ply", &ply(&triangles, Encoding::Big));
        prop_assert_eq!(scene.meshes[0].positions.len(), expected.len());
        // Faces that are small for where they lie have an origin of their own.
        let placed = scene.meshes[0].positions.iter().map(|position| position.as_dvec3() + scene.origin);
        for (found, expected) in placed.zip(&expected) {
            let expected = expected.as_dvec3();
            prop_assert!(found.distance(expected) <= 1e-6 * expected.length(), "{found} is not {expected}");
        }
    }

    /// Normals are missing, so they are flat: each the normal of its triangle.
    #[test]
    fn missing_normals_are_flat(mesh in polygons()) {
        let scene = read("mesh.ply", &ply(&mesh, Encoding::Little));
        let mesh = &scene.meshes[0];
        prop_assert_eq!(mesh.positions.len(), 3 * mesh.triangles.len());
        for triangle in &mesh.triangles {
            let [a, b, c] = triangle.map(|i| mesh.positions[i as usize].as_dvec3());
            let normal = (b - a).cross(c - a);
            for &i in triangle {
                let found = mesh.normals[i as usize].as_dvec3();
                prop_assert!((found.length() - 1.0).abs() < 1e-5);
                prop_assert!(normal.length() == 0.0 || found.dot(normal.normalize()) > 0.999_99);
            }
        }
    }
}

#[test]
fn ply_colours_are_linearized_and_normals_kept() {
    let scene = read(
        "a.ply",
        b"ply\r\nformat ascii 1.0\r\nelement vertex 3\r\nproperty double x\r\nproperty double y\r\nproperty double z\r\n\
          property float nx\r\nproperty float ny\r\nproperty float nz\r\nproperty uchar red\r\nproperty uchar green\r\n\
          property uchar blue\r\nproperty float s\r\nproperty float t\r\nelement face 1\r\n\
          property list uchar uint vertex_index\r\nend_header\r\n\
          0 0 0  0 0 2  255 188 0  0 0\r\n1 0 0  0 0 1  0 0 0  1 0\r\n0 1 0  0 1 1  0 0 0  0 1\r\n3 0 1 2\r\n",
    );
    let mesh = &scene.meshes[0];
    assert_eq!(mesh.positions.len(), 3, "vertices stay shared");
    assert_eq!(mesh.normals[0], Vec3::Z);
    assert!((mesh.colors[0] - Vec4::new(1.0, 0.5029, 0.0, 1.0)).length() < 1e-3);
    // v counts from the bottom in the file, from the top here.
    assert_eq!(mesh.uvs[0][2], Vec2::ZERO);
}

#[test]
fn ply_strips_turn_every_second_triangle() {
    let scene = read(
        "a.ply",
        b"ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
          element tristrips 1\nproperty list int int vertex_indices\nend_header\n\
          0 0 0\n1 0 0\n0 1 0\n1 1 0\n8 0 1 2 3 -1 0 1 3\n",
    );
    assert_eq!(scene.triangle_count(), 3);
    assert_eq!(scene.meshes[0].normals, [Vec3::Z; 9]);
}

#[test]
fn damaged_ply_files_say_what_is_wrong() {
    let header = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                  element face 1\nproperty list uchar int vertex_indices\nend_header\n";
    let with = |body: &str| format!("{header}{body}");
    let cases = [
        (with("0 0 0 1 0 0 0 1 0 3 0 1 3"), "names vertex 3, but there are 3"),
        (with("0 0 0 1 0 0 0 1 0 3 0 1 -1"), "no index"),
        (with("0 0 0 1 0 0 0 1 0 -3 0 1 2"), "promises -3 items"),
        (with("0 0 0 1 0 0 0 1 0 3000000 0 1 2"), "promises 3000000 items"),
        (with("0 0 0 1 0 0 0 1 0 3 0 1"), "promises 3 items, but the file has room for 2"),
        (with("0 0 0 1 0 0 0 1               "), "ends too early"),
        (with("0 0 0 1 0 0 0 1 zero 3 0 1 2"), "'zero' stands where a number should"),
        (with("0 0 0").replace("vertex 3", "vertex 99999999999999"), "more than the file has room for"),
        (with("").replace("vertex 3", "vertex -3"), "header line 3"),
        (with("").replace("float x", "half x"), "header line 4"),
        (with("").replace("ascii", "utf8"), "header line 2"),
        (with("").replace("1.0", "2.0"), "version 2.0"),
        (with("0 0 0 1 0 0 0 1 0 3 0 1 2").replace("float z", "float w"), "no x, y and z"),
        ("ply\nformat ascii 1.0\n".to_owned(), "header does not end"),
        ("plywood\n".to_owned(), "does not start with 'ply'"),
    ];
    for (text, reason) in cases {
        let error = attempt("a.ply", text.as_bytes()).unwrap_err().to_string();
        assert!(
            error.contains(reason) && error.contains("a.ply") && !error.contains('\n'),
            "{reason}: {error}"
        );
    }
}

#[test]
fn triangles_with_corners_that_are_not_finite_are_dropped_with_a_warning() {
    let text =
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv nan 0 0\nv inf 0 0\nv 1e30 0 0\nf 1 2 3\nf 1 2 4\nf 1 2 5\nf 1 2 6\n";
    let scene = read("a.obj", text.as_bytes());
    assert_eq!(scene.triangle_count(), 1);
    assert!(scene.warnings[0].contains("left out 3 triangles"), "{:?}", scene.warnings);
    assert!(scene.bounds().unwrap().max.is_finite());
}

#[test]
fn obj_reads_polygons_negative_indices_joined_lines_and_comments() {
    let scene = read(
        "a.obj",
        b"# a square and a triangle\nv 0 0 0 # origin\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 \\\n 3 4\nf -4 -3 -2\nl 1 2\n",
    );
    assert_eq!(scene.triangle_count(), 3);
    assert_eq!(scene.meshes.len(), 1);
    assert!(scene.materials[0].double_sided);
    assert!(scene.warnings[0].contains("points, lines"));
}

#[test]
fn obj_faces_are_smooth_with_normals_and_flat_without() {
    let scene = read(
        "a.obj",
        b"v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 1 1\nvt 0 0.25\nf 1/1/1 2/1/1 3/1/1\nf 3//1 2//1 1//1\nf 1 2 3\n",
    );
    assert_eq!(scene.meshes.len(), 2);
    assert!((scene.meshes[0].normals[0] - Vec3::new(0.0, 1.0, 1.0).normalize()).length() < 1e-6);
    assert_eq!(scene.meshes[0].uvs[0][0], Vec2::new(0.0, 0.75));
    assert_eq!(scene.meshes[1].normals, [Vec3::Z; 3]);
}

#[test]
fn damaged_obj_files_name_the_line() {
    for (text, reason) in [
        ("v 0 0 0\nf 1 2 3\n", "line 2: a face names vertex 2, but there are 1"),
        ("v 0 0 0\nf 1 0 1\n", "line 2: a face names vertex 0"),
        ("v 0 0 0\nf 1 -2 1\n", "line 2: a face names vertex -2"),
        ("v 0 0\n", "line 1: 3 numbers expected, 2 found"),
        ("\n\nv 0 0 x\n", "line 3: 'x' is no number"),
        ("v 0 0 1.#QNAN\nv 0 0\n", "line 2: 3 numbers expected"),
        ("v 0 0 0\nf 1/a 1 1\n", "'1/a' is no face corner"),
        ("v 0 0 0\nf 1/// 1 1\n", "'1///' is no face corner"),
        ("v 0 0 0\nf -9223372036854775808 1 1\n", "there are 1"),
    ] {
        let error = attempt("a.obj", text.as_bytes()).unwrap_err().to_string();
        assert!(error.contains(reason) && !error.contains('\n'), "{text:?}: {error}");
    }
}

#[test]
fn obj_materials_are_translated_and_missing_ones_are_warnings() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    image::RgbaImage::from_pixel(2, 1, image::Rgba([255, 0, 0, 255]))
        .save(folder.path().join("red dot.png"))
        .unwrap();
    write(
        "a.mtl",
        "newmtl matte\nKd 0.8 0.4 0.2\nKs 0 0 0\nillum 1\nnewmtl shiny\nKd 0 0 0\nKs 0.5 0.25 0.5\nNs 98\nNi 1.4\nKe 1 2 3\n\
         map_Kd red dot.png\nd 0.5\nillum 2\nnewmtl broken\nmap_Kd -s 1 1 1 nothing.png\n",
    );
    write(
        "a.obj",
        "mtllib a.mtl\nmtllib absent.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl matte\nf 1 2 3\nusemtl shiny\nf 1 2 3\n\
         usemtl unknown\nf 1 2 3\n",
    );
    let scene = load(&folder.path().join("a.obj"), &LoadOptions::default()).unwrap().scene;
    let used: Vec<_> = scene.meshes.iter().map(|mesh| &scene.materials[mesh.material.unwrap().0]).collect();
    assert_eq!(used[0].surface.base_color, Vec3::new(0.8, 0.4, 0.2));
    assert_eq!(used[0].surface.specular, 0.0);
    assert_eq!(used[1].surface.base_color, Vec3::ONE, "black times a map would be black");
    assert_eq!(used[1].surface.specular, 0.5);
    assert_eq!(used[1].surface.specular_color, Vec3::new(1.0, 0.5, 1.0));
    // alpha = sqrt(2 / 100), roughness = sqrt(alpha).
    assert!((used[1].surface.roughness - 0.02_f32.sqrt().sqrt()).abs() < 1e-6);
    assert_eq!(used[1].surface.ior, 1.4);
    assert_eq!(used[1].emissive, Vec3::new(1.0, 2.0, 3.0));
    assert!(used[1].base_color_texture.is_some());
    assert_eq!((used[1].alpha, used[1].alpha_mode), (0.5, AlphaMode::Blend));
    assert_eq!(used[2].surface.base_color, Vec3::splat(0.5));
    for part in ["absent.mtl", "nothing.png", "'unknown' is not defined"] {
        assert!(scene.warnings.iter().any(|warning| warning.contains(part)), "{part}: {:?}", scene.warnings);
    }
}

#[test]
fn formats_are_told_by_name_and_content() {
    let extensions: Vec<&str> = formats().iter().flat_map(|format| format.extensions).copied().collect();
    assert_eq!(extensions, ["glb", "gltf", "obj", "ply", "stl", "toml"]);
    let error = attempt("a.xyz", b"hello").unwrap_err().to_string();
    assert!(error.contains("a.xyz") && error.contains("PLY .ply"), "{error}");
    let text = b"ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
    let scene = read("a.obj", text);
    assert!(scene.warnings.iter().any(|warning| warning.contains("named like OBJ but holds PLY")));
    assert!(matches!(attempt("A.PLY", b""), Err(SceneFileError::Invalid { .. })));
    assert!(matches!(load("nothing.ply".as_ref(), &LoadOptions::default()), Err(SceneFileError::Io { .. })));
    assert!(matches!(
        load(std::env::temp_dir().as_path(), &LoadOptions::default()),
        Err(SceneFileError::Invalid { .. })
    ));
}

#[test]
fn the_memory_limit_holds() {
    let mut text = "v 0 0 0\nv 1 0 0\nv 0 1 0\n".to_owned();
    text.extend(std::iter::repeat_n("f 1 2 3\n", 2_000));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.obj");
    std::fs::write(&path, text).unwrap();
    assert!(load(&path, &LoadOptions::default()).is_ok());
    let options = LoadOptions { memory_limit: 1 << 20, ..LoadOptions::default() };
    let error = load(&path, &options).unwrap_err();
    assert_eq!(
        error.to_string(),
        format!("{} asks for more than the 1 MiB allowed for one scene", path.display())
    );
}
