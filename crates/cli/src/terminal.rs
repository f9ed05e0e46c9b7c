//! What the user sees while a command works: warnings, progress, results.

use std::io::{self, IsTerminal, Write};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::error::{CliError, single_line};

/// Where messages go, and whether there are any.
#[derive(Clone, Copy, Debug)]
pub struct Terminal {
    quiet: bool,
}

impl Terminal {
    /// With `quiet`, only errors and results are shown.
    pub fn new(quiet: bool) -> Self {
        Self { quiet }
    }

    /// One line `gnomon: warning: ...` on standard error.
    pub fn warn(self, message: &str) {
        if !self.quiet {
            say(&format!("gnomon: warning: {}", single_line(message)));
        }
    }

    /// One line on standard error that tells what was done.
    pub fn note(self, message: &str) {
        if !self.quiet {
            say(&single_line(message));
        }
    }

    /// A bar from 0 to 1 on standard error.
    pub fn bar(self, label: &'static str) -> Progress {
        let bar = ProgressBar::with_draw_target(Some(Progress::STEPS), self.target());
        bar.set_style(style("{prefix:>12} [{bar:30}] {percent:>3} %  {eta} left  {msg}"));
        bar.set_prefix(label);
        Progress(bar)
    }

    /// A moving sign on standard error for work whose length is unknown.
    pub fn spinner(self, label: &'static str) -> Progress {
        let bar = ProgressBar::with_draw_target(None, self.target());
        bar.set_style(style("{prefix:>12} {spinner} {elapsed}"));
        bar.set_prefix(label);
        if !bar.is_hidden() {
            bar.enable_steady_tick(Duration::from_millis(120));
        }
        Progress(bar)
    }

    fn target(self) -> ProgressDrawTarget {
        if self.quiet || !io::stderr().is_terminal() {
            ProgressDrawTarget::hidden()
        } else {
            ProgressDrawTarget::stderr()
        }
    }
}

/// A bar or spinner; it vanishes when dropped.
pub struct Progress(ProgressBar);

impl Progress {
    const STEPS: u64 = 1000;

    /// Sets the finished share, 0..1. From any thread.
    pub fn set(&self, share: f32) {
        self.0.set_position((share.clamp(0.0, 1.0) * Self::STEPS as f32) as u64);
    }

    /// Says beside the bar what is being done. From any thread.
    pub fn tell(&self, what: &str) {
        self.0.set_message(what.to_owned());
    }

    /// Clears the bar, lets `act` print, and draws it again.
    pub fn suspend<T>(&self, act: impl FnOnce() -> T) -> T {
        self.0.suspend(act)
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}

fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}

/// Prints a result on standard output, with a line end.
///
/// # Errors
/// [`CliError::ClosedOutput`] if nobody reads any more, [`CliError::Output`].
pub fn print(text: &str) -> Result<(), CliError> {
    let mut out = io::stdout().lock();
    let text = text.trim_end();
    writeln!(out, "{text}").and_then(|()| out.flush()).map_err(|error| match error.kind() {
        io::ErrorKind::BrokenPipe => CliError::ClosedOutput,
        _ => CliError::Output(error),
    })
}

/// One line on standard error.
pub fn say(line: &str) {
    // A closed standard error leaves nobody to tell.
    let _ = writeln!(io::stderr().lock(), "{line}");
}
