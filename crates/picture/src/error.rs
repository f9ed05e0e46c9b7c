use std::io;
use std::path::PathBuf;

/// Why the bytes of a picture could not be decoded. [`ImageError::Decode`] adds the file.
#[derive(Debug, thiserror::Error)]
pub enum DecodeError {
    /// The file contradicts its own format or ends early: the file is at fault.
    #[error("damaged {format} file: {reason}")]
    Malformed {
        /// Format's name.
        format: &'static str,
        /// What is wrong, and where.
        reason: String,
    },
    /// The file may be sound but uses something that this reader does not know.
    #[error("{format} file uses an unsupported feature: {feature}")]
    Unsupported {
        /// Format's name.
        format: &'static str,
        /// The feature.
        feature: String,
    },
    /// The header asks for more than [`crate::MAX_TEXELS`] or than a file of this length can hold.
    #[error("{format} file is over a size limit: {reason}")]
    TooLarge {
        /// Format's name.
        format: &'static str,
        /// Claimed size and the limit it breaks.
        reason: String,
    },
    /// The file has layers of which none is plainly its picture.
    #[error(
        "none of its layers is plainly the picture: {layers} (name one, for an environment by --env-layer)"
    )]
    NoPlainLayer {
        /// The layers, or channels where they are no layers of colours.
        layers: String,
    },
    /// The file has no such layer.
    #[error("there is no layer '{name}' with colours in it: there is {known}", name = gnomon_messages::quoted(name))]
    NoLayer {
        /// What was asked for.
        name: String,
        /// Layers that there are.
        known: String,
    },
    /// No known format starts like this.
    #[error("not a picture of a known format (known: {known})")]
    UnknownFormat {
        /// Names of the formats that were tried.
        known: String,
    },
}

impl DecodeError {
    pub(crate) fn malformed(format: &'static str, reason: impl Into<String>) -> Self {
        Self::Malformed { format, reason: reason.into() }
    }

    pub(crate) fn unsupported(format: &'static str, feature: impl Into<String>) -> Self {
        Self::Unsupported { format, feature: feature.into() }
    }

    pub(crate) fn too_large(format: &'static str, reason: impl Into<String>) -> Self {
        Self::TooLarge { format, reason: reason.into() }
    }
}

/// Why a picture could not be read from or written to a file.
#[derive(Debug, thiserror::Error)]
pub enum ImageError {
    /// The operating system did not give the file.
    #[error("cannot read {path}: {source}", path = path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// The operating system did not take the file. Nothing was left under that name that was not there before.
    #[error("cannot write {path}: {source}", path = path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// The file was read but is not a picture that can be used.
    #[error("{path}: {source}", path = path.display())]
    Decode {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        source: DecodeError,
    },
    /// The picture cannot be stored in the format that the file name asks for: the caller is at fault.
    #[error("cannot write {path}: {reason}", path = path.display())]
    Encode {
        /// The file.
        path: PathBuf,
        /// What does not fit.
        reason: String,
    },
    /// No writer goes by this extension.
    #[error("cannot write {path}: the name must end in one of {known}", path = path.display())]
    UnknownExtension {
        /// The file.
        path: PathBuf,
        /// Extensions that can be written.
        known: String,
    },
}
