use gnomon::envmap::{Equirect, Projection, builtin};
use gnomon::studio::{self, EnvironmentLook, environment_named};
use gnomon_terminal::Terminal;

use crate::error::CliError;

/// Reads or makes the environment that the command line names, and turns it about +y [degrees]. What had to be repaired is told as
/// warnings.
///
/// # Errors
/// Unreadable files, pictures of no known layout, names of nothing.
pub fn load_environment(
    name: &str,
    projection: Option<Projection>,
    rotation_degrees: f32,
    terminal: Terminal,
) -> Result<Equirect, CliError> {
    let look = EnvironmentLook {
        source: Some(environment_named(name)),
        projection: projection.map(|projection| projection.name().to_owned()),
        ..EnvironmentLook::default()
    };
    let (map, warnings) = studio::load_environment(&look)?;
    warnings.iter().for_each(|warning| terminal.warn(warning));
    Ok(if rotation_degrees == 0.0 { map } else { map.rotated(rotation_degrees.to_radians()) })
}

/// Names of the built-in environments, for people.
pub fn builtin_names() -> String {
    builtin::names().collect::<Vec<_>>().join(", ")
}
