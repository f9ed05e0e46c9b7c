//! three.js, as a scene for `ObjectLoader` (<https://threejs.org/docs/#api/en/loaders/ObjectLoader>).
//!
//! - Axes are Gnomon's. A `DirectionalLight` shines from its position to the origin; its intensity is the irradiance of a surface that faces
//!   it, as materials divide by pi.
//! - `environment` lights and is mirrored: there is no second map. It is looked up at `u = atan(z, x) / 2 pi + 1/2`, a quarter beside Gnomon's
//!   columns, and a data texture's first row is the lowest. So its texels are written in that order, as halves.
//! - `RectAreaLight` casts no shadow. A shadow camera has to be fitted to the scene: it covers 10 m around the origin.

use gnomon_envmap::Equirect;
use gnomon_lights::DistantLight;
use half::f16;
use serde_json::{Value, json};

use super::{Reflections, Target};
use crate::{Rig, Sun};

pub(super) const TARGET: Target = Target {
    name: "three",
    extensions: &[],
    summary: "three.js: a scene for ObjectLoader, with shadow-casting directional lights and the map inside",
    reflections: Reflections::Ambient,
    most_lights: Some(8),
    loses: "lights have no size",
    map_extension: "exr",
    text,
};

/// Distance of lights from the origin, half the width of what a shadow camera sees, and the far end of that [m].
const DISTANCE: f64 = 20.0;
const REACH: f32 = 10.0;
const FAR: f32 = 50.0;
const SHADOW_MAP: u32 = 2048;
/// Most columns of the map.
const WIDTH: u32 = 512;

/// `EquirectangularReflectionMapping`, `RepeatWrapping`, `ClampToEdgeWrapping`, `LinearFilter`, `HalfFloatType`, `RGBAFormat`.
const MAPPING: u32 = 303;
const WRAP: [u32; 2] = [1000, 1001];
const LINEAR: u32 = 1006;
const HALF_FLOAT: u32 = 1016;
const RGBA: u32 = 1023;

fn text(rig: &Rig) -> String {
    let lights: Vec<Value> = rig.set.lights.iter().enumerate().map(entry).collect();
    let mut document = json!({
        "metadata": { "version": 4.6, "type": "Object", "generator": "Gnomon" },
        "object": {
            "uuid": "rig",
            "type": "Scene",
            "name": "Rig",
            "userData": { "about": rig.about, "residual": rig.residual },
            "children": lights,
        },
    });
    if rig.residual.is_some() {
        document["images"] = json!([{ "uuid": "residual-image", "url": image(&rig.set.residual) }]);
        document["textures"] = json!([{
            "uuid": "residual",
            "image": "residual-image",
            "mapping": MAPPING,
            "wrap": WRAP,
            "minFilter": LINEAR,
            "magFilter": LINEAR,
            "type": HALF_FLOAT,
            "format": RGBA,
            "colorSpace": "srgb-linear",
            "flipY": false,
            "generateMipmaps": false,
        }]);
        document["object"]["environment"] = json!("residual");
        document["object"]["environmentIntensity"] = json!(1);
    }
    format!("{document}\n")
}

fn image(map: &Equirect) -> Value {
    let width = map.width().clamp(4, WIDTH).next_multiple_of(4);
    let map = map.resized(width, (width / 2).max(1));
    let (width, height) = (map.width(), map.height());
    let texel = |i: u32| {
        let (column, row) = (i % width, height - 1 - i / width);
        // A quarter further in three.js is the same direction.
        map.radiance().get((column + width - width / 4) % width, row).extend(1.0)
    };
    let bits = |value: f32| f16::from_f32(value.min(f16::MAX.to_f32())).to_bits();
    let data: Vec<u16> = (0..width * height).flat_map(|i| texel(i).to_array().map(bits)).collect();
    json!({ "type": "Uint16Array", "data": data, "width": width, "height": height })
}

fn entry((index, light): (usize, &DistantLight)) -> Value {
    let sun = Sun::of(light);
    let (color, intensity) = sun.color_and_intensity();
    let place = (sun.towards * DISTANCE).as_vec3();
    json!({
        "uuid": format!("light-{index}"),
        "type": "DirectionalLight",
        "name": format!("Light {index}"),
        "color": color_number(color),
        "intensity": intensity as f32,
        "castShadow": true,
        "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, place.x, place.y, place.z, 1],
        "shadow": {
            "mapSize": [SHADOW_MAP, SHADOW_MAP],
            "camera": {
                "uuid": format!("shadow-{index}"), "type": "OrthographicCamera",
                "left": -REACH, "right": REACH, "top": REACH, "bottom": -REACH, "near": 0.1, "far": FAR,
            },
        },
        "userData": { "angularDiameter": sun.diameter as f32, "irradiance": sun.irradiance.as_vec3().to_array() },
    })
}

/// As `Color.getHex()` gives it: sRGB, a byte a channel, within half a percent of the brightest.
fn color_number(color: glam::DVec3) -> u32 {
    let byte = |value: f64| (gnomon_picture::tonemap::srgb_encode(value as f32) * 255.0).round() as u32;
    byte(color.x) << 16 | byte(color.y) << 8 | byte(color.z)
}
