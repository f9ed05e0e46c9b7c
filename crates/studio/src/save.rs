//! Scene files that bring the same picture.

use std::io;
use std::path::{Component, Path, PathBuf};

use gnomon_lights::fit::FitSettings;
use gnomon_picture::atomic;
use gnomon_renderer::{DisplaySettings, LightPaths, LightingSettings, TechniqueSettings};
use gnomon_scene::{Camera, ReflectanceSettings};
use gnomon_scene_files::{EnvironmentSource, plain};
use serde::Serialize;
use toml::{Table, Value};

use crate::look::{AnimationLook, CameraLook, EnvironmentLook, PictureSettings, SceneLook};
use crate::{SceneSource, Stage, Studio, StudioError};

/// The tables of a scene file that a look decides, in the order in which they are written.
#[derive(Serialize)]
struct LookTables<'a> {
    #[serde(flatten)]
    scene: &'a SceneLook,
    #[serde(skip_serializing_if = "Option::is_none")]
    camera: Option<Camera>,
    environment: EnvironmentTable,
    fit: &'a FitSettings,
    #[serde(serialize_with = "gnomon_options::serialize")]
    render: (LightPaths, (LightingSettings, TechniqueSettings)),
    #[serde(serialize_with = "gnomon_options::serialize")]
    display: (PictureSettings, DisplaySettings),
    animation: &'a AnimationLook,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    surface: Vec<SurfaceTable<'a>>,
}

#[derive(Serialize)]
struct EnvironmentTable {
    #[serde(skip_serializing_if = "Option::is_none")]
    file: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    builtin: Option<String>,
    /// `[display]` has the number, where there is one.
    exposure: &'static str,
    #[serde(flatten)]
    options: EnvironmentLook,
}

#[derive(Serialize)]
struct SurfaceTable<'a> {
    #[serde(skip_serializing_if = "Option::is_none")]
    material: Option<usize>,
    reflectance: &'a ReflectanceSettings,
}

/// Keys of a scene file that [`LookTables`] replaces.
const REPLACED: [&str; 15] = [
    "bump_scale",
    "emission",
    "ground",
    "ground_camera_height",
    "lamp_strength",
    "variant",
    "up",
    "unit",
    "camera",
    "environment",
    "fit",
    "render",
    "display",
    "animation",
    "surface",
];

impl Stage {
    /// Writes a scene file of which `gnomon render` makes the same picture. Models and maps stay where they are: the file names them, by
    /// paths relative to itself where that can be.
    ///
    /// # Errors
    /// [`StudioError::Request`] for a scene or an environment that no file can name, and for edits of a rig; a scene file that is no longer there; files that cannot
    /// be written.
    pub fn save_scene(&self, path: &Path) -> Result<(), StudioError> {
        if let SceneSource::Files(files) = self.source() {
            let path = files.path().display();
            return Err(StudioError::Request(format!(
                "{path} cannot be saved: a program gave its files, which no scene file can name"
            )));
        }
        let text = self.written(&Place::Disk(path.parent().unwrap_or(Path::new(""))))?;
        atomic::write::<io::Error>(path, |file| file.write_all(text.as_bytes()))
            .map_err(|source| StudioError::Write { path: path.to_owned(), source })
    }

    /// The same as a text. Of a scene whose files a program gave it is a file beside the scene's own: it names them by their paths among
    /// each other. Others are named from the working directory.
    ///
    /// # Errors
    /// As [`Stage::save_scene`].
    pub fn scene_file(&self) -> Result<String, StudioError> {
        self.written(&match self.source() {
            SceneSource::Files(files) => Place::Among(files.path().parent().unwrap_or(Path::new(""))),
            SceneSource::Builtin(_) | SceneSource::File(_) | SceneSource::Made(_) => {
                Place::Disk(Path::new(""))
            }
        })
    }

    fn written(&self, place: &Place<'_>) -> Result<String, StudioError> {
        let mut scene = self.scene_tables(place)?;
        let look = self.look();
        if look.edited_rig().is_some() {
            return Err(StudioError::Request(
                "the light rig has edits that no scene file can hold: save the rig first".to_owned(),
            ));
        }
        // The scene's own camera is found again, and goes on moving where a clip moves it.
        let is_own = look.camera == CameraLook::Automatic && self.reloads_its_camera();
        let camera = scene.get("camera").filter(|_| is_own).cloned();
        REPLACED.iter().for_each(|key| drop(scene.remove(*key)));
        scene.extend(camera.map(|camera| ("camera".to_owned(), camera)));
        let (file, builtin) = match &look.map {
            Some(EnvironmentSource::File(file)) => (Some(place.name(file)?), None),
            Some(EnvironmentSource::Builtin(name)) => (None, Some(name.clone())),
            None if look.environment.rig.is_some() => (None, None),
            None => {
                return Err(StudioError::Request("an environment without a file cannot be saved".to_owned()));
            }
        };
        let all = look.reflectance.as_ref().map(|reflectance| SurfaceTable { material: None, reflectance });
        let single = look
            .surfaces
            .iter()
            .map(|(&material, reflectance)| SurfaceTable { material: Some(material), reflectance });
        let tables = LookTables {
            scene: &look.scene,
            camera: if is_own { None } else { Some(self.camera()?) },
            environment: EnvironmentTable {
                file,
                builtin,
                exposure: "automatic",
                options: look.environment.with_files(|file| place.name(Path::new(file)))?,
            },
            fit: &look.fit,
            render: (look.paths.clone(), (look.lighting.clone(), look.techniques.clone())),
            display: (look.picture.clone(), look.display.clone()),
            animation: &look.animation,
            surface: all.into_iter().chain(single).collect(),
        };
        let written = |error: toml::ser::Error| {
            StudioError::Request(format!("the scene cannot be written as TOML: {error}"))
        };
        let tables = toml::to_string(&tables).map_err(written)?;
        let scene = toml::to_string(&scene).map_err(written)?;
        Ok(format!("# A Gnomon scene. SCENE_FORMAT.md describes every key.\n\n{tables}\n{scene}"))
    }

