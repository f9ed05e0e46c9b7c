//! What a dropped file is.

use std::path::Path;

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
