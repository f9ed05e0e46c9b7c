//! Drives `gnomon-lab`: the files of its suites exist, parse and hold numbers.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

use std::path::Path;
use std::process::Command;

use gnomon_renderer::{Gpu, GpuOptions};
use gnomon_testing::command::{Run, command, files};
use serde_json::Value;

/// `gnomon-lab ARGUMENTS`, to be run in `folder`.
fn lab(folder: &Path, arguments: &[&str]) -> Command {
    command(env!("CARGO_BIN_EXE_gnomon-lab"), folder, arguments)
}

/// Runs it.
fn run(folder: &Path, arguments: &[&str]) -> Run {
    Run::of(&lab(folder, arguments).output().unwrap())
}

/// Whether this machine can draw; says `skipped` where it cannot.
fn can_render() -> bool {
    let usable = Gpu::new(&GpuOptions::default()).is_ok();
    if !usable {
        gnomon_testing::skip("no usable graphics adapter");
    }
    usable
}

#[test]
fn every_convolution_experiment_leaves_readable_files() {
    let names = ["cost", "rivals", "order", "lights", "maps", "ambient", "failures"];
    check_suite("convolution", &names, "convolution mip M=4");
}

#[test]
fn every_subtractive_experiment_leaves_readable_files() {
    let names = ["lights", "equal-time", "sampling", "best"];
    check_suite("subtractive", &names, "subtractive, 1/16 of the samples");
}

#[test]
fn every_budget_experiment_leaves_readable_files() {
    check_suite("budget", &["scenes"], "1000 hard maps");
}

#[test]
fn every_bumps_experiment_leaves_readable_files() {
    check_suite("bumps", &["pictures"], "scatter, horizons");
}

#[test]
fn every_motion_experiment_leaves_readable_files() {
    check_suite("motion", &["animation", "environment"], "longest over median at rest");
}

/// Runs a suite without data; its experiments are `expected`, and what it prints holds `printed`.
fn check_suite(suite: &str, expected: &[&str], printed: &str) {
    let folder = tempfile::tempdir().unwrap();
    if !can_render() {
        return;
    }
    let empty = folder.path().join("empty");
    std::fs::create_dir(&empty).unwrap();
    let arguments = [suite, "--smoke", "-o", "deep/out", "--data", "empty"];
    let run = run(folder.path(), &arguments).succeeded();
    assert!(run.out.contains(printed) && run.out.contains("report.md"), "{}", run.out);

    let out = folder.path().join("deep/out");
    let read = |name: &str| std::fs::read_to_string(out.join(name)).unwrap();
    let page = read("report.md");
    // The data folder is empty, and the report says what stands in.
    assert!(page.contains("stands in"), "{page}");
    let results: Value = serde_json::from_str(&read("results.json")).unwrap();
    let sections = results["sections"].as_array().unwrap();
    let names: Vec<_> = sections.iter().map(|section| section["name"].as_str().unwrap()).collect();
    assert_eq!(names, expected);
    for section in sections {
        for table in section["tables"].as_array().unwrap() {
            let rows = table["rows"].as_array().unwrap();
            assert!(!rows.is_empty(), "{} is empty", table["name"]);
            check_csv(&read(&format!("{}.csv", table["name"].as_str().unwrap())), rows.len());
        }
        assert!(!errors(&section["tables"][0]).is_empty(), "{}", section["name"]);
    }
    // Not every suite has a truth.
    let truth = out.join("truth");
    for name in if truth.is_dir() { files(&truth) } else { Vec::new() } {
        assert!(name.ends_with(".exr") || name.ends_with(".txt"), "{name} has no business there");
    }
    for name in files(&out).into_iter().filter(|name| name != "truth") {
        match Path::new(&name).extension().and_then(|extension| extension.to_str()) {
            Some("png") => {
                let sheet = gnomon_picture::read(out.join(&name)).unwrap().image;
                assert!(sheet.width() > 32 && sheet.height() > 24, "{name}");
            }
            Some("svg") => assert!(read(&name).ends_with("</svg>\n"), "{name}"),
            Some("csv" | "md" | "json") => {}
            _ => panic!("{name} has no business here"),
        }
        assert!(
            name == "results.json" || name == "report.md" || page.contains(&format!("({name})")),
            "{name}"
        );
    }
}

