use gnomon_options::{Group, number, settings, whole};
use gnomon_shaders::layout;

use super::ShadowSettings;
use super::depth_map::DepthMapTechnique;
use super::depth_maps::MapDepth;

static GROUP: Group = Group {
    table: "pcf",
    heading: "Percentage-closer filtering (pcf)",
    condition: Some(("shadows", &["pcf"])),
};

settings! {
    /// Parameters of percentage-closer filtering.
    pub struct PcfSettings in GROUP {
        /// Radius of the kernel, in texels of the shadow map.
        radius: f32 = 1.5, number(0.0, 1024.0).unit("texels");
        /// Shadow tests a lookup, each between four texels.
        samples: u32 = 16, whole(1, 1024);
        /// Factor on the offset along the normal. The comparison with the receiver's own plane needs only so much as covers half a texel,
        /// and every more leaks light at contacts.
        normal_offset_scale: f32 = 0.5, number(0.0, 10.0);
        /// Distance towards the light by which a receiver is moved, as a share of the depth range. Tilted surfaces are covered by the
        /// comparison with their own plane; this bias only has to cover rounding.
        depth_bias: f32 = 0.001, number(0.0, 1.0);
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

fn parameters(settings: &ShadowSettings, resolution: u32) -> Vec<u8> {
    let &PcfSettings { radius, samples, normal_offset_scale, depth_bias } = &settings.pcf;
    let radius_uv = radius / resolution as f32;
    let parameters = layout::PcfParameters { samples, radius_uv, normal_offset_scale, depth_bias };
    layout::bytes(&parameters)
}
