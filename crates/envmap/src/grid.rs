//! Where the texels of each kind of map lie on the sphere: what resampling needs to know of a projection.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use crate::cube::face_solid_angle;

/// Widest patch that stands for a part of a texel [rad]; its edges are taken as great circles.
const MAX_PATCH: f64 = TAU / 480.0;

/// What a texel of a file stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sampling {
    /// Texel `i` of `n` covers `[i, i + 1] / n`.
    Areas,
    /// Texel `i` of `n` is a sample at `i / (n - 1)` and stands for what lies nearest to it: half a cell at the ends.
    /// OpenEXR's environment maps are made so.
    EdgeToEdge,
}

impl Sampling {
    /// Cell edge `index` in `0..=count`, from 0 to 1.
    pub(crate) fn edge(self, index: u32, count: u32) -> f64 {
        let (low, high) = self.range(count);
        (f64::from(index).clamp(low, high) - low) / (high - low)
    }

    /// First and last edge counted in cells: edge `i` lies at `i` except at the ends.
    pub(crate) fn range(self, count: u32) -> (f64, f64) {
        match self {
            Self::EdgeToEdge if count > 1 => (0.5, f64::from(count) - 0.5),
            _ => (0.0, f64::from(count)),
        }
    }
}

/// A partition of the sphere into texels, each of one or more small patches.
pub(crate) trait Patches: Sync {
    /// Number of texels.
    fn texel_count(&self) -> usize;
    /// Solid angle of a texel [sr]; all together have 4 pi. A texel of 0 is not part of the map.
    fn solid_angle(&self, texel: usize) -> f64;
    /// Calls `take` with the corners (unit, in turn) of each patch of a texel. Neighbours share corners.
    fn patches(&self, texel: usize, take: impl FnMut([DVec3; 4]));
}

/// Texels of an equirect map.
pub(crate) struct EquirectGrid {
    width: usize,
    /// Patches of a texel, across and down.
    parts: (usize, usize),
    /// Sine and cosine of the edges of patches.
    phi: Vec<(f64, f64)>,
    theta: Vec<(f64, f64)>,
    /// Solid angle of a texel in each row.
    angles: Vec<f64>,
}

impl EquirectGrid {
    pub(crate) fn new(width: u32, height: u32) -> Self {
        let (columns, rows) = (width as usize, height as usize);
        let parts = |extent: f64, count: usize| (extent / count as f64 / MAX_PATCH).ceil().max(1.0) as usize;
        let parts = (parts(TAU, columns), parts(PI, rows));
        let edges = |extent: f64, count: usize| -> Vec<(f64, f64)> {
            (0..=count).map(|i| (extent * i as f64 / count as f64).sin_cos()).collect()
        };
        let angles = (0..rows).map(|y| {
            let (top, bottom) = (PI * y as f64 / rows as f64, PI * (y + 1) as f64 / rows as f64);
            TAU / columns as f64 * 2.0 * (0.5 * (top + bottom)).sin() * (0.5 * (bottom - top)).sin()
        });
        Self {
            width: columns,
            parts,
            phi: edges(TAU, columns * parts.0),
            theta: edges(PI, rows * parts.1),
            angles: angles.collect(),
        }
    }
}

impl Patches for EquirectGrid {
    fn texel_count(&self) -> usize {
        self.width * self.angles.len()
    }

    fn solid_angle(&self, texel: usize) -> f64 {
        self.angles[texel / self.width]
    }

    fn patches(&self, texel: usize, mut take: impl FnMut([DVec3; 4])) {
        let (x, y) = (texel % self.width, texel / self.width);
        let corner = |x: usize, y: usize| {
            let ((sin_phi, cos_phi), (sin_theta, cos_theta)) = (self.phi[x], self.theta[y]);
            DVec3::new(sin_theta * sin_phi, cos_theta, -sin_theta * cos_phi)
        };
        for y in y * self.parts.1..(y + 1) * self.parts.1 {
            for x in x * self.parts.0..(x + 1) * self.parts.0 {
                take([corner(x, y), corner(x + 1, y), corner(x + 1, y + 1), corner(x, y + 1)]);
            }
        }
    }
}

/// Texels of a cube map, face by face.
pub(crate) struct CubeGrid {
    size: u32,
    sampling: Sampling,
}

impl CubeGrid {
    pub(crate) fn new(size: u32, sampling: Sampling) -> Self {
        Self { size, sampling }
    }

    pub(crate) fn texel_count(&self) -> usize {
        6 * self.size as usize * self.size as usize
    }

    /// Index of the texel in column `x` and row `y` of a face.
    pub(crate) fn texel(&self, face: usize, x: usize, y: usize) -> usize {
        let size = self.size as usize;
        (face * size + y.min(size - 1)) * size + x.min(size - 1)
    }

    /// First and last edge of a face counted in texels.
    pub(crate) fn range(&self) -> (f64, f64) {
        self.sampling.range(self.size)
    }

    /// Solid angle of every texel [sr].
    pub(crate) fn solid_angles(&self) -> Vec<f64> {
        let edges: Vec<f64> = (0..=self.size).map(|i| 2.0 * self.sampling.edge(i, self.size) - 1.0).collect();
        let row = |y: &[f64]| {
            let y = [y[0], y[1]];
            edges.windows(2).map(|x| face_solid_angle([x[0], x[1]], y)).collect::<Vec<f64>>()
        };
        let face: Vec<f64> = edges.windows(2).flat_map(row).collect();
        face.repeat(6)
    }
}
