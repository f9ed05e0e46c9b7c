//! glTF 2.0 with `KHR_lights_punctual`
//! (<https://github.com/KhronosGroup/glTF/tree/main/extensions/2.0/Khronos/KHR_lights_punctual>).
//!
//! - Axes are Gnomon's. A directional light shines along its node's -z; its intensity is the illuminance of a surface that faces it [lux],
//!   here the irradiance in the map's own unit, and its colour is at most 1.
//! - It has neither size nor map: both stand in `extras`. Blender's importer divides by 683 unless its lighting mode is "Unitless".

use glam::Quat;
use gnomon_lights::DistantLight;
use serde_json::{Value, json};

use super::{Reflections, Target};
use crate::{Rig, Sun};

pub(super) const TARGET: Target = Target {
    name: "gltf",
    extensions: &["gltf"],
    summary: "glTF: directional lights; sizes and the map's name in extras",
    reflections: Reflections::Nothing,
    most_lights: None,
    loses: "lights have no size and the map is only named (extras)",
    map_extension: "exr",
    text,
};

fn text(rig: &Rig) -> String {
    let (lights, nodes): (Vec<Value>, Vec<Value>) = rig.set.lights.iter().enumerate().map(entry).unzip();
    let names: Vec<usize> = (0..nodes.len()).collect();
    let mut scene = json!({
        "name": "Rig",
        "extras": { "about": rig.about, "residual": rig.residual },
    });
    let mut document = json!({ "asset": { "version": "2.0", "generator": "Gnomon" }, "scene": 0 });
    // Lists without an entry are not valid.
    if !nodes.is_empty() {
        scene["nodes"] = json!(names);
        document["nodes"] = json!(nodes);
        document["extensionsUsed"] = json!(["KHR_lights_punctual"]);
        document["extensions"] = json!({ "KHR_lights_punctual": { "lights": lights } });
    }
    document["scenes"] = json!([scene]);
    format!("{document:#}\n")
}

fn entry((index, light): (usize, &DistantLight)) -> (Value, Value) {
    let sun = Sun::of(light);
    let (color, intensity) = sun.color_and_intensity();
    let turn = Quat::from_rotation_arc(glam::Vec3::Z, sun.towards.as_vec3()).normalize();
    let name = format!("Light {index}");
    let light = json!({
        "name": name,
        "type": "directional",
        "color": color.as_vec3().to_array(),
        "intensity": intensity as f32,
        "extras": { "angular_diameter": sun.diameter as f32, "radiance": light.radiance.to_array() },
    });
    let node = json!({
        "name": name,
        "rotation": turn.to_array(),
        "extensions": { "KHR_lights_punctual": { "light": index } },
    });
    (light, node)
}
