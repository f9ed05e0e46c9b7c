//! Help, wrong arguments, closed pipes: what everyone meets first.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

mod support;

use std::io::Read;
use std::process::Stdio;

use support::{command, files, gnomon};

const COMMANDS: [&str; 8] =
    ["render", "reference", "reflectance", "decompose", "compare", "inspect", "info", "demo"];

#[test]
fn help_names_every_command_and_every_command_has_help() {
    let folder = tempfile::tempdir().unwrap();
    let help = gnomon(folder.path(), &["--help"]).succeeded();
    assert!(help.err.is_empty());
    for name in COMMANDS {
        assert!(help.out.contains(&format!("\n  {name} ")), "{name} is missing in\n{}", help.out);
        let own = gnomon(folder.path(), &[name, "--help"]).succeeded();
        assert!(own.out.contains("Usage: gnomon"), "{}", own.out);
    }
}

#[test]
fn version_is_printed() {
    let folder = tempfile::tempdir().unwrap();
    let run = gnomon(folder.path(), &["--version"]).succeeded();
    assert_eq!(run.out.trim(), format!("gnomon {}", env!("CARGO_PKG_VERSION")));
}

#[test]
fn wrong_arguments_are_one_line_and_exit_2() {
    let folder = tempfile::tempdir().unwrap();
    let cases: &[(&[&str], &str)] = &[
        (&[], "--help"),
        (&["paint"], "'paint'"),
        (&["render"], "required"),
        (&["render", "three-boxes", "--env", "room", "-o", "a.png", "--size", "0x4"], "640x480"),
        (&["render", "three-boxes", "--env", "room", "-o", "a.jpg"], ".png or .exr"),
        (&["render", "three-boxes", "--env", "room", "-o", "a_####.png"], "--frames"),
        (&["render", "three-boxes", "--env", "room", "-o", "absent/a.png"], "no folder absent"),
        (&["render", "three-boxes", "-o", "a.png", "--size", "8x8"], "--env"),
        (&["render", "three-boxes", "--env", "room", "-o", "a.png", "--lights", "lamps"], "lamps"),
        (
            &["render", "three-boxes", "--env", "room", "-o", "a.png", "--ground", "lava"],
            "`lava`: it takes one of: none, plane",
        ),
        (&["render", "three-boxes", "--env", "room", "-o", "a.png", "--camera", "eye=1,2"], "eye"),
        (
            &["render", "three-boxes", "--env", "room", "-o", "a.png", "--reflectance", "phnog"],
            "are: metallic-roughness, lambert",
        ),
        (
            &["reference", "three-boxes", "--env", "room", "-o", "a.exr", "--reflectance", "phong"],
            "'shininess'",
        ),
        (
            &[
                "reference",
                "three-boxes",
                "--env",
                "room",
                "-o",
                "a.exr",
                "--reflectance",
                "lambert:diffuse=2",
            ],
            "diffuse must be 0 to 1",
        ),
        (&["render", "absent.glb", "--env", "room", "-o", "a.png"], "'absent.glb'"),
        (&["reference", "three-boxes", "--env", "absent.hdr", "-o", "a.exr"], "'absent.hdr'"),
        (&["reference", "three-boxes", "--env", "room", "-o", "a.exr", "--spp", "0"], "samples"),
        (&["reference", "three-boxes", "--env", "room", "-o", "a.exr", "--layers", "uv"], "found; a similar"),
        (&["render", "three-boxes", "--env", "room", "-o", "a.png", "--frames", "5..1"], "before the first"),
        (&["render", "three-boxes", "--env", "room", "-o", "a.png", "--budget-ms", "-1"], "a number above 0"),
        (
            &["render", "three-boxes", "--env", "room", "-o", "a.png", "--check", "-1"],
            "expected 0 or a number",
        ),
        (&["render", "three-boxes", "--env", "room", "-o", "a.png", "--light-count", "-1"], "from 1 to 4096"),
        (
            &["render", "three-boxes", "--env", "room", "-o", "a.png", "--camera", "left"],
            "the scene's cameras are camera",
        ),
        (
            &["render", "three-boxes", "--env", "room", "-o", "a.png", "--background-map", "sky"],
            "sky is built in",
        ),
        (&["reference", "three-boxes", "--env", "room", "-o", "a.exr", "--env-rotation", "nan"], "finite"),
        (&["reference", "three-boxes", "--env", "room", "-o", "a.exr", "--size", "99999x99999"], "too large"),
        (
            &["render", "three-boxes", "--env", "room", "-o", "a.exr", "--check", "15"],
            "0 or a number of pixels from 16",
        ),
        (
            &["render", "three-boxes", "--env", "room", "-o", "a.exr", "--check", "all"],
            "0 or a number of pixels",
        ),
        (&["render", "three-boxes", "--env", "room", "-o", "a.exr", "--max-error", "2"], "0.02 or 2%"),
        (&["render", "three-boxes", "--env", "room", "-o", "a.exr", "--max-error=-1%"], "0.02 or 2%"),
        (
            &["render", "three-boxes", "--env", "room", "-o", "a.exr", "--max-error", "2%", "--check", "0"],
            "it does not go with --check 0",
        ),
        (
            &[
                "render",
                "three-boxes",
                "--env",
                "room",
                "-o",
                "a.exr",
                "--max-error",
                "2%",
                "--budget-ms",
                "9",
            ],
            "cannot be used with",
        ),
        (&["decompose", "room", "--light-count", "3", "--threshold", "0.1"], "--threshold"),
        (&["decompose", "room", "--threshold", "2"], "--threshold cannot be `2`"),
        (&["decompose", "room", "--method", "cubes"], "cubes"),
        (&["decompose", "room", "--projection", "mercator"], "equirect"),
        (&["compare", "a.png"], "required"),
        (&["compare", "a.png", "b.png"], "a.png"),
        (&["compare", "a.png", "b.png", "--region", "x=1"], "NAME=X,Y"),
    ];
    for (arguments, part) in cases {
        let run = gnomon(folder.path(), arguments).failed(part);
        assert!(run.out.is_empty(), "{arguments:?} printed {}", run.out);
    }
    assert!(files(folder.path()).is_empty(), "a failed command left {:?}", files(folder.path()));
}

