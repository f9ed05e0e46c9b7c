//! From names on the command line to pictures on disk.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

mod support;

use gnomon::metrics::compare;
use gnomon_testing::tolerances::{FLUX, GPU_RELATIVE_RMSE};
use support::{can_render, files, gnomon};

#[test]
fn decompose_writes_lights_residual_and_preview() {
    let folder = tempfile::tempdir().unwrap();
    let json = gnomon(folder.path(), &["decompose", "room"]).succeeded().json();
    assert_eq!(json["method"], "optimized", "the fit that render draws with");
    assert!(!json["lights"].as_array().unwrap().is_empty());
    for channel in 0..3 {
        let flux = |name: &str| json[name][channel].as_f64().unwrap();
        let lights = json["lights"].as_array().unwrap().iter();
        let lights: f64 = lights.map(|light| light["derived"]["flux"][channel].as_f64().unwrap()).sum();
        assert!((lights + flux("residual_flux") - flux("total_flux")).abs() <= FLUX * flux("total_flux"));
    }

    let outputs = ["-o", "lights.json", "--residual", "rest.exr", "--preview", "preview.png"];
    let run =
        gnomon(folder.path(), &[&["decompose", "sky", "--env-rotation", "90"][..], &outputs[..]].concat());
    assert!(run.succeeded().out.is_empty());
    assert_eq!(files(folder.path()), ["lights.json", "lights_environment.exr", "preview.png", "rest.exr"]);
    let rest = gnomon::picture::read(folder.path().join("rest.exr")).unwrap().image;
    assert_eq!((rest.width(), rest.height()), (1024, 512));
}

/// Each program gets the fit that it can show, with the maps that it needs, and what it cannot show is told.
#[test]
fn decompose_writes_rigs_for_other_programs() {
    let folder = tempfile::tempdir().unwrap();
    let decompose = |arguments: &[&str]| gnomon(folder.path(), &[&["decompose", "room"], arguments].concat());
    for (arguments, part, told) in [
        (&["-o", "a.usda"][..], "def RectLight", ""),
        (&["-o", "a.xml"], "type=\"rectangle\"", ""),
        (&["-o", "a.py"], "\"a_environment.exr\"", "blender: outlines become disks"),
        (&["-o", "a.gltf"], "KHR_lights_punctual", "gltf: lights have no size"),
        (&["-o", "a.babylon"], "\"a_residual.hdr\"", "babylon: lights have no size"),
        (&["-o", "a.rs"], "DirectionalLight {", "even ambient light"),
        (&["-o", "b.json", "--format", "three"], "\"type\":\"Scene\"", "three: lights have no size"),
        (&["-o", "b.xml", "--format", "mujoco"], "<headlight", "even ambient light"),
    ] {
        let run = decompose(arguments).succeeded();
        let text = std::fs::read_to_string(folder.path().join(arguments[1])).unwrap();
        assert!(text.contains(part), "{arguments:?}");
        assert!(run.err.contains(told), "{arguments:?}: {}", run.err);
        assert!(run.err.contains("light behind edges is off by"), "{}", run.err);
        assert_eq!(told.is_empty(), !run.err.contains("warning"), "{}", run.err);
    }
    let written = files(folder.path());
    for map in ["a_environment.exr", "a_residual.hdr", "b_residual.exr"] {
        assert!(written.iter().any(|file| file == map), "{written:?}");
    }
    // A fit that leaves nothing is no fit for a program that mirrors what is left.
    let run = decompose(&["-o", "c.babylon", "--method", "optimized", "--light-count", "6"]).succeeded();
    assert!(
        run.err.contains("babylon mirrors what lights leave") && run.err.contains("4 lights at most"),
        "{}",
        run.err
    );
    decompose(&["--format", "usd"]).failed("usd is written to a file");
    decompose(&["-o", "a.max"]).failed("--format");
    decompose(&["-o", "a.usda", "--format", "maya"]).failed("the formats of rigs are gnomon, usd,");
    decompose(&["-o", "none/a.usda"]).failed("there is no folder");
    decompose(&["-o", "a.usda", "--rig", "b.json"]).failed("--rig");
}

