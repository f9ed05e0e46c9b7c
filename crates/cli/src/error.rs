//! Everything that can stop a command, and how it is said: one line.

use std::error::Error;
use std::io;
use std::path::PathBuf;

use gnomon::bench::BenchError;
use gnomon::envmap::EnvMapError;
use gnomon::image::ImageError;
use gnomon::lights::FitError;
use gnomon::metrics::MetricsError;
use gnomon::reference::ReferenceError;
use gnomon::renderer::RenderError;
use gnomon::renderer::lod::LodError;
use gnomon::report::ReportError;
use gnomon::scene::SceneError;
use gnomon::studio::StudioError;

/// Why a command ended early.
#[derive(Debug, thiserror::Error)]
pub enum CliError {
    /// The command line does not make sense: the user is at fault.
    #[error("{0}")]
    Usage(String),
    /// A file of text or JSON could not be written.
    #[error("cannot write {path}: {source}", path = path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// The reader of standard output went away, as `| head` does. Not a failure.
    #[error("standard output was closed")]
    ClosedOutput,
    /// Standard output could not be written.
    #[error("cannot write to standard output: {0}")]
    Output(io::Error),
    /// A picture could not be read or written.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// The environment cannot be used.
    #[error(transparent)]
    Environment(#[from] EnvMapError),
    /// The scene cannot be used.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The lights cannot be fitted.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// The pictures cannot be compared.
    #[error(transparent)]
    Metrics(#[from] MetricsError),
    /// The reference cannot be rendered.
    #[error(transparent)]
    Reference(#[from] ReferenceError),
    /// The picture cannot be set up or kept.
    #[error(transparent)]
    Studio(#[from] StudioError),
    /// There is no window, or a scripted session failed.
    #[cfg(feature = "view")]
    #[error(transparent)]
    View(#[from] gnomon_viewer::ViewerError),
    /// The picture cannot be rendered.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// The frame rate cannot be held.
    #[error(transparent)]
    LevelOfDetail(#[from] LodError),
    /// An experiment gave nothing.
    #[error(transparent)]
    Bench(#[from] BenchError),
    /// The report cannot be written.
    #[error(transparent)]
    Report(#[from] ReportError),
}

impl CliError {
    /// A fault of the command line.
    pub fn usage(message: impl Into<String>) -> Self {
        Self::Usage(message.into())
    }

    /// The error and its causes on one line. A cause that its effect already names is not said twice.
    pub fn one_line(&self) -> String {
        let mut text = self.to_string();
        let mut cause = self.source();
        while let Some(error) = cause {
            let words = error.to_string();
            if !text.contains(&words) {
                text = format!("{text}: {words}");
            }
            cause = error.source();
        }
        single_line(&text)
    }
}

/// The text with every run of white space, line ends included, as one space; control characters are dropped, because file
/// names and file contents may hold escape sequences.
pub fn single_line(text: &str) -> String {
    let visible: String =
        text.chars().map(|c| if c.is_whitespace() { ' ' } else { c }).filter(|c| !c.is_control()).collect();
    visible.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn causes_are_joined_once_on_one_line() {
        let error = CliError::Write { path: "a.json".into(), source: io::Error::other("disk\nfull") };
        assert_eq!(error.one_line(), "cannot write a.json: disk full");
    }

    #[test]
    fn terminal_escapes_are_dropped() {
        assert_eq!(single_line("a\x1b[31m b\r\n\tc"), "a[31m b c");
    }
}
