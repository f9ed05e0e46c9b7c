//! Light rigs that a session edits.

use std::io;
use std::path::Path;

use gnomon_lights::{LightDocument, LightEntry};
use gnomon_picture::atomic;
use gnomon_rigs::targets;
use serde::{Deserialize, Serialize};

use crate::look::EnvironmentLook;
use crate::save::Place;
use crate::{Look, SceneSource, Stage, Studio, StudioError};

/// The lights of a rig as they are edited, in the place of those that its file has. The maps are the file's. Edits are gone once the look names
/// another file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EditedRig {
    /// The rig that they belong to: [`EnvironmentLook::rig`].
    pub file: String,
    /// Its lights.
    pub lights: Vec<LightEntry>,
    /// The light that shines alone, whatever else is on: the others and the map do not. It is not saved.
    #[serde(default)]
    pub solo: Option<usize>,
}

impl EditedRig {
    /// A document with these lights, so far as they shine.
    pub(crate) fn apply(&self, document: &mut LightDocument) {
        document.lights.clone_from(&self.lights);
        if let Some(solo) = self.solo {
            for (index, light) in document.lights.iter_mut().enumerate() {
                light.enabled = index == solo;
            }
        }
    }
}

impl Look {
    /// Edits of the rig that is named.
    pub fn edited_rig(&self) -> Option<&EditedRig> {
        self.rig.as_ref().filter(|edited| Some(&edited.file) == self.environment.rig.as_ref())
    }
}

impl Stage {
    /// The lights of the look's rig, for edits: to be changed and put into [`Look::rig`]. `None` without a rig, and until it is read.
    pub fn rig(&self) -> Option<EditedRig> {
        let edited = self.look().edited_rig().cloned();
        edited.or_else(|| {
            let (file, document) = (self.look().environment.rig.clone()?, self.surroundings().rig()?);
            Some(EditedRig { file, lights: document.lights.clone(), solo: None })
        })
    }

    /// Writes the rig as it is edited. Its maps stay where they are: the file names them, by paths relative to itself.
    ///
    /// # Errors
    /// [`StudioError::Request`] without a rig, and for one whose files a program gave; a file that cannot be written.
    pub fn save_rig(&self, path: &Path) -> Result<(), StudioError> {
        let (Some(edited), Some(read)) = (self.rig(), self.surroundings().rig()) else {
            return Err(StudioError::Request("there is no light rig to be saved".to_owned()));
        };
        if let SceneSource::Files(_) = self.source() {
            let file = &edited.file;
            return Err(StudioError::Request(format!("{file} cannot be saved: a program gave its files")));
        }
        let from = Path::new(&edited.file).parent().unwrap_or(Path::new(""));
        let place = Place::Disk(path.parent().unwrap_or(Path::new("")));
        let moved = |map: &Option<String>| map.as_ref().map(|map| place.name(&from.join(map))).transpose();
        let mut document = LightDocument {
            lights: edited.lights,
            residual: moved(&read.residual)?,
            background: moved(&read.background)?,
            ..LightDocument::clone(read)
        };
        document.check()?;
        document.derive();
        atomic::write::<io::Error>(path, |file| file.write_all(document.to_json().as_bytes()))
            .map_err(|source| StudioError::Write { path: path.to_owned(), source })
    }
}

impl Studio {
    /// Writes the rig as it is edited, or else a rig of the lights that are fitted to the environment with the maps that it needs, and goes on with
    /// what is written. The turn of the environment is none of the rig's.
    ///
    /// # Errors
    /// As [`Stage::save_rig`]; maps that cannot be written.
    pub fn save_rig(&mut self, path: &Path) -> Result<(), StudioError> {
        let file = path.to_str().ok_or_else(|| {
            StudioError::Request(format!("{} cannot be named by a look: it is no text", path.display()))
        })?;
        if self.stage().rig().is_some() {
            self.stage().save_rig(path)?;
        } else {
            let about = ["Lights of a session, by Gnomon.".to_owned()];
            let map = self.stage().surroundings().whole_map();
            gnomon_rigs::write(&targets()[0], path, map, self.lights(), &about)?;
        }
        self.edit(|look| look.open_rig(file))?;
        // A file of the same name has other lights now.
        self.reload_environment();
        Ok(())
    }
}

impl Look {
    /// Takes a rig as its file has it. One that is open stays as it is lit: what strength, tint and clamp made of a map that was fitted is in the rig.
    fn open_rig(&mut self, file: &str) {
        if self.environment.rig.is_none() {
            self.map = None;
            let rotation = self.environment.rotation;
            self.environment = EnvironmentLook { rotation, ..EnvironmentLook::default() };
        }
        self.environment.rig = Some(file.to_owned());
        self.rig = None;
    }
}
