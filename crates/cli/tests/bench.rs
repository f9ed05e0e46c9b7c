//! `gnomon bench convolution`, `subtractive` and `motion`: their files exist, parse and hold numbers.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

mod support;

use std::path::Path;

use serde_json::Value;
use support::{can_render, command, files, gnomon};

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
fn every_motion_experiment_leaves_readable_files() {
    check_suite("motion", &["animation", "environment"], "longest over median at rest");
}

/// Runs a suite without data; its experiments are `expected`, and what it prints holds `printed`.
fn check_suite(suite: &str, expected: &[&str], printed: &str) {
    let folder = tempfile::tempdir().unwrap();
    if !can_render(folder.path()) {
        return;
    }
    let empty = folder.path().join("empty");
    std::fs::create_dir(&empty).unwrap();
    let arguments = ["bench", suite, "--smoke", "-o", "deep/out", "--data", "empty"];
    let run = gnomon(folder.path(), &arguments).succeeded();
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
        let errors = errors(&section["tables"][0]);
        assert!(!errors.is_empty() && errors.iter().all(|error| error.is_finite()), "{}", section["name"]);
    }
    // Not every suite has a truth.
    let truth = out.join("truth");
    for name in if truth.is_dir() { files(&truth) } else { Vec::new() } {
        assert!(name.ends_with(".exr") || name.ends_with(".txt"), "{name} has no business there");
    }
    for name in files(&out).into_iter().filter(|name| name != "truth") {
        match Path::new(&name).extension().and_then(|extension| extension.to_str()) {
            Some("png") => {
                let sheet = gnomon::image::read(out.join(&name)).unwrap().image;
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

/// As many fields on every line as the heading has, quoted ones counted as one.
fn check_csv(text: &str, rows: usize) {
    let fields = |line: &str| {
        let quoted =
            |(index, part): (usize, &str)| if index % 2 == 0 { part.matches(',').count() } else { 0 };
        1 + line.split('"').enumerate().map(quoted).sum::<usize>()
    };
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), rows + 1, "{text}");
    assert!(lines.iter().all(|line| fields(line) == fields(lines[0])), "{text}");
}

#[test]
fn one_experiment_and_bad_requests() {
    let folder = tempfile::tempdir().unwrap();
    let bench = |arguments: &[&str]| {
        let mut all = vec!["bench", "convolution", "--smoke", "-o", "out"];
        all.extend(arguments);
        gnomon(folder.path(), &all)
    };
    let run = bench(&["--only", "order,nonsense"]).failed("'nonsense'");
    assert!(run.out.is_empty() && files(folder.path()).is_empty());
    bench(&["--quick"]).failed("--quick");
    if !can_render(folder.path()) {
        return;
    }
    bench(&["--data", "absent"]).failed("absent");
    bench(&["--truth", "absent"]).failed("absent");
    assert!(files(folder.path()).is_empty());
    let output = command(folder.path(), &["bench", "convolution", "--smoke", "--only", "order", "-o", "one"])
        .env("GNOMON_DATA", folder.path())
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let results = std::fs::read_to_string(folder.path().join("one/results.json")).unwrap();
    let results: Value = serde_json::from_str(&results).unwrap();
    assert_eq!(results["sections"].as_array().unwrap().len(), 1);
}