/// A rig with a light off and another moved and tinted, through a lens whose axis is not in the middle.
#[test]
fn an_edited_rig_is_drawn_as_it_is_traced() {
    let folder = tempfile::tempdir().unwrap();
    if !can_render(folder.path()) {
        return;
    }
    gnomon(folder.path(), &["decompose", "room", "-o", "rig.json"]).succeeded();
    let read = std::fs::read_to_string(folder.path().join("rig.json")).unwrap();
    let mut rig: serde_json::Value = serde_json::from_str(&read).unwrap();
    rig["lights"][0]["enabled"] = false.into();
    rig["lights"][1]["direction"] = serde_json::json!([-1, 1, 1]);
    rig["lights"][1]["radiance"] = serde_json::json!([900, 300, 100]);
    std::fs::write(folder.path().join("edited.json"), rig.to_string()).unwrap();
    let camera = "eye=3,2,4; target=0,0.4,0; fx=90; fy=80; cx=20; cy=28; size=64x48";
    let scene = ["three-boxes", "--size", "64x48", "--camera", camera];
    let run = |arguments: &[&str]| gnomon(folder.path(), &[arguments, &scene[..]].concat()).succeeded();
    run(&["reference", "--rig", "edited.json", "-o", "truth.exr", "--spp", "1024"]);
    run(&["reference", "--rig", "rig.json", "-o", "before.exr", "--spp", "256"]);
    run(&["render", "--rig", "edited.json", "-o", "picture.exr"]);
    let error = |name: &str| {
        let json = gnomon(folder.path(), &["compare", "picture.exr", name]).succeeded().json();
        json["relative_rmse"].as_f64().unwrap()
    };
    assert!(error("truth.exr") < GPU_RELATIVE_RMSE, "{}", error("truth.exr"));
    assert!(error("before.exr") > 2.0 * GPU_RELATIVE_RMSE, "{}", error("before.exr"));
}

#[test]
fn reference_is_seeded_and_its_variance_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let trace = |seed: &str, name: &str| {
        let scene = ["reference", "three-boxes", "--env", "room", "--size", "16x12", "--spp", "64"];
        let run = gnomon(
            folder.path(),
            &[&scene[..], &["--seed", seed, "-o", name, "--variance", "var.exr"]].concat(),
        );
        assert!(run.succeeded().err.is_empty(), "no progress bar without a terminal");
        gnomon::picture::read(folder.path().join(name)).unwrap().image
    };
    let (first, again, other) = (trace("1", "a.exr"), trace("1", "b.exr"), trace("2", "c.exr"));
    assert_eq!(first, again);
    assert_ne!(first, other);
    assert!(compare(&other, &first, None).unwrap().relative_rmse < 0.1);
    let variance = gnomon::picture::read(folder.path().join("var.exr")).unwrap().image;
    assert!(variance.texels().iter().all(|v| v.min_element() >= 0.0));
    assert!(variance.texels().iter().any(|v| v.max_element() > 0.0));
}

/// The picture is near the truth, and far from it without its shadows: the planted fault.
#[test]
fn render_is_near_the_reference_and_without_shadows_it_is_not() {
    let folder = tempfile::tempdir().unwrap();
    if !can_render(folder.path()) {
        return;
    }
    let scene = ["three-boxes", "--env", "room", "--size", "64x48"];
    let run = |arguments: &[&str]| gnomon(folder.path(), &[arguments, &scene[..]].concat()).succeeded();
    run(&["reference", "-o", "truth.exr", "--spp", "1024"]);
    run(&["render", "-o", "picture.exr"]);
    run(&["render", "-o", "flat.exr", "--shadows", "none"]);
    run(&["render", "-o", "disks.png", "--lights", "disks", "--stats", "stats.json"]);
    let error = |name: &str| {
        let json = gnomon(folder.path(), &["compare", name, "truth.exr"]).succeeded().json();
        json["relative_rmse"].as_f64().unwrap()
    };
    let (drawn, flat) = (error("picture.exr"), error("flat.exr"));
    assert!(drawn < GPU_RELATIVE_RMSE, "{drawn}");
    assert!(flat > 2.0 * GPU_RELATIVE_RMSE, "{flat} without shadows");

    let stats: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(folder.path().join("stats.json")).unwrap()).unwrap();
    assert_eq!(
        stats["light_count"].as_u64().unwrap(),
        stats["fit"]["lights"].as_array().unwrap().len() as u64
    );
    let passes: Vec<&str> =
        stats["passes"].as_array().unwrap().iter().map(|p| p["name"].as_str().unwrap()).collect();
    assert!(passes.contains(&"shadow maps") && passes.contains(&"light"), "{passes:?}");
    assert!(stats["frame_milliseconds"].as_f64().unwrap() > 0.0);
    assert!(stats["adapter"]["name"].is_string());
}

