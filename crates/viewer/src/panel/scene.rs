//! Scene, animation, material, saving.

use std::path::Path;

use eframe::egui::Id;
use gnomon_scene::{Ground, builtin};
use gnomon_studio::{AnimationLook, Look, SceneSource};

use super::fields::Fields;
use crate::viewer::Viewer;

pub fn show(fields: &mut Fields<'_>, viewer: &mut Viewer, wanted: &mut Look) {
    let Some(studio) = viewer.studio() else { return };
    let name = match studio.stage().source() {
        SceneSource::Builtin(name) => name.clone(),
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
    let mut ground = wanted.ground == Ground::Plane;
    if fields.check("ground", "ground", &mut ground, "a plane under the models") {
        wanted.ground = if ground { Ground::Plane } else { Ground::None };
    }
    animation(fields, viewer, wanted, &animations);
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

fn animation(fields: &mut Fields<'_>, viewer: &mut Viewer, wanted: &mut Look, animations: &[(String, f32)]) {
    const REST: &str = "at rest";
    if animations.is_empty() {
        return;
    }
    let names: Vec<&str> = animations.iter().map(|(name, _)| name.as_str()).collect();
    let labels = clip_labels(&names);
    let chosen = wanted.animation.clip.as_deref().and_then(|clip| clip_number(&names, clip));
    let shown = chosen.map_or(REST, |clip| labels[clip].as_str());
    let entries = std::iter::once(REST).chain(labels.iter().map(String::as_str)).map(|label| (label, ""));
    if let Some(picked) = fields.choice("clip", "clip", shown, entries) {
        let clip = labels.iter().position(|label| label == picked);
        viewer.playing = clip.is_some();
        wanted.animation = AnimationLook { clip: clip.map(|clip| clip_name(&names, clip)), time: 0.0 };
    }
    let Some(duration) = chosen.map(|clip| animations[clip].1) else { return };
    let is_beyond = duration > 0.0 && wanted.animation.time > duration;
    let mut time = if is_beyond { wanted.animation.time.rem_euclid(duration) } else { wanted.animation.time };
    if fields.slider("time", "time", &mut time, 0.0..=duration.max(1e-3), " s") {
        wanted.animation.time = time;
        viewer.playing = false;
    }
    fields.check("", "play", &mut viewer.playing, "run (Space)");
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
