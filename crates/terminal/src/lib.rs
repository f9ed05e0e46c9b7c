//! How the project's commands speak to people: results on standard output; warnings, progress and one line for an error on
//! standard error.

use std::error::Error;
use std::io::{self, IsTerminal, Write};
use std::process::ExitCode;
use std::time::Duration;

use clap::Parser;
use clap::error::ErrorKind;
pub use gnomon_messages::{one_line, with_causes};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Why a command could not speak, or was not understood.
#[derive(Debug, thiserror::Error)]
pub enum TerminalError {
    /// The command line does not make sense: the user is at fault.
    #[error("{0}")]
    Usage(String),
    /// The reader of standard output went away, as `| head` does. Not a failure.
    #[error("standard output was closed")]
    ClosedOutput,
    /// Standard output could not be written.
    #[error("cannot write to standard output: {0}")]
    Output(io::Error),
}

/// Where messages go, and whether there are any.
#[derive(Clone, Copy, Debug)]
pub struct Terminal {
    program: &'static str,
    quiet: bool,
}

impl Terminal {
    /// Of a program of that name. With `quiet`, only errors and results are shown.
    pub fn new(program: &'static str, quiet: bool) -> Self {
        Self { program, quiet }
    }

    /// Whether only errors and results are shown.
    pub fn is_quiet(self) -> bool {
        self.quiet
    }

    /// One line `PROGRAM: warning: ...` on standard error.
    pub fn warn(self, message: &str) {
        if !self.quiet {
            say(&format!("{}: warning: {}", self.program, one_line(message)));
        }
    }

    /// One line on standard error that tells what was done.
    pub fn note(self, message: &str) {
        if !self.quiet {
            say(&one_line(message));
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
/// [`TerminalError::ClosedOutput`] if nobody reads any more, [`TerminalError::Output`].
pub fn print(text: &str) -> Result<(), TerminalError> {
    let mut out = io::stdout().lock();
    let text = text.trim_end();
    writeln!(out, "{text}").and_then(|()| out.flush()).map_err(|error| match error.kind() {
        io::ErrorKind::BrokenPipe => TerminalError::ClosedOutput,
        _ => TerminalError::Output(error),
    })
}

/// One line on standard error.
fn say(line: &str) {
    // A closed standard error leaves nobody to tell.
    let _ = writeln!(io::stderr().lock(), "{line}");
}

/// Reads the command line and acts on it. The exit status is 0, or 2 after one line `PROGRAM: error: ...`; a closed standard output is no
/// failure.
pub fn run<C: Parser, E>(program: &str, act: impl FnOnce(&C) -> Result<(), E>) -> ExitCode
where
    E: Error + From<TerminalError> + 'static,
{
    let result = match C::try_parse() {
        Ok(arguments) => act(&arguments),
        Err(error) => explain(program, &error).map_err(E::from),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) if is_closed_output(&error) => ExitCode::SUCCESS,
        Err(error) => {
            say(&format!("{program}: error: {}", with_causes(&error)));
            ExitCode::from(2)
        }
    }
}

/// Whether an error, or what it wraps, is [`TerminalError::ClosedOutput`].
fn is_closed_output(error: &(dyn Error + 'static)) -> bool {
    matches!(error.downcast_ref(), Some(TerminalError::ClosedOutput))
        || error.source().is_some_and(is_closed_output)
}

/// Help and version are results; everything else that clap refuses becomes one line.
fn explain(program: &str, error: &clap::Error) -> Result<(), TerminalError> {
    let text = error.render().to_string();
    match error.kind() {
        ErrorKind::DisplayHelp | ErrorKind::DisplayVersion => print(&text),
        ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand | ErrorKind::MissingSubcommand => {
            Err(TerminalError::Usage(format!("no command given (see {program} --help)")))
        }
        _ => Err(TerminalError::Usage(format!("{} (see --help)", one_line(&complaint(&text))))),
    }
}

/// What is wrong, of all that clap says, with its tip. How to pass for a file what was meant as an option is none.
fn complaint(text: &str) -> String {
    let text = text.split("\nUsage:").next().unwrap_or_default();
    let text = text.trim_start_matches("error: ").split("\nFor more information").next().unwrap_or_default();
    let (what, tips) = text.split_once("\n\n  tip: ").unwrap_or((text, ""));
    let tips = tips.split("\n  tip: ").map(str::trim);
    let helpful = tips.filter(|tip| !tip.is_empty() && !tip.starts_with("to pass "));
    std::iter::once(what.trim()).chain(helpful).collect::<Vec<_>>().join("; ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, thiserror::Error)]
    #[error("{text}")]
    struct Outer {
        text: &'static str,
        source: TerminalError,
    }

    #[test]
    fn tips_are_set_apart_and_only_those_that_help() {
        let said = |text: &str| {
            complaint(&format!("error: {text}\n\nUsage: a <B>\n\nFor more information, try '--help'.\n"))
        };
        assert_eq!(
            said("unexpected argument '-1' found\n\n  tip: to pass '-1' as a value, use '-- -1'"),
            "unexpected argument '-1' found"
        );
        assert_eq!(
            said("unexpected argument '--layers' found\n\n  tip: a similar argument exists: '--paper'"),
            "unexpected argument '--layers' found; a similar argument exists: '--paper'"
        );
        assert_eq!(said("a value is required"), "a value is required");
    }

    #[test]
    fn a_closed_output_is_found_under_what_wraps_it() {
        let outer = |source| Outer { text: "no table", source };
        assert!(is_closed_output(&outer(TerminalError::ClosedOutput)));
        assert!(!is_closed_output(&outer(TerminalError::Usage("why".to_owned()))));
    }
}
