use std::path::{Path, PathBuf};

use gnomon_messages::quoted;

/// Why a file gave no scene or no camera. Every message is one line that names who is at fault.
#[derive(Debug, thiserror::Error)]
pub enum SceneFileError {
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
    Elsewhere(SceneFileError),
}

impl Fault {
    pub fn invalid(message: impl Into<String>) -> Self {
        Self::Invalid(message.into())
    }

    pub fn unsupported(message: impl Into<String>) -> Self {
        Self::Unsupported(message.into())
    }

    pub fn at(self, path: &Path) -> SceneFileError {
        let path = path.to_owned();
        match self {
            // Messages of parsers quote the file: they may bring line breaks.
            Self::Invalid(message) => SceneFileError::Invalid { path, message: quoted(&message) },
            Self::Unsupported(message) => SceneFileError::Unsupported { path, message: quoted(&message) },
            Self::TooLarge { limit_mib } => SceneFileError::TooLarge { path, limit_mib },
            Self::Elsewhere(error) => error,
        }
    }
}

impl From<SceneFileError> for Fault {
    fn from(error: SceneFileError) -> Self {
        Self::Elsewhere(error)
    }
}
