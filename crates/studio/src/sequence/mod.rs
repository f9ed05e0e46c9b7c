//! Sequences: which frames there are, what each shows, and the files that they become.

mod digest;
mod files;
mod film;

use glam::{Mat4, Quat, Vec3};
use gnomon_scene::Camera;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::look::CameraLook;
use crate::{Look, Stage, StudioError};

pub use files::{FrameFiles, SequenceRun};
pub use film::Film;

pub(crate) use digest::Digest;

/// How a scene changes over time. Everything goes by rates, so that a frame depends on its number alone and not on which frames are
/// drawn with it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Timeline {
    /// Frames a second.
    pub frames_per_second: f64,
    /// Turn of the camera about the vertical through the scene's middle, right-hand rule [degrees / s].
    pub turntable: f64,
    /// Turn of the environment about +y, right-hand rule [degrees / s].
    pub environment_turn: f64,
}

impl Timeline {
    /// A scene of which only clips move.
    ///
    /// # Errors
    /// As [`Timeline::check`].
    pub fn new(frames_per_second: f64) -> Result<Self, StudioError> {
        Self { frames_per_second, turntable: 0.0, environment_turn: 0.0 }.check()
    }

    /// The same, if all of it makes sense.
    ///
    /// # Errors
    /// [`StudioError::Request`]: a rate that is not positive, turns that are not finite.
    pub fn check(self) -> Result<Self, StudioError> {
        if !(self.frames_per_second > 0.0 && self.frames_per_second <= 1e6) {
            return Err(StudioError::Request(
                "frames a second must be above 0 and at most 1000000".to_owned(),
            ));
        }
        if !(self.turntable.is_finite() && self.environment_turn.is_finite()) {
            return Err(StudioError::Request("turns must be finite".to_owned()));
        }
        Ok(self)
    }

    /// Time of a frame [s].
    pub fn seconds(&self, frame: u32) -> f64 {
        f64::from(frame) / self.frames_per_second
    }

    /// Number of frames in so many seconds, at least one.
    pub fn frames_in(&self, seconds: f64) -> u32 {
        (seconds * self.frames_per_second).round().clamp(1.0, f64::from(u32::MAX)) as u32
    }
}

/// A stage over time.
#[derive(Clone, Debug)]
pub struct Sequence {
    timeline: Timeline,
    look: Look,
    camera: Camera,
    center: Vec3,
}

impl Sequence {
    /// The stage as it is, from frame 0 on. Without a clip in its look, the scene's first clip plays, if it has one.
    ///
    /// # Errors
    /// As [`Timeline::check`] and [`Stage::camera`].
    pub fn new(stage: &Stage, timeline: Timeline) -> Result<Self, StudioError> {
        let timeline = timeline.check()?;
        let mut look = stage.look().clone();
        if look.animation.clip.is_none() {
            look.animation.clip = crate::pose::first_clip(stage.scene());
        }
        let mut stage = stage.clone();
        stage.set_look(look.clone())?;
        Ok(Self { timeline, look, camera: stage.camera()?, center: stage.center() })
    }

    /// The look of a frame.
    pub fn look(&self, frame: u32) -> Look {
        let Timeline { turntable, environment_turn, .. } = self.timeline;
        let seconds = self.timeline.seconds(frame);
        let mut look = self.look.clone();
        look.animation.time = (f64::from(look.animation.time) + seconds) as f32;
        let rotation = f64::from(look.environment.rotation) + environment_turn * seconds;
        look.environment.rotation = (rotation % 360.0) as f32;
        if turntable != 0.0 {
            let angle = (turntable * seconds).rem_euclid(360.0).to_radians() as f32;
            let mut camera = self.camera.clone();
            camera.world_from_camera = Mat4::from_translation(self.center)
                * Mat4::from_quat(Quat::from_rotation_y(angle))
                * Mat4::from_translation(-self.center)
                * camera.world_from_camera;
            look.camera = CameraLook::Free(camera);
        }
        look
    }

    /// The look of a frame with pose and camera of the one before: what motion is measured from. Nothing was before frame 0, which stands
    /// still.
    pub fn look_before(&self, frame: u32) -> Look {
        let before = self.look(frame.saturating_sub(1));
        Look { animation: before.animation, camera: before.camera, ..self.look(frame) }
    }

    /// Everything that the pixels of all frames depend on, in words, and a digest of it: `how` says what draws them. Files count by what is
    /// in them, not by their names and times.
    pub fn description(&self, stage: &Stage, how: Value) -> (Value, String) {
        let mut digest = Digest::default();
        let mut look = self.look.clone();
        look.map = None;
        (look.environment.rig, look.environment.background_map, look.rig) = Default::default();
        let words = |look: &Look| {
            json!({
                "program": concat!("gnomon ", env!("CARGO_PKG_VERSION")),
                "look": look,
                "exposure": stage.exposure(),
                "timeline": self.timeline,
                "drawn_by": how,
            })
        };
        digest.add(words(&look).to_string().as_bytes());
        digest.add_scene(stage.scene());
        let sky = stage.sky();
        digest.add_picture(sky.map.radiance());
        digest.add_picture(sky.background.radiance());
        digest.add(format!("{:?}", (sky.lights, sky.grade)).as_bytes());
        let mut words = words(&self.look);
        words["scene"] = stage.source().to_string().into();
        (words, digest.to_string())
    }
}
