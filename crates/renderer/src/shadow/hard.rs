use gnomon_options::{Group, number, settings};
use gnomon_shaders::layout;

use super::ShadowSettings;
use super::depth_map::DepthMapTechnique;
use super::depth_maps::MapDepth;

static GROUP: Group =
    Group { table: "hard", heading: "Hard shadow maps (hard)", condition: Some(("shadows", &["hard"])) };

settings! {
    /// Parameters of hard shadow maps.
    pub struct HardSettings in GROUP {
        /// Distance towards the light by which a receiver is moved, as a share of the stored depth's range: under a perspective map the
        /// same bias is more metres the farther the receiver. Surfaces tilted against the light are covered by the offset along the
        /// normal; this bias only has to cover rounding.
        depth_bias: f32 = 0.002, number(0.0, 1.0);
    }
}

/// Projective shadow maps with a z-buffer test (Williams 1978; Heidrich 2001, section 2).
pub(super) static HARD: DepthMapTechnique = DepthMapTechnique {
    name: "hard",
    summary: "one z-buffer test from each light's centre",
    module: "shadow_hard",
    depth: MapDepth::Projected,
    parameters,
};

fn parameters(settings: &ShadowSettings, _: u32) -> Vec<u8> {
    let parameters = layout::HardParameters { depth_bias: settings.hard.depth_bias };
    layout::bytes(&parameters)
}
