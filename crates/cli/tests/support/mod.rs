//! Drives the real binary.

#![allow(dead_code, unused_imports, reason = "every test file uses another part of this")]

use std::path::Path;
use std::process::Command;

pub use gnomon_testing::command::{Run, files};

/// The command with these arguments, run in `folder`.
pub fn command(folder: &Path, arguments: &[&str]) -> Command {
    gnomon_testing::command::command(env!("CARGO_BIN_EXE_gnomon"), folder, arguments)
}

/// Runs `gnomon ARGUMENTS` in `folder`.
pub fn gnomon(folder: &Path, arguments: &[&str]) -> Run {
    Run::of(&command(folder, arguments).output().unwrap())
}

/// Whether this machine can draw; says `skipped` where it cannot.
pub fn can_render(folder: &Path) -> bool {
    let info = gnomon(folder, &["info", "--json"]).succeeded().json();
    let usable = info["adapters"].as_array().unwrap().iter().any(|adapter| adapter["usable"] == true);
    if !usable {
        gnomon_testing::skip("no usable graphics adapter");
    }
    usable
}
