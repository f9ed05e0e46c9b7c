//! Drives a real binary of the project.

use std::path::Path;
use std::process::{Command, Output, Stdio};

use serde_json::Value;

/// What one run of a command gave.
pub struct Run {
    /// Exit status; `None` where a signal ended it.
    pub status: Option<i32>,
    /// Standard output.
    pub out: String,
    /// Standard error.
    pub err: String,
}

impl Run {
    /// What a finished process left.
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

    /// Fails the test unless the run ended in exit status 2 and one line `PROGRAM: error: ...` that contains `part`, beside warnings.
    #[track_caller]
    pub fn failed(self, part: &str) -> Self {
        assert_eq!(self.status, Some(2), "{}{}", self.out, self.err);
        let errors: Vec<&str> = self.err.lines().filter(|line| !line.contains(": warning: ")).collect();
        assert_eq!(errors.len(), 1, "{}", self.err);
        let message = errors[0].split_once(": error: ").filter(|(program, _)| program.starts_with("gnomon"));
        assert!(message.is_some_and(|(_, message)| message.contains(part)), "{}", errors[0]);
        self
    }

    /// Standard output as JSON.
    ///
    /// # Panics
    /// Where it is none: the test fails.
    #[track_caller]
    pub fn json(&self) -> Value {
        serde_json::from_str(&self.out).unwrap_or_else(|error| panic!("{error}: {}", self.out))
    }
}

/// The binary with these arguments, run in `folder`.
pub fn command(binary: &str, folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(binary);
    command.args(arguments).current_dir(folder).stdin(Stdio::null());
    if std::env::var_os("XDG_RUNTIME_DIR").is_none() {
        // Software Vulkan drivers complain on standard error without one.
        command.env("XDG_RUNTIME_DIR", std::env::temp_dir());
    }
    command
}

/// Names of the files in a folder, sorted.
///
/// # Panics
/// Where the folder cannot be read: the test fails.
#[track_caller]
pub fn files(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let mut names: Vec<_> =
        entries.flatten().map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}
