use glam::DVec3;
use gnomon_envmap::Equirect;
use rayon::prelude::*;
use serde_json::{Map, Value, json};

use super::error::check_map;
use super::faces::luminance;
use super::options::Stop;
use super::sphere_grid::{RowInterval, SphereGrid, cone_coverage};
use super::{FitError, FitOptions, LightFit};
use crate::{DistantLight, LightSet};

pub(super) const SUMMARY: &str =
    "bright disks found by a centre-surround filter; the rest stays ambient (Arbree 2005)";

/// Number of filter sizes (section 3).
const SIZES: usize = 20;
/// Angular extent [degrees] of the smallest and largest filter (section 3).
const EXTENT_DEGREES: (f64, f64) = (4.5, 45.0);
/// Inner radius over outer radius (figure 1).
const INNER: f64 = 0.75;
/// Weight of the ring against +1 for the inner disk (figure 1).
const RING_WEIGHT: f64 = 10.0;
/// Share of the texels that may become a light's centre (section 3).
const CANDIDATES: f64 = 0.1;
/// A light below this share of the flux of all before it ends the search (Weber's law).
const WEBER: f32 = 0.02;
/// Responses this close, relative to the map's flux, count as equal.
const TIE: f64 = 1e-10;
/// Least and most columns of the grid on which candidates compete, and most of the one on which the winner is placed.
const COARSE_WIDTH: (usize, usize) = (128, 256);
const FINE_WIDTH: usize = 1024;

/// Disk lights by a centre-surround filter on the sphere (Arbree, Walter and Bala 2005, section 3).
///
/// Where the paper leaves a choice, these readings give 8, 8, 4 and 18 lights on its four maps (the paper: 8, 10, 4, 17):
/// the *angular extent* of a filter is the full apex angle of its **outer** cone, so lights are 1.7 to 16.9 degrees in
/// radius; the twenty sizes are spaced geometrically; the filter **sums** flux, and the sum is divided by the extent;
/// candidates are the texels of highest radiance in the original map. Spacing and choice of candidates hardly matter.
/// With the extent as the outer *radius* the counts are 8, 6, 3, 16, but Grace's six lights cover whole walls and
/// windows with 66 % of the flux; a filter of *means* prefers tiny lights and stops early (3 on Grace, 1 on Kitchen).
#[derive(Clone, Debug)]
pub struct Disks {
    stop: Stop,
    sizes: Vec<FilterSize>,
}

/// One filter: angles in radians.
#[derive(Clone, Copy, Debug)]
struct FilterSize {
    extent: f64,
    outer_radius: f64,
    inner_radius: f64,
}

pub(super) fn build(options: &FitOptions) -> Result<Box<dyn LightFit>, FitError> {
    Ok(Box::new(Disks::new(options)?))
}

impl Disks {
    /// `threshold` is the share of the flux of all earlier lights below which a light ends the search (0.02);
    /// `light_count` asks for exactly so many, as long as the map has flux; `max_extent` [rad] leaves out filters whose
    /// light would be wider.
    pub fn new(options: &FitOptions) -> Result<Self, FitError> {
        options.validate()?;
        options.refuse_sampler("disks")?;
        let ratio = EXTENT_DEGREES.1 / EXTENT_DEGREES.0;
        let mut sizes: Vec<FilterSize> = (0..SIZES)
            .map(|i| {
                let extent = (EXTENT_DEGREES.0 * ratio.powf(i as f64 / (SIZES - 1) as f64)).to_radians();
                FilterSize { extent, outer_radius: 0.5 * extent, inner_radius: 0.5 * INNER * extent }
            })
            .collect();
        if let Some(given) = options.max_extent {
            let least = (INNER * EXTENT_DEGREES.0.to_radians()) as f32 * 1.0001;
            if !(given >= least && given <= std::f32::consts::PI) {
                return Err(FitError::MaxExtent { method: "disks", given, least });
            }
            sizes.retain(|size| 2.0 * size.inner_radius <= f64::from(given));
        }
        let stop = match options.light_count {
            Some(count) => Stop::Count(count),
            None => Stop::Threshold(options.threshold.unwrap_or(WEBER)),
        };
        Ok(Self { stop, sizes })
    }
}

