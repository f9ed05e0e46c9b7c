//! Data sets, by the real binary.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

mod support;

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

use serde_json::Value;
use support::{can_render, command, files, gnomon};

/// Twelve items that take little time, of everything that may be drawn.
const MANIFEST: &str = r#"
items = 12
seed = 3
pictures = ["exr", "png"]
layers = ["depth", "object"]

[scene]
file = { list = ["three-boxes", "column"] }

[environment]
file = { any = ["room", "sky"] }
rotation = { min = 0.0, max = 360.0 }

[camera]
azimuth = { from = 0, to = 90, steps = 2 }
elevation = { min = 5.0, max = 40.0 }

[[pose]]
node = 1
move = { min = [0.0, 0.0, 0.0], max = [0.2, 0.0, 0.2] }

[[material]]
material = 0
base_color = { min = [0.1, 0.1, 0.1], max = [0.9, 0.9, 0.9] }

[fit]
light_count = 4
method = "disks"

[render]
ambient = "unshadowed"
shadow_resolution = 64
supersample = 1

[display]
size = [48, 36]
"#;

fn items(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    files(folder).into_iter().map(|name| (name.clone(), fs::read(folder.join(name)).unwrap())).collect()
}

#[test]
fn an_item_is_the_same_in_any_part_of_the_set() {
    let folder = tempfile::tempdir().unwrap();
    if !can_render(folder.path()) {
        return;
    }
    fs::write(folder.path().join("set.toml"), MANIFEST).unwrap();
    gnomon(folder.path(), &["dataset", "set.toml", "-o", "whole"]).succeeded();
    let whole = items(&folder.path().join("whole"));
    assert_eq!(whole.len(), 36);
    let pictures: std::collections::BTreeSet<_> =
        whole.iter().filter(|(name, _)| name.ends_with(".exr")).map(|(_, bytes)| bytes).collect();
    assert_eq!(pictures.len(), 12, "no two items show the same");

    // In two parts, of which one is killed and taken up again.
    let parts = folder.path().join("parts");
    let mut run =
        command(folder.path(), &["dataset", "set.toml", "-o", "parts", "--range", "4..11"]).spawn().unwrap();
    let deadline = Instant::now() + Duration::from_secs(120);
    while !parts.is_dir() || files(&parts).iter().filter(|name| name.ends_with(".json")).count() < 2 {
        assert!(Instant::now() < deadline && run.try_wait().unwrap().is_none());
        std::thread::sleep(Duration::from_millis(1));
    }
    run.kill().unwrap();
    run.wait().unwrap();
    gnomon(folder.path(), &["dataset", "set.toml", "-o", "parts", "--range", "0..3"]).succeeded();
    gnomon(folder.path(), &["dataset", "set.toml", "-o", "parts"]).succeeded();
    let parts: BTreeMap<_, _> =
        items(&parts).into_iter().filter(|(name, _)| !name.ends_with(".part")).collect();
    assert!(parts == whole);

    let line: Value = serde_json::from_slice(&whole["000005.json"]).unwrap();
    assert_eq!((&line["item"], &line["camera"]["size"]), (&5.into(), &serde_json::json!([48, 36])));
    assert_eq!(line["lights"].as_array().unwrap().len(), 4);
    for object in line["objects"].as_array().unwrap() {
        let sides: Vec<f64> =
            object["box_2d"].as_array().unwrap().iter().map(|side| side.as_f64().unwrap()).collect();
        assert!(
            sides[0] < sides[2] && sides[1] < sides[3] && sides[2] <= 47.5 && sides[3] <= 35.5,
            "{object}"
        );
    }

    // The files of shards are the same.
    gnomon(folder.path(), &["dataset", "set.toml", "-o", "shards", "--shards", "5"]).succeeded();
    let shards = items(&folder.path().join("shards"));
    let names: Vec<_> = shards.keys().map(String::as_str).filter(|name| name.ends_with(".tar")).collect();
    assert_eq!(names, ["000000-000004.tar", "000005-000009.tar", "000010-000011.tar"]);
    let first = &shards["000000-000004.tar"];
    let picture = &whole["000003.exr"];
    assert!(first.windows(picture.len()).any(|bytes| bytes == picture.as_slice()));

    // Another manifest is not mixed in.
    fs::write(folder.path().join("set.toml"), MANIFEST.replace("seed = 3", "seed = 4")).unwrap();
    gnomon(folder.path(), &["dataset", "set.toml", "-o", "whole"]).failed("belongs to another manifest");
}

#[test]
fn a_bad_item_is_left_out_and_told() {
    let folder = tempfile::tempdir().unwrap();
    if !can_render(folder.path()) {
        return;
    }
    let manifest = MANIFEST.replace(r#"["three-boxes", "column"]"#, r#"["three-boxes", "absent.glb"]"#);
    fs::write(folder.path().join("set.toml"), manifest.replace("items = 12", "items = 4")).unwrap();
    let run = gnomon(folder.path(), &["dataset", "set.toml", "-o", "out"]);
    run.failed("2 of 4 items could not be drawn");
    let lines = files(&folder.path().join("out"));
    assert_eq!(lines.iter().filter(|name| name.ends_with(".json")).count(), 2);
}

#[test]
fn a_manifest_that_makes_no_sense_is_told_in_a_line() {
    let folder = tempfile::tempdir().unwrap();
    for (change, why) in [
        (("items = 12", "items = 0"), "1 to 1000000000 items, not 0"),
        (("items = 12", "itms = 12"), "unknown field `itms`"),
        (("[scene]", "[scenes]"), "scenes"),
        (("file = { list", "fil = { list"), "fil"),
        (("light_count = 4", "light_count = -4"), "light_count"),
        (("azimuth", "azimut"), "azimut"),
        (("seed = 3", "seed = "), "line 3"),
        (("\"depth\", \"object\"", "\"motion\""), "no layer `motion`"),
        (("[\"exr\", \"png\"]", "[\"png\"]"), "has to hold \"exr\""),
        (("min = 5.0", "min = 50.0"), "`camera.elevation` lies between"),
    ] {
        fs::write(folder.path().join("set.toml"), MANIFEST.replace(change.0, change.1)).unwrap();
        gnomon(folder.path(), &["dataset", "set.toml", "-o", "out"]).failed(why);
    }
    fs::write(folder.path().join("set.toml"), MANIFEST).unwrap();
    gnomon(folder.path(), &["dataset", "set.toml", "-o", "out", "--range", "5..12"])
        .failed("the last one of the manifest is 11");
}
