//! Sequences and saved scenes, by the real binary.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

mod support;

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::time::{Duration, Instant, SystemTime};

use support::{can_render, command, files, gnomon};

/// A scene that takes little time, moving in every way that needs no file.
const MOVING: [&str; 20] = [
    "three-boxes",
    "--env",
    "room",
    "--size",
    "48x36",
    "--lights",
    "disks",
    "--light-count",
    "4",
    "--ambient",
    "unshadowed",
    "--shadow-resolution",
    "64",
    "--supersample",
    "1",
    "--fps",
    "4",
    "--turntable",
    "40",
    "--env-turn=-30",
];

/// Every picture of a folder.
fn pictures(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let names = files(folder).into_iter().filter(|name| !name.ends_with(".json"));
    names.map(|name| (name.clone(), fs::read(folder.join(name)).unwrap())).collect()
}

fn times(folder: &Path) -> BTreeMap<String, SystemTime> {
    let time = |name: &String| fs::metadata(folder.join(name)).unwrap().modified().unwrap();
    files(folder)
        .into_iter()
        .filter(|name| name.ends_with(".png"))
        .map(|name| (name.clone(), time(&name)))
        .collect()
}

#[test]
fn frames_do_not_depend_on_how_runs_are_split_or_broken_off() {
    let folder = tempfile::tempdir().unwrap();
    if !can_render(folder.path()) {
        return;
    }
    let arguments = |frames: &'static str, output: &'static str| {
        [&["render", "--frames", frames, "-o", output][..], &MOVING[..]].concat()
    };
    gnomon(folder.path(), &arguments("0..23", "whole/x_###.png")).succeeded();
    let whole = pictures(&folder.path().join("whole"));
    assert_eq!(whole.len(), 24);
    assert!(whole.contains_key("x_000.png") && whole.contains_key("x_023.png"));
    let distinct: std::collections::BTreeSet<_> = whole.values().collect();
    assert_eq!(distinct.len(), 24, "everything moves");

    gnomon(folder.path(), &arguments("20..23", "split/x_###.png")).succeeded();
    gnomon(folder.path(), &arguments("0..19", "split/x_###.png")).succeeded();
    assert!(pictures(&folder.path().join("split")) == whole);

    let killed = folder.path().join("killed");
    let mut run = command(folder.path(), &arguments("0..23", "killed/x_###.png")).spawn().unwrap();
    let deadline = Instant::now() + Duration::from_secs(120);
    while !killed.join("x_002.png").exists() {
        assert!(Instant::now() < deadline && run.try_wait().unwrap().is_none());
        std::thread::sleep(Duration::from_millis(1));
    }
    run.kill().unwrap();
    run.wait().unwrap();
    let before = times(&killed);
    assert!((3..24).contains(&before.len()), "killed too late: {} frames", before.len());
    gnomon(folder.path(), &arguments("0..23", "killed/x_###.png")).succeeded();
    assert!(pictures(&killed) == whole);
    let after = times(&killed);
    // The last one before the kill may not have been noted.
    assert!(
        before.iter().take(before.len() - 1).all(|(name, time)| after[name] == *time),
        "kept files were drawn again"
    );
}

#[test]
fn frames_of_other_settings_are_not_mixed() {
    let folder = tempfile::tempdir().unwrap();
    let run = |arguments: &[&str]| {
        let fixed = ["reference", "column", "--size", "8x6", "--spp", "2", "-o", "x.exr"];
        gnomon(folder.path(), &[&fixed[..], arguments].concat())
    };
    run(&["--env", "room", "--duration", "0.2", "--fps", "10"]).succeeded();
    assert_eq!(files(folder.path()), ["x_####.exr.sequence.json", "x_0000.exr", "x_0001.exr"]);
    run(&["--env", "sky", "--frames", "0..2"]).failed("x_0000.exr was drawn with other settings");
    run(&["--env", "room", "--frames", "0..2", "--fps", "10", "--exposure", "1"]).failed("--overwrite");
    let first = fs::read(folder.path().join("x_0000.exr")).unwrap();
    run(&["--env", "room", "--frames", "1..2", "--fps", "10"]).succeeded();
    assert_eq!(files(folder.path()).len(), 4);
    run(&["--env", "sky", "--frames", "0..2", "--overwrite"]).succeeded();
    assert_ne!(fs::read(folder.path().join("x_0000.exr")).unwrap(), first);
    run(&["--env", "sky", "--turntable", "3"]).failed("--frames or --duration");
    run(&["--env", "sky", "--frames", "0..9", "--duration", "0.1"]).failed("ends with frame 2");
    run(&["--env", "sky", "--frames", "5..3"]).failed("0..99");
    run(&["--env", "sky", "--duration=-3"]).failed("above 0");
    run(&["--env", "sky", "--frames", "0..4294967295"]).failed("at most 1000000 frames");
    run(&["--env", "sky", "--clip", "Dance"]).failed("no clip 'Dance'");
}

