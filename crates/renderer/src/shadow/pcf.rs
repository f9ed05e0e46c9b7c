use gnomon_shaders::layout;

use super::depth_map::DepthMapTechnique;
use super::depth_maps::MapDepth;
use super::{ShadowSettings, in_range};
use crate::RenderError;

/// Parameters of percentage-closer filtering.
#[derive(Clone, Debug, PartialEq)]
pub struct PcfSettings {
    /// Radius of the kernel in texels of the depth map, 0 to 1024.
    pub radius_texels: f32,
    /// Shadow tests a lookup, each between four texels: 1 to 1024.
    pub samples: u32,
    /// Factor on the renderer's offset along the normal, 0 to 10: the comparison with the receiver's own plane needs only so much
    /// as covers half a texel, and every more leaks light at contacts.
    pub normal_offset_scale: f32,
    /// Distance towards the light by which a receiver is moved, as a share of the depth range, 0 to 1. Tilted surfaces are
    /// covered by the comparison with their own plane; this bias only has to cover rounding.
    pub depth_bias: f32,
}

impl Default for PcfSettings {
    fn default() -> Self {
        Self { radius_texels: 1.5, samples: 16, normal_offset_scale: 0.5, depth_bias: 0.001 }
    }
}

/// Percentage-closer filtering (Reeves et al. 1987) over a disk of fixed size.
pub(super) static PCF: DepthMapTechnique = DepthMapTechnique {
    name: "pcf",
    summary: "percentage-closer filtering with a fixed kernel (Reeves et al. 1987)",
    module: "shadow_pcf",
    depth: MapDepth::Linear,
    parameters,
};

fn parameters(settings: &ShadowSettings, resolution: u32) -> Result<Vec<u8>, RenderError> {
    let settings = &settings.pcf;
    let radius = in_range("radius of percentage-closer filtering", settings.radius_texels, 0.0..=1024.0)?;
    let parameters = layout::PcfParameters {
        samples: in_range("samples of percentage-closer filtering", settings.samples, 1..=1024)?,
        radius_uv: radius / resolution as f32,
        normal_offset_scale: in_range(
            "normal offset of percentage-closer filtering",
            settings.normal_offset_scale,
            0.0..=10.0,
        )?,
        depth_bias: in_range("depth bias of percentage-closer filtering", settings.depth_bias, 0.0..=1.0)?,
    };
    Ok(layout::bytes(&parameters))
}
