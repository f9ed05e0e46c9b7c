//! What a renderer makes of its settings and lights: built whole, then swapped in, so that what fails leaves everything as it was.

use glam::Quat;
use gnomon_scene::PlacedLight;
use gnomon_shaders::layout;

use super::{Passes, Renderer};
use crate::compose::ComposePass;
use crate::debug_view::DebugGroup;
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
    /// Where there is a debug view, one for every batch.
    pub debug_groups: Vec<DebugGroup>,
}

/// Bind groups of the environment's maps and the radiance cache.
pub(super) struct EnvironmentGroups {
    pub compose: wgpu::BindGroup,
    pub cache: wgpu::BindGroup,
}

/// What lights are made for.
pub(super) struct Surroundings<'a> {
    pub chosen: &'a Chosen,
    pub compose: &'a ComposePass,
    pub cache: &'a RadianceCache,
    /// The scene's own lights.
    pub near_lights: &'a [PlacedLight],
    pub world_from_environment: Quat,
}

impl Passes {
    /// The pass that composes as was chosen.
    pub(super) fn compose(&self, gpu: &Gpu, chosen: &Chosen) -> Result<ComposePass, RenderError> {
        ComposePass::new(gpu, &self.gbuffer.read_layout, &self.points.compose_layout, chosen.compositing)
    }
}

impl Renderer {
    /// Everything of the lights of an environment and those of a scene.
    pub(super) fn lit(
        &self,
        surroundings: &Surroundings<'_>,
        mut lighting: Lighting,
    ) -> Result<Lit, RenderError> {
        let &Surroundings { chosen, near_lights, world_from_environment, .. } = surroundings;
        lighting.turn(world_from_environment);
        let (gpu, passes) = (&self.gpu, &self.passes);
        let settings = &chosen.settings.techniques;
        let context = BatchContext {
            gpu,
            shared: &passes.shared,
            technique: chosen.technique,
            settings,
            view: &self.view,
        };
        let batches =
            LightBatches::new(&context, &lighting, near_lights, (self.room_for_points(), self.slice_count))?;
        let mut groups = vec![
            (layout::GROUP_FRAME, &passes.shared.frame),
            (layout::GROUP_SURFACE, &passes.gbuffer.read_layout),
            (layout::GROUP_PASS, &passes.points.light_layout),
        ];
        groups.extend(batches.shadow_layout().map(|shadow| (layout::GROUP_SHADOW, shadow)));
        let light = LightPass::new(gpu, chosen.technique.module(&settings.shadow_settings), &groups)?;
        let environment = self.environment_groups(surroundings, &lighting);
        let mut lit = Lit { lighting, batches, light, environment, debug_groups: Vec::new() };
        if let Some(debug) = &self.debug {
            lit.debug_groups = debug.groups(gpu, &self.view, &lit);
            lit.batches.sum_only(gpu, debug.only_light(&lit));
        }
        Ok(lit)
    }

    /// The same scene, environment and settings at the target's points.
    pub(super) fn relit(&self) -> Result<Option<Lit>, RenderError> {
        let State { chosen, compose, cache, lit } = &self.state;
        let surroundings = Surroundings {
            chosen,
            compose,
            cache,
            near_lights: &self.near_lights,
            world_from_environment: self.world_from_environment,
        };
        lit.as_ref().map(|lit| self.lit(&surroundings, lit.lighting.clone())).transpose()
    }

    /// Room for the target's shading points; none before there is one.
    pub(super) fn room_for_points(&self) -> u64 {
        self.target.as_ref().map_or(0, |target| target.points.capacity)
    }

    pub(super) fn new_cache(&self, chosen: &Chosen, lobes: Vec<layout::CachedLobe>) -> RadianceCache {
        let resolution = chosen.settings.techniques.radiance_cache_resolution;
        RadianceCache::new(&self.gpu, lobes, resolution, chosen.settings.techniques.radiance_cache_samples)
    }

    pub(super) fn environment_groups(
        &self,
        surroundings: &Surroundings<'_>,
        lighting: &Lighting,
    ) -> EnvironmentGroups {
        let (gpu, cache) = (&self.gpu, surroundings.cache);
        EnvironmentGroups {
            compose: surroundings.compose.environment_group(gpu, &self.view, lighting, cache),
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
