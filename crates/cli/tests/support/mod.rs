//! Drives the real binary.

#![allow(dead_code, reason = "every test file uses another part of this")]

use std::path::Path;
use std::process::{Command, Output, Stdio};

use serde_json::Value;

/// What one run of the command gave.
pub struct Run {
    /// Exit status; `None` where a signal ended it.
    pub status: Option<i32>,
    /// Standard output.
    pub out: String,
    /// Standard error.
    pub err: String,
}

impl Run {
    pub fn of(output: &Output) -> Self {
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        Self { status: output.status.code(), out: text(&output.stdout), err: text(&output.stderr) }
    }

    /// Fails the test unless the run succeeded.
    #[track_caller]
    pub fn succeeded(self) -> Self {
        assert_eq!(self.status, Some(0), "{}", self.err);
        self
    }

    /// Fails the test unless the run ended in exit status 2 and one error line that contains `part`.
    #[track_caller]
    pub fn failed(self, part: &str) -> Self {
        assert_eq!(self.status, Some(2), "{}{}", self.out, self.err);
        let errors: Vec<&str> =
            self.err.lines().filter(|line| !line.starts_with("gnomon: warning: ")).collect();
        assert_eq!(errors.len(), 1, "{}", self.err);
        assert!(errors[0].starts_with("gnomon: error: ") && errors[0].contains(part), "{}", errors[0]);
        self
    }

    /// Standard output as JSON.
    #[track_caller]
    pub fn json(&self) -> Value {
        serde_json::from_str(&self.out).unwrap()
    }
}

/// The command with these arguments, run in `folder`.
pub fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_gnomon"));
    command.args(arguments).current_dir(folder).stdin(Stdio::null());
    if std::env::var_os("XDG_RUNTIME_DIR").is_none() {
        // Software Vulkan drivers complain on standard error without one.
        command.env("XDG_RUNTIME_DIR", std::env::temp_dir());
    }
    command
}

/// Runs `gnomon ARGUMENTS` in `folder`.
pub fn gnomon(folder: &Path, arguments: &[&str]) -> Run {
    Run::of(&command(folder, arguments).output().unwrap())
}

/// Names of the files in a folder, sorted.
pub fn files(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<_> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
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
