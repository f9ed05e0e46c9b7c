//! The environment.

use gnomon_scene_files::EnvironmentSource;
use gnomon_studio::Look;

use super::fields::Fields;
use super::scene::file_name;

pub fn show(fields: &mut Fields<'_>, wanted: &mut Look) {
    let name = match &wanted.environment.source {
        None => "none".to_owned(),
        Some(EnvironmentSource::Builtin(name)) => name.clone(),
        Some(EnvironmentSource::File(path)) => file_name(path),
    };
    let names: Vec<&str> = gnomon_envmap::builtin::names().collect();
    let entries = names.iter().map(|name| (*name, "built in"));
    if let Some(picked) = fields.choice("map", "environment", &name, entries) {
        wanted.environment = gnomon_studio::EnvironmentLook {
            source: Some(EnvironmentSource::Builtin(picked.to_owned())),
            ..Default::default()
        };
        wanted.display.exposure = None;
    }
    // Any number of turns is allowed.
    let mut rotation = wrapped(wanted.environment.rotation);
    if fields.slider("rotation", "rotation", &mut rotation, -180.0..=180.0, "°") {
        wanted.environment.rotation = rotation;
    }
}

/// The same angle from -180 to 180 degrees.
pub fn wrapped(degrees: f32) -> f32 {
    if degrees.abs() <= 180.0 { degrees } else { (degrees + 180.0).rem_euclid(360.0) - 180.0 }
}
