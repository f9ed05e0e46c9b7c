//! Scene, animation, material, saving.

use std::path::Path;

use eframe::egui::Id;
use gnomon_scene::builtin;
use gnomon_studio::{Clip, Look, SCENE, SceneSource};

use super::fields::Fields;
use super::options::{self, Offer};
use crate::viewer::Viewer;

pub fn show(fields: &mut Fields<'_>, viewer: &mut Viewer, wanted: &mut Look) {
    let Some(studio) = viewer.studio() else { return };
    let name = match studio.stage().source() {
        SceneSource::Builtin(name) | SceneSource::Made(name) => name.clone(),
        SceneSource::File(path) => file_name(path),
        SceneSource::Files(files) => file_name(files.path()),
    };
    let triangles = studio.scene().triangle_count();
    let clips = studio.stage().clips();
    let entries = builtin::NAMES.map(|name| (name, "built in"));
    if let Some(picked) = fields.choice("scene", "scene", &name, entries) {
        viewer.open_scene(SceneSource::Builtin(picked.to_owned()));
    }
    fields.text("triangles", &triangles.to_string());
    open_line(fields, viewer);
    options_of_scene(fields, viewer, wanted, &clips);
}

/// A path, for whoever cannot drop a file.
fn open_line(fields: &mut Fields<'_>, viewer: &mut Viewer) {
    let id = Id::unique("path to open");
    let mut path: String = fields.ui.data(|data| data.get_temp(id)).unwrap_or_default();
    if fields.line("open", "open", &mut path, "file, or drop one") && !path.trim().is_empty() {
        viewer.open_file(Path::new(path.trim()));
    }
    fields.ui.data_mut(|data| data.insert_temp(id, path));
}

/// Options whose choices are the scene's own clips, and the rest.
fn options_of_scene(fields: &mut Fields<'_>, viewer: &mut Viewer, wanted: &mut Look, clips: &[Clip]) {
    let look = wanted.clone();
    let before = &look.animation;
    let playing = clips.iter().find(|clip| clip.is_chosen).map(|clip| clip.duration);
    let texts = || clips.iter().map(|clip| (clip.name.clone(), clip.label.clone()));
    options::show(fields, wanted, SCENE.heading, &look, &|spec| match (spec.key, playing) {
        ("clip", _) if !clips.is_empty() => Offer::Texts(texts().collect()),
        ("time", Some(duration)) => Offer::UpTo(duration),
        ("clip" | "time", _) => Offer::Nothing,
        _ => Offer::Declared,
    });
    if wanted.animation.clip != before.clip {
        viewer.playing = wanted.animation.clip.is_some();
        wanted.animation.time = 0.0;
    } else if wanted.animation.time != before.time {
        viewer.playing = false;
    }
    if playing.is_some() {
        fields.check("", "play", &mut viewer.playing, "run (Space)");
    }
}

pub fn save(fields: &mut Fields<'_>, viewer: &mut Viewer) {
    let mut path = std::mem::take(&mut viewer.picture_path);
    let picture = fields.line("save picture", "save picture", &mut path, "picture.png or .exr");
    viewer.picture_path = path;
    let mut path = std::mem::take(&mut viewer.scene_path);
    let scene = fields.line("save scene", "save scene", &mut path, "scene.toml");
    viewer.scene_path = path;
    if picture {
        viewer.save_picture();
    }
    if scene {
        viewer.save_scene();
    }
}

/// A path's last part, for people.
pub fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}
