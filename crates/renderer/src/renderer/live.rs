//! What changes while running, each change by the least work.

use glam::Quat;
use gnomon_lights::LightSet;
use gnomon_scene::Scene;

use super::Renderer;
use crate::compose::ComposePass;
use crate::lighting::{Lighting, PreparedLighting};
use crate::settings::in_range;
use crate::{DisplaySettings, RenderError, RenderSettings, ambient, composite, shadow, unshadowed};

impl Renderer {
    /// The settings in force.
    pub fn settings(&self) -> &RenderSettings {
        &self.settings
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
        if let Some(lit) = &mut self.lighting {
            lit.lighting.turn(self.world_from_environment);
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
        let (ambient, ambient_cells) = (prepared.ambient.name, prepared.ambient_cells);
        self.light_up(Lighting::new(&self.gpu, prepared)?)?;
        self.ambient = ambient::by_name(ambient)?;
        self.settings.lighting.ambient = ambient.to_owned();
        self.settings.lighting.ambient_cells = ambient_cells;
        scopes.finish()
    }

    /// How the next frames are displayed.
    ///
    /// # Errors
    /// [`RenderError::OutOfRange`] for an exposure that [`DisplaySettings`] does not allow.
    pub fn set_display(&mut self, display: DisplaySettings) -> Result<(), RenderError> {
        let settings = self.settings.clone().with(|s| s.display = display);
        settings.check()?;
        self.settings = settings;
        Ok(())
    }

    /// Whether passes are timed, see [`crate::MeasureSettings::profile`].
    pub fn set_profile(&mut self, profile: bool) {
        self.settings.measure.profile = profile;
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
        settings.check()?;
        let scopes = self.gpu.catch_errors();
        shadow::usable(&self.gpu, &settings.techniques.shadows)?;
        let ambient = ambient::by_name(&settings.lighting.ambient)?;
        let same_rest = self.ambient == ambient
            && self.settings.lighting.ambient_cells == settings.lighting.ambient_cells;
        let before = self.lighting.as_ref().map(|lit| lit.lighting.clone());
        let lighting = match before.clone() {
            Some(lighting) if !same_rest => {
                Some(lighting.with_lights(&self.gpu, ambient.lights(set, settings.lighting.ambient_cells)?))
            }
            same => same,
        };
        let old = std::mem::replace(&mut self.settings, settings);
        if let Err(error) = self.follow_settings(scene, lighting) {
            self.settings = old;
            self.follow_settings(scene, before)?;
            return Err(error);
        }
        scopes.finish()
    }

    /// Makes everything anew that depends on settings.
    fn follow_settings(&mut self, scene: &Scene, lighting: Option<Lighting>) -> Result<(), RenderError> {
        self.technique = shadow::by_name(&self.settings.techniques.shadows)?;
        self.ambient = ambient::by_name(&self.settings.lighting.ambient)?;
        self.compositing = composite::by_name(&self.settings.techniques.compositing)?;
        self.unshadowed = unshadowed::by_name(&self.settings.techniques.unshadowed)?;
        let passes = &mut self.passes;
        let layouts = (&passes.gbuffer.read_layout, &passes.points.compose_layout);
        passes.compose = ComposePass::new(&self.gpu, layouts.0, layouts.1, self.compositing)?;
        self.target = None;
        // Without lighting no bind group is made of the compositing pass that goes.
        self.lighting = None;
        self.cache_lobes(scene);
        lighting.map_or(Ok(()), |lighting| self.light_up(lighting))
    }
}
