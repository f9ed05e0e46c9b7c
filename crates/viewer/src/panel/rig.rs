//! The lights of a rig, one at a time.

use glam::Vec3;
use gnomon_lights::{LightEntry, ShapeEntry};
use gnomon_studio::Look;

use super::fields::{Fields, drag};
use crate::viewer::Viewer;

/// A lamp that is added: the angle across of a hand at arm's length, in front and above [degrees].
const ADDED: (f32, f32, f32) = (0.0, 45.0, 5.0);

/// Irradiance of what faces such a lamp where no light tells what suits.
const ADDED_IRRADIANCE: f32 = 3.0;

/// Controls of the rig that is open, else only what makes one of the lights that are fitted.
pub fn show(fields: &mut Fields<'_>, viewer: &mut Viewer, wanted: &mut Look) {
    let Some(rig) = viewer.studio().and_then(|studio| studio.stage().rig()) else {
        fields.text("lights", "fitted: save them as a rig to edit them");
        return save(fields, viewer);
    };
    let mut edited = rig.clone();
    if let Some(last) = rig.lights.len().checked_sub(1) {
        viewer.rig_light = viewer.rig_light.min(last);
        fields.slider("light", "rig light", &mut viewer.rig_light, 0..=last, "");
        let index = viewer.rig_light;
        light(fields, &mut edited.lights[index]);
        let mut solo = edited.solo == Some(index);
        if fields.check("", "rig solo", &mut solo, "solo: no other light, no map") {
            edited.solo = solo.then_some(index);
        }
    }
    let reload = match fields.buttons(&["add light", "remove light", "reload rig"]) {
        Some("add light") => {
            let lamp = added(&edited.lights);
            edited.lights.push(lamp);
            viewer.rig_light = edited.lights.len() - 1;
            false
        }
        Some("remove light") if viewer.rig_light < edited.lights.len() => {
            edited.lights.remove(viewer.rig_light);
            edited.solo = None;
            false
        }
        clicked => clicked == Some("reload rig"),
    };
    if edited != rig {
        wanted.rig = Some(edited);
    }
    save(fields, viewer);
    if reload {
        // What is wanted else would put the edits back.
        wanted.rig = None;
        viewer.reload_rig();
    }
}

fn save(fields: &mut Fields<'_>, viewer: &mut Viewer) {
    let mut path = std::mem::take(&mut viewer.rig_path);
    let asked = fields.line("save rig", "save rig", &mut path, "rig.json");
    viewer.rig_path = path;
    if asked {
        viewer.save_rig();
    }
}

/// Whether it shines, where it is, how large, and its light.
fn light(fields: &mut Fields<'_>, light: &mut LightEntry) {
    fields.check("", "rig on", &mut light.enabled, "shines");
    let [mut azimuth, mut elevation] = angles(Vec3::from(light.direction));
    let turned = fields.slider("azimuth", "rig azimuth", &mut azimuth, -180.0..=180.0, "°");
    if fields.slider("elevation", "rig elevation", &mut elevation, -90.0..=90.0, "°") || turned {
        light.direction = direction(azimuth, elevation).to_array();
    }
    if let ShapeEntry::Disk { angular_radius } = &mut light.shape {
        let mut degrees = angular_radius.to_degrees();
        if fields.slider("radius", "rig radius", &mut degrees, 0.1..=80.0, "°") {
            *angular_radius = degrees.to_radians();
        }
    }
    let strength = light.radiance.iter().copied().fold(0.0, f32::max);
    let mut wanted = strength;
    if fields.row("radiance", "of the strongest color", |ui, targets| {
        drag(ui, targets, "rig radiance", &mut wanted, 0.0..=1e9)
    }) {
        light.radiance = match strength > 0.0 {
            true => light.radiance.map(|channel| channel * (wanted / strength)),
            false => [wanted; 3],
        };
    }
    let mut tint = light.radiance.map(|channel| if strength > 0.0 { channel / strength } else { 1.0 });
    let changed = fields.row("tint", "", |ui, targets| {
        let channels = ["red", "green", "blue"].iter().zip(&mut tint);
        let changed = channels
            .map(|(channel, value)| drag(ui, targets, &format!("rig tint {channel}"), value, 0.0..=1.0));
        changed.fold(false, |any, one| any | one)
    });
    if changed {
        light.radiance = tint.map(|channel| channel * strength);
    }
}

/// A lamp as bright as the others are on average.
fn added(lights: &[LightEntry]) -> LightEntry {
    let (azimuth, elevation, radius) = ADDED;
    let radius = radius.to_radians();
    let flux = |light: &LightEntry| light.derived.as_ref().map_or(0.0, |derived| derived.flux[1] as f32);
    let all: f32 = lights.iter().map(flux).sum();
    let irradiance = if all > 0.0 { all / lights.len() as f32 } else { ADDED_IRRADIANCE };
    LightEntry {
        enabled: true,
        direction: direction(azimuth, elevation).to_array(),
        tangent: None,
        shape: ShapeEntry::Disk { angular_radius: radius },
        radiance: [irradiance / (std::f32::consts::PI * radius.sin().powi(2)); 3],
        derived: None,
    }
}

/// Azimuth from +z to +x and elevation [degrees].
fn angles(direction: Vec3) -> [f32; 2] {
    let direction = direction.normalize_or(Vec3::Y);
    [direction.x.atan2(direction.z).to_degrees(), direction.y.asin().to_degrees()]
}

fn direction(azimuth: f32, elevation: f32) -> Vec3 {
    let (azimuth, elevation) = (azimuth.to_radians(), elevation.to_radians());
    Vec3::new(azimuth.sin() * elevation.cos(), elevation.sin(), azimuth.cos() * elevation.cos())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_and_directions_are_each_others() {
        for at in [Vec3::Z, Vec3::X, Vec3::new(-0.6, 0.64, 0.48), Vec3::new(0.1, -0.9, -0.3).normalize()] {
            let [azimuth, elevation] = angles(at);
            assert!(direction(azimuth, elevation).abs_diff_eq(at, 1e-5), "{at} {azimuth} {elevation}");
        }
        assert_eq!(angles(Vec3::X), [90.0, 0.0]);
    }
}
