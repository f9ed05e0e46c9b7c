//! What a renderer makes of its settings and lights: built whole, then swapped in, so that what fails leaves everything as it was.

use glam::{Quat, Vec3};
use gnomon_envmap::Grade;
use gnomon_scene::PlacedLight;
use gnomon_shaders::layout;

use super::{Passes, Renderer};
use crate::compose::ComposePass;
use crate::debug_view::DebugGroup;
use crate::geometry::Geometry;
use crate::gloss::GlossPass;
use crate::light_batches::{BatchContext, LightBatches};
use crate::light_pass::LightPass;
use crate::lighting::Lighting;
use crate::radiance_cache::RadianceCache;
use crate::ray_scene::{self, RayScene};
use crate::settings::Chosen;
use crate::shadow::Techniques;
use crate::shadow::technique::ShadowTechnique;
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
    /// How its shadows are found.
    pub technique: &'static dyn ShadowTechnique,
    pub batches: LightBatches,
    pub light: LightPass,
    /// Module that it sums bumps with.
    pub bumps: &'static str,
    /// Where glossy surfaces are traced.
    pub gloss: Option<GlossPass>,
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
    /// With the models that shaders are to know.
    pub gpu: &'a Gpu,
    pub chosen: &'a Chosen,
    pub technique: &'static dyn ShadowTechnique,
    pub compose: &'a ComposePass,
    pub cache: &'a RadianceCache,
    /// The scene's own lights.
    pub near_lights: &'a [PlacedLight],
    /// Where the technique or gloss traces rays.
    pub ray_scene: Option<&'a RayScene>,
    /// Whether gloss does.
    pub traces_gloss: bool,
    pub world_from_environment: Quat,
    pub grade: Grade,
    /// Module for slot `bumps`.
    pub bumps: &'static str,
}

impl Lit {
    /// What sums of light are multiplied by to be kept in halves ([`layout::View::sum_scales`]).
    pub fn sum_scales(&self) -> Vec3 {
        let scales = self.batches.sum_scales();
        let peak = self.lighting.peak();
        let Some(gloss) = self.gloss.as_ref().filter(|_| peak > 0.0) else { return scales };
        // The mean of a lobe's samples is no brighter than the brightest texel, and what other surfaces send is about as bright at most.
        let specular = 16384.0 / peak;
        match gloss.mirrors_scene {
            true => scales.with_y(specular).with_z(scales.z.min(specular)),
            false => scales.with_y(specular),
        }
    }
}

impl Passes {
    /// The pass that composes as was chosen.
    pub(super) fn compose(&self, gpu: &Gpu, chosen: &Chosen) -> Result<ComposePass, RenderError> {
        ComposePass::new(
            gpu,
            &self.gbuffer.read_layout,
            &self.of_models.points.compose_layout,
            chosen.compositing,
        )
    }
}

impl Renderer {
    /// Everything of the lights of an environment and those of a scene.
    pub(super) fn lit(
        &self,
        surroundings: &Surroundings<'_>,
        mut lighting: Lighting,
    ) -> Result<Lit, RenderError> {
        let &Surroundings { gpu, chosen, technique, near_lights, bumps, .. } = surroundings;
        let ray_scene = surroundings.ray_scene.filter(|_| technique.traces_rays());
        lighting.set(surroundings.world_from_environment, surroundings.grade);
        let passes = &self.passes;
        let settings = &chosen.settings.techniques;
        let context = BatchContext {
            gpu,
            shared: &passes.shared,
            technique,
            settings,
            view: &self.view,
            ray_scene,
            bumps,
        };
        let batches =
            LightBatches::new(&context, &lighting, near_lights, (self.room_for_points(), self.slice_count))?;
        let mut groups = vec![
            (layout::GROUP_FRAME, &passes.shared.frame),
            (layout::GROUP_SURFACE, &passes.gbuffer.read_layout),
            (layout::GROUP_PASS, &passes.of_models.points.light_layout),
        ];
        groups.extend(batches.shadow_layout().map(|shadow| (layout::GROUP_SHADOW, shadow)));
        let light = LightPass::new(gpu, [technique.module(&settings.shadow_settings), bumps], &groups)?;
        let layouts = [&passes.gbuffer.read_layout, &passes.of_models.points.light_layout];
        let gloss = surroundings.ray_scene.filter(|_| surroundings.traces_gloss);
        let gloss =
            gloss.map(|scene| GlossPass::new(gpu, &self.view, &lighting, scene, layouts)).transpose()?;
        let environment = self.environment_groups(surroundings, &lighting);
        let mut lit =
            Lit { lighting, technique, batches, light, bumps, gloss, environment, debug_groups: Vec::new() };
        if let Some(debug) = &self.debug {
            lit.debug_groups = debug.groups(gpu, &self.view, &lit);
            lit.batches.sum_only(gpu, debug.only_light(&lit));
        }
        Ok(lit)
    }

    /// How shadows of these lights, `lamps_are_wide` or not, are found in a geometry.
    pub(super) fn technique(
        &self,
        chosen: &Chosen,
        lighting: &Lighting,
        geometry: &Geometry,
        lamps_are_wide: bool,
    ) -> &'static dyn ShadowTechnique {
        let Techniques { usual, wide } = chosen.shadows;
        let has_room = !wide.traces_rays() || ray_scene::has_room_for(&self.gpu, geometry);
        if (lighting.omits_hidden || lamps_are_wide) && has_room { wide } else { usual }
    }

    /// The same scene, environment and settings at the target's points.
    pub(super) fn relit(&self) -> Result<Option<Lit>, RenderError> {
        let State { chosen, compose, cache, lit } = &self.state;
        let Some(lit) = lit else { return Ok(None) };
        let surroundings = Surroundings {
            gpu: &self.gpu,
            chosen,
            technique: lit.technique,
            compose,
            cache,
            near_lights: &self.near_lights,
            ray_scene: self.ray_scene.as_ref(),
            traces_gloss: lit.gloss.is_some(),
            world_from_environment: self.world_from_environment,
            grade: self.grade,
            bumps: lit.bumps,
        };
        self.lit(&surroundings, lit.lighting.clone()).map(Some)
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
            cache: self.passes.of_models.cache.group(gpu, cache, &lighting.background),
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
