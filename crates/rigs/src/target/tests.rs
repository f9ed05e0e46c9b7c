//! Values parsed back from the text of every program, by that program's own axes and units.

#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests fail as tests do")]

use std::f64::consts::PI;

use glam::{DQuat, DVec2, DVec3, Vec3};
use gnomon_envmap::Equirect;
use gnomon_lights::{DistantLight, LightDocument, LightSet};
use gnomon_picture::RgbImage;
use serde_json::Value;

use super::*;

/// Half angles of the two disks [rad].
const RADII: [f64; 2] = [0.1, 0.25];

/// Something red above, something green towards +x, and a wide blue rectangle towards +z.
fn set() -> LightSet {
    let radiance = |radius: f64| 2.0 * PI * (1.0 - radius.cos());
    let front = [DVec3::NEG_X, DVec3::Y, DVec3::Z];
    let lights = vec![
        DistantLight::disk(DVec3::Y, RADII[0], DVec3::new(9.0, 1.0, 0.5) * radiance(RADII[0])),
        DistantLight::disk(DVec3::X, RADII[1], DVec3::new(0.5, 3.0, 1.0) * radiance(RADII[1])),
        DistantLight::rectangle(
            front,
            DVec2::new(-0.3, -0.1),
            DVec2::new(0.3, 0.1),
            DVec3::new(0.1, 0.2, 2.0),
        ),
    ];
    let rest = RgbImage::from_fn(16, 8, |x, y| Vec3::new(x as f32, y as f32, 0.5));
    LightSet::new("disks", lights, Equirect::new(rest))
}

fn text(name: &str) -> String {
    let set = set();
    let residual = Some("a \"rest\"_residual.exr".to_owned());
    let about = vec!["Lights -- of a---map\u{ffff}-".to_owned()];
    let map = set.residual.clone();
    by_name(name).unwrap().text(&Rig { about, set: &set, map: &map, residual, whole: None })
}

/// Direction towards each light in Gnomon's axes, and irradiance of a surface that faces it.
type Found = Vec<(DVec3, DVec3)>;

/// Closed forms: a disk's irradiance is pi sin^2 of its half angle times its radiance.
fn check(name: &str, found: &Found) {
    let disk = |radiance: DVec3, radius: f64| radiance * (PI * radius.sin().powi(2));
    let rectangle = &set().lights[2];
    let expected = [
        (DVec3::Y, disk(DVec3::new(9.0, 1.0, 0.5), RADII[0])),
        (DVec3::X, disk(DVec3::new(0.5, 3.0, 1.0), RADII[1])),
        (DVec3::Z, rectangle.radiance.as_dvec3() * f64::from(rectangle.irradiance(Vec3::Z))),
    ];
    assert_eq!(found.len(), 3, "{name}");
    for ((towards, irradiance), (to, value)) in found.iter().zip(expected) {
        assert!((*towards - to).length() < 1e-5, "{name}: {towards} is not {to}");
        let error = (*irradiance / value - 1.0).abs().max_element();
        assert!(error < 1e-4, "{name}: {irradiance} is not {value}");
    }
}

/// The numbers in a text.
fn numbers_of(text: &str) -> Vec<f64> {
    text.split(|c: char| !(c.is_ascii_digit() || "+-.e".contains(c)))
        .filter_map(|word| word.parse().ok())
        .collect()
}

fn vector(values: &[f64]) -> DVec3 {
    DVec3::from_slice(values)
}

fn array(value: &Value) -> DVec3 {
    let values: Vec<f64> = value.as_array().unwrap().iter().map(|value| value.as_f64().unwrap()).collect();
    vector(&values)
}

/// What follows `key` in a text, to the end of the line.
fn after<'a>(text: &'a str, key: &str) -> &'a str {
    let (_, rest) = text.split_once(key).unwrap_or_else(|| panic!("no {key} in {text}"));
    rest.lines().next().unwrap()
}

/// Of z-up programs: `(x, -z, y)` back.
fn from_z_up(v: DVec3) -> DVec3 {
    DVec3::new(v.x, v.z, -v.y)
}

/// Projected solid angle of a rectangle of these half sides at distance 1, seen face on.
fn facing(half: DVec2) -> f64 {
    let corner = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
        .map(|(x, y)| glam::Vec2::new((x * half.x) as f32, (y * half.y) as f32));
    let light = DistantLight::quadrilateral(Vec3::Z, Vec3::X, corner, Vec3::ONE).unwrap();
    light.irradiance(Vec3::Z).into()
}

#[test]
fn names_and_extensions_are_told_apart() {
    let mut names: Vec<_> = targets().iter().map(|target| target.name).collect();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), targets().len());
    for (extension, name) in [("json", "gnomon"), ("USDA", "usd"), ("xml", "mitsuba"), ("mjcf", "mujoco")] {
        assert_eq!(by_extension(extension).unwrap().name, name);
    }
    assert!(by_extension("max").is_none() && by_name("maya").is_none());
}

