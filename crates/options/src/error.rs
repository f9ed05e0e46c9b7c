/// A value that an option cannot have.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{option} cannot be {value}: it takes {allowed}")]
pub struct OptionError {
    /// The option, as whoever gave the value calls it.
    pub option: String,
    /// The value, as text on one line.
    pub value: String,
    /// What it may be, in words.
    pub allowed: String,
}
