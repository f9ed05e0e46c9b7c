//! What changes while running, each change by the least work.

use glam::Quat;
use gnomon_lights::LightSet;
use gnomon_scene::Scene;

use super::Renderer;
use crate::lighting::{Lighting, PreparedLighting};
use crate::settings::{Chosen, in_range};
use crate::{DisplaySettings, RenderError, RenderSettings};

impl Renderer {
    /// The settings in force.
    pub fn settings(&self) -> &RenderSettings {
        &self.state.chosen.settings
    }

    /// Turns the environment: what was seen towards `d` is then seen towards `world_from_environment * d`. Lights turn with it, and
    /// so do the directions in which coefficients and maps are looked up; nothing is fitted, filtered or uploaded again, and a turned
    /// environment costs a frame no more than another. The turn stays when the lighting is set anew.
    ///
    /// # Errors
    /// [`RenderError::OutOfRange`] unless the quaternion has unit length, within a thousandth.
    pub fn set_environment_rotation(&mut self, world_from_environment: Quat) -> Result<(), RenderError> {
        in_range("length of the environment's rotation", world_from_environment.length(), 0.999..=1.001)?;
        self.world_from_environment = world_from_environment.normalize();
        if let Some(lit) = &mut self.state.lit {
            lit.lighting.turn(self.world_from_environment);
            lit.batches.refit();
        }
        Ok(())
    }

    /// [`Renderer::set_lighting`] of what has been worked out beforehand: an upload, and shadow maps for the lights. What it was worked
    /// out with for the ambient rest becomes part of the settings.
    ///
    /// # Errors
    /// As [`Renderer::set_lighting`]; the lighting before it then stays.
    pub fn set_prepared_lighting(&mut self, prepared: PreparedLighting) -> Result<(), RenderError> {
        let scopes = self.gpu.catch_errors();
        let mut chosen = self.state.chosen.clone();
        chosen.ambient = prepared.ambient;
        chosen.settings.lighting.ambient = prepared.ambient.name.to_owned();
        chosen.settings.lighting.ambient_cells = prepared.ambient_cells;
        let parts = (&self.state.compose, &self.state.cache);
        let lit = self.lit(&chosen, parts, Lighting::new(&self.gpu, prepared)?, &self.near_lights)?;
        self.state.chosen = chosen;
        self.take_lit(lit);
        scopes.finish()
    }

    /// How the next frames are displayed.
    ///
    /// # Errors
    /// [`RenderError::Option`] for an exposure that [`DisplaySettings`] does not allow.
    pub fn set_display(&mut self, display: DisplaySettings) -> Result<(), RenderError> {
        let settings = self.settings().clone().with(|s| s.display = display);
        settings.check()?;
        self.state.chosen.settings = settings;
        Ok(())
    }

    /// Whether passes are timed, see [`crate::MeasureSettings::profile`].
    pub fn set_profile(&mut self, profile: bool) {
        self.state.chosen.settings.measure.profile = profile;
    }

    /// Takes other settings over, techniques among them: shadow maps are made anew, meshes, textures and maps of the environment stay
    /// where they are. `scene` and `set` are those that were set last.
    ///
    /// # Errors
    /// As [`Renderer::new`] and [`Renderer::set_lighting`]; the settings before it then stay.
    pub fn set_settings(
        &mut self,
        settings: RenderSettings,
        scene: &Scene,
        set: &LightSet,
    ) -> Result<(), RenderError> {
        let scopes = self.gpu.catch_errors();
        let chosen = Chosen::new(&self.gpu, settings)?;
        let cells = |chosen: &Chosen| chosen.settings.lighting.ambient_cells;
        let same_rest =
            (chosen.ambient, cells(&chosen)) == (self.state.chosen.ambient, cells(&self.state.chosen));
        let lighting = match self.state.lit.as_ref().map(|lit| lit.lighting.clone()) {
            Some(lighting) if !same_rest => {
                let ambient = chosen.ambient.lights(set, cells(&chosen))?;
                Some(lighting.with_lights(&self.gpu, ambient))
            }
            same => same,
        };
        let next = self.new_state(chosen, scene, lighting)?;
        self.state = next;
        self.bind_debug_view();
        scopes.finish()
    }
}
