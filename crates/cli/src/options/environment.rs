use std::path::Path;

use gnomon::envmap::{Equirect, Projection, builtin, load};

use crate::error::CliError;
use crate::terminal::Terminal;

/// An environment before it is read.
#[derive(Clone, Debug)]
pub struct EnvironmentSpec {
    /// A file, or else the name of a built-in environment.
    pub name: String,
    /// Layout of the file, where it must be forced.
    pub projection: Option<Projection>,
    /// Turn about +y by the right-hand rule [degrees].
    pub rotation_degrees: f32,
}

impl EnvironmentSpec {
    /// The file or built-in of that name as it is.
    pub fn named(name: &str) -> Self {
        Self { name: name.to_owned(), projection: None, rotation_degrees: 0.0 }
    }
}

/// Reads or makes the environment and turns it. What had to be repaired is told as warnings.
///
/// # Errors
/// Unreadable files, pictures of no known layout, names of nothing.
pub fn load_environment(spec: &EnvironmentSpec, terminal: Terminal) -> Result<Equirect, CliError> {
    let map = match builtin::by_name(&spec.name) {
        // A file beside us may bear the name of a built-in; whoever means it writes ./room.
        Some(map) => map,
        None => {
            let environment = load(Path::new(&spec.name), spec.projection).map_err(|error| {
                if Path::new(&spec.name).exists() {
                    CliError::from(error)
                } else {
                    CliError::usage(format!(
                        "there is no environment '{}': no such file, and the built-in ones are {}",
                        spec.name,
                        builtin_names()
                    ))
                }
            })?;
            for warning in environment.warnings() {
                terminal.warn(&format!("{}: {warning}", spec.name));
            }
            environment.map
        }
    };
    Ok(if spec.rotation_degrees == 0.0 { map } else { map.rotated(spec.rotation_degrees.to_radians()) })
}

/// Names of the built-in environments, for people.
pub fn builtin_names() -> String {
    builtin::names().collect::<Vec<_>>().join(", ")
}
