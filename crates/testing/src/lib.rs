//! Test support shared by every crate: every tolerance of the project, where the external data lies, and skipping that cannot be mistaken
//! for passing; runs of the real binaries.
#![allow(clippy::panic, reason = "helpers of tests fail the test")]

pub mod command;
mod surfaces;
pub mod tolerances;

pub use surfaces::{glossy_models, glossy_surface, tabulated_surfaces};

use std::path::PathBuf;

/// Folder with the external test data: `$GNOMON_DATA`, else `../shared/data` beside the repository.
/// `None` where neither exists; callers then report through [`skip`] and return.
pub fn data_dir() -> Option<PathBuf> {
    let dir = match std::env::var_os("GNOMON_DATA") {
        Some(dir) => PathBuf::from(dir),
        None => PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data")),
    };
    dir.is_dir().then_some(dir)
}

/// Path of one external data file, or `None` after printing `skipped` with the reason.
pub fn data_file(relative: &str) -> Option<PathBuf> {
    let path = data_dir().map(|dir| dir.join(relative)).filter(|path| path.exists());
    if path.is_none() {
        skip(&format!("external data {relative} is absent (set GNOMON_DATA to its folder)"));
    }
    path
}

/// Reports on the terminal, past the test harness's capture, that the calling test did not run.
#[expect(clippy::print_stderr, reason = "a skipped test must be seen, also when the harness captures output")]
pub fn skip(reason: &str) {
    use std::io::Write;
    let name = std::thread::current().name().unwrap_or("test").to_owned();
    // The harness captures `eprintln!` only; a direct write reaches the terminal.
    if writeln!(std::io::stderr().lock(), "skipped {name}: {reason}").is_err() {
        eprintln!("skipped {name}: {reason}");
    }
}