#[test]
fn a_scene_file_brings_environment_and_camera_and_the_command_line_overrules_them() {
    let folder = tempfile::tempdir().unwrap();
    let quad = "v -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nf 1 4 3 2\n";
    std::fs::write(folder.path().join("quad.obj"), quad).unwrap();
    let scene = "ground = \"none\"\n[environment]\nbuiltin = \"sky\"\nrotation = 90\n\
        [camera]\neye = [0, 3, 0.1]\ntarget = [0, 0, 0]\nfov = 20\n[[model]]\nfile = \"quad.obj\"\n";
    std::fs::write(folder.path().join("scene.toml"), scene).unwrap();
    let trace = |output: &str, arguments: &[&str]| {
        let fixed = ["reference", "-o", output, "--size", "8x6", "--spp", "64"];
        gnomon(folder.path(), &[&fixed[..], arguments].concat()).succeeded();
        gnomon::picture::read(folder.path().join(output)).unwrap().image
    };
    let own = trace("own.exr", &["scene.toml"]);
    let view = ["--camera", "eye=0,3,0.1; target=0,0,0; fov=20", "--ground", "none"];
    let told =
        trace("told.exr", &[&["quad.obj", "--env", "sky", "--env-rotation", "90"][..], &view[..]].concat());
    assert_eq!(own, told);
    assert_ne!(own, trace("room.exr", &["scene.toml", "--env", "room"]));
    assert_ne!(own, trace("view.exr", &["scene.toml", "--camera", "eye=3,3,3; target=0,0,0; fov=60"]));
}

#[test]
fn an_adapter_that_is_not_there_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["render", "three-boxes", "--env", "sky", "-o", "b.png", "--adapter", "abacus"];
    gnomon(folder.path(), &arguments).failed("abacus");
    assert!(files(folder.path()).is_empty());
}

#[test]
fn a_number_comes_with_every_picture() {
    let folder = tempfile::tempdir().unwrap();
    if !can_render(folder.path()) {
        return;
    }
    let scene = ["render", "three-boxes", "--env", "room", "--size", "64x48", "--lights", "disks"];
    let run = |arguments: &[&str]| gnomon(folder.path(), &[&scene[..], arguments].concat()).succeeded();
    let stats = || -> serde_json::Value {
        serde_json::from_str(&std::fs::read_to_string(folder.path().join("stats.json")).unwrap()).unwrap()
    };
    let told = run(&["-o", "a.exr", "--stats", "stats.json"]).err;
    let check = stats()["check"].clone();
    let [error, uncertainty] =
        ["relative_rmse", "uncertainty"].map(|key| 100.0 * check[key].as_f64().unwrap());
    assert_eq!(check["pixels"], 256);
    let line = format!("check: {error:.1} % off ray-traced truth, +- {uncertainty:.1} % (256 pixels)\n");
    assert_eq!(told, line);
    assert_eq!(run(&["-o", "b.exr"]).err, line, "the same picture, the same number");
    // It is that of `compare`.
    gnomon(folder.path(), &[&["reference"], &scene[1..6], &["-o", "truth.exr", "--spp", "1024"]].concat())
        .succeeded();
    let compared = gnomon(folder.path(), &["compare", "a.exr", "truth.exr"]).succeeded().json();
    let whole = 100.0 * compared["relative_rmse"].as_f64().unwrap();
    assert!((whole - error).abs() < 3.0 * uncertainty, "{error} +- {uncertainty}, not {whole}");

    let few = run(&["-o", "a.exr", "--check", "32"]).err;
    assert!(few.contains("(32 pixels)") && few.lines().count() == 1, "{few}");
    assert!(run(&["-o", "a.png", "--debug", "normals"]).err.is_empty(), "normals have no truth");
    assert!(run(&["-o", "a.exr", "--check", "0", "--stats", "stats.json"]).err.is_empty());
    assert!(stats().get("check").is_none());
    assert!(
        run(&["-o", "s_####.exr", "--frames", "0..1"]).err.is_empty(),
        "frames are not checked by default"
    );
    let frames = run(&["-o", "s_####.exr", "--frames", "0..1", "--overwrite", "--check", "32"]).err;
    assert!(frames.contains("check of frame 1: ") && frames.lines().count() == 2, "{frames}");
}