impl LightFit for Disks {
    fn name(&self) -> &'static str {
        "disks"
    }

    fn parameters(&self) -> Map<String, Value> {
        let mut parameters = Map::new();
        self.stop.insert_into(&mut parameters);
        let degrees = self.sizes.iter().map(|size| size.extent.to_degrees());
        parameters.insert("filter_extents_degrees".into(), json!(degrees.collect::<Vec<_>>()));
        parameters.insert("inner_to_outer_radius".into(), json!(INNER));
        parameters.insert("ring_weight".into(), json!(-RING_WEIGHT));
        parameters.insert("candidate_share".into(), json!(CANDIDATES));
        parameters
    }

    fn fit(&self, map: &Equirect) -> Result<LightSet, FitError> {
        check_map(map)?;
        let mut search = Search::new(map, &self.sizes);
        let mut residual = map.clone().into_radiance();
        let mut lights: Vec<DistantLight> = Vec::new();
        let mut luminous_sum = 0.0;
        while let Some((centre, radius)) = search.best(matches!(self.stop, Stop::Count(_))) {
            let (width, height) = (map.width() as usize, map.height() as usize);
            let covered = cone_coverage(width, height, centre, radius);
            let mut flux = DVec3::ZERO;
            for part in &covered {
                let texel = residual.get(part.column as u32, part.row as u32);
                let left = texel * (1.0 - part.share) as f32;
                flux += (texel.as_dvec3() - left.as_dvec3()) * map.texel_solid_angle(part.row as u32);
            }
            let luminous = luminance(flux);
            if let Stop::Threshold(share) = self.stop
                && luminous < f64::from(share) * luminous_sum
            {
                break;
            }
            for part in &covered {
                *residual.get_mut(part.column as u32, part.row as u32) *= (1.0 - part.share) as f32;
            }
            search.remove(centre, radius);
            luminous_sum += luminous;
            lights.push(DistantLight::disk(centre, radius, flux));
            if let Stop::Count(count) = self.stop
                && lights.len() >= count
            {
                break;
            }
        }
        Ok(LightSet {
            method: self.name(),
            parameters: self.parameters(),
            lights,
            residual: Equirect::new(residual),
            omits_hidden: false,
            stands_alone: false,
            taken_out: 0,
        })
    }
}

/// A place where a light may be centred, with the flux in the disk and ring of every filter size.
struct Candidate {
    column: usize,
    row: usize,
    direction: DVec3,
    fluxes: Vec<FilterFlux>,
}

#[derive(Clone, Copy, Default)]
struct FilterFlux {
    inner: f64,
    ring: f64,
}

/// Rows of one filter around a centre in one grid row.
struct FilterRows {
    inner: Vec<RowInterval>,
    outer: Vec<RowInterval>,
}

impl FilterRows {
    fn new(grid: &SphereGrid, row: usize, size: &FilterSize) -> Self {
        Self { inner: grid.cone(row, size.inner_radius), outer: grid.cone(row, size.outer_radius) }
    }

    fn flux(&self, grid: &SphereGrid, column: usize) -> FilterFlux {
        let inner = grid.cone_flux(column, &self.inner);
        FilterFlux { inner, ring: grid.cone_flux(column, &self.outer) - inner }
    }
}

/// Filter responses over the remaining map. All sizes and candidates compete on a coarse grid; the winner is then
/// placed to a fraction of a coarse cell on a fine one. After a removal only filters that reach it are run again.
struct Search<'a> {
    sizes: &'a [FilterSize],
    coarse: SphereGrid,
    fine: SphereGrid,
    total: f64,
    candidates: Vec<Candidate>,
    /// Ring weight; lowered only where a count is asked for that the paper's filter cannot reach.
    ring_weight: f64,
}

impl<'a> Search<'a> {
    fn new(map: &Equirect, sizes: &'a [FilterSize]) -> Self {
        // No more columns than the map's, where it has enough: candidates within one texel would tie.
        let coarse_width = (map.width() as usize).clamp(COARSE_WIDTH.0, COARSE_WIDTH.1);
        let fine_width = (map.width() as usize).clamp(COARSE_WIDTH.1, FINE_WIDTH);
        let coarse = SphereGrid::from_map(map, coarse_width, coarse_width / 2);
        let fine = SphereGrid::from_map(map, fine_width, fine_width / 2);
        let total = coarse.total();
        let mut search =
            Self { sizes, coarse, fine, total, candidates: Vec::new(), ring_weight: RING_WEIGHT };
        search.choose_candidates();
        search
    }

