use gnomon_shaders::layout;

use super::{DepthMapsOnly, ShadowResources, ShadowSettings, ShadowTechnique, in_range};
use crate::depth_maps::DepthMaps;
use crate::{Gpu, RenderError};

/// Percentage-closer soft shadows (Fernando 2005).
pub(super) struct Pcss;

/// Parameters of percentage-closer soft shadows.
#[derive(Clone, Debug)]
pub struct PcssSettings {
    /// Texels looked at for blockers: 1 to 1024.
    pub search_samples: u32,
    /// Shadow tests over the penumbra's kernel, each between four texels: 1 to 1024.
    pub filter_samples: u32,
    /// Factor on the renderer's offset along the normal, 0 to 10: the comparison with the receiver's own plane needs only so much
    /// as covers half a texel, and every more leaks light at contacts.
    pub normal_offset_scale: f32,
    /// Distance towards the light by which a receiver is moved, as a share of the depth range, 0 to 1. Tilted surfaces are
    /// covered by the comparison with their own plane; this bias only has to cover rounding.
    pub depth_bias: f32,
    /// Turns the samples from place to place, which trades banding for noise.
    pub rotate_per_pixel: bool,
}

impl Default for PcssSettings {
    fn default() -> Self {
        Self {
            search_samples: 16,
            filter_samples: 32,
            normal_offset_scale: 0.35,
            depth_bias: 0.001,
            rotate_per_pixel: false,
        }
    }
}

impl ShadowTechnique for Pcss {
    fn name(&self) -> &'static str {
        "pcss"
    }

    fn summary(&self) -> &'static str {
        "percentage-closer soft shadows: blocker search, then a kernel of the penumbra's width (Fernando 2005)"
    }

    fn module(&self, _: &ShadowSettings) -> &'static str {
        "shadow_pcss"
    }

    fn needs_depth_maps(&self) -> bool {
        true
    }

    fn resources(
        &self,
        gpu: &Gpu,
        settings: &ShadowSettings,
        maps: &DepthMaps,
    ) -> Result<Box<dyn ShadowResources>, RenderError> {
        let settings = &settings.pcss;
        let parameters = layout::PcssParameters {
            search_samples: in_range("samples of the blocker search", settings.search_samples, 1..=1024)?,
            filter_samples: in_range("samples of soft shadows", settings.filter_samples, 1..=1024)?,
            normal_offset_scale: in_range(
                "normal offset of soft shadows",
                settings.normal_offset_scale,
                0.0..=10.0,
            )?,
            depth_bias: in_range("depth bias of soft shadows", settings.depth_bias, 0.0..=1.0)?,
            rotate_per_pixel: u32::from(settings.rotate_per_pixel),
            padding_0: 0,
            padding_1: 0,
            padding_2: 0,
        };
        let parameters = bytemuck::bytes_of(&parameters);
        Ok(Box::new(DepthMapsOnly::with_parameters(gpu, "percentage-closer soft shadows", parameters, maps)))
    }
}
