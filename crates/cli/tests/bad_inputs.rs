//! Damaged and hostile files: each ends in a result or in one clear error, in bounded time and memory, never in a panic.

#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

mod support;

use std::fs::File;
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use gnomon_testing::tolerances::{BAD_INPUT_BYTES, BAD_INPUT_SECONDS};
use support::files;

/// What one file may end in.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Expected {
    Success,
    Error,
    Either,
}

/// Every file under a folder, in a fixed order.
fn walk(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() { folders.push(path) } else { found.push(path) }
        }
    }
    found.sort();
    found
}

/// Runs `gnomon ARGUMENTS` within the limits; what is wrong with how it ended, if anything.
fn misbehaviour(folder: &Path, log: &str, arguments: &[String], expected: Expected) -> Option<String> {
    let errors = folder.join(log);
    let start = Instant::now();
    let mut child = Command::new("sh")
        .arg("-c")
        .arg(format!("ulimit -v {}; exec \"$0\" \"$@\"", BAD_INPUT_BYTES / 1024))
        .arg(env!("CARGO_BIN_EXE_gnomon"))
        .args(arguments)
        .current_dir(folder)
        // Every thread reserves address space; what counts is what the file makes of it.
        .env("RAYON_NUM_THREADS", "2")
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(File::create(&errors).unwrap())
        .spawn()
        .unwrap();
    let status = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        if start.elapsed() > Duration::from_secs(BAD_INPUT_SECONDS) {
            child.kill().unwrap();
            child.wait().unwrap();
            return Some(format!("still running after {BAD_INPUT_SECONDS} s"));
        }
        std::thread::sleep(Duration::from_millis(2));
    };
    let text = std::fs::read_to_string(&errors).unwrap();
    std::fs::remove_file(&errors).unwrap();
    let told = text.lines().filter(|line| line.starts_with("gnomon: error: ")).count();
    let other = text.lines().filter(|line| !line.starts_with("gnomon: ")).count();
    match (status.code(), expected) {
        (Some(0), Expected::Success | Expected::Either) if told == 0 && other == 0 => None,
        (Some(2), Expected::Error | Expected::Either) if told == 1 && other == 0 => None,
        (Some(code), _) => Some(format!("{expected:?} expected, exit status {code}: {}", text.trim())),
        (None, _) => Some(format!("ended by signal {:?}: {}", status.signal(), text.trim())),
    }
}

/// Runs all cases on two threads and fails with every one that misbehaved.
#[track_caller]
fn check(folder: &Path, cases: Vec<(Vec<String>, Expected)>) {
    assert!(!cases.is_empty(), "no files were found");
    let count = cases.len();
    let queue = Mutex::new(cases.into_iter().enumerate());
    let faults = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                loop {
                    let Some((index, (arguments, expected))) = queue.lock().unwrap().next() else { break };
                    if let Some(fault) = misbehaviour(folder, &format!("{index}.log"), &arguments, expected) {
                        faults.lock().unwrap().push(format!("gnomon {}: {fault}", arguments.join(" ")));
                    }
                }
            });
        }
    });
    let faults = faults.into_inner().unwrap();
    assert!(faults.is_empty(), "{} of {count} runs misbehaved:\n{}", faults.len(), faults.join("\n"));
}

fn text(path: &Path) -> String {
    path.to_str().unwrap().to_owned()
}

/// Decoding alone, and then the whole way through a light fit.
fn picture_cases(path: &Path, decoded: Expected) -> [(Vec<String>, Expected); 2] {
    let path = text(path);
    let fitted = if decoded == Expected::Error { Expected::Error } else { Expected::Either };
    [
        (vec!["compare".to_owned(), path.clone(), path.clone()], decoded),
        (vec!["decompose".to_owned(), path], fitted),
    ]
}

