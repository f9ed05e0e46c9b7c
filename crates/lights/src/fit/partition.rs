use glam::Vec3;
use gnomon_envmap::Equirect;
use gnomon_image::RgbImage;
use rayon::prelude::*;
use serde_json::{Map, Value, json};

use super::cuts::cut_faces;
use super::error::check_map;
use super::faces::{Faces, TexelRect, luminance};
use super::growth::{Growth, ROUNDING, luminous, take};
use super::rectangles::{Outline, hottest, is_above};
use super::{FitError, FitOptions, LightFit};
use crate::{DistantLight, LightSet};

pub(super) const SUMMARY: &str =
    "bright peaks, and rectangles that divide the rest of the map where partly hidden lights err most";

/// Texels along a face's edge.
const FACE_SIZE: usize = 64;
/// Growth threshold for peaks: at texels half as wide as the paper's, a strip of the same light is half the share.
const PEAK_THRESHOLD: f64 = 0.04;
/// Number of lights unless told otherwise.
const LIGHT_COUNT: usize = 60;

/// Uniform rectangles on cube faces that hold all of the map's flux: the residual is black. Half of the lights, the
/// strongest peaks above their face's mean, come from growth as in [`super::Rectangles`]; the rest divides what remains,
/// face by face, where cuts reduce the error of partly hidden lights most.
#[derive(Clone, Debug)]
pub struct Partition {
    light_count: usize,
    max_extent: Option<f32>,
}

pub(super) fn build(options: &FitOptions) -> Result<Box<dyn LightFit>, FitError> {
    Ok(Box::new(Partition::new(options)?))
}

impl Partition {
    /// `light_count` (at least 6) is met exactly, unless the map has less to divide; `max_extent` [rad] bounds the angular
    /// length of every light's sides, if need be with more lights than asked for. There is no threshold.
    pub fn new(options: &FitOptions) -> Result<Self, FitError> {
        options.validate()?;
        options.validate_tiling("partition")?;
        if options.threshold.is_some() {
            return Err(FitError::NoThreshold("partition"));
        }
        Ok(Self { light_count: options.light_count.unwrap_or(LIGHT_COUNT), max_extent: options.max_extent })
    }

    /// The strongest peaks, then a partition of the rest.
    fn lights(&self, map: &Equirect) -> Vec<DistantLight> {
        let count = self.light_count;
        let mut faces = Faces::new(map, FACE_SIZE);
        let max_extent = self.max_extent.map_or(f64::INFINITY, f64::from);
        let growth = Growth { outline: Outline::Rectangle, threshold: PEAK_THRESHOLD, max_extent };
        let mut peaks: Vec<Peak> =
            (0..6).into_par_iter().flat_map_iter(|face| face_peaks(&faces, face, growth)).collect();
        peaks.sort_by(|a, b| b.luminous_flux.total_cmp(&a.luminous_flux));
        let lit = (0..6).filter(|face| luminance(faces.mean_radiance(*face)) > 0.0).count();
        peaks.truncate((count / 2).min(count - lit));
        let mut lights = Vec::new();
        let means: Vec<_> = (0..6).map(|face| faces.mean_radiance(face)).collect();
        for peak in &peaks {
            // A stronger peak may have had it all.
            if !is_above(&faces, peak.face, peak.rect, means[peak.face]) {
                continue;
            }
            let flux = take(&mut faces, peak.face, peak.rect, means[peak.face]);
            lights.push(faces.light(peak.face, peak.rect, flux));
        }
        for cell in cut_faces(&faces, count - lights.len(), max_extent) {
            lights.push(faces.light(cell.face, cell.rect, faces.rect_flux(cell.face, cell.rect)));
        }
        lights
    }
}

/// A bright patch of a face.
struct Peak {
    face: usize,
    rect: TexelRect,
    /// What it has above the residue.
    luminous_flux: f64,
}

/// All lights of a face that hold more than its mean.
fn face_peaks(faces: &Faces, face: usize, growth: Growth) -> Vec<Peak> {
    let residue = luminance(faces.mean_radiance(face));
    let mut covered = vec![false; faces.solid_angle.len()];
    let original = luminous(faces, face);
    let mut flux = original.clone();
    let mut peaks = Vec::new();
    while let Some(seed) = hottest(&flux, |texel| !covered[texel]) {
        if flux[seed] <= (1.0 + ROUNDING) * residue * faces.solid_angle[seed] {
            break;
        }
        let rect = growth.grow(faces, &flux, &original, seed);
        let total: f64 = rect.texels(faces.size).map(|texel| flux[texel]).sum();
        let solid_angle: f64 = rect.texels(faces.size).map(|texel| faces.solid_angle[texel]).sum();
        let above = total - (1.0 + ROUNDING) * residue * solid_angle;
        for texel in rect.texels(faces.size) {
            covered[texel] = true;
            if above > 0.0 {
                flux[texel] = residue * faces.solid_angle[texel];
            }
        }
        if above > 0.0 {
            peaks.push(Peak { face, rect, luminous_flux: above });
        }
    }
    peaks
}

impl LightFit for Partition {
    fn name(&self) -> &'static str {
        "partition"
    }

    fn parameters(&self) -> Map<String, Value> {
        let mut parameters = Map::new();
        parameters.insert("light_count".into(), json!(self.light_count));
        parameters.insert("face_size".into(), json!(FACE_SIZE));
        parameters.insert("peak_threshold".into(), json!(PEAK_THRESHOLD));
        parameters.insert("max_extent".into(), json!(self.max_extent));
        parameters
    }

    fn fit(&self, map: &Equirect) -> Result<LightSet, FitError> {
        check_map(map)?;
        let mut lights = self.lights(map);
        lights.retain(|light| light.radiance.max_element() > 0.0);
        let residual = Equirect::new(RgbImage::filled(map.width(), map.height(), Vec3::ZERO));
        Ok(LightSet { method: self.name(), parameters: self.parameters(), lights, residual })
    }
}
