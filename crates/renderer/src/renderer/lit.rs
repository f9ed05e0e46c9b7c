//! What a renderer makes of its lights.

use gnomon_scene::{PlacedLight, Scene};
use gnomon_shaders::layout;

use super::Renderer;
use crate::RenderError;
use crate::light_pass::LightPass;
use crate::lighting::Lighting;
use crate::shadow_batches::ShadowBatches;

/// What depends on the lights.
pub(super) struct Lit {
    pub lighting: Lighting,
    pub batches: ShadowBatches,
    pub frame_groups: Vec<wgpu::BindGroup>,
    pub light: LightPass,
    pub environment: EnvironmentGroups,
}

/// Bind groups of the environment's maps and the radiance cache.
pub(super) struct EnvironmentGroups {
    pub compose: wgpu::BindGroup,
    pub cache: wgpu::BindGroup,
}

impl Renderer {
    /// Takes the scene's own lights over; more or fewer of them than before need other maps.
    pub(super) fn set_near_lights(&mut self, scene: &Scene) -> Result<(), RenderError> {
        let near_lights = scene.placed_lights();
        match &self.lighting {
            Some(lit) if near_lights.len() != self.near_lights.len() => {
                let lit = self.lit(lit.lighting.clone(), &near_lights)?;
                self.near_lights = near_lights;
                self.take_lit(lit);
            }
            _ => self.near_lights = near_lights,
        }
        Ok(())
    }

    /// Makes what depends on the lights: those of the environment and then the scene's own.
    pub(super) fn light_up(&mut self, lighting: Lighting) -> Result<(), RenderError> {
        let lit = self.lit(lighting, &self.near_lights)?;
        self.take_lit(lit);
        Ok(())
    }

    fn lit(&self, mut lighting: Lighting, near_lights: &[PlacedLight]) -> Result<Lit, RenderError> {
        lighting.turn(self.world_from_environment);
        let gpu = &self.gpu;
        let (technique, passes) = (self.technique, &self.passes);
        let batches =
            ShadowBatches::new(gpu, &passes.shadow_map, technique, &self.settings, &lighting, near_lights)?;
        let mut groups = vec![
            (layout::GROUP_FRAME, &passes.frame_layout),
            (layout::GROUP_SURFACE, &passes.gbuffer.read_layout),
            (layout::GROUP_PASS, &passes.points.light_layout),
        ];
        groups.extend(batches.shadow_layout().map(|shadow| (layout::GROUP_SHADOW, shadow)));
        let light =
            LightPass::new(gpu, technique.module(&self.settings.techniques.shadow_settings), &groups)?;
        let frame_groups = batches.frame_groups(gpu, &passes.frame_layout, &self.view);
        let environment = self.environment_groups(&lighting);
        Ok(Lit { lighting, batches, frame_groups, light, environment })
    }

    fn take_lit(&mut self, lit: Lit) {
        self.lighting = Some(lit);
        self.bind_debug_view();
    }

    pub(super) fn environment_groups(&self, lighting: &Lighting) -> EnvironmentGroups {
        let (gpu, passes) = (&self.gpu, &self.passes);
        EnvironmentGroups {
            compose: passes.compose.environment_group(gpu, &self.view, lighting, &self.cache),
            cache: passes.cache.group(gpu, &self.cache, &lighting.background),
        }
    }

    /// GPU memory of all shadow maps and their filtered images in bytes.
    pub fn shadow_bytes(&self) -> u64 {
        self.lighting.as_ref().map_or(0, |lit| lit.batches.bytes())
    }

    /// Number of batches that the lights are drawn in: one for each size of map, more where memory is short.
    pub fn shadow_batches(&self) -> usize {
        self.lighting.as_ref().map_or(0, |lit| lit.batches.len())
    }
}
