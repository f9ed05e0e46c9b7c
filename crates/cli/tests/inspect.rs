//! What people run on a folder before a batch.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

mod support;

use glam::Vec3;
use gnomon::picture::{RgbImage, write};
use support::gnomon;

#[test]
fn every_file_is_told_in_a_line_and_one_that_cannot_be_read_fails() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::create_dir(at("maps")).unwrap();
    let mut map = RgbImage::filled(8, 4, Vec3::splat(0.5));
    *map.get_mut(0, 0) = Vec3::splat(f32::NAN);
    write(at("maps/sky.exr"), &map).unwrap();
    std::fs::write(at("flat.obj"), "v 0 0 0\nv 2 0 0\nv 0 3 0\nusemtl none\nf 1 2 3\n").unwrap();
    std::fs::write(
        at("scene.toml"),
        "[environment]\nfile = \"maps/sky.exr\"\n[[model]]\nfile = \"flat.obj\"\n",
    )
    .unwrap();
    std::fs::write(at("notes.txt"), "nothing of ours").unwrap();

    let run = gnomon(folder.path(), &["inspect", "."]).succeeded();
    let lines: Vec<&str> = run.out.lines().collect();
    assert_eq!(lines.len(), 3, "{}", run.out);
    assert!(lines[0].starts_with("./flat.obj: scene, 1 triangle, 1 mesh"), "{}", lines[0]);
    assert!(lines[0].contains("2.0000 x 3.0000 x 0.0000 m"), "{}", lines[0]);
    assert!(lines[1].starts_with("./maps/sky.exr: OpenEXR map, equirect, 8 x 4 texels"), "{}", lines[1]);
    assert!(lines[1].ends_with("; but 1 NaN texels were set to 0"), "{}", lines[1]);
    assert!(lines[2].contains("environment ./maps/sky.exr") && lines[2].contains("NaN"), "{}", lines[2]);

    std::fs::write(at("maps/broken.hdr"), "#?RADIANCE\n").unwrap();
    let run = gnomon(folder.path(), &["inspect", "maps", "flat.obj", "absent.glb"])
        .failed("2 of 4 files cannot be read");
    assert_eq!(run.out.lines().count(), 4, "{}", run.out);
    assert!(run.out.contains("maps/broken.hdr: cannot be read: damaged Radiance file"), "{}", run.out);

    let run = gnomon(folder.path(), &["inspect", "--json", "maps", "flat.obj"]).failed("1 of 3 files");
    let reports: serde_json::Value = serde_json::from_str(&run.out).unwrap();
    assert_eq!(reports[0]["kind"], "map");
    assert!(reports[0]["error"].as_str().unwrap().contains("damaged"));
    assert_eq!(reports[1]["found"]["projection"], "equirect");
    assert_eq!(reports[1]["left_out"].as_array().unwrap().len(), 1);
    assert_eq!((&reports[2]["kind"], &reports[2]["found"]["triangles"]), (&"scene".into(), &1.into()));
}

#[test]
fn a_layer_is_chosen_by_name_and_named_where_none_is_plain() {
    let Some(file) = gnomon_testing::data_file("field/exr_blender_multilayer/case.exr") else { return };
    let folder = tempfile::tempdir().unwrap();
    let file = file.to_str().unwrap();
    let decompose = |more: &[&str]| {
        let arguments =
            [&["decompose", file, "--method", "partition", "--light-count", "8", "-o", "l.json"], more];
        gnomon(folder.path(), &arguments.concat())
    };
    let plain = decompose(&[]).succeeded();
    assert!(!plain.err.contains("warning"), "{}", plain.err);
    let lights = || std::fs::read_to_string(folder.path().join("l.json")).unwrap();
    let by_itself = lights();
    decompose(&["--env-layer", "viewlayer.combined"]).succeeded();
    assert_eq!(lights(), by_itself);
    let grey = decompose(&["--env-layer", "ViewLayer.Depth.Z"]).succeeded();
    assert!(grey.err.contains("as grey") && lights() != by_itself, "{}", grey.err);
    decompose(&["--env-layer", "diffuse"]).failed("there is ViewLayer.Combined");
}
