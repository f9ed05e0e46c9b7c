//! What the ambient rest of a fit does about shadows, side by side on one interface: it may become lights of its own.

use gnomon_envmap::Equirect;
use gnomon_lights::{DistantLight, FitOptions, LightSet, fit};
use gnomon_options::Choice;
use gnomon_picture::RgbImage;

use crate::RenderError;

/// A way to shadow the ambient rest.
#[derive(Debug, PartialEq, Eq)]
pub struct Ambient {
    /// Name for people and files.
    pub name: &'static str,
    /// One line for help texts.
    pub summary: &'static str,
    method: Method,
}

#[derive(Debug, PartialEq, Eq)]
enum Method {
    Unshadowed,
    Occlusion,
    Cells,
}

/// Every way.
pub const AMBIENTS: &[Ambient] = &[
    Ambient {
        name: "cells",
        summary: "wide lights that tile the rest, each with its own shadow: occlusion with a direction",
        method: Method::Cells,
    },
    Ambient {
        name: "occlusion",
        summary: "the rest times the cosine-weighted share of the sky that is open",
        method: Method::Occlusion,
    },
    Ambient { name: "unshadowed", summary: "the rest as it is (Arbree 2005)", method: Method::Unshadowed },
];

/// The same as choices of an option.
pub(crate) fn choices() -> Vec<Choice> {
    AMBIENTS.iter().map(|ambient| Choice { name: ambient.name, summary: ambient.summary }).collect()
}

/// The way called `name`.
///
/// # Errors
/// [`RenderError::UnknownName`] lists the names there are.
pub fn by_name(name: &str) -> Result<&'static Ambient, RenderError> {
    AMBIENTS.iter().find(|ambient| ambient.name == name).ok_or_else(|| RenderError::UnknownName {
        what: "ambient shadows",
        name: name.to_owned(),
        choices: AMBIENTS.iter().map(|ambient| ambient.name).collect::<Vec<_>>().join(", "),
    })
}

/// Share of the flux below which a residual is not worth maps of its own.
const NEGLIGIBLE: f64 = 1e-6;

/// A light set with the lights that its ambient rest asks for.
pub(crate) struct AmbientLights {
    /// Lights that light.
    pub lights: Vec<DistantLight>,
    /// So many of them are the fit's own, those in front.
    pub of_fit: usize,
    /// Lights whose visibility alone is asked for; their radiance is 1 everywhere.
    pub probes: Vec<DistantLight>,
    /// What stays ambient.
    pub residual: Equirect,
    /// Both of the set.
    pub omits_hidden: bool,
    pub stands_alone: bool,
    /// Of the set.
    pub taken_out: usize,
}

impl Ambient {
    /// Turns the residual of `set` into at most `cells` lights or probes.
    pub(crate) fn lights(&self, set: &LightSet, cells: usize) -> Result<AmbientLights, RenderError> {
        let mut lights = set.lights.clone();
        let of_fit = lights.len();
        let mut probes = Vec::new();
        let mut residual = set.residual.clone();
        let luminance = |flux: glam::DVec3| flux.dot(gnomon_picture::LUMINANCE.as_dvec3());
        let rest = luminance(residual.flux());
        let negligible = rest <= NEGLIGIBLE * (rest + luminance(lights.iter().map(DistantLight::flux).sum()));
        let tiled = |map: &Equirect| {
            let options = FitOptions { light_count: Some(cells), ..FitOptions::default() };
            fit::cells(map, &options).map_err(|error| RenderError::OutOfRange {
                what: "cells of the ambient rest",
                range: format!("what can be tiled ({error})"),
                value: cells.to_string(),
            })
        };
        if !negligible {
            match self.method {
                Method::Unshadowed => {}
                Method::Occlusion => {
                    let white = RgbImage::filled(residual.width(), residual.height(), glam::Vec3::ONE);
                    probes = tiled(&Equirect::new(white))?;
                }
                Method::Cells => {
                    lights.extend(tiled(&residual)?);
                    residual = Equirect::new(RgbImage::filled(
                        residual.width(),
                        residual.height(),
                        glam::Vec3::ZERO,
                    ));
                }
            }
        }
        let LightSet { omits_hidden, stands_alone, taken_out, .. } = *set;
        Ok(AmbientLights { lights, of_fit, probes, residual, omits_hidden, stands_alone, taken_out })
    }
}
