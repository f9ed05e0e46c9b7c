use std::path::{Path, PathBuf};

/// Why a scene or camera could not be had. Every message is one line that names who is at fault.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// The file system refused.
    #[error("cannot read {}: {source}", path.display())]
    Io {
        /// The file that was asked for.
        path: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// Neither name nor content tell a format that can be read.
    #[error("{} is no scene format known here (known: {known})", path.display())]
    UnknownFormat {
        /// The file.
        path: PathBuf,
        /// Known formats with their file name extensions.
        known: String,
    },
    /// The file breaks its format's rules.
    #[error("{} is damaged or invalid: {message}", path.display())]
    Invalid {
        /// The file at fault.
        path: PathBuf,
        /// Where and what.
        message: String,
    },
    /// The file is in order, but needs something that Gnomon does not have.
    #[error("{} cannot be used: {message}", path.display())]
    Unsupported {
        /// The file.
        path: PathBuf,
        /// What it needs.
        message: String,
    },
    /// The file would take more memory than [`crate::LoadOptions::memory_limit`].
    #[error("{} asks for more than the {limit_mib} MiB allowed for one scene", path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// The limit in MiB.
        limit_mib: usize,
    },
    /// The caller asked for something that does not exist or makes no sense.
    #[error("{0}")]
    Request(String),
}

/// What a reader of bytes finds wrong; [`Fault::at`] adds whose bytes they were.
#[derive(Debug)]
pub(crate) enum Fault {
    Invalid(String),
    Unsupported(String),
    TooLarge {
        limit_mib: usize,
    },
    /// About another file that this one names.
    Elsewhere(SceneError),
}

impl Fault {
    pub fn invalid(message: impl Into<String>) -> Self {
        Self::Invalid(message.into())
    }

    pub fn unsupported(message: impl Into<String>) -> Self {
        Self::Unsupported(message.into())
    }

    pub fn at(self, path: &Path) -> SceneError {
        let path = path.to_owned();
        match self {
            // Messages of parsers quote the file: they may bring line breaks.
            Self::Invalid(message) => SceneError::Invalid { path, message: one_line(&message) },
            Self::Unsupported(message) => SceneError::Unsupported { path, message: one_line(&message) },
            Self::TooLarge { limit_mib } => SceneError::TooLarge { path, limit_mib },
            Self::Elsewhere(error) => error,
        }
    }
}

impl From<SceneError> for Fault {
    fn from(error: SceneError) -> Self {
        Self::Elsewhere(error)
    }
}

/// The text on one line, cut where it is long: it may quote the file.
pub(crate) fn one_line(text: &str) -> String {
    const LONGEST: usize = 300;
    let mut line = String::new();
    for word in text.split(|c: char| c.is_whitespace() || c.is_control()).filter(|word| !word.is_empty()) {
        if line.len() + word.len() > LONGEST {
            line.push(' ');
            line.extend(word.chars().take(LONGEST.saturating_sub(line.len())));
            line.push_str("...");
            break;
        }
        if !line.is_empty() {
            line.push(' ');
        }
        line.push_str(word);
    }
    line
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quoted_text_becomes_one_bounded_line() {
        assert_eq!(one_line("a\n  b\t\u{1b}[31mc "), "a b [31mc");
        assert!(one_line(&format!("see {}", "9".repeat(10_000))).len() < 320);
        assert!(one_line(&"\u{e9} ".repeat(10_000)).len() < 320);
    }
}
