//! Changes of one thing each, see [`Renderer::change`].

use glam::Quat;
use gnomon_envmap::{Equirect, Grade};
use gnomon_lights::LightSet;
use gnomon_scene::Scene;

use super::{Change, LightingChange, Renderer, SceneChange};
use crate::lighting::PreparedLighting;
use crate::lod::LevelOfDetail;
use crate::{DisplaySettings, RenderError, RenderSettings};

impl Renderer {
    /// The settings in force.
    pub fn settings(&self) -> &RenderSettings {
        &self.state.chosen.settings
    }

    /// What changes could not take over as it is since this was asked last, a line each: meshes whose shadows a technique cannot draw
    /// exactly.
    pub fn take_warnings(&mut self) -> Vec<String> {
        std::mem::take(&mut self.warnings)
    }

    /// Takes a scene over: its triangles, materials, textures and area lights. Meshes and textures that it shares with the scene before,
    /// by their `Arc`, are not uploaded again.
    ///
    /// # Errors
    /// As [`Renderer::change`].
    pub fn set_scene(&mut self, scene: &Scene) -> Result<(), RenderError> {
        self.change(Change { scene: Some(SceneChange::Whole(scene)), ..Change::default() })
    }

    /// Takes a new pose of the scene that was set last (node transforms, joints, morph weights) without an upload of its meshes.
    /// A scene with other meshes is taken over whole.
    ///
    /// Vertices move on the GPU. What the CPU needs of a deformed mesh, the place of its shadow maps, follows from boxes around
    /// each joint's vertices: it may be larger than the mesh, and its shadows somewhat coarser than those of a rigid one.
    ///
    /// # Errors
    /// As [`Renderer::change`].
    pub fn move_scene(&mut self, scene: &Scene) -> Result<(), RenderError> {
        self.change(Change { scene: Some(SceneChange::Pose(scene)), ..Change::default() })
    }

    /// Takes new material parameters of the scene that was set last, reflectance models among them, without an upload of its meshes or
    /// textures: for editing while running. A scene with other meshes, or meshes of other materials, is taken over whole.
    ///
    /// # Errors
    /// As [`Renderer::change`].
    pub fn set_materials(&mut self, scene: &Scene) -> Result<(), RenderError> {
        self.change(Change { scene: Some(SceneChange::Materials(scene)), ..Change::default() })
    }

    /// Turns the environment: what was seen towards `d` is then seen towards `world_from_environment * d`. Lights turn with it, and
    /// so do the directions in which coefficients and maps are looked up; nothing is fitted, filtered or uploaded again, and a turned
    /// environment costs a frame no more than another. The turn stays when the lighting is set anew.
    ///
    /// # Errors
    /// [`RenderError::OutOfRange`] unless the quaternion has unit length, within a thousandth.
    pub fn set_environment_rotation(&mut self, world_from_environment: Quat) -> Result<(), RenderError> {
        let world_from_environment = Some(world_from_environment);
        self.change(Change { world_from_environment, ..Change::default() })
    }

    /// Multiplies the radiance of the environment, in whatever way it is seen or lights. Nothing is fitted, filtered or uploaded again. The grade stays
    /// when the lighting is set anew.
    ///
    /// # Errors
    /// [`RenderError::OutOfRange`] for a factor below 0 or above 1e12.
    pub fn set_environment_grade(&mut self, grade: Grade) -> Result<(), RenderError> {
        self.change(Change { grade: Some(grade), ..Change::default() })
    }

    /// Takes an environment over: `map` is what the camera sees and mirrors reflect, `set` how it casts light and shadow.
    ///
    /// # Errors
    /// [`RenderError::OverLimit`] where the adapter cannot hold that many lights or so large a map.
    pub fn set_lighting(&mut self, map: &Equirect, set: &LightSet) -> Result<(), RenderError> {
        self.set_prepared_lighting(PreparedLighting::new(map, set, self.settings())?)
    }

    /// [`Renderer::set_lighting`] of what has been worked out beforehand: an upload, and shadow maps for the lights. What it was worked
    /// out with for the ambient rest becomes part of the settings.
    ///
    /// # Errors
    /// As [`Renderer::set_lighting`].
    pub fn set_prepared_lighting(&mut self, prepared: PreparedLighting) -> Result<(), RenderError> {
        self.change(Change {
            lighting: Some(LightingChange::Prepared(Box::new(prepared))),
            ..Change::default()
        })
    }

    /// How the next frames are displayed.
    ///
    /// # Errors
    /// [`RenderError::Option`] for an exposure that [`DisplaySettings`] does not allow.
    pub fn set_display(&mut self, display: DisplaySettings) -> Result<(), RenderError> {
        let settings = Some(self.settings().clone().with(|s| s.display = display));
        self.change(Change { settings, ..Change::default() })
    }

    /// Whether passes are timed, see [`crate::MeasureSettings::profile`].
    pub fn set_profile(&mut self, profile: bool) {
        self.state.chosen.settings.measure.profile = profile;
    }

    /// Takes other settings over, techniques among them: shadow maps are made anew, meshes, textures and maps of the environment stay
    /// where they are. `set` is the one that was set last.
    ///
    /// # Errors
    /// As [`Renderer::new`] and [`Renderer::set_lighting`].
    pub fn set_settings(&mut self, settings: RenderSettings, set: &LightSet) -> Result<(), RenderError> {
        let other_rest = self.state.lit.is_some() && settings.lighting != self.settings().lighting;
        let lighting = other_rest.then_some(LightingChange::Fit(set));
        self.change(Change { settings: Some(settings), lighting, ..Change::default() })
    }

    /// Takes another level of detail over: `set` is another fit to the environment that was given last, with as many lights as
    /// `level` says.
    ///
    /// # Errors
    /// [`RenderError::Option`] for a setting that [`RenderSettings`] does not allow, otherwise as [`Renderer::set_lighting`].
    pub fn set_level_of_detail(&mut self, level: LevelOfDetail, set: &LightSet) -> Result<(), RenderError> {
        let settings = self.settings().clone().with(|s| level.set(&mut s.techniques));
        let lighting = Some(LightingChange::Fit(set));
        self.change(Change { settings: Some(settings), lighting, ..Change::default() })
    }
}
