//! Mitsuba 3, as an XML scene fragment (<https://mitsuba.readthedocs.io/en/stable/src/generated/plugins_emitters.html>).
//!
//! - +y is up and a map's columns run as Gnomon's: `envmap` looks a direction up at `u = atan2(x, -z) / 2 pi`.
//! - `rectangle` covers [-1, 1]^2 and `disk` the unit disk of its own x and y; both emit along +z, which has to point to the scene. Matrices
//!   hold axes as columns.
//! - `area` takes radiance. Emitters are seen by the camera and mirrored, before the map.

use glam::Vec3;
use gnomon_lights::DistantLight;

use super::{Reflections, Target, numbers, xml_comment};
use crate::{FarShape, Outline, Rig};

pub(super) const TARGET: Target = Target {
    name: "mitsuba",
    extensions: &["xml"],
    summary: "Mitsuba 3: far rectangles and disks and an envmap, to include into a scene",
    reflections: Reflections::Lights,
    most_lights: None,
    loses: "",
    map_extension: "exr",
    text,
};

/// Distance of lights [m]: for models of some metres their shadows are those of distant lights within 0.1 %.
const DISTANCE: f32 = 10_000.0;

fn text(rig: &Rig) -> String {
    let about = xml_comment(rig, "     ");
    let mut text =
        format!("<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<!--\n{about}-->\n<scene version=\"3.0.0\">\n");
    if let Some(file) = &rig.residual {
        text += &format!(
            "    <emitter type=\"envmap\" id=\"residual\">\n        <string name=\"filename\" value=\"{}\"/>\n        \
             <float name=\"scale\" value=\"1\"/>\n    </emitter>\n",
            escaped(file)
        );
    }
    for (index, light) in rig.set.lights.iter().enumerate() {
        text += &emitter(light, index);
    }
    text + "</scene>\n"
}

fn emitter(light: &DistantLight, index: usize) -> String {
    let shape = FarShape::of(light);
    let (kind, half) = match shape.outline {
        Outline::Disk(radius) => ("disk", glam::Vec2::splat(radius)),
        Outline::Rectangle(half) => ("rectangle", half),
    };
    // x, y and z in this order are right-handed.
    let columns = [
        shape.across * (half.x * DISTANCE),
        -shape.along * (half.y * DISTANCE),
        -shape.towards,
        shape.towards * DISTANCE,
    ];
    let row = |of: fn(Vec3) -> f32| columns.map(|column| f64::from(of(column)));
    let rows = [row(|v| v.x), row(|v| v.y), row(|v| v.z), [0.0, 0.0, 0.0, 1.0]];
    format!(
        "    <shape type=\"{kind}\" id=\"light_{index}\">\n        <transform name=\"to_world\">\n            <matrix value=\"{}\"/>\n        \
         </transform>\n        <emitter type=\"area\">\n            <rgb name=\"radiance\" value=\"{}\"/>\n        </emitter>\n    </shape>\n",
        numbers(rows.into_iter().flatten(), " "),
        numbers(shape.radiance.as_dvec3().to_array(), " ")
    )
}

/// Text between quotation marks.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}
