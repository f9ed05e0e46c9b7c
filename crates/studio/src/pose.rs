use gnomon_scene::{Bounds, Scene};

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
    let by_name = scene.animations.iter().position(|clip| clip.name == name);
    let by_number = || name.parse().ok().filter(|&number: &usize| number < scene.animations.len());
    by_name.or_else(by_number).ok_or_else(|| {
        if scene.animations.is_empty() {
            return StudioError::Request(format!(
                "there is no clip '{}': the scene has none",
                gnomon_messages::quoted(name)
            ));
        }
        let names: Vec<_> = scene.animations.iter().map(|clip| clip.name.as_str()).collect();
        StudioError::unknown("clip", name, &names)
    })
}

#[cfg(test)]
mod tests {
    use gnomon_scene::Animation;

    use super::*;

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
