use glam::DVec3;
use gnomon_envmap::Equirect;
use rayon::prelude::*;
use serde_json::{Map, Value, json};

use super::error::check_map;
use super::faces::{Faces, TexelRect, luminance};
use super::growth::{Growth, ROUNDING, luminous, take};
use super::options::Stop;
use super::{FitError, FitOptions, LightFit};
use crate::{DistantLight, LightSet};

pub(super) const SUMMARY: &str = "rectangles grown on cube faces until they hold the whole map (Annen 2008)";
pub(super) const SUMMARY_SQUARES: &str =
    "squares grown on cube faces until they hold the whole map (Annen 2008)";

/// Texels along a face's edge. On 32 texels the thresholds of the paper's figure 10 (0.015, 0.025, 0.035) give 33, 50 and
/// 75 squares or 26, 49 and 69 rectangles on its map, where it reports 30, 45 and 60; on 64 texels there are twice as many.
/// Six of ours hold the residue, which the paper does not mention again.
const FACE_SIZE: usize = 32;
/// Number of lights unless told otherwise: as many as in the paper's best pictures.
const LIGHT_COUNT: usize = 60;
/// Least allowed `max_extent` [rad]: it takes some 1500 lights to cover the sphere.
pub(super) const LEAST_EXTENT: f32 = 0.1;
/// Thresholds between which the one for a number of lights is searched.
const SEARCH: (f64, f64) = (1e-5, 0.97);
/// Halvings of that range's logarithm: steps of about one in 10^5.
const SEARCH_STEPS: usize = 20;

/// What a light's outline is on its cube face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outline {
    /// Each side grows on its own.
    Rectangle,
    /// A corner grows: one row and one column at once.
    Square,
}

/// Uniform rectangles or squares on cube faces that hold all of the map's flux (Annen et al. 2008, section 4.2): the
/// residual is black.
///
/// A light starts as the texel of most energy and grows by a row or column at a time, while what that adds is more than
/// a share `t` of the grown light; then its energy is taken out of the face, except for a residue at the face's mean
/// radiance. Lights start on texels that none covers yet, until all are covered; one that holds no more than the mean
/// takes all it has. What residue is left becomes one light a face (with `max_extent`, a grid of them).
///
/// A larger `t` gives more lights. For a `light_count` (60 unless told otherwise) `t` is found by bisection.
#[derive(Clone, Debug)]
pub struct Rectangles {
    outline: Outline,
    stop: Stop,
    max_extent: Option<f32>,
}

pub(super) fn build_rectangles(options: &FitOptions) -> Result<Box<dyn LightFit>, FitError> {
    Ok(Box::new(Rectangles::new(Outline::Rectangle, options)?))
}

pub(super) fn build_squares(options: &FitOptions) -> Result<Box<dyn LightFit>, FitError> {
    Ok(Box::new(Rectangles::new(Outline::Square, options)?))
}

impl Rectangles {
    /// `threshold` is the paper's `t`. `light_count` (at least 6) is met from below, as nearly as one `t` for all faces
    /// allows; where even the smallest `t` gives more, that set is the result. `max_extent` [rad] bounds the angular
    /// length of every light's sides.
    pub fn new(outline: Outline, options: &FitOptions) -> Result<Self, FitError> {
        options.validate()?;
        options.validate_tiling(name(outline))?;
        options.refuse_sampler(name(outline))?;
        let stop = match (options.light_count, options.threshold) {
            (Some(count), _) => Stop::Count(count),
            (None, Some(threshold)) => Stop::Threshold(threshold),
            (None, None) => Stop::Count(LIGHT_COUNT),
        };
        Ok(Self { outline, stop, max_extent: options.max_extent })
    }

    /// The paper's procedure, face by face.
    fn until_covered(&self, faces: &Faces, threshold: f64) -> Vec<DistantLight> {
        let max_extent = self.max_extent.map_or(f64::INFINITY, f64::from);
        let growth = Growth { outline: self.outline, threshold, max_extent };
        let lights = (0..6).into_par_iter().flat_map_iter(|face| cover_face(faces, face, growth));
        lights.filter(|light| light.radiance.max_element() > 0.0).collect()
    }

