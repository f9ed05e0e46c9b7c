use gnomon_options::{Group, number, settings};
use gnomon_shaders::layout;

use super::ShadowSettings;
use super::depth_map::DepthMapTechnique;
use super::depth_maps::MapDepth;

static GROUP: Group = Group {
    table: "hard_linear",
    heading: "Hard shadow maps of linear depth (hard-linear)",
    condition: Some(("shadows", &["hard-linear"])),
};

settings! {
    /// Parameters of hard shadow maps of linear depth.
    pub struct HardLinearSettings in GROUP {
        /// Difference of linear depth up to which a receiver counts as its own blocker's surface, as a share of the depth range: the same
        /// number of metres everywhere.
        depth_bias: f32 = 0.002, number(0.0, 1.0);
    }
}

/// Shadow maps of linear depth, compared by subtraction (Heidrich 2001, section 2.1).
pub(super) static HARD_LINEAR: DepthMapTechnique = DepthMapTechnique {
    name: "hard-linear",
    summary: "one subtraction of linear depths from each light's centre (Heidrich 2001)",
    module: "shadow_hard_linear",
    depth: MapDepth::Linear,
    parameters,
};

fn parameters(settings: &ShadowSettings, _: u32) -> Vec<u8> {
    let parameters = layout::HardParameters { depth_bias: settings.hard_linear.depth_bias };
    layout::bytes(&parameters)
}
