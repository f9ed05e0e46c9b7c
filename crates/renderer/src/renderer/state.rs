//! What a renderer makes of its settings and lights: built whole, then swapped in, so that what fails leaves everything as it was.

use gnomon_scene::{PlacedLight, Scene};
use gnomon_shaders::layout;

use super::{Passes, Renderer};
use crate::compose::ComposePass;
use crate::light_batches::{BatchContext, LightBatches};
use crate::light_pass::LightPass;
use crate::lighting::Lighting;
use crate::radiance_cache::RadianceCache;
use crate::settings::Chosen;
use crate::{Gpu, RenderError};

/// What depends on the settings.
pub(super) struct State {
    pub chosen: Chosen,
    pub compose: ComposePass,
    pub cache: RadianceCache,
    pub lit: Option<Lit>,
}

/// What depends on the lights, too.
pub(super) struct Lit {
    pub lighting: Lighting,
    pub batches: LightBatches,
    pub light: LightPass,
    pub environment: EnvironmentGroups,
}

/// Bind groups of the environment's maps and the radiance cache.
pub(super) struct EnvironmentGroups {
    pub compose: wgpu::BindGroup,
    pub cache: wgpu::BindGroup,
}

impl Passes {
    /// The pass that composes as was chosen.
    pub(super) fn compose(&self, gpu: &Gpu, chosen: &Chosen) -> Result<ComposePass, RenderError> {
        ComposePass::new(gpu, &self.gbuffer.read_layout, &self.points.compose_layout, chosen.compositing)
    }
}

impl Renderer {
    /// The state for other settings, a scene and perhaps an environment.
    pub(super) fn new_state(
        &self,
        chosen: Chosen,
        scene: &Scene,
        lighting: Option<Lighting>,
    ) -> Result<State, RenderError> {
        let compose = self.passes.compose(&self.gpu, &chosen)?;
        let cache = self.new_cache(&chosen, chosen.cached_lobes(scene));
        let parts = (&compose, &cache);
        let lit =
            lighting.map(|lighting| self.lit(&chosen, parts, lighting, &self.near_lights)).transpose()?;
        Ok(State { chosen, compose, cache, lit })
    }

    /// Everything of the lights of an environment and those of a scene.
    pub(super) fn lit(
        &self,
        chosen: &Chosen,
        (compose, cache): (&ComposePass, &RadianceCache),
        mut lighting: Lighting,
        near_lights: &[PlacedLight],
    ) -> Result<Lit, RenderError> {
        lighting.turn(self.world_from_environment);
        let (gpu, passes) = (&self.gpu, &self.passes);
        let settings = &chosen.settings.techniques;
        let context = BatchContext {
            gpu,
            shared: &passes.shared,
            technique: chosen.technique,
            settings,
            view: &self.view,
        };
        let batches = LightBatches::new(&context, &lighting, near_lights, self.room_for_points())?;
        let mut groups = vec![
            (layout::GROUP_FRAME, &passes.shared.frame),
            (layout::GROUP_SURFACE, &passes.gbuffer.read_layout),
            (layout::GROUP_PASS, &passes.points.light_layout),
        ];
        groups.extend(batches.shadow_layout().map(|shadow| (layout::GROUP_SHADOW, shadow)));
        let light = LightPass::new(gpu, chosen.technique.module(&settings.shadow_settings), &groups)?;
        let environment = self.environment_groups((compose, cache), &lighting);
        Ok(Lit { lighting, batches, light, environment })
    }

    /// The same environment and settings with the scene's lights as they are now, or at the target's points.
    pub(super) fn relit(&self, near_lights: &[PlacedLight]) -> Result<Option<Lit>, RenderError> {
        let State { chosen, compose, cache, lit } = &self.state;
        let lighting = lit.as_ref().map(|lit| lit.lighting.clone());
        lighting.map(|lighting| self.lit(chosen, (compose, cache), lighting, near_lights)).transpose()
    }

    pub(super) fn take_lit(&mut self, lit: Lit) {
        self.state.lit = Some(lit);
        self.bind_debug_view();
    }

    /// Takes the scene's own lights over; more or fewer of them than before need other maps.
    pub(super) fn set_near_lights(&mut self, scene: &Scene) -> Result<(), RenderError> {
        let near_lights = scene.placed_lights();
        if near_lights.len() != self.near_lights.len()
            && let Some(lit) = self.relit(&near_lights)?
        {
            self.take_lit(lit);
        }
        self.near_lights = near_lights;
        self.refit_lights();
        Ok(())
    }

    /// Lights, scene or pose are others from the next frame on.
    pub(super) fn refit_lights(&mut self) {
        if let Some(lit) = &mut self.state.lit {
            lit.batches.refit();
        }
    }

    /// Room for the target's shading points; none before there is one.
    pub(super) fn room_for_points(&self) -> u64 {
        self.target.as_ref().map_or(0, |target| target.points.capacity)
    }

    fn new_cache(&self, chosen: &Chosen, lobes: Vec<layout::CachedLobe>) -> RadianceCache {
        let resolution = chosen.settings.techniques.radiance_cache_resolution;
        RadianceCache::new(&self.gpu, lobes, resolution, chosen.settings.techniques.radiance_cache_samples)
    }

    /// Takes over whether the scene is glossy, and makes the radiance cache one of its lobes.
    pub(super) fn take_lobes(&mut self, scene: &Scene) {
        self.is_glossy = scene.materials.iter().any(|material| !material.surface.is_matte());
        let lobes = self.state.chosen.cached_lobes(scene);
        if self.state.cache.rewrite(&lobes) {
            return;
        }
        let cache = self.new_cache(&self.state.chosen, lobes);
        let groups = |lit: &Lit| self.environment_groups((&self.state.compose, &cache), &lit.lighting);
        let groups = self.state.lit.as_ref().map(groups);
        if let (Some(lit), Some(groups)) = (&mut self.state.lit, groups) {
            lit.environment = groups;
        }
        self.state.cache = cache;
    }

    fn environment_groups(
        &self,
        (compose, cache): (&ComposePass, &RadianceCache),
        lighting: &Lighting,
    ) -> EnvironmentGroups {
        let gpu = &self.gpu;
        EnvironmentGroups {
            compose: compose.environment_group(gpu, &self.view, lighting, cache),
            cache: self.passes.cache.group(gpu, cache, &lighting.background),
        }
    }

    /// GPU memory of what the shadow technique keeps of the lights, in bytes.
    pub fn shadow_bytes(&self) -> u64 {
        self.state.lit.as_ref().map_or(0, |lit| lit.batches.bytes())
    }

    /// Number of batches that the lights are drawn in: one for each size of map, more where memory is short.
    pub fn shadow_batches(&self) -> usize {
        self.state.lit.as_ref().map_or(0, |lit| lit.batches.len())
    }
}
