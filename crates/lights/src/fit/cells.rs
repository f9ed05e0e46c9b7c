use gnomon_envmap::Equirect;

use super::cuts::cut_faces;
use super::error::check_map;
use super::faces::Faces;
use super::{FitError, FitOptions};
use crate::DistantLight;

/// Texels along a face's edge.
const FACE_SIZE: usize = 32;
/// Largest width and height of a cell [rad], where there are enough cells for it: four a face.
const MAX_EXTENT: f64 = std::f64::consts::FRAC_PI_4 + 1e-6;
const LEAST_FOR_EXTENT: usize = 24;

/// Divides a map, as the residual of a fit, into at most `count` wide lights (6 to [`super::MAX_LIGHTS`]) that together
/// cover all of the sphere that is not black. Each carries exactly the flux, with its colour, of its part of the map, and
/// from 24 lights on none is wider or higher than an eighth of a turn.
///
/// # Errors
/// A count out of range, a map without texels or with some that are no radiance.
pub fn cells(map: &Equirect, count: usize) -> Result<Vec<DistantLight>, FitError> {
    let options = FitOptions { light_count: Some(count), ..FitOptions::default() };
    options.validate()?;
    options.validate_tiling("cells")?;
    check_map(map)?;
    let faces = Faces::new(map, FACE_SIZE);
    let max_extent = if count < LEAST_FOR_EXTENT { f64::INFINITY } else { MAX_EXTENT };
    let lights = cut_faces(&faces, count, max_extent)
        .into_iter()
        .map(|cell| faces.light(cell.face, cell.rect, faces.rect_flux(cell.face, cell.rect)));
    Ok(lights.filter(|light| light.radiance.max_element() > 0.0).collect())
}
