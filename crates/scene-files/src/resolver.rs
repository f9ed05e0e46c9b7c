//! Where the files of a scene come from.

use std::collections::HashMap;
use std::io::{self, Read};
use std::path::{Component, Path, PathBuf};

/// Gives the bytes of the files that a scene consists of, by the paths that they name each other with.
pub trait Resolver {
    /// All bytes of a file.
    ///
    /// # Errors
    /// [`ReadError`], [`ReadError::TooLong`] for more than `most` bytes.
    fn read(&self, path: &Path, most: usize) -> Result<Vec<u8>, ReadError>;
}

/// Why there are no bytes.
#[derive(Debug)]
pub enum ReadError {
    /// The file is not there or cannot be read.
    Io(io::Error),
    /// It is a folder, a device or a pipe, which may never end.
    NotRegular,
    /// It is longer than was allowed.
    TooLong,
}

impl From<io::Error> for ReadError {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
}

/// The file system.
#[derive(Clone, Copy, Debug, Default)]
pub struct FileResolver;

impl Resolver for FileResolver {
    fn read(&self, path: &Path, most: usize) -> Result<Vec<u8>, ReadError> {
        let metadata = std::fs::metadata(path)?;
        if !metadata.is_file() {
            return Err(ReadError::NotRegular);
        }
        let length = usize::try_from(metadata.len()).ok().filter(|length| *length <= most);
        let mut bytes = Vec::with_capacity(length.ok_or(ReadError::TooLong)?);
        // Not past the length that was allowed, even if the file grows meanwhile.
        std::fs::File::open(path)?.take(metadata.len()).read_to_end(&mut bytes)?;
        Ok(bytes)
    }
}

/// A path without `.` and `..`, which are taken by their word: there are no links.
pub fn plain(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir => drop(plain.pop()),
            other => plain.push(other),
        }
    }
    plain
}

/// Files in memory, by their [`plain`] paths: what a browser fetched, or an archive held.
impl Resolver for HashMap<PathBuf, Vec<u8>> {
    fn read(&self, path: &Path, most: usize) -> Result<Vec<u8>, ReadError> {
        let bytes = self.get(&plain(path)).ok_or_else(|| io::Error::from(io::ErrorKind::NotFound))?;
        if bytes.len() <= most { Ok(bytes.clone()) } else { Err(ReadError::TooLong) }
    }
}
