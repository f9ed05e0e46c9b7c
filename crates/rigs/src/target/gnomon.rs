//! Gnomon's own document, which `gnomon render --rig` reads.

use gnomon_lights::LightDocument;

use super::{Reflections, Target};
use crate::Rig;

pub(super) const TARGET: Target = Target {
    name: "gnomon",
    extensions: &["json"],
    summary: "JSON that gnomon render --rig takes",
    reflections: Reflections::LightsBeforeMap,
    most_lights: None,
    loses: "",
    map_extension: "exr",
    text,
};

fn text(rig: &Rig) -> String {
    let document = rig.set.document();
    LightDocument { residual: rig.residual.clone(), background: rig.whole.clone(), ..document }.to_json()
}
