use gnomon_shaders::layout;

use super::depth_map::DepthMapTechnique;
use super::depth_maps::MapDepth;
use super::{ShadowSettings, in_range};
use crate::RenderError;

/// Parameters of percentage-closer soft shadows.
#[derive(Clone, Debug, PartialEq)]
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
}

impl Default for PcssSettings {
    fn default() -> Self {
        Self { search_samples: 16, filter_samples: 32, normal_offset_scale: 0.35, depth_bias: 0.001 }
    }
}

/// Percentage-closer soft shadows (Fernando 2005).
pub(super) static PCSS: DepthMapTechnique = DepthMapTechnique {
    name: "pcss",
    summary: "percentage-closer soft shadows: blocker search, then a kernel of the penumbra's width (Fernando 2005)",
    module: "shadow_pcss",
    depth: MapDepth::Linear,
    parameters,
};

fn parameters(settings: &ShadowSettings, _: u32) -> Result<Vec<u8>, RenderError> {
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
    };
    Ok(layout::bytes(&parameters))
}