    /// What is in the scene, for a file that lies there.
    fn scene_tables(&self, place: &Place<'_>) -> Result<Table, StudioError> {
        let mut model = Table::new();
        match self.source() {
            SceneSource::File(path) if is_scene_file(path) => {
                let text = std::fs::read_to_string(path)
                    .map_err(|source| StudioError::Read { path: path.clone(), source })?;
                return read_tables(path, &text, place);
            }
            SceneSource::Files(files) if is_scene_file(files.path()) => {
                return read_tables(files.path(), &files.text(files.path())?, place);
            }
            SceneSource::File(path) => drop(model.insert("file".to_owned(), place.name(path)?.into())),
            SceneSource::Files(files) => {
                drop(model.insert("file".to_owned(), place.name(files.path())?.into()));
            }
            SceneSource::Made(name) => {
                return Err(StudioError::Request(format!(
                    "{name} cannot be saved: a program made it, and no scene file can name it"
                )));
            }
            SceneSource::Builtin(name) => {
                model.insert("builtin".to_owned(), name.clone().into());
                model.insert("ground".to_owned(), true.into());
            }
        }
        Ok(Table::from_iter([("model".to_owned(), Value::from(vec![Value::from(model)]))]))
    }
}

impl Studio {
    /// [`Stage::save_scene`] of what is shown.
    ///
    /// # Errors
    /// As [`Stage::save_scene`].
    pub fn save_scene(&self, path: &Path) -> Result<(), StudioError> {
        self.stage().save_scene(path)
    }
}

fn is_scene_file(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml"))
}

/// The tables of a scene file, its models' paths seen from where another is to lie.
fn read_tables(path: &Path, text: &str, place: &Place<'_>) -> Result<Table, StudioError> {
    let mut tables: Table =
        text.trim_start_matches('\u{feff}').parse().map_err(|error: toml::de::Error| {
            let words = gnomon_messages::quoted(error.message());
            StudioError::Request(format!("{} is no scene file any more: {words}", path.display()))
        })?;
    let own = path.parent().unwrap_or(Path::new(""));
    for (table, key) in [("model", "file"), ("light", "profile")] {
        let entries = tables.get_mut(table).and_then(Value::as_array_mut);
        for entry in entries.into_iter().flatten().filter_map(Value::as_table_mut) {
            if let Some(Value::String(file)) = entry.get_mut(key) {
                *file = place.name(&own.join(&*file))?;
            }
        }
    }
    Ok(tables)
}

/// The folder in which a scene file is to lie, from where it names others.
pub(crate) enum Place<'a> {
    Disk(&'a Path),
    /// Among the files that a program gave.
    Among(&'a Path),
}

impl Place<'_> {
    pub(crate) fn name(&self, path: &Path) -> Result<String, StudioError> {
        match self {
            Self::Disk(folder) => relative(path, folder),
            Self::Among(folder) => way(&plain(path), &plain(folder)),
        }
    }
}

/// A path as seen from a folder, with `/`; absolute where there is no way from the one to the other.
fn relative(path: &Path, folder: &Path) -> Result<String, StudioError> {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    // Links are followed where things exist, so that `..` leads where it should.
    let absolute = |path: &Path| {
        std::fs::canonicalize(path)
            .or_else(|_| std::path::absolute(path))
            .map_err(|source| StudioError::Read { path: path.to_owned(), source })
    };
    let (path, folder) = (absolute(path)?, absolute(folder)?);
    let no_way = path.components().next() != folder.components().next();
    if no_way { named(&path) } else { way(&path, &folder) }
}

/// The way from a folder to a path that begins where it does.
fn way(path: &Path, folder: &Path) -> Result<String, StudioError> {
    let common = path.components().zip(folder.components()).take_while(|(a, b)| a == b).count();
    let above = folder.components().skip(common).map(|_| Component::ParentDir);
    named(&above.chain(path.components().skip(common)).collect::<PathBuf>())
}

/// A path as scene files have it, with `/`.
fn named(path: &Path) -> Result<String, StudioError> {
    let text = path.to_str().ok_or_else(|| {
        StudioError::Request(format!("{} cannot be named in a scene file: it is no text", path.display()))
    })?;
    Ok(if cfg!(windows) { text.replace('\\', "/") } else { text.to_owned() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_seen_from_the_folder() {
        let root = tempfile::tempdir().unwrap();
        let folder = root.path().join("a/b");
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::create_dir_all(root.path().join("c")).unwrap();
        for (file, expected) in
            [("a/b/x.obj", "x.obj"), ("a/x.obj", "../x.obj"), ("c/x.obj", "../../c/x.obj")]
        {
            std::fs::write(root.path().join(file), "").unwrap();
            assert_eq!(relative(&root.path().join(file), &folder).unwrap(), expected);
        }
    }
}
