//! Environment and lights.

use gnomon_lights::fit;
use gnomon_scene_files::EnvironmentSource;
use gnomon_studio::Look;

use super::fields::Fields;
use super::scene::file_name;
use crate::viewer::Viewer;

pub fn environment(fields: &mut Fields<'_>, viewer: &mut Viewer, wanted: &mut Look) {
    let name = match &wanted.environment.source {
        None => "none".to_owned(),
        Some(EnvironmentSource::Builtin(name)) => name.clone(),
        Some(EnvironmentSource::File(path)) => file_name(path),
    };
    let exposure = viewer.studio().map_or(0.0, |studio| studio.stage().exposure());
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
    fields.automatic("exposure", "exposure", &mut wanted.display.exposure, (exposure, -20.0..=20.0), 0.02);
    fields.check("background", "background", &mut wanted.display.background, "show the map");
}

/// The same angle from -180 to 180 degrees.
pub fn wrapped(degrees: f32) -> f32 {
    if degrees.abs() <= 180.0 { degrees } else { (degrees + 180.0).rem_euclid(360.0) - 180.0 }
}

pub fn lights(fields: &mut Fields<'_>, viewer: &mut Viewer, wanted: &mut Look) {
    let (fitted, summed) = viewer
        .studio()
        .map_or((0, 0), |studio| (studio.lights().lights.len(), studio.renderer().light_count()));
    let methods = fit::methods().iter().map(|method| (method.name, method.summary));
    let entries = methods.chain(std::iter::once(("none", "ambient light only")));
    if let Some(picked) = fields.choice("fit", "fit", &wanted.fit.method, entries) {
        wanted.fit.method = picked.to_owned();
    }
    if wanted.fit.method == "samples" {
        let chosen = wanted.fit.sampler.clone().unwrap_or_else(|| "default".to_owned());
        let entries = fit::samplers().iter().map(|sampler| (sampler.name, sampler.summary));
        if let Some(picked) = fields.choice("sampler", "sampler", &chosen, entries) {
            wanted.fit.sampler = Some(picked.to_owned());
        }
    }
    if wanted.fit.method != "none" {
        fields.automatic("number", "lights", &mut wanted.fit.light_count, (fitted.max(1), 1..=2000), 0.5);
    }
    fields.text("in force", &format!("{fitted} fitted, {summed} with ambient"));
}
