//! The environment.

use gnomon_scene_files::EnvironmentSource;
use gnomon_studio::{ENVIRONMENT, Look};

use super::fields::Fields;
use super::options;
use super::scene::file_name;

pub fn show(fields: &mut Fields<'_>, wanted: &mut Look, in_force: &Look) {
    let name = match &wanted.map {
        None => "none".to_owned(),
        Some(EnvironmentSource::Builtin(name)) => name.clone(),
        Some(EnvironmentSource::File(path)) => file_name(path),
    };
    let names: Vec<&str> = gnomon_envmap::builtin::names().collect();
    let entries = names.iter().map(|name| (*name, "built in"));
    if let Some(picked) = fields.choice("map", "environment", &name, entries) {
        wanted.set_environment(EnvironmentSource::Builtin(picked.to_owned()));
        wanted.display.exposure = None;
    }
    options::show(fields, wanted, ENVIRONMENT.heading, in_force, &options::as_declared);
}