#[test]
fn a_picture_of_a_clip_is_the_frame_of_its_time() {
    let Some(model) = gnomon_testing::data_file("models/BoxAnimated.glb") else { return };
    let folder = tempfile::tempdir().unwrap();
    let run = |arguments: &[&str]| {
        let fixed = ["reference", model.to_str().unwrap(), "--env", "room", "--size", "16x12", "--spp", "4"];
        gnomon(folder.path(), &[&fixed[..], arguments].concat())
    };
    // Without --clip a sequence plays the first one, and a single picture none.
    run(&["--frames", "0..3", "--fps", "2", "-o", "x.exr"]).succeeded();
    run(&["--clip", "0", "--time", "1.5", "-o", "single.exr"]).succeeded();
    run(&["-o", "rest.exr"]).succeeded();
    let [single, frame, rest] =
        ["single.exr", "x_0003.exr", "rest.exr"].map(|name| fs::read(folder.path().join(name)).unwrap());
    assert!(single == frame && single != rest);
    run(&["--clip", "7", "-o", "a.exr"]).failed("clip");
}

#[cfg(unix)]
#[test]
fn films_go_through_ffmpeg_and_are_whole_or_not_there() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let run = |path: &str, size: &str| {
        let arguments = [
            "reference",
            "column",
            "--env",
            "room",
            "--size",
            size,
            "--spp",
            "2",
            "--frames",
            "0..2",
            "-o",
            "x.mp4",
        ];
        let output = command(folder.path(), &arguments).env("PATH", path).output().unwrap();
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    };
    let (status, words) = run("/nowhere", "8x6");
    assert!(status == Some(2) && words.contains("ffmpeg") && words.contains("install it"), "{words}");
    let bin = folder.path().join("bin");
    fs::create_dir(&bin).unwrap();
    let path = format!("{}:/usr/bin:/bin", bin.display());
    let install = |script: &str| {
        fs::write(bin.join("ffmpeg"), script).unwrap();
        fs::set_permissions(bin.join("ffmpeg"), fs::Permissions::from_mode(0o755)).unwrap();
    };
    // Stands in for the encoder: the film is the frames' bytes.
    install("#!/bin/sh\nfor last; do :; done\ncat > \"$last\"\n");
    let (status, words) = run(&path, "8x6");
    assert_eq!(status, Some(0), "{words}");
    assert_eq!(fs::read(folder.path().join("x.mp4")).unwrap().len(), 3 * 8 * 6 * 3);
    let (status, words) = run(&path, "9x6");
    assert!(status == Some(2) && words.contains("even"), "{words}");
    fs::remove_file(folder.path().join("x.mp4")).unwrap();
    install("#!/bin/sh\nfor last; do :; done\nhead -c 100 > \"$last\"\necho 'no such encoder' >&2\nexit 1\n");
    let (status, words) = run(&path, "8x6");
    assert!(status == Some(2) && words.contains("no such encoder"), "{words}");
    assert_eq!(files(folder.path()), ["bin"], "nothing half-written");
}