#[test]
fn gnomon_s_own_document_has_the_lights_and_names_the_map() {
    let document = LightDocument::from_json(&text("gnomon")).unwrap();
    assert_eq!(document.residual.as_deref(), Some("a \"rest\"_residual.exr"));
    let found = document.shining().into_iter().map(|light| {
        let facing = light.irradiance(light.direction);
        (light.direction.as_dvec3(), (light.radiance * facing).as_dvec3())
    });
    check("gnomon", &found.collect());
}

/// Of `DiskLight`, `RectLight` and `DistantLight`: emission, axes as rows, and sizes.
#[test]
fn usd_lights_shine_along_their_minus_z() {
    for name in ["usd", "usd-distant"] {
        let text = text(name);
        assert!(text.starts_with("#usda 1.0") && text.contains("upAxis = \"Y\""));
        assert_eq!(text.matches("float inputs:intensity").count(), 4, "{text}");
        assert!(after(&text, "texture:file = ").contains("@a \"rest\"_residual.exr@"));
        let lights = text.split("    def ").filter(|block| block.contains("\"Light"));
        let found = lights.map(|block| {
            let number = |key: &str| numbers_of(after(block, key))[0];
            let value = vector(&numbers_of(after(block, "inputs:color = "))) * number("inputs:intensity = ");
            let rows = numbers_of(after(block, "xformOp:transform = "));
            let [x, y, z, place] = [0, 4, 8, 12].map(|start| vector(&rows[start..start + 3]));
            assert!((x.cross(y) - z).length() < 1e-5, "not right-handed: {block}");
            let distance = place.length();
            let solid = if block.starts_with("DistantLight") {
                PI * (0.5 * number("inputs:angle = ").to_radians()).sin().powi(2)
            } else {
                assert!((place / distance - z).length() < 1e-5, "does not face the scene: {block}");
                assert!(block.contains("inputs:normalize = 0"));
                match block.starts_with("DiskLight") {
                    true => PI * (number("inputs:radius = ") / distance).atan().sin().powi(2),
                    false => {
                        let sides = DVec2::new(number("inputs:width = "), number("inputs:height = "));
                        // Its width is that along x.
                        assert!(sides.x > sides.y && x.y.abs() < 1e-6, "{block}");
                        facing(0.5 * sides / distance)
                    }
                }
            };
            (z, value * solid)
        });
        check(name, &found.collect());
    }
}

/// XML 1.0, section 2.5.
#[test]
fn comments_of_xml_hold_no_two_hyphens_whatever_a_map_is_called() {
    for name in ["mujoco", "mitsuba"] {
        let text = text(name);
        let (_, rest) = text.split_once("<!--").unwrap();
        let (comment, _) = rest.split_once("--").unwrap();
        assert!(rest[comment.len()..].starts_with("-->\n<"), "{name}: {rest}");
        assert!(comment.contains("Lights - - of a- - -map\u{fffd}-\n"), "{name}: {comment}");
    }
}

/// Of `rectangle` and `disk`: axes as columns.
#[test]
fn mitsuba_s_shapes_face_the_scene_along_their_z() {
    let text = text("mitsuba");
    assert!(text.contains("a &quot;rest&quot;_residual.exr"));
    let found = text.split("<shape ").skip(1).map(|block| {
        let rows = numbers_of(after(block, "<matrix value="));
        let [x, y, z, place] =
            [0, 1, 2, 3].map(|column| DVec3::new(rows[column], rows[4 + column], rows[8 + column]));
        assert!(x.cross(y).dot(z) > 0.0 && (z.length() - 1.0).abs() < 1e-5, "{block}");
        let distance = place.length();
        assert!((place / distance + z).length() < 1e-5, "does not face the scene: {block}");
        let half = DVec2::new(x.length(), y.length()) / distance;
        let solid = match block.starts_with("type=\"disk\"") {
            true => PI * half.x.atan().sin().powi(2),
            false => facing(half),
        };
        (-z, vector(&numbers_of(after(block, "radiance\" value="))) * solid)
    });
    check("mitsuba", &found.collect());
}

#[test]
fn blender_s_suns_are_in_a_z_up_world() {
    let text = text("blender");
    assert!(
        text.contains("RESIDUAL = \"a \\\"rest\\\"_residual.exr\"") && text.contains("REFLECTION = None")
    );
    let list = text.split_once("LIGHTS = [").unwrap().1.split_once(']').unwrap().0;
    let found = list.trim().lines().map(|line| {
        let values = numbers_of(line);
        assert!(values[7] > 0.0 && values[7] < PI);
        (from_z_up(vector(&values)), vector(&values[3..6]) * values[6])
    });
    check("blender", &found.collect());
}

