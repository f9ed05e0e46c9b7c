use thiserror::Error;

/// What is wrong with a file.
#[derive(Debug, Error)]
pub enum MeasuredError {
    /// Another kind of file.
    #[error(
        "'.{0}' is no file of measured reflectance (these are: .bsdf of the RGL, .binary of MERL, .json of tables)"
    )]
    Extension(String),
    /// Damaged, or of another version.
    #[error("{0}")]
    Invalid(String),
}

pub(crate) fn invalid(message: impl Into<String>) -> MeasuredError {
    MeasuredError::Invalid(message.into())
}