#[test]
fn an_error_is_kept_or_said_to_be_out_of_reach() {
    let folder = tempfile::tempdir().unwrap();
    if !can_render(folder.path()) {
        return;
    }
    // What is given stays: one setting is left to try.
    let fixed = ["--light-count", "12", "--supersample", "1", "--shadow-resolution", "64"];
    let sharp = ["--sharp-shadow-resolution", "64", "--shadow-sampling", "8", "--sharp-shadow-sampling", "8"];
    let scene = ["render", "three-boxes", "--env", "room", "--size", "48x36", "-o", "a.exr"];
    let run = |most: &str, options: &[&str]| {
        let bound = ["--max-error", most, "--stats", "stats.json"];
        let run = gnomon(folder.path(), &[&scene[..], &bound, options].concat()).succeeded();
        let stats = std::fs::read_to_string(folder.path().join("stats.json")).unwrap();
        (run.err, serde_json::from_str::<serde_json::Value>(&stats).unwrap())
    };
    let (told, stats) = run("0.1%", &[&fixed[..], &sharp].concat());
    let settings = "12 lights, shadow maps of 64 and 64, shadow sampling 8 and 8, 1 x 1 samples a pixel";
    assert!(told.contains("warning: no setting that --max-error tries keeps 0.1 %"), "{told}");
    assert!(told.contains(settings) && told.contains("check: "), "{told}");
    assert_eq!((&stats["max_error"]["met"], &stats["light_count"]), (&false.into(), &12.into()));
    let (told, stats) = run("0.5", &[]);
    assert!(told.starts_with("max-error: 16 lights") && !told.contains("warning"), "{told}");
    let check = &stats["check"];
    assert!(check["relative_rmse"].as_f64().unwrap() + check["uncertainty"].as_f64().unwrap() <= 0.5);
    assert_eq!((&stats["max_error"]["met"], &stats["max_error"]["bound"]), (&true.into(), &0.5.into()));
}

#[test]
fn demo_writes_its_sheet() {
    let folder = tempfile::tempdir().unwrap();
    if !can_render(folder.path()) {
        return;
    }
    let arguments = ["demo", "-o", "deep/demo", "--lights", "disks", "--spp", "2"];
    let run = gnomon(folder.path(), &arguments).succeeded();
    assert!(run.out.contains("relative RMSE") && run.out.contains("sheet.png"), "{}", run.out);
    let demo = folder.path().join("deep/demo");
    assert_eq!(files(&demo), ["comparison.json", "gpu.exr", "reference.exr", "sheet.png"]);
    let sheet = gnomon::picture::read(demo.join("sheet.png")).unwrap().image;
    let panel = gnomon::picture::read(demo.join("gpu.exr")).unwrap().image;
    assert!(sheet.width() >= 2 * panel.width() && sheet.height() >= 3 * panel.height());
}

/// The value of debug views is checked in the renderer's own tests.
#[test]
fn debug_views_are_written_as_they_are() {
    let folder = tempfile::tempdir().unwrap();
    if !can_render(folder.path()) {
        return;
    }
    let scene = ["three-boxes", "--env", "room", "--size", "64x48", "--lights", "disks", "-o", "view.png"];
    let run = |arguments: &[&str]| gnomon(folder.path(), &[&["render"], &scene[..], arguments].concat());
    run(&["--debug", "normals"]).succeeded();
    let normals = gnomon::picture::read(folder.path().join("view.png")).unwrap().image;
    // The ground's normal is +y: (0.5, 1, 0.5) as bytes, in the picture's last row.
    let bytes =
        normals.get(32, 47).to_array().map(|c| (255.0 * gnomon::picture::tonemap::srgb_encode(c)).round());
    assert!(bytes[1] >= 254.0 && (bytes[0] - 128.0).abs() <= 1.0, "{bytes:?}");
    run(&["--debug", "lights", "--debug-light", "1"]).succeeded();
    run(&["--debug", "norms"]).failed("base-color");
}
