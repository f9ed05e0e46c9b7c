//! Scenes whose files a program gives.

use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use gnomon_envmap::{Environment, LoadOptions, from_bytes};
use gnomon_scene_files::{ReadError, Resolver};

use crate::StudioError;

/// Longest file of an environment that is read [bytes].
const LONGEST_MAP: usize = 1 << 31;

/// A scene file with the files that it names: models, textures, an environment. They come from wherever a program has them: what was
/// dropped on a page, an archive, a server.
#[derive(Clone)]
pub struct SceneFiles {
    path: PathBuf,
    files: Arc<dyn Resolver + Send + Sync>,
}

impl SceneFiles {
    /// The scene file at `path` among `files`: a map from paths to bytes, or whatever else gives them.
    pub fn new(path: impl Into<PathBuf>, files: impl Resolver + Send + Sync + 'static) -> Self {
        Self { path: path.into(), files: Arc::new(files) }
    }

    /// Path of the scene file, which tells its format.
    pub fn path(&self) -> &Path {
        &self.path
    }

    pub(crate) fn resolver(&self) -> &dyn Resolver {
        &*self.files
    }

    /// One of the files as text.
    pub(crate) fn text(&self, path: &Path) -> Result<String, StudioError> {
        let bytes = self.bytes(path)?;
        String::from_utf8(bytes)
            .map_err(|_| StudioError::Request(format!("{} is not a file of text", path.display())))
    }

    /// One of the files as an environment.
    pub(crate) fn environment(
        &self,
        path: &Path,
        options: LoadOptions<'_>,
    ) -> Result<Environment, StudioError> {
        Ok(from_bytes(path, &self.bytes(path)?, options)?)
    }

    fn bytes(&self, path: &Path) -> Result<Vec<u8>, StudioError> {
        let shown = path.display();
        self.files.read(path, LONGEST_MAP).map_err(|error| match error {
            ReadError::Io(source) => StudioError::Read { path: path.to_owned(), source },
            ReadError::NotRegular => StudioError::Request(format!("{shown} is not a regular file")),
            ReadError::TooLong => StudioError::Request(format!("{shown} is longer than {LONGEST_MAP} bytes")),
        })
    }
}

impl fmt::Debug for SceneFiles {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SceneFiles").field("path", &self.path).finish_non_exhaustive()
    }
}

/// The same path among the very same files.
impl PartialEq for SceneFiles {
    fn eq(&self, other: &Self) -> bool {
        self.path == other.path && Arc::ptr_eq(&self.files, &other.files)
    }
}

impl Eq for SceneFiles {}

/// What to do with a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileKind {
    /// Opened as a scene.
    Scene,
    /// Taken as the environment.
    Environment,
}

/// Tells by the name. Whatever is no picture is tried as a scene, whose loader then says what it cannot read.
pub fn kind_of(path: &Path) -> FileKind {
    let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    let mut formats = gnomon_picture::formats().iter();
    match formats.any(|format| format.extensions.contains(&extension.as_str())) {
        true => FileKind::Environment,
        false => FileKind::Scene,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_are_environments_and_all_else_is_a_scene() {
        for (name, kind) in [
            ("a.hdr", FileKind::Environment),
            ("a.b.EXR", FileKind::Environment),
            ("a.jpeg", FileKind::Environment),
            ("fox.glb", FileKind::Scene),
            ("scene.toml", FileKind::Scene),
            ("README", FileKind::Scene),
        ] {
            assert_eq!(kind_of(Path::new(name)), kind, "{name}");
        }
    }
}
