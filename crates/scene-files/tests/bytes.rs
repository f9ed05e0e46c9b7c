//! Scenes that are no files.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use gnomon_scene_files::{LoadOptions, Resolver, SceneFileError, load, load_bytes};

const SCENE: &str = "[[model]]\nfile = \"models/./part.obj\"\n";
const MODEL: &str = "mtllib ../library/part.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n";
const LIBRARY: &str = "newmtl red\nKd 1 0 0\nmap_Kd missing.png\n";

fn files() -> HashMap<PathBuf, Vec<u8>> {
    let files = [("s/scene.toml", SCENE), ("s/models/part.obj", MODEL), ("s/library/part.mtl", LIBRARY)];
    files.map(|(path, text)| (path.into(), text.as_bytes().to_vec())).into()
}

#[test]
fn bytes_make_the_scene_that_files_make_and_say_the_same() {
    let folder = tempfile::tempdir().unwrap();
    for (path, bytes) in files() {
        let path = folder.path().join(path);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, bytes).unwrap();
    }
    let options = LoadOptions::default();
    let from_files = load(&folder.path().join("s/scene.toml"), &options).unwrap();
    let mut from_bytes = load_bytes(Path::new("s/scene.toml"), SCENE.as_bytes(), &files(), &options).unwrap();
    assert_eq!(from_bytes.scene.warnings.len(), 1, "{:?}", from_bytes.scene.warnings);
    assert!(from_bytes.scene.warnings[0].contains("missing.png"));
    from_bytes.scene.warnings.clone_from(&from_files.scene.warnings);
    assert_eq!(from_bytes, from_files);
}

#[test]
fn what_is_missing_or_too_long_is_named() {
    let (mut files, name) = (files(), Path::new("s/scene.toml"));
    let small = LoadOptions { memory_limit: 2000, ..LoadOptions::default() };
    let loaded = |files: &dyn Resolver, options| load_bytes(name, SCENE.as_bytes(), files, options);
    files.insert("s/models/part.obj".into(), vec![b' '; 3000]);
    let error = loaded(&files, &small).unwrap_err();
    assert!(matches!(error, SceneFileError::TooLarge { .. }), "{error}");
    files.remove(Path::new("s/models/part.obj"));
    let error = loaded(&files, &LoadOptions::default()).unwrap_err();
    assert!(matches!(error, SceneFileError::Io { .. }), "{error}");
    assert!(error.to_string().starts_with("cannot read s/models/./part.obj: "), "{error}");
}