#[test]
fn radiance_files_end_as_their_manifest_says() {
    let Some(manifest) = gnomon_testing::data_file("bad_inputs/hdr/MANIFEST.tsv") else { return };
    let manifest_text = std::fs::read_to_string(&manifest).unwrap();
    let outcome = |name: &str| {
        let line = manifest_text.lines().find(|line| line.split('\t').next() == Some(name))?;
        let words = line.split('\t').nth(1)?;
        Some(match words.split([',', ';', ' ']).next()? {
            _ if words.contains(" or ") => Expected::Either,
            "ok" => Expected::Success,
            _ => Expected::Error,
        })
    };
    let folder = tempfile::tempdir().unwrap();
    let cases = walk(manifest.parent().unwrap())
        .into_iter()
        .filter(|path| path.extension().is_some_and(|extension| extension == "hdr"))
        .flat_map(|path| {
            let name = path.file_name().unwrap().to_str().unwrap();
            let expected = outcome(name).unwrap_or(if name.starts_with("imagers_valid") {
                Expected::Success
            } else {
                Expected::Either
            });
            picture_cases(&path, expected)
        })
        .collect();
    check(folder.path(), cases);
    assert!(files(folder.path()).is_empty());
}

#[test]
fn damaged_exr_files_end_in_a_result_or_one_error() {
    let Some(data) = gnomon_testing::data_file("bad_inputs/exr") else { return };
    let folder = tempfile::tempdir().unwrap();
    let cases = walk(&data).iter().flat_map(|path| picture_cases(path, Expected::Either)).collect();
    check(folder.path(), cases);
    assert!(files(folder.path()).is_empty());
}

#[test]
fn invalid_gltf_files_end_in_a_picture_or_one_error() {
    let Some(data) = gnomon_testing::data_file("bad_inputs/gltf") else { return };
    let folder = tempfile::tempdir().unwrap();
    let environment = folder.path().join("grey.exr");
    let grey = gnomon::picture::RgbImage::filled(16, 8, glam::Vec3::ONE);
    gnomon::picture::write(&environment, &grey).unwrap();
    let scenes = walk(&data)
        .into_iter()
        .filter(|path| path.extension().is_some_and(|extension| extension == "gltf" || extension == "glb"));
    let cases: Vec<(Vec<String>, Expected)> = scenes
        .enumerate()
        .map(|(index, path)| {
            // The generator's positive models are valid.
            let valid = path.components().any(|part| part.as_os_str() == "Positive") && is_complete(&path);
            let output = format!("{index}.exr");
            let path = text(&path);
            let arguments =
                ["reference", &path, "--env", "grey.exr", "--size", "8x8", "--spp", "1", "-o", &output];
            let expected = if valid { Expected::Success } else { Expected::Either };
            (arguments.map(str::to_owned).to_vec(), expected)
        })
        .collect();
    check(folder.path(), cases);
    // Finished pictures only: nothing half-written beside them.
    let whole = |name: &String| name.ends_with(".exr") && !name.starts_with('.');
    assert!(files(folder.path()).iter().all(whole), "{:?}", files(folder.path()));
}

/// Whether a .gltf file's pictures are all there and it asks for no extension: the data folder lacks some textures, and some
/// models require extensions that do not exist.
fn is_complete(path: &Path) -> bool {
    let Ok(model) = serde_json::from_slice::<serde_json::Value>(&std::fs::read(path).unwrap()) else {
        return false;
    };
    let images = model["images"].as_array().into_iter().flatten();
    let present = |uri: &str| uri.starts_with("data:") || path.parent().unwrap().join(uri).exists();
    model["extensionsRequired"].is_null() && images.filter_map(|image| image["uri"].as_str()).all(present)
}

/// The planted fault: this check sees a wrong end when there is one.
#[test]
fn a_wrong_end_is_seen() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["compare".to_owned(), "absent.exr".to_owned(), "absent.exr".to_owned()];
    let fault = misbehaviour(folder.path(), "log", &arguments, Expected::Success).unwrap();
    assert!(fault.contains("exit status 2") && fault.contains("absent.exr"), "{fault}");
    assert!(misbehaviour(folder.path(), "log", &arguments, Expected::Error).is_none());
    let help = ["--help".to_owned()];
    assert!(misbehaviour(folder.path(), "log", &help, Expected::Error).is_some());
}
