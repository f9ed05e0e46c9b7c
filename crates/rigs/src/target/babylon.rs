//! Babylon.js, as a `.babylon` scene (<https://doc.babylonjs.com/setup/support/.babylonFileFormat>).
//!
//! - `useRightHandedSystem` gives Gnomon's axes. Type 1 is a directional light, which shines along `direction`; its intensity is the
//!   irradiance of a surface that faces it, as PBR materials divide by pi.
//! - An `HDRCubeTexture` shows the middle of a map towards +z of its left-handed space, which is -z here: half a turn beside Gnomon's columns.
//!   It lights and is mirrored: there is no second map.
//! - A shadow map's depth covers what lies around the origin: by default it would be the camera's, whose rounding hides shadows. Version 9 reads
//!   generators only once one was made or `RegisterShadowGeneratorSceneComponent(ShadowGenerator)` was called.
//! - Materials take four lights unless their `maxSimultaneousLights` says more.

use gnomon_lights::DistantLight;
use serde_json::{Value, json};

use super::{Reflections, Target};
use crate::{Rig, Sun};

pub(super) const TARGET: Target = Target {
    name: "babylon",
    extensions: &["babylon"],
    summary: "Babylon.js: directional lights with shadow generators, and a map",
    reflections: Reflections::Ambient,
    most_lights: Some(4),
    loses: "lights have no size, each shadow generator's renderList awaits the meshes, and version 9 reads generators only after RegisterShadowGeneratorSceneComponent(ShadowGenerator)",
    map_extension: "hdr",
    text,
};

/// Distance of lights from the origin, and of the ends of what their shadow maps see [m].
const DISTANCE: f64 = 20.0;
const NEAR: f32 = 0.1;
const FAR: f32 = 50.0;
const SHADOW_MAP: u32 = 2048;
/// Of a receiver's depth, as a share of the map's range, and along its normal [m]: without them lit surfaces are striped.
const BIAS: f32 = 2e-4;
const NORMAL_BIAS: f32 = 0.01;

fn text(rig: &Rig) -> String {
    let (lights, shadows): (Vec<Value>, Vec<Value>) = rig.set.lights.iter().enumerate().map(entry).unzip();
    let mut document = json!({
        "producer": { "name": "Gnomon", "about": rig.about },
        "useRightHandedSystem": true,
        // The loader gives a PBR scene's map no harmonics, and then it lights nothing.
        "isPBR": false,
        "ambientColor": [0, 0, 0],
        "lights": lights,
        "shadowGenerators": shadows,
        "cameras": [],
        "materials": [],
        "meshes": [],
    });
    if let Some(file) = &rig.residual {
        document["environmentTexture"] = json!(file);
        document["environmentTextureType"] = json!("BABYLON.HDRCubeTexture");
        document["environmentTextureSize"] = json!(256);
        document["environmentTexturePrefilterOnLoad"] = json!(true);
        document["environmentTextureRotationY"] = json!(std::f32::consts::PI);
        document["environmentIntensity"] = json!(1);
    }
    format!("{document:#}\n")
}

fn entry((index, light): (usize, &DistantLight)) -> (Value, Value) {
    let sun = Sun::of(light);
    let (color, intensity) = sun.color_and_intensity();
    let name = format!("Light {index}");
    let light = json!({
        "name": name,
        "id": name,
        "type": 1,
        "position": (sun.towards * DISTANCE).as_vec3().to_array(),
        "direction": (-sun.towards).as_vec3().to_array(),
        "diffuse": color.as_vec3().to_array(),
        "specular": color.as_vec3().to_array(),
        "intensity": intensity as f32,
        "shadowMinZ": NEAR,
        "shadowMaxZ": FAR,
        "metadata": { "angularDiameter": sun.diameter as f32 },
    });
    let shadow = json!({
        "lightId": name,
        "mapSize": SHADOW_MAP,
        "bias": BIAS,
        "normalBias": NORMAL_BIAS,
        "usePercentageCloserFiltering": true,
        "renderList": [],
    });
    (light, shadow)
}
