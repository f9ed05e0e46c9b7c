use std::sync::Arc;

use gnomon_scene::{Animation, Bounds, Scene};

use crate::StudioError;
use crate::look::AnimationLook;

/// The clip that plays where none is named: the first.
pub(crate) fn first_clip(scene: &Scene) -> Option<String> {
    // By name, which is looked up first: of several clips of that name it means this one, and another may be called "0".
    scene.animations.first().map(|clip| clip.name.clone())
}

/// Box around what is to be framed: over the clip that a look asks for, or at rest where it asks for none. The scene then is at rest.
pub(crate) fn reach(scene: &mut Scene, look: &AnimationLook) -> Result<Option<Bounds>, StudioError> {
    match &look.clip {
        Some(name) => Ok(scene.bounds_of_clip(clip_index(scene, name)?)?),
        None => {
            scene.rest();
            Ok(scene.bounds_to_frame())
        }
    }
}

/// Takes the pose that a look asks for; a scene is at rest where it asks for no clip.
pub(crate) fn pose(scene: &mut Scene, look: &AnimationLook) -> Result<(), StudioError> {
    let Some(name) = &look.clip else {
        scene.rest();
        return Ok(());
    };
    let clip = clip_index(scene, name)?;
    let duration = scene.animations[clip].duration();
    // The end itself is the last pose, not the first again.
    let is_beyond = duration > 0.0 && !(0.0..=duration).contains(&look.time);
    Ok(scene.animate(clip, if is_beyond { look.time.rem_euclid(duration) } else { look.time })?)
}

/// The clip of that name, or else of that number from 0.
fn clip_index(scene: &Scene, name: &str) -> Result<usize, StudioError> {
    let names: Vec<_> = scene.animations.iter().map(|clip| clip.name.as_str()).collect();
    clip_number(&names, name).ok_or_else(|| {
        if names.is_empty() {
            return StudioError::Request(format!(
                "there is no clip '{}': the scene has none",
                gnomon_messages::quoted(name)
            ));
        }
        StudioError::unknown("clip", name, &names)
    })
}

fn clip_number(names: &[&str], clip: &str) -> Option<usize> {
    let by_number = || clip.parse().ok().filter(|&number: &usize| number < names.len());
    names.iter().position(|name| *name == clip).or_else(by_number)
}

/// A clip of a scene, for people to choose.
#[derive(Clone, Debug, PartialEq)]
pub struct Clip {
    /// What a look calls it.
    pub name: String,
    /// What people call it.
    pub label: String,
    /// Its length [s].
    pub duration: f32,
    /// Whether it is the one that the look asks for.
    pub is_chosen: bool,
}

/// The clips of a scene as a look has them. A clip without a name of its own goes by its number.
pub(crate) fn clips(scene: &Scene, look: &AnimationLook) -> Vec<Clip> {
    let names: Vec<_> = scene.animations.iter().map(|clip| clip.name.as_str()).collect();
    let chosen = look.clip.as_deref().and_then(|clip| clip_number(&names, clip));
    let clip = |(number, clip): (usize, &Arc<Animation>)| {
        let is_own = has_own_name(&names, number);
        let (name, label) = match is_own {
            true => (clip.name.clone(), clip.name.clone()),
            false => (number.to_string(), format!("clip {number}")),
        };
        let is_chosen = chosen == Some(number);
        // The one that plays may go by its number where it has a name.
        let name = look.clip.clone().filter(|_| is_chosen).unwrap_or(name);
        Clip { name, label, duration: clip.duration(), is_chosen }
    };
    scene.animations.iter().enumerate().map(clip).collect()
}

fn has_own_name(names: &[&str], clip: usize) -> bool {
    !names[clip].is_empty() && names.iter().filter(|other| **other == names[clip]).count() == 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clips_go_by_their_names_where_they_have_their_own() {
        let names = ["walk", "", "run", "walk"];
        let named = |name: &str| Animation { name: name.to_owned(), ..Animation::default() }.into();
        let scene = Scene { animations: names.map(named).to_vec(), ..Scene::default() };
        let labels = |clips: &[Clip]| clips.iter().map(|clip| clip.label.clone()).collect::<Vec<_>>();
        let clips_of = |clip: &str| {
            clips(&scene, &AnimationLook { clip: Some(clip.to_owned()), ..AnimationLook::default() })
        };
        let at_rest = clips(&scene, &AnimationLook::default());
        assert_eq!(labels(&at_rest), ["clip 0", "clip 1", "run", "clip 3"]);
        assert!(at_rest.iter().all(|clip| !clip.is_chosen));
        for (number, clip) in at_rest.iter().enumerate() {
            assert_eq!(clip_index(&scene, &clip.name).unwrap(), number);
        }
        let chosen = clips_of("2");
        assert_eq!((chosen[2].name.as_str(), chosen[2].is_chosen), ("2", true));
        assert!(clips_of("4").iter().all(|clip| !clip.is_chosen) && clip_index(&scene, "4").is_err());
    }

    #[test]
    fn the_first_clip_is_meant_whatever_clips_are_called() {
        for names in [["walk", "0"], ["", ""], ["run", "run"], ["1", "0"]] {
            let named = |name: &str| Animation { name: name.to_owned(), ..Animation::default() }.into();
            let scene = Scene { animations: names.map(named).to_vec(), ..Scene::default() };
            assert_eq!(clip_index(&scene, &first_clip(&scene).unwrap()).unwrap(), 0, "{names:?}");
        }
        assert_eq!(first_clip(&Scene::default()), None);
    }
}
