use glam::Vec4;
use gnomon_options::{Group, number, settings, whole};
use gnomon_shaders::layout;
use gnomon_shaders::twin::sample_pattern::{hammersley, vogel_disk};

use super::ShadowSettings;
use super::depth_map::DepthMapTechnique;
use super::depth_maps::MapDepth;

static GROUP: Group = Group {
    table: "pcss",
    heading: "Percentage-closer soft shadows (pcss)",
    condition: Some(("shadows", &["auto", "pcss"])),
};

settings! {
    /// Parameters of percentage-closer soft shadows.
    pub struct PcssSettings in GROUP {
        /// Texels looked at for blockers.
        search_samples: u32 = 16, whole(1, layout::PCSS_SAMPLES as i64);
        /// Shadow tests over the penumbra's kernel, each between four texels.
        filter_samples: u32 = 16, whole(1, layout::PCSS_SAMPLES as i64);
        /// Factor on the offset along the normal. The comparison with the receiver's own plane needs only so much as covers half a texel,
        /// and every more leaks light at contacts.
        normal_offset_scale: f32 = 0.35, number(0.0, 10.0);
        /// Distance towards the light by which a receiver is moved, as a share of the depth range. Tilted surfaces are covered by the
        /// comparison with their own plane; this bias only has to cover rounding.
        depth_bias: f32 = 0.001, number(0.0, 1.0);
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

/// The module's parameters, and behind them its points.
fn parameters(settings: &ShadowSettings, _: u32) -> Vec<u8> {
    let &PcssSettings { search_samples, filter_samples, normal_offset_scale, depth_bias } = &settings.pcss;
    let half = |samples: u32| (samples / 2).max(1);
    let sets = [search_samples, filter_samples, half(search_samples), half(filter_samples)];
    let in_sets = sets.into_iter().flat_map(|count| (0..count).map(move |i| (i, count)));
    let mut points = vec![Vec4::ZERO; layout::PCSS_POINTS as usize];
    for (point, (i, count)) in points.iter_mut().zip(in_sets) {
        let (disk, square) = (vogel_disk(i, count, 0.0), hammersley(i, count));
        *point = Vec4::new(disk.x, disk.y, square.x, square.y);
    }
    let parameters =
        layout::PcssParameters { search_samples, filter_samples, normal_offset_scale, depth_bias };
    [layout::bytes(&parameters), bytemuck::cast_slice(&points).to_vec()].concat()
}
