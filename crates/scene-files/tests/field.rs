//! Cases from the field: a file as some program wrote it, and one that says the same plainly.
#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests fail the test")]

mod summary;

use gnomon_scene::AlphaMode;
use gnomon_testing::data_file;

use self::summary::{Summary, open};

const CASES: [(&str, &str); 24] = [
    ("obj_ngon_u_shape", "u.obj plain.obj"),
    ("obj_quad_arrowhead", "arrow.obj plain.obj"),
    ("obj_backslash_in_comment", "comment.obj plain.obj"),
    ("obj_mtllib_two_files", "two.obj plain.obj"),
    ("obj_vn_msvc_nan", "case.obj plain.obj"),
    ("obj_crlf_tabs", "case.obj plain.obj"),
    ("obj_utm_coordinates", "case.obj plain.obj"),
    ("obj_index_zero", "case.obj plain.obj"),
    ("obj_negative_mixed", "case.obj plain.obj"),
    ("mtl_map_scale", "case.obj plain.obj"),
    ("mtl_map_option_then_blank_in_name", "case.obj plain.obj"),
    ("mtl_map_lowercase", "case.obj plain.obj"),
    ("mtl_hash_in_name", "case.obj plain.obj"),
    ("mtl_kd_xyz_spectral", "case.obj plain.obj"),
    ("ply_ngon_u_shape", "case.ply plain.ply"),
    ("ply_double_utm", "case.ply plain.ply"),
    ("ply_meshlab_ascii_wedge_colors", "case.ply plain.ply"),
    ("ply_texture_wedges", "case.ply plain.obj"),
    ("ply_face_colors", "case.ply plain.ply"),
    ("ply_big_endian_odd_lists", "case.ply plain.ply"),
    ("ply_int64_indices", "case.ply plain.ply"),
    ("ply_comment_in_body", "case.ply plain.ply"),
    ("ply_header_crlf_binary", "case.ply plain.ply"),
    ("gltf_far_origin_node", "case.glb plain.glb"),
];

#[test]
fn cases_say_what_their_plain_files_say() {
    let Some(folder) = data_file("field") else { return };
    for (case, files) in CASES {
        let [odd, plain] = files.split_once(' ').map(|(odd, plain)| [odd, plain]).unwrap();
        let [odd, plain] = [odd, plain].map(|file| Summary::of(&open(&folder.join(case).join(file)).scene));
        odd.assert_like(&plain, case);
    }
}

#[test]
fn leaves_are_cut_out() {
    let Some(path) = data_file("field/mtl_map_d_leaves/case.obj") else { return };
    let scene = open(&path).scene;
    let used = |mesh: &gnomon_scene::Mesh| &scene.materials[mesh.material.unwrap().0];
    assert!(scene.meshes.iter().any(|mesh| matches!(used(mesh).alpha_mode, AlphaMode::Mask { .. })));
}