#[test]
fn a_saved_scene_renders_the_same() {
    let folder = tempfile::tempdir().unwrap();
    if !can_render(folder.path()) {
        return;
    }
    for name in ["models", "saved", "elsewhere"] {
        fs::create_dir(folder.path().join(name)).unwrap();
    }
    let quad = "v -1 0 -1\nv 1 0.5 -1\nv 1 0.2 1\nv -1 0 1\nf 1 4 3 2\n";
    fs::write(folder.path().join("models/quad.obj"), quad).unwrap();
    let lit = "[[model]]\nfile = \"quad.obj\"\nname = \"sheet\"\nscale = 0.7\n[[light]]\nshape = \"sphere\"\nradius = 0.2\n\
        position = [0, 1, 0]\nradiance = [3, 2, 1]\n[environment]\nbuiltin = \"room\"\n[material.clay]\nroughness = 0.3\n";
    fs::write(folder.path().join("models/lit.toml"), lit).unwrap();
    let small = ["--size", "64x48", "--shadow-resolution", "64", "--light-count", "8"];
    let cases: [(&str, &[&str]); 3] = [
        ("three-boxes", &["--env", "sky", "--env-rotation", "33.3", "--shadows", "pcf", "--ground", "plane"]),
        (
            "models/quad.obj",
            &[
                "--env",
                "room",
                "--exposure",
                "0.3",
                "--lights",
                "disks",
                "--reflectance",
                "phong:shininess=7.7,specular=0.3",
            ],
        ),
        (
            "models/lit.toml",
            &[
                "--camera",
                "eye=2.1,3.3,1.7; target=0.1,0,0; fov=33",
                "--tone-mapping",
                "linear",
                "--ambient",
                "occlusion",
            ],
        ),
    ];
    for (scene, options) in cases {
        let saved = ["render", scene, "-o", "a.png", "--save-scene", "saved/scene.toml"];
        gnomon(folder.path(), &[&saved[..], &small[..], options].concat()).succeeded();
        gnomon(
            folder.path(),
            &["render", "saved/scene.toml", "-o", "b.png", "--save-scene", "elsewhere/scene.toml"],
        )
        .succeeded();
        gnomon(&folder.path().join("elsewhere"), &["render", "scene.toml", "-o", "c.png"]).succeeded();
        let [a, b, c] =
            ["a.png", "b.png", "elsewhere/c.png"].map(|name| fs::read(folder.path().join(name)).unwrap());
        let text = fs::read_to_string(folder.path().join("elsewhere/scene.toml")).unwrap();
        assert!(a == b && b == c, "{scene}: another picture from\n{text}");
        assert!(!text.contains(&*folder.path().to_string_lossy()), "a path that is not relative in\n{text}");
        // The planted fault: the picture does depend on what is saved.
        fs::write(folder.path().join("saved/scene.toml"), text.replace("rotation = ", "rotation = 1"))
            .unwrap();
        fs::write(folder.path().join("saved/quad.obj"), quad).unwrap();
        fs::write(folder.path().join("models/quad.obj"), quad).unwrap();
        gnomon(folder.path(), &["render", "saved/scene.toml", "-o", "d.png"]).succeeded();
        assert!(fs::read(folder.path().join("d.png")).unwrap() != a, "{scene}");
    }
}

#[test]
fn mistakes_in_what_a_scene_file_says_of_drawing_are_told_with_their_line() {
    let folder = tempfile::tempdir().unwrap();
    let start = "[environment]\nbuiltin = \"room\"\n[[model]]\nbuiltin = \"column\"\n";
    for (text, reason) in [
        ("[render]\nshadow = \"pcf\"\n", "line 6: unknown field `shadow`"),
        ("[fit]\nlight_count = -3\n", "line 6: "),
        ("[display]\nsize = [3]\n", "line 6: "),
        ("[animation]\ntime = \"noon\"\n", "line 6: "),
        ("[[surface]]\nreflectance = \"phong\"\n", "'shininess'"),
        ("[render]\nshadows = \"candles\"\n", "candles"),
        ("[fit]\nmethod = \"candles\"\n", "candles"),
        ("[display]\ntone_mapping = \"sepia\"\n", "sepia"),
        ("[animation]\nclip = \"Dance\"\n", "no clip 'Dance'"),
        ("[[surface]]\nmaterial = 9\nreflectance = \"lambert\"\n", "no material 9"),
    ] {
        fs::write(folder.path().join("scene.toml"), format!("{start}{text}")).unwrap();
        gnomon(folder.path(), &["render", "scene.toml", "-o", "a.png"]).failed(reason);
    }
    assert_eq!(files(folder.path()), ["scene.toml"]);
}

#[test]
fn a_scene_is_saved_once_all_is_known_to_be_fit_for_it() {
    let folder = tempfile::tempdir().unwrap();
    if !can_render(folder.path()) {
        return;
    }
    let run = |arguments: &[&str]| {
        let small = ["--size", "16x12", "--lights", "none", "--ambient", "unshadowed", "--supersample", "1"];
        let saved = ["render", "column", "--env", "room", "--save-scene", "s.toml"];
        gnomon(folder.path(), &[&saved[..], &small[..], arguments].concat())
    };
    let before = files(folder.path());
    run(&["--debug", "candles", "-o", "a.png"]).failed("candles");
    run(&["--frames", "0..9", "--duration", "0.1", "-o", "a.png"]).failed("ends with frame");
    assert_eq!(files(folder.path()), before);
    run(&["--frames", "0..0", "-o", "a.png"]).succeeded();
    fs::remove_file(folder.path().join("s.toml")).unwrap();
    // And with it whether the background is seen, which an option says against the file.
    run(&["--background", "none", "-o", "dark.png"]).succeeded();
    assert!(fs::read_to_string(folder.path().join("s.toml")).unwrap().contains("background = \"none\""));
    for (output, background) in [("again.png", None), ("seen.png", Some("environment"))] {
        let option = background.map_or(vec![], |background| vec!["--background", background]);
        gnomon(folder.path(), &[&["render", "s.toml", "-o", output][..], &option[..]].concat()).succeeded();
    }
    let [dark, again, seen] =
        ["dark.png", "again.png", "seen.png"].map(|name| fs::read(folder.path().join(name)).unwrap());
    assert!(dark == again && dark != seen);
}
