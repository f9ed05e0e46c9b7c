//! Scene, animation, material, saving.

use std::path::Path;

use eframe::egui::Id;
use gnomon_scene::builtin;
use gnomon_studio::{Look, SCENE, SceneSource};

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
    let animations: Vec<(String, f32)> = (studio.scene().animations.iter())
        .map(|animation| (animation.name.clone(), animation.duration()))
        .collect();
    let entries = builtin::NAMES.map(|name| (name, "built in"));
    if let Some(picked) = fields.choice("scene", "scene", &name, entries) {
        viewer.open_scene(SceneSource::Builtin(picked.to_owned()));
    }
    fields.text("triangles", &triangles.to_string());
    open_line(fields, viewer);
    options_of_scene(fields, viewer, wanted, &animations);
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
fn options_of_scene(
    fields: &mut Fields<'_>,
    viewer: &mut Viewer,
    wanted: &mut Look,
    clips: &[(String, f32)],
) {
    let names: Vec<&str> = clips.iter().map(|(name, _)| name.as_str()).collect();
    let look = wanted.clone();
    let before = &look.animation;
    let chosen = look.animation.clip.as_deref().and_then(|clip| clip_number(&names, clip));
    let playing = chosen.map(|clip| clips[clip].1);
    // The clip that plays may go by its number where it has a name.
    let text_of = |clip| match &before.clip {
        Some(text) if chosen == Some(clip) => text.clone(),
        _ => clip_name(&names, clip),
    };
    let texts = || clip_labels(&names).into_iter().enumerate().map(|(clip, label)| (text_of(clip), label));
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

/// Names of clips for people: a clip without a name of its own goes by its number.
fn clip_labels(names: &[&str]) -> Vec<String> {
    let label = |i| if has_own_name(names, i) { names[i].to_owned() } else { format!("clip {i}") };
    (0..names.len()).map(label).collect()
}

/// What a look calls the clip of that number.
fn clip_name(names: &[&str], clip: usize) -> String {
    if has_own_name(names, clip) { names[clip].to_owned() } else { clip.to_string() }
}

fn has_own_name(names: &[&str], clip: usize) -> bool {
    !names[clip].is_empty() && names.iter().filter(|other| **other == names[clip]).count() == 1
}

/// The clip that a look means: by its name, or else by its number.
fn clip_number(names: &[&str], clip: &str) -> Option<usize> {
    let by_number = || clip.parse().ok().filter(|&number: &usize| number < names.len());
    names.iter().position(|name| *name == clip).or_else(by_number)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clips_go_by_their_names_where_they_have_their_own() {
        let names = ["walk", "", "run", "walk"];
        assert_eq!(clip_labels(&names), ["clip 0", "clip 1", "run", "clip 3"]);
        assert_eq!(clip_number(&names, "run"), Some(2));
        assert_eq!(clip_number(&names, "3"), Some(3));
        assert_eq!(clip_number(&names, "4"), None);
        assert_eq!(clip_number(&[], "0"), None);
        for clip in 0..names.len() {
            assert_eq!(clip_number(&names, &clip_name(&names, clip)), Some(clip));
        }
    }
}
