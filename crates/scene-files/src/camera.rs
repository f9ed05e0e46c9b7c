//! Camera files, and cameras of the command line.

use std::path::Path;

use gnomon_messages::quoted;
use gnomon_scene::Camera;

use crate::SceneFileError;

/// Reads a camera file: the keys of a scene file's `[camera]` (`SCENE_FORMAT.md`), `eye`, `target` and `fov` as people write
/// them or `matrix` and a lens as programs do; as TOML, or as JSON where it starts with `{`.
///
/// # Errors
/// [`SceneFileError::Io`], or [`SceneFileError::Invalid`] naming what is wrong.
pub fn read_camera(path: &Path) -> Result<Camera, SceneFileError> {
    const MOST_BYTES: u64 = 1 << 20;
    let io = |source| SceneFileError::Io { path: path.to_owned(), source };
    let invalid = |message: &str| SceneFileError::Invalid { path: path.to_owned(), message: quoted(message) };
    let metadata = std::fs::metadata(path).map_err(io)?;
    if !metadata.is_file() || metadata.len() > MOST_BYTES {
        return Err(invalid("a camera file is a small text file"));
    }
    let text = std::fs::read_to_string(path).map_err(io)?;
    let text = text.trim_start_matches('\u{feff}');
    if text.trim_start().starts_with('{') {
        serde_json::from_str(text).map_err(|error| invalid(&error.to_string()))
    } else {
        ::toml::from_str(text).map_err(|error| invalid(error.message()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn camera_files_are_toml_or_json() {
        let folder = tempfile::tempdir().unwrap();
        let expected: Camera = "eye=1,2,3;target=0,0,0;fov=50".parse().unwrap();
        for (name, text) in [
            ("a.toml", "# a view\neye = [1, 2, 3]\ntarget = [0, 0, 0]\nfov = 50\n"),
            ("a.json", r#"{"eye": [1, 2, 3], "target": [0, 0, 0], "fov": 50}"#),
        ] {
            let path = folder.path().join(name);
            std::fs::write(&path, text).unwrap();
            assert_eq!(read_camera(&path).unwrap(), expected);
        }
        for (text, why) in [
            ("eye = [1, 2, 3]\ntarget = [0, 0, 0]\nfov = 50\nroll = 3", "roll"),
            ("eye = [1, 2, 3]\ntarget = [0, 0, 0]\nfov = 180", "fov is 180 degrees"),
            (r#"{"eye": [1, 2, 3], "target": [1, 2, 3], "fov": 50}"#, "same point"),
        ] {
            let path = folder.path().join("bad.toml");
            std::fs::write(&path, text).unwrap();
            let error = read_camera(&path).unwrap_err().to_string();
            assert!(error.contains(why) && !error.contains('\n'), "{error}");
        }
        assert!(matches!(read_camera(folder.path()), Err(SceneFileError::Invalid { .. })));
        assert!(matches!(read_camera(&folder.path().join("none")), Err(SceneFileError::Io { .. })));
    }
}