/// Of every kind of option: wrong on the command line, and in a scene file.
#[test]
fn wrong_values_of_options_are_one_line_that_says_what_is_allowed() {
    let folder = tempfile::tempdir().unwrap();
    let scene = "[environment]\nbuiltin = \"room\"\n[[model]]\nbuiltin = \"column\"\n";
    for (option, text, (table, key), value, allowed) in [
        ("lights", "lamps", ("fit", "method"), "\"lamps\"", "one of: disks, squares"),
        ("light-count", "0", ("fit", "light_count"), "0", "a whole number from 1 to 4096, or automatic"),
        ("threshold", "1", ("fit", "threshold"), "1", "a number above 0 and below 1, or automatic"),
        ("shadows", "candles", ("render", "shadows"), "\"candles\"", "one of: auto, convolution, pcss"),
        (
            "shadow-resolution",
            "100",
            ("render", "shadow_resolution"),
            "100",
            "a power of two from 16 to 8192",
        ),
        ("caster-deviation", "nan", ("render", "caster_deviation"), "nan", "a number from 0 to 16 texels"),
        ("pcss-search-samples", "0", ("render.pcss", "search_samples"), "0", "a whole number from 1 to 1024"),
        ("prefilter", "box", ("render", "prefilter"), "\"box\"", "one of: mip, sat"),
        ("size", "8x", ("display", "size"), "[8, 0]", "WIDTHxHEIGHT in pixels, as in 640x480"),
        ("time", "nan", ("animation", "time"), "nan", "a finite number [s]"),
        ("background", "maybe", ("display", "background"), "\"maybe\"", "transparent"),
    ] {
        let argument = format!("--{option}");
        let arguments = ["render", "three-boxes", "--env", "room", "-o", "a.png", &argument, text];
        let run = gnomon(folder.path(), &arguments).failed(allowed);
        let shown = if text == "nan" { "NaN" } else { text };
        assert!(run.err.contains(&format!("cannot be `{shown}`")) && run.err.contains("--"), "{}", run.err);
        std::fs::write(folder.path().join("a.toml"), format!("{scene}[{table}]\n{key} = {value}\n")).unwrap();
        let run = gnomon(folder.path(), &["render", "a.toml", "-o", "a.png"]).failed(allowed);
        assert!(run.err.contains("line 6: ") && run.err.contains(&format!("`{key}`")), "{}", run.err);
    }
    for (line, allowed) in [
        (
            "projection = \"mercator\"",
            "line 3: `projection` cannot be `mercator`: it takes one of: equirect, vertical-cross",
        ),
        ("rotation = inf", "line 3: `rotation` cannot be `inf`: it takes a finite angle in degrees"),
        (
            "turn = 3",
            "line 3: unknown field `turn`, expected one of `file`, `builtin`, `exposure`, `projection`, `layer`, `rotation`",
        ),
    ] {
        let text = scene.replace("[[model]]", &format!("{line}\n[[model]]"));
        std::fs::write(folder.path().join("a.toml"), text).unwrap();
        gnomon(folder.path(), &["render", "a.toml", "-o", "a.png"]).failed(allowed);
    }
    std::fs::write(folder.path().join("a.toml"), format!("{scene}[render.pcss]\nsamples = 3\n")).unwrap();
    gnomon(folder.path(), &["render", "a.toml", "-o", "a.png"])
        .failed("unknown field `samples`, expected one of `search_samples`");
    assert_eq!(files(folder.path()), ["a.toml"]);
}