#[test]
fn gltf_s_nodes_shine_along_their_minus_z() {
    let document: Value = serde_json::from_str(&text("gltf")).unwrap();
    let lights = &document["extensions"]["KHR_lights_punctual"]["lights"];
    let found = document["nodes"].as_array().unwrap().iter().map(|node| {
        let turn: Vec<f64> =
            node["rotation"].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
        let index = node["extensions"]["KHR_lights_punctual"]["light"].as_u64().unwrap();
        let light = &lights[index as usize];
        let color = array(&light["color"]);
        assert!(color.max_element() <= 1.0);
        (-(DQuat::from_slice(&turn) * DVec3::NEG_Z), color * light["intensity"].as_f64().unwrap())
    });
    check("gltf", &found.collect());
}

#[test]
fn three_s_lights_come_from_their_places_and_its_map_lies_as_gnomon_s() {
    let document: Value = serde_json::from_str(&text("three")).unwrap();
    let found = document["object"]["children"].as_array().unwrap().iter().map(|light| {
        let place: Vec<f64> =
            light["matrix"].as_array().unwrap().iter().map(|value| value.as_f64().unwrap()).collect();
        let irradiance = array(&light["userData"]["irradiance"]);
        let hex = light["color"].as_u64().unwrap();
        let byte = |shift: u64| gnomon_picture::tonemap::srgb_decode((hex >> shift & 255) as f32 / 255.0);
        let shown = Vec3::new(byte(16), byte(8), byte(0)).as_dvec3() * light["intensity"].as_f64().unwrap();
        // Bytes are that coarse.
        assert!(
            (shown - irradiance).abs().max_element() < 5e-3 * irradiance.max_element(),
            "{shown} {irradiance}"
        );
        (vector(&place[12..15]).normalize(), irradiance)
    });
    check("three", &found.collect());

    let image = &document["images"][0]["url"];
    let (width, height) = (image["width"].as_u64().unwrap() as u32, image["height"].as_u64().unwrap() as u32);
    let map = set().residual.resized(width, height);
    for y in 0..height {
        for x in 0..width {
            let towards = map.texel_direction(x, y);
            // equirectUv of three.js; rows of a data texture run upwards.
            let u = towards.z.atan2(towards.x) / (2.0 * std::f32::consts::PI) + 0.5;
            let v = towards.y.asin() / std::f32::consts::PI + 0.5;
            let at = |share: f32, count: u32| ((share * count as f32).floor() as u32).min(count - 1);
            let index = 4 * (at(v, height) * width + at(u, width)) as usize;
            let texel = |channel: usize| {
                half::f16::from_bits(image["data"][index + channel].as_u64().unwrap() as u16).to_f32()
            };
            let expected = map.radiance().get(x, y);
            assert!((Vec3::new(texel(0), texel(1), texel(2)) - expected).length() < 0.02, "{towards}");
        }
    }
}

#[test]
fn babylon_s_lights_shine_along_their_directions_in_a_right_handed_scene() {
    let document: Value = serde_json::from_str(&text("babylon")).unwrap();
    assert_eq!(document["useRightHandedSystem"], true);
    // Half a turn either way: u = atan(x, -z) / 2 pi + 1/2 there.
    assert!((document["environmentTextureRotationY"].as_f64().unwrap() - PI).abs() < 1e-6);
    let found = document["lights"].as_array().unwrap().iter().map(|light| {
        assert!((array(&light["position"]).normalize() + array(&light["direction"])).length() < 1e-5);
        (-array(&light["direction"]), array(&light["diffuse"]) * light["intensity"].as_f64().unwrap())
    });
    check("babylon", &found.collect());
    assert_eq!(document["shadowGenerators"].as_array().unwrap().len(), 3);
}

#[test]
fn bevy_s_lights_have_their_irradiance_and_the_rest_is_ambient() {
    let text = text("bevy");
    let list = text.split_once("= [\n").unwrap().1.split_once("];").unwrap().0;
    let found = list.lines().map(|line| {
        let values = numbers_of(line);
        (vector(&values), vector(&values[3..6]) * values[6])
    });
    check("bevy", &found.collect());
    let ambient = numbers_of(after(&text, "AmbientLight { color: "));
    let mean = set().residual_flux() / (4.0 * PI);
    assert!((vector(&ambient) * ambient[3] - mean).length() < 1e-4 * mean.length());
}

#[test]
fn mujoco_s_lights_are_exposed_and_in_a_z_up_world() {
    let text = text("mujoco");
    let exposure = f64::from(set().residual.suitable_exposure()).exp2();
    let found = text.lines().filter(|line| line.contains("<light ")).map(|line| {
        let value =
            |key: &str| vector(&numbers_of(line.split_once(key).unwrap().1.split('"').next().unwrap()));
        (-from_z_up(value(" dir=\"")), value(" diffuse=\"") * (PI / exposure))
    });
    check("mujoco", &found.collect());
    let ambient = vector(&numbers_of(after(&text, "headlight ambient=\"")));
    let mean = set().residual_flux() / (4.0 * PI) * exposure;
    assert!((ambient - mean).length() < 1e-4 * mean.length());
}