/// Headings of the columns of errors, or what stands for them, of first tables; every first table has one of them.
const ERRORS: [&str; 6] = [
    "relative RMSE",
    "no shadows",
    "unshadowed",
    "relative RMSE, mean",
    "additive",
    "longest over median at rest",
];

/// Numbers of the first column of errors of a table in `results.json`.
fn errors(table: &Value) -> Vec<f64> {
    let columns = table["columns"].as_array().unwrap();
    let place = |name: &&str| columns.iter().position(|column| column["name"] == **name);
    let place = ERRORS.iter().find_map(place).unwrap();
    table["rows"].as_array().unwrap().iter().filter_map(|row| row[place].as_f64()).collect()
}

/// As many fields on every line as the heading has, quoted ones counted as one, and every number finite.
fn check_csv(text: &str, rows: usize) {
    let fields = |line: &str| {
        let quoted =
            |(index, part): (usize, &str)| if index % 2 == 0 { part.matches(',').count() } else { 0 };
        1 + line.split('"').enumerate().map(quoted).sum::<usize>()
    };
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), rows + 1, "{text}");
    assert!(lines.iter().all(|line| fields(line) == fields(lines[0])), "{text}");
    // JSON has null for what is no number and for what was not measured; here they differ.
    let numbers = lines.iter().flat_map(|line| line.split(',')).filter_map(|field| field.parse::<f64>().ok());
    assert!(numbers.into_iter().all(f64::is_finite), "{text}");
}

#[test]
fn one_experiment_and_bad_requests() {
    let folder = tempfile::tempdir().unwrap();
    let smoke = |arguments: &[&str]| {
        run(folder.path(), &[&["convolution", "--smoke", "-o", "out"], arguments].concat())
    };
    let run = smoke(&["--only", "order,nonsense"]).failed("'nonsense'");
    assert!(run.out.is_empty() && files(folder.path()).is_empty());
    smoke(&["--quick"]).failed("--quick");
    if !can_render() {
        return;
    }
    smoke(&["--data", "absent"]).failed("absent");
    smoke(&["--truth", "absent"]).failed("absent");
    assert!(files(folder.path()).is_empty());
    let output = lab(folder.path(), &["convolution", "--smoke", "--only", "order", "-o", "one"])
        .env("GNOMON_DATA", folder.path())
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let results = std::fs::read_to_string(folder.path().join("one/results.json")).unwrap();
    let results: Value = serde_json::from_str(&results).unwrap();
    assert_eq!(results["sections"].as_array().unwrap().len(), 1);
}

#[test]
fn fits_are_timed_and_samplers_compared() {
    let folder = tempfile::tempdir().unwrap();
    let json = run(folder.path(), &["fits", "sky", "--repeats", "1", "--json"]).succeeded().json();
    let fits = json["fits"].as_array().unwrap();
    assert!(fits.len() >= 3 && fits.iter().all(|fit| fit["median_milliseconds"].as_f64().unwrap() > 0.0));
    let samplers = json["samplers"].as_array().unwrap();
    assert!(
        samplers.len() >= 3
            && samplers.iter().all(|sampler| sampler["relative_rmse"][3].as_f64().unwrap() < 0.1)
    );
    let table = run(folder.path(), &["fits", "sky", "--repeats", "1"]).succeeded().out;
    assert!(table.contains("median ms") && table.contains("error with N samples"), "{table}");
    run(folder.path(), &["fits", "--repeats", "0"]).failed("repeats");
    run(folder.path(), &["fits", "absent.hdr"]).failed("absent.hdr");
    run(folder.path(), &["paint"]).failed("'paint'");
}
