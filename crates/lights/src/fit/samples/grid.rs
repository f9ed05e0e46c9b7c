use std::f64::consts::{PI, TAU};

use glam::DVec3;
use gnomon_envmap::Equirect;

use crate::fit::faces::luminance;

/// Flux and directions of a map's texels, whole or in part. Columns may go on past the right edge; the fraction of a row is
/// one of its solid angle, so that equal parts of a texel hold equal flux.
pub(super) struct Grid<'a> {
    map: &'a Equirect,
    pub(super) width: usize,
    pub(super) height: usize,
    /// Solid angle [sr] of a texel of each row.
    solid_angle: Vec<f64>,
}

impl<'a> Grid<'a> {
    pub(super) fn new(map: &'a Equirect) -> Self {
        let solid_angle = (0..map.height()).map(|y| map.texel_solid_angle(y)).collect();
        Self { map, width: map.width() as usize, height: map.height() as usize, solid_angle }
    }

    /// Columns and rows of all texels.
    pub(super) fn texels(&self) -> impl Iterator<Item = (usize, usize)> + use<> {
        let (width, height) = (self.width, self.height);
        (0..height).flat_map(move |y| (0..width).map(move |x| (x, y)))
    }

    /// Solid angle [sr] of a texel of row `y`.
    pub(super) fn solid_angle(&self, y: usize) -> f64 {
        self.solid_angle[y]
    }

    pub(super) fn radiance(&self, x: usize, y: usize) -> DVec3 {
        self.map.radiance().get(x as u32, y as u32).as_dvec3()
    }

    /// Flux [radiance x sr] of a texel.
    pub(super) fn flux(&self, x: usize, y: usize) -> DVec3 {
        self.radiance(x, y) * self.solid_angle[y]
    }

    pub(super) fn luminous_flux(&self, x: usize, y: usize) -> f64 {
        luminance(self.radiance(x, y)) * self.solid_angle[y]
    }

    /// The column opposite to the azimuth of the light's centroid: samplers that need a seam put it there, so that samples
    /// turn with the map.
    pub(super) fn seam(&self) -> f64 {
        let centroid: DVec3 = self
            .texels()
            .map(|(x, y)| self.luminous_flux(x, y) * self.direction(x as f64 + 0.5, y as f64 + 0.5))
            .sum();
        // The azimuth of a direction is that of its column; half a turn on is its negative.
        (-centroid.x).atan2(centroid.z).rem_euclid(TAU) / TAU * self.width as f64
    }

    /// Cosine of the polar angle of a row, whose fraction is one of solid angle.
    pub(super) fn cos_theta(&self, y: f64) -> f64 {
        let row = (y as usize).min(self.height - 1);
        let edge = |row: usize| (PI * row as f64 / self.height as f64).cos();
        edge(row) + (y - row as f64) * (edge(row + 1) - edge(row))
    }

    /// Unit direction of a place on the map.
    pub(super) fn direction(&self, x: f64, y: f64) -> DVec3 {
        let cos_theta = self.cos_theta(y).clamp(-1.0, 1.0);
        let sin_theta = (1.0 - cos_theta * cos_theta).sqrt();
        let (sin_phi, cos_phi) = (TAU * x / self.width as f64).sin_cos();
        DVec3::new(sin_theta * sin_phi, cos_theta, -sin_theta * cos_phi)
    }
}
