//! Bevy, as a Rust file (<https://docs.rs/bevy/0.20.0/bevy/light/prelude/struct.DirectionalLight.html>).
//!
//! - Axes are Gnomon's. A `DirectionalLight` shines along its transform's -z; its illuminance is the irradiance of a surface that faces it
//!   [lux] and is exposed as a camera would: a radiance of 1 is `NITS`, which the default exposure shows as white.
//! - Ten lights at most, one on WebGL. Environment maps have to be filtered cube maps: what lights leave becomes even ambient light.

use gnomon_lights::DistantLight;

use super::{Reflections, Target, comment};
use crate::rig::split;
use crate::{Rig, Sun};

pub(super) const TARGET: Target = Target {
    name: "bevy",
    extensions: &["rs"],
    summary: "Bevy: a Rust function that spawns directional lights and gives the ambient light",
    reflections: Reflections::Nothing,
    most_lights: Some(10),
    loses: "lights have no outline, shadows are soft only with the feature experimental_pbr_pcss, and what lights leave becomes even ambient light",
    map_extension: "exr",
    text,
};

fn text(rig: &Rig) -> String {
    let lights: String = rig.set.lights.iter().map(entry).collect();
    let (color, brightness) = split(rig.set.residual_flux() / (4.0 * std::f64::consts::PI));
    let named = |file: &Option<String>| file.as_deref().unwrap_or("none: lights leave nothing").to_owned();
    format!(
        "{about}// Written for Bevy 0.20. The map that the lights leave: {residual}\n\n\
         use bevy::prelude::*;\n\n\
         /// What a radiance of 1 is [cd/m^2]: white at Bevy's default exposure, 1.2 * 2^9.7.\n\
         pub const NITS: f32 = 998.0;\n\n\
         /// Direction towards it, linear colour, irradiance, angle across [rad].\n\
         const LIGHTS: [([f32; 3], [f32; 3], f32, f32); {count}] = [\n{lights}];\n\n\
         /// Spawns the lights.\n\
         pub fn spawn_rig(commands: &mut Commands) {{\n    \
             for (towards, [red, green, blue], irradiance, _angle) in LIGHTS {{\n        \
                 commands.spawn((\n            \
                     DirectionalLight {{\n                \
                         color: Color::linear_rgb(red, green, blue),\n                \
                         illuminance: irradiance * NITS,\n                \
                         shadow_maps_enabled: true,\n                \
                         ..default()\n            \
                     }},\n            \
                     // Its back points towards the light.\n            \
                     Transform::from_rotation(Quat::from_rotation_arc(Vec3::Z, Vec3::from_array(towards))),\n        \
                 ));\n    \
             }}\n\
         }}\n\n\
         /// Ambient light for a camera: what the lights leave, from everywhere alike.\n\
         pub fn ambient() -> AmbientLight {{\n    \
             AmbientLight {{ color: Color::linear_rgb({color}), brightness: {brightness:?} * NITS, ..default() }}\n\
         }}\n",
        about = comment(rig, "// "),
        residual = named(&rig.residual),
        count = rig.set.lights.len(),
        color = floats(color.to_array()),
        brightness = brightness as f32,
    )
}

/// Numbers as Rust reads them as floats.
fn floats<const N: usize>(values: [f64; N]) -> String {
    values.map(|value| format!("{:?}", value as f32)).join(", ")
}

fn entry(light: &DistantLight) -> String {
    let sun = Sun::of(light);
    let (color, intensity) = sun.color_and_intensity();
    let [towards, color] = [sun.towards, color].map(|v| floats(v.to_array()));
    format!("    ([{towards}], [{color}], {}),\n", floats([intensity, sun.diameter]))
}
