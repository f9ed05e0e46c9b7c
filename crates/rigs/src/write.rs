//! A rig and its maps, as files.

use std::io;
use std::path::{Path, PathBuf};

use glam::Vec3;
use gnomon_envmap::Equirect;
use gnomon_lights::LightSet;
use gnomon_messages::quoted;
use gnomon_picture::{ImageError, atomic};
use thiserror::Error;

use crate::{FarShape, Reflections, Rig, Target};

/// Why a rig is not there.
#[derive(Debug, Error)]
pub enum RigError {
    /// A file name that other files cannot name.
    #[error("cannot write {}: a rig's maps are named after it, so that its name must be text", path.display())]
    Name {
        /// The file.
        path: PathBuf,
    },
    /// A map could not be written.
    #[error(transparent)]
    Map(#[from] ImageError),
    /// The rig could not be written.
    #[error("cannot write {}: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
}

/// What [`write`] has written.
#[derive(Clone, Debug, PartialEq)]
pub struct Written {
    /// Files of maps beside the rig.
    pub maps: Vec<PathBuf>,
    /// What the program cannot show of it, a line each.
    pub warnings: Vec<String>,
}

/// Writes the lights of `map` for a program: the file itself, and beside it, named after it, the maps `_residual` and `_environment`, the
/// whole one, as far as it needs them. Maps come first, and no file is left half-written. `about` says what the rig is of, for a comment.
///
/// # Errors
/// [`RigError`].
pub fn write(
    target: &Target,
    path: &Path,
    map: &Equirect,
    set: &LightSet,
    about: &[String],
) -> Result<Written, RigError> {
    let stem = path.file_stem().and_then(|stem| stem.to_str());
    let stem = stem.ok_or_else(|| RigError::Name { path: path.to_owned() })?;
    let is_black = set.residual.radiance().texels().iter().all(|texel| *texel == Vec3::ZERO);
    let named = |what: &str| format!("{stem}_{what}.{}", target.map_extension);
    let residual = (!is_black).then(|| named("residual"));
    let has_whole = match target.reflections {
        Reflections::OwnMap => is_black,
        Reflections::LightsBeforeMap => true,
        _ => false,
    };
    let whole = has_whole.then(|| named("environment"));
    let mut maps = Vec::new();
    for (file, map) in [(&residual, &set.residual), (&whole, map)] {
        if let Some(file) = file {
            let path = path.with_file_name(file);
            gnomon_picture::write(&path, map.radiance())?;
            maps.push(path);
        }
    }
    let mut about: Vec<String> = about.iter().map(|line| quoted(line)).collect();
    about.push(
        match (is_black, target.reflections) {
            (false, _) => "The map holds what the lights leave: it belongs to them at the same scale.",
            (true, Reflections::OwnMap) => {
                "The lights leave nothing: the map is the whole one, for mirrors and the camera alone."
            }
            (true, Reflections::Lights | Reflections::LightsBeforeMap) => {
                "The lights leave nothing: mirrors show them."
            }
            (true, _) => "The lights leave nothing: there is no map.",
        }
        .to_owned(),
    );
    let rig = Rig { about, set, map, residual, whole };
    let text = target.text(&rig);
    atomic::write::<io::Error>(path, |file| file.write_all(text.as_bytes()))
        .map_err(|source| RigError::Write { path: path.to_owned(), source })?;
    Ok(Written { maps, warnings: warnings(target, &rig, is_black) })
}

fn warnings(target: &Target, rig: &Rig, is_black: bool) -> Vec<String> {
    let name = target.name;
    let count = rig.set.lights.len();
    let mut warnings = Vec::new();
    if !target.loses.is_empty() {
        warnings.push(format!("{name}: {}", target.loses));
    }
    if let Some(most) = target.most_lights.filter(|most| count > *most) {
        warnings.push(format!("{name} draws {most} lights at most, and these are {count}: ask for fewer"));
    }
    if is_black && target.reflections == Reflections::Ambient {
        let method = rig.set.method;
        warnings
            .push(format!("{name} mirrors what lights leave, and {method} leave nothing: disks leave a map"));
    }
    let areas = target.reflections == Reflections::Lights && target.loses.is_empty();
    let inexact = rig.set.lights.iter().filter(|light| areas && !FarShape::of(light).is_exact).count();
    if inexact > 0 {
        warnings.push(format!("{name}: {inexact} of {count} outlines are no rectangles and become some"));
    }
    warnings
}