    /// The brightest tenth of the cells by radiance.
    fn choose_candidates(&mut self) {
        let grid = &self.coarse;
        let mut cells: Vec<(f64, usize)> = (0..grid.width * grid.height)
            .map(|cell| (grid.radiance(cell % grid.width, cell / grid.width), cell))
            .collect();
        let count = ((cells.len() as f64 * CANDIDATES) as usize).max(1);
        cells.select_nth_unstable_by(count - 1, |a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        cells.truncate(count);
        cells.sort_unstable_by_key(|&(_, cell)| cell);
        self.candidates = cells
            .into_iter()
            .map(|(_, cell)| {
                let (column, row) = (cell % grid.width, cell / grid.width);
                let fluxes = vec![FilterFlux::default(); self.sizes.len()];
                Candidate { column, row, direction: grid.direction(column, row), fluxes }
            })
            .collect();
        self.run_filters(|_, _| true);
    }

    /// Runs the filters that `concerns(candidate direction, size)`.
    fn run_filters(&mut self, concerns: impl Fn(DVec3, &FilterSize) -> bool + Sync) {
        let (grid, sizes) = (&self.coarse, self.sizes);
        // One run a grid row: its candidates share the cones' shapes.
        let mut rows: Vec<&mut [Candidate]> = self.candidates.chunk_by_mut(|a, b| a.row == b.row).collect();
        rows.par_iter_mut().for_each(|row| {
            for (index, size) in sizes.iter().enumerate() {
                let mut shape = None;
                for candidate in row.iter_mut().filter(|candidate| concerns(candidate.direction, size)) {
                    let shape = shape.get_or_insert_with(|| FilterRows::new(grid, candidate.row, size));
                    candidate.fluxes[index] = shape.flux(grid, candidate.column);
                }
            }
        });
    }

    fn response(&self, flux: FilterFlux, size: &FilterSize) -> f64 {
        (flux.inner - self.ring_weight * flux.ring) / size.extent
    }

    /// Centre and radius [rad] of the disk of highest positive response. `insist` keeps looking where the paper's filter
    /// finds nothing: among new candidates first, then with a lighter ring.
    fn best(&mut self, insist: bool) -> Option<(DVec3, f64)> {
        let mut renewed = false;
        loop {
            if let Some((candidate, size)) = self.best_candidate() {
                return Some(self.placed(candidate, size));
            }
            if !insist || self.coarse.total() <= TIE * self.total {
                return None;
            }
            if !renewed {
                self.choose_candidates();
                renewed = true;
            } else if self.ring_weight > 0.0 {
                // At weight 0 any disk with flux responds.
                self.ring_weight = if self.ring_weight > 1.0 { 0.5 * self.ring_weight } else { 0.0 };
            } else {
                return None;
            }
        }
    }

    fn best_candidate(&self) -> Option<(usize, usize)> {
        let mut best = Best::new(TIE * self.total);
        for (index, candidate) in self.candidates.iter().enumerate() {
            for (size, (flux, filter)) in candidate.fluxes.iter().zip(self.sizes).enumerate() {
                let response = self.response(*flux, filter);
                best.offer(response, || self.coarse.radiance(candidate.column, candidate.row), (index, size));
            }
        }
        best.place
    }

    /// The winner again on the fine grid: nearby centres, neighbouring sizes.
    fn placed(&self, candidate: usize, size: usize) -> (DVec3, f64) {
        let candidate = &self.candidates[candidate];
        let grid = &self.fine;
        let scale = grid.width as f64 / self.coarse.width as f64;
        // The candidate's own cell and half of its neighbours.
        let span = |cell: usize| {
            let from = ((cell as f64 - 0.5) * scale).round() as i64;
            from..(((cell as f64 + 1.5) * scale).round() as i64).max(from + 1)
        };
        let mut best = Best::new(TIE * self.total);
        let sizes = size.saturating_sub(1)..(size + 2).min(self.sizes.len());
        for row in span(candidate.row) {
            if row < 0 || row >= grid.height as i64 {
                continue;
            }
            let row = row as usize;
            for size in sizes.clone() {
                let filter = &self.sizes[size];
                let shape = FilterRows::new(grid, row, filter);
                for column in span(candidate.column) {
                    let column = column.rem_euclid(grid.width as i64) as usize;
                    let response = self.response(shape.flux(grid, column), filter);
                    best.offer(response, || grid.radiance(column, row), (column, row, size));
                }
            }
        }
        match best.place {
            Some((column, row, size)) => (grid.direction(column, row), self.sizes[size].inner_radius),
            None => (candidate.direction, self.sizes[size].inner_radius),
        }
    }

    fn remove(&mut self, centre: DVec3, radius: f64) {
        self.coarse.remove_cone(centre, radius);
        self.fine.remove_cone(centre, radius);
        let cell = std::f64::consts::PI / self.coarse.height as f64;
        self.run_filters(|direction, size| {
            let reach = radius + size.outer_radius + 2.0 * cell;
            direction.dot(centre) > reach.min(std::f64::consts::PI).cos()
        });
    }
}

/// The highest response so far. Equal ones go to the brighter texel, so that the lights of a turned map turn with it.
struct Best<T> {
    tolerance: f64,
    response: f64,
    radiance: f64,
    place: Option<T>,
}

impl<T> Best<T> {
    /// Responses count from `tolerance` upwards, and as equal within it.
    fn new(tolerance: f64) -> Self {
        Self { tolerance, response: tolerance, radiance: 0.0, place: None }
    }

    fn offer(&mut self, response: f64, radiance: impl FnOnce() -> f64, place: T) {
        if response < self.response - self.tolerance || response <= self.tolerance {
            return;
        }
        let radiance = radiance();
        if self.place.is_none() || response > self.response + self.tolerance || radiance > self.radiance {
            *self = Self { tolerance: self.tolerance, response, radiance, place: Some(place) };
        }
    }
}