#[test]
fn options_that_come_to_nothing_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let scene = ["reference", "three-boxes", "--env", "room", "-o", "a.exr", "--size", "8x8", "--spp", "2"];
    let options = ["--env-layer", "x", "--projection", "equirect", "--up", "z", "--unit", "mm"];
    let run = gnomon(folder.path(), &[&scene[..], &options].concat()).succeeded();
    for option in ["env-layer", "projection", "up", "unit"] {
        let told = format!("--{option} has no effect: ");
        assert_eq!(run.err.matches(&told).count(), 1, "{told}: {}", run.err);
    }
    assert!(gnomon(folder.path(), &scene).succeeded().err.is_empty());
    std::fs::write(folder.path().join("empty.gltf"), r#"{"asset": {"version": "2.0"}}"#).unwrap();
    let empty = ["reference", "empty.gltf", "--env", "room", "-o", "b.exr", "--size", "8x8", "--spp", "2"];
    assert!(gnomon(folder.path(), &empty).succeeded().err.contains("nothing will be seen"));
    let beyond = ["compare", "a.exr", "a.exr", "--region", "corner=6,6,4x1"];
    assert!(gnomon(folder.path(), &beyond).succeeded().err.contains("corner reaches beyond"));
}

/// As in `gnomon info | head -1`: the reader goes away, and that is no failure.
#[test]
fn a_closed_pipe_is_success() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["decompose", "room", "--method", "partition", "--light-count", "500"];
    // Longer than a pipe holds, so that the command is still writing when the reader goes.
    assert!(gnomon(folder.path(), &arguments).succeeded().out.len() > 1 << 17);
    let mut child =
        command(folder.path(), &arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut first = [0; 16];
    child.stdout.take().unwrap().read_exact(&mut first).unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(output.stderr.is_empty());
}

#[test]
fn info_lists_what_there_is() {
    let folder = tempfile::tempdir().unwrap();
    let text = gnomon(folder.path(), &["info"]).succeeded().out;
    for part in ["adapters", "OpenEXR", "glTF", "equirect", "disks"] {
        assert!(text.contains(part), "{part} is missing in\n{text}");
    }
    let json = gnomon(folder.path(), &["info", "--json"]).succeeded().json();
    assert!(json["adapters"].is_array() && json["light_fits"].as_array().unwrap().len() >= 3);
}
