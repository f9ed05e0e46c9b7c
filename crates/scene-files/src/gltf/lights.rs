//! KHR_lights_punctual: points, spots and suns. Ours have an extent, which the extension does not know; what Blender calls a custom property
//! of a light becomes its `extras`: `radius` of a point or spot [m] (or `shadow_soft_size`, Blender's own name for it), and `angle` of a sun,
//! its angular diameter [rad].

use std::f32::consts::{FRAC_PI_2, FRAC_PI_4};

use glam::Vec3;
use gnomon_messages::quoted;
use gnomon_scene::{AreaLight, AreaLightShape, NodeId, Spread};

use super::schema::LightEntry;

/// Radius of a light whose file gives none [m]: that of a small bulb.
const RADIUS: f32 = 0.01;

/// Radii that are taken [m], as in a scene file.
const RADII: std::ops::RangeInclusive<f32> = 1e-6..=1e6;

/// Angular diameter of a sun whose file gives none, and those that are taken [rad].
const SUN_ANGLE: f32 = 0.00925;
const SUN_ANGLES: std::ops::RangeInclusive<f32> = 1e-4..=3.0;

/// Largest radiance: sums over many lights stay finite.
const MOST_RADIANCE: f32 = 1e30;

/// A light of the file at a node, or why there is none. One candela is an intensity of 1, one lux an irradiance of 1 in the environment's unit.
pub fn light(entry: &LightEntry, node: NodeId) -> Result<AreaLight, String> {
    let number = |keys: &[&str], range: std::ops::RangeInclusive<f32>, default: f32| {
        let found = keys.iter().find_map(|key| Some((*key, entry.extras.get(key)?)));
        let Some((key, value)) = found else { return Ok(default) };
        let value = value.as_f64().map(|value| value as f32).filter(|value| range.contains(value));
        value
            .ok_or_else(|| format!("extras.{key} must be a number from {} to {}", range.start(), range.end()))
    };
    let (shape, spread) = match entry.kind.as_str() {
        "directional" => {
            let angle = number(&["angle"], SUN_ANGLES, SUN_ANGLE)?;
            (AreaLightShape::Sun { angular_radius: 0.5 * angle }, Spread::Even)
        }
        "point" | "spot" => {
            let radius = number(&["radius", "shadow_soft_size"], RADII, RADIUS)?;
            let spread = if entry.kind == "spot" { cone(entry)? } else { Spread::Even };
            (AreaLightShape::Sphere { radius }, spread)
        }
        other => return Err(format!("it is of the unknown type '{}'", quoted(other))),
    };
    let color = Vec3::from_array(entry.color.unwrap_or([1.0; 3]));
    let radiance = entry.intensity.unwrap_or(1.0) * color / shape.facing_irradiance();
    if !(radiance.is_finite() && radiance.min_element() >= 0.0 && radiance.max_element() <= MOST_RADIANCE) {
        return Err("its color and intensity must be numbers of at least 0".to_owned());
    }
    Ok(AreaLight { node, shape, radiance, spread })
}

fn cone(entry: &LightEntry) -> Result<Spread, String> {
    let angles = entry.spot.as_ref();
    let inner = angles.and_then(|spot| spot.inner_cone_angle).unwrap_or(0.0);
    let outer = angles.and_then(|spot| spot.outer_cone_angle).unwrap_or(FRAC_PI_4);
    // Writers round a quarter turn up.
    if !(0.0 <= inner && inner <= outer && 0.0 < outer && outer <= FRAC_PI_2 + 1e-4) {
        return Err("its cone angles must be from 0 to a quarter turn, the outer one larger".to_owned());
    }
    Ok(Spread::Cone { inner, outer: outer.min(FRAC_PI_2) })
}
