//! Files opened and saved.

use std::path::{Path, PathBuf};

use gnomon_scene_files::EnvironmentSource;
use gnomon_studio::{FileKind, SceneSource, StudioError, kind_of};

use super::Viewer;
use crate::notices::Level;

impl Viewer {
    /// Opens a file, whatever it is.
    pub fn open_file(&mut self, path: &Path) {
        match kind_of(path) {
            FileKind::Scene => self.open_scene(SceneSource::File(path.to_owned())),
            FileKind::Environment => {
                let name = path.to_string_lossy().into_owned();
                self.set_environment(EnvironmentSource::File(name.into()));
            }
        }
    }

    /// Loads another scene.
    pub fn open_scene(&mut self, source: SceneSource) {
        match &mut self.studio {
            Some(studio) => studio.load_scene(source),
            None => self.notices.add(Level::Warning, "wait until the first scene is open"),
        }
    }

    /// Takes another environment, as it is.
    pub fn set_environment(&mut self, source: EnvironmentSource) {
        self.edit(|look| {
            look.set_environment(source);
            look.display.exposure = None;
        });
    }

    /// Writes the GPU's picture at the size that is on display: PNG as it is shown, EXR as radiance.
    pub fn save_picture(&mut self) {
        let path = PathBuf::from(self.picture_path.trim());
        let Some(studio) = &mut self.studio else { return };
        let [width, height] = studio.look().picture.size;
        let saved = (|| -> Result<(), StudioError> {
            let frame = studio.frame(width, height)?;
            let linear = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("exr"));
            let picture = match linear || self.picture.is_debug_view() {
                true => frame.radiance,
                false => {
                    let rule = studio.look().display.tone_mapping;
                    gnomon_picture::tonemap::tone_mapped(&frame.radiance, rule, studio.stage().exposure())
                }
            };
            Ok(gnomon_picture::write(&path, &picture)?)
        })();
        self.picture.touch();
        self.tell_saved(&path, saved);
    }

    /// Writes the scene with its look, so that `gnomon render` makes the picture that is on display.
    pub fn save_scene(&mut self) {
        let path = PathBuf::from(self.scene_path.trim());
        let Some(studio) = &mut self.studio else { return };
        let saved = studio.save_scene(&path);
        self.tell_saved(&path, saved);
    }

    /// Writes the light rig as it is edited, or the fitted lights as one, and goes on with it.
    pub fn save_rig(&mut self) {
        let path = PathBuf::from(self.rig_path.trim());
        let Some(studio) = &mut self.studio else { return };
        let saved = studio.save_rig(&path);
        self.tell_saved(&path, saved);
    }

    /// Drops all edits of the light rig, and reads its file anew.
    pub fn reload_rig(&mut self) {
        self.edit(|look| look.rig = None);
        if let Some(studio) = &mut self.studio {
            studio.reload_environment();
        }
    }

    fn tell_saved(&mut self, path: &Path, saved: Result<(), StudioError>) {
        match saved {
            Ok(()) => {
                let shown = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
                self.notices.add(Level::Done, &format!("saved {}", shown.display()));
            }
            Err(error) => self.notices.error(&error),
        }
    }
}