    /// The set of most lights among those of at most `count` that a bisection of the threshold meets.
    fn of_count(&self, faces: &Faces, count: usize) -> (f64, Vec<DistantLight>) {
        let (mut low, mut high) = (SEARCH.0.ln(), SEARCH.1.ln());
        let mut best = (SEARCH.0, self.until_covered(faces, SEARCH.0));
        for _ in 0..SEARCH_STEPS {
            if best.1.len() >= count {
                break;
            }
            let middle = 0.5 * (low + high);
            let lights = self.until_covered(faces, middle.exp());
            if lights.len() > count {
                high = middle;
                continue;
            }
            low = middle;
            if lights.len() > best.1.len() {
                best = (middle.exp(), lights);
            }
        }
        best
    }
}

/// Lights of one face, those of its residue last.
fn cover_face(faces: &Faces, face: usize, growth: Growth) -> Vec<DistantLight> {
    let mean = faces.mean_radiance(face);
    let mut left = faces.one_face(face);
    let mut covered = vec![false; left.solid_angle.len()];
    let original = luminous(faces, face);
    let mut flux = original.clone();
    let mut lights = Vec::new();
    while let Some(seed) = hottest(&flux, |texel| !covered[texel]) {
        if flux[seed] <= 0.0 {
            break;
        }
        let rect = growth.grow(&left, &flux, &original, seed);
        let residue = if is_above(&left, face, rect, mean) { mean } else { DVec3::ZERO };
        let taken = take(&mut left, face, rect, residue);
        for texel in rect.texels(left.size) {
            covered[texel] = true;
            flux[texel] = luminance(left.flux[face][texel]);
        }
        lights.push(left.light(face, rect, taken));
    }
    // The residue, in as few parts as the largest extent allows; equal steps are widest in angle at the centre.
    let parts = if growth.max_extent < std::f64::consts::FRAC_PI_2 {
        (1.0 / (0.5 * growth.max_extent).tan()).ceil() as usize + 1
    } else {
        1
    };
    let edge = |part: usize| part * left.size / parts;
    for (column, row) in (0..parts * parts).map(|part| (part % parts, part / parts)) {
        let rect = TexelRect { min: [edge(column), edge(row)], max: [edge(column + 1), edge(row + 1)] };
        lights.push(left.light(face, rect, left.rect_flux(face, rect)));
    }
    lights
}

/// Whether a rectangle's luminous flux exceeds that of a uniform `radiance`, beyond rounding.
pub(super) fn is_above(faces: &Faces, face: usize, rect: TexelRect, radiance: DVec3) -> bool {
    let solid_angle: f64 = rect.texels(faces.size).map(|texel| faces.solid_angle[texel]).sum();
    luminance(faces.rect_flux(face, rect)) > (1.0 + ROUNDING) * luminance(radiance) * solid_angle
}

/// The allowed texel of most flux; the first of equals.
pub(super) fn hottest(flux: &[f64], allowed: impl Fn(usize) -> bool) -> Option<usize> {
    (0..flux.len())
        .filter(|texel| allowed(*texel))
        .reduce(|best, texel| if flux[texel] > flux[best] { texel } else { best })
}

fn name(outline: Outline) -> &'static str {
    match outline {
        Outline::Rectangle => "rectangles",
        Outline::Square => "squares",
    }
}

impl LightFit for Rectangles {
    fn name(&self) -> &'static str {
        name(self.outline)
    }

    fn parameters(&self) -> Map<String, Value> {
        let mut parameters = Map::new();
        self.stop.insert_into(&mut parameters);
        parameters.insert("face_size".into(), json!(FACE_SIZE));
        parameters.insert("max_extent".into(), json!(self.max_extent));
        parameters
    }

    fn fit(&self, map: &Equirect) -> Result<LightSet, FitError> {
        check_map(map)?;
        let faces = Faces::new(map, FACE_SIZE);
        let mut parameters = self.parameters();
        let lights = match self.stop {
            Stop::Threshold(threshold) => self.until_covered(&faces, f64::from(threshold)),
            Stop::Count(count) => {
                let (threshold, lights) = self.of_count(&faces, count);
                parameters.insert("threshold".into(), json!(threshold));
                lights
            }
        };
        Ok(LightSet::without_residual(self.name(), parameters, lights, map))
    }
}
