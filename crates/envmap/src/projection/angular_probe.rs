use std::f64::consts::PI;

use glam::{DVec2, DVec3, Vec3};
use gnomon_picture::RgbImage;
use rayon::prelude::*;

use super::{Entry, Projection, Unfolded};
use crate::grid::Patches;
use crate::{CubeMap, Equirect};

/// Patches along each side of a texel.
const PARTS: usize = 4;

/// As Debevec describes it: the centre looks along -z, +x is to the right, +y above.
pub(super) const ENTRY: Entry = Entry {
    projection: Projection::AngularProbe,
    shape: "1:1",
    attribute: None,
    fits: |width, height| width > 0 && width == height,
    unfold: |image, _| Probe::unfold(&image, -1.0),
};

/// As OpenImageIO reads it: the centre looks along +z and +x is to the right, so that what it makes of a photographed probe
/// is a mirror image of the place.
pub(super) const MIRRORED: Entry = Entry {
    projection: Projection::MirroredProbe,
    shape: "1:1",
    attribute: None,
    fits: |_, _| false,
    unfold: |image, _| Probe::unfold(&image, 1.0),
};

struct Probe {
    grid: ProbeGrid,
    texels: Vec<Vec3>,
}

impl Probe {
    fn unfold(image: &RgbImage, centre_z: f64) -> Option<Box<dyn Unfolded>> {
        let size = image.width();
        if size == 0 || size != image.height() {
            return None;
        }
        let grid = ProbeGrid::new(size as usize, centre_z);
        // What lies outside the disc is no part of the map, so it must not be counted as NaN either.
        let inside = |(texel, angle): (&Vec3, &f64)| if *angle > 0.0 { *texel } else { Vec3::ZERO };
        let texels = image.texels().iter().zip(&grid.angles).map(inside).collect();
        Some(Box::new(Self { grid, texels }))
    }
}

impl Unfolded for Probe {
    fn texels_mut(&mut self) -> &mut [Vec3] {
        &mut self.texels
    }

    /// By way of a cube map whose texels are half as wide as the probe's at its centre.
    fn into_equirect(self: Box<Self>) -> Equirect {
        let size = self.grid.size as u32;
        let cube = CubeMap::resampled(&self.grid, &self.texels, size.div_ceil(2));
        Equirect::from_cube(&cube, 2 * size, size)
    }
}

/// Texels of an angular map: the angle from the centre's direction is `pi` times the distance from the centre.
struct ProbeGrid {
    size: usize,
    /// z of the direction at the centre: 1 or -1.
    centre_z: f64,
    angles: Vec<f64>,
}

impl ProbeGrid {
    fn new(size: usize, centre_z: f64) -> Self {
        let mut grid = Self { size, centre_z, angles: Vec::new() };
        let angle = |texel: usize| {
            let part = |part: usize| {
                let r = grid.position(texel, part, DVec2::splat(0.5)).length();
                // theta = pi r, so d omega = sin(theta) d theta d phi = pi sin(pi r) / r dA.
                if r < 1.0 { (PI * r).sin() / r.max(1e-12) } else { 0.0 }
            };
            (0..PARTS * PARTS).map(part).sum::<f64>()
        };
        let mut angles: Vec<f64> = (0..size * size).into_par_iter().map(angle).collect();
        let total: f64 = angles.iter().sum();
        angles.iter_mut().for_each(|angle| *angle *= 4.0 * PI / total);
        grid.angles = angles;
        grid
    }

    /// Place in the disc, x to the right and y up, of a point inside one of a texel's parts.
    fn position(&self, texel: usize, part: usize, inside: DVec2) -> DVec2 {
        let corner = DVec2::new((texel % self.size) as f64, (texel / self.size) as f64);
        let part = DVec2::new((part % PARTS) as f64, (part / PARTS) as f64);
        let at = (corner + (part + inside) / PARTS as f64) * (2.0 / self.size as f64) - 1.0;
        DVec2::new(at.x, -at.y)
    }

    /// Direction (unit) at a place; the rim, where all directions are one, stands for everything outside it.
    fn direction(&self, at: DVec2) -> DVec3 {
        let r = at.length().min(1.0);
        let sin_over_r = if r > 1e-9 { (PI * r).sin() / r } else { PI };
        DVec3::new(at.x * sin_over_r, at.y * sin_over_r, self.centre_z * (PI * r).cos())
    }
}

impl Patches for ProbeGrid {
    fn texel_count(&self) -> usize {
        self.size * self.size
    }

    fn solid_angle(&self, texel: usize) -> f64 {
        self.angles[texel]
    }

    fn patches(&self, texel: usize, mut take: impl FnMut([DVec3; 4])) {
        for part in 0..PARTS * PARTS {
            if self.position(texel, part, DVec2::splat(0.5)).length() < 1.0 {
                let corner = |x: f64, y: f64| self.direction(self.position(texel, part, DVec2::new(x, y)));
                take([corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0)]);
            }
        }
    }
}
