use std::sync::Arc;

use glam::Vec3;
use gnomon::envmap::{Equirect, builtin};
use gnomon::lights::DistantLight;
use gnomon::options::Given;
use gnomon::picture;
use gnomon::studio::{self, Look, environment_named};
use gnomon_terminal::Terminal;

use crate::error::CliError;

/// An environment to be fitted.
pub struct GivenEnvironment {
    /// With all of its light.
    pub whole: Arc<Equirect>,
    /// Without what became lights of its own ([`studio::EnvironmentLook::clamp`]).
    pub fitted: Arc<Equirect>,
    pub taken_out: Vec<DistantLight>,
    /// Of all this light, for what is made of it: it changes no fit.
    pub factor: Vec3,
}

/// Reads or makes the environment that the command line names, and turns it as it is `given`. What had to be repaired is told as warnings.
///
/// # Errors
/// Unreadable files, pictures of no known layout, names of nothing.
pub fn load_environment(name: &str, given: &Given, terminal: Terminal) -> Result<GivenEnvironment, CliError> {
    let mut look = Look { map: Some(environment_named(name)), ..Look::default() };
    given.apply(&mut look);
    if look.environment.rig.is_some() || look.environment.background_map.is_some() {
        return Err(CliError::usage(
            "--rig and --background-map are for pictures: here an environment is fitted",
        ));
    }
    let (surroundings, warnings) = studio::load_surroundings(&look)?;
    warnings.iter().for_each(|warning| terminal.warn(warning));
    let turn = look.environment.rotation.to_radians();
    let turned =
        |map: &Arc<Equirect>| if turn == 0.0 { Arc::clone(map) } else { Arc::new(map.rotated(turn)) };
    Ok(GivenEnvironment {
        whole: turned(surroundings.whole_map()),
        fitted: turned(surroundings.map()),
        taken_out: surroundings.lights().iter().map(|light| light.rotated(turn)).collect(),
        factor: look.environment.grade().light,
    })
}

/// What an environment may be, for help texts.
pub fn environment_help() -> String {
    let formats = picture::formats().iter().map(|format| format.extensions[0]).collect::<Vec<_>>();
    format!("Environment map ({}), or a built-in one: {}", formats.join(", "), builtin_names())
}

/// Names of the built-in environments, for people.
pub fn builtin_names() -> String {
    builtin::names().collect::<Vec<_>>().join(", ")
}
