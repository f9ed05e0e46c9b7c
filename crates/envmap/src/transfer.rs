use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::grid::{CubeGrid, Patches};
use crate::overlap::overlaps;

/// Largest relative error of a texel's covered solid angle, that is, of a constant map.
const COVERAGE_TOLERANCE: f64 = 4e-4;
/// Rounds of balancing after which the remaining coverage error is accepted.
const MAX_ROUNDS: usize = 20;
/// Texels that one task handles.
const CHUNK: usize = 4096;

/// Flux-conserving resampling between a map and a cube map, either way.
///
/// The overlaps `K_ij` [sr] of map texel `i` and cube texel `j` are geometric and exact but for the curvature of texel
/// edges. Then `u_i K_ij v_j` is balanced (Sinkhorn 1967) until its sums are the solid angles of the texels: exactly for
/// the source, so that each channel's flux is kept whatever the map, and within [`COVERAGE_TOLERANCE`] for the destination, so
/// that a constant stays one. A source texel only ever reaches texels that it overlaps.
pub(crate) struct Transfer {
    map_angles: Vec<f64>,
    cube_angles: Vec<f64>,
    /// Overlaps by map texel, and the same by cube texel.
    by_map: Sparse,
    by_cube: Sparse,
}

impl Transfer {
    pub(crate) fn new(map: &impl Patches, cube: &CubeGrid) -> Self {
        let count = map.texel_count();
        let map_angles: Vec<f64> = (0..count).map(|texel| map.solid_angle(texel)).collect();
        let task = |task: usize| {
            let mut rows = Sparse { starts: vec![0], entries: Vec::with_capacity(2 * CHUNK) };
            for texel in task * CHUNK..((task + 1) * CHUNK).min(count) {
                let first = rows.entries.len();
                map.patches(texel, |patch| {
                    overlaps(patch, cube, |other, overlap| rows.add(first, other, overlap));
                });
                rows.starts.push(rows.entries.len() as u32);
            }
            rows
        };
        let parts: Vec<Sparse> = (0..count.div_ceil(CHUNK)).into_par_iter().map(task).collect();
        let by_map = Sparse::joined(&parts);
        let by_cube = by_map.transposed(cube.texel_count());
        Self { map_angles, cube_angles: cube.solid_angles(), by_map, by_cube }
    }

    /// Radiance of the cube's texels, from the map's.
    pub(crate) fn to_cube(&self, map: &[Vec3]) -> Vec<Vec3> {
        transfer(&self.by_map, &self.map_angles, &self.by_cube, &self.cube_angles, map)
    }

    /// Radiance of the map's texels, from the cube's.
    pub(crate) fn to_map(&self, cube: &[Vec3]) -> Vec<Vec3> {
        transfer(&self.by_cube, &self.cube_angles, &self.by_map, &self.map_angles, cube)
    }
}

/// Compressed sparse rows.
struct Sparse {
    starts: Vec<u32>,
    entries: Vec<(u32, f32)>,
}

impl Sparse {
    /// Adds to the last row, which begins at entry `first`.
    fn add(&mut self, first: usize, column: usize, overlap: f64) {
        match self.entries[first..].iter_mut().find(|entry| entry.0 == column as u32) {
            Some(entry) => entry.1 += overlap as f32,
            None => self.entries.push((column as u32, overlap as f32)),
        }
    }

    fn joined(parts: &[Self]) -> Self {
        let mut starts = vec![0];
        let mut offset = 0;
        for part in parts {
            starts.extend(part.starts[1..].iter().map(|start| start + offset));
            offset += part.entries.len() as u32;
        }
        let entries: Vec<&[(u32, f32)]> = parts.iter().map(|part| part.entries.as_slice()).collect();
        Self { starts, entries: entries.concat() }
    }

    fn transposed(&self, rows: usize) -> Self {
        let mut starts = vec![0u32; rows + 1];
        for &(column, _) in &self.entries {
            starts[column as usize + 1] += 1;
        }
        let mut total = 0;
        for start in &mut starts {
            total += *start;
            *start = total;
        }
        let mut next = starts.clone();
        let mut entries = vec![(0, 0.0); self.entries.len()];
        for row in 0..self.rows() {
            for &(column, overlap) in self.row(row) {
                let at = &mut next[column as usize];
                entries[*at as usize] = (row as u32, overlap);
                *at += 1;
            }
        }
        Self { starts, entries }
    }

    fn rows(&self) -> usize {
        self.starts.len() - 1
    }

    fn row(&self, row: usize) -> &[(u32, f32)] {
        &self.entries[self.starts[row] as usize..self.starts[row + 1] as usize]
    }

    /// `wanted_r / sum_c K_rc x_c` for every row `r`, or 0 where the sum is.
    fn divide(&self, wanted: &[f64], x: &[f64]) -> Vec<f64> {
        let one = |(row, wanted): (usize, &f64)| {
            let product = |&(column, overlap): &(u32, f32)| f64::from(overlap) * x[column as usize];
            let sum: f64 = self.row(row).iter().map(product).sum();
            if sum > 0.0 { wanted / sum } else { 0.0 }
        };
        wanted.par_iter().enumerate().with_min_len(CHUNK).map(one).collect()
    }
}

fn transfer(
    scatter: &Sparse,
    source_angles: &[f64],
    gather: &Sparse,
    destination_angles: &[f64],
    source: &[Vec3],
) -> Vec<Vec3> {
    let mut v = vec![1.0; destination_angles.len()];
    let mut u = scatter.divide(source_angles, &v);
    for _ in 0..MAX_ROUNDS {
        let wanted_v = gather.divide(destination_angles, &u);
        let error = |(old, new): (&f64, &f64)| if *new > 0.0 { (old / new - 1.0).abs() } else { 0.0 };
        if v.iter().zip(&wanted_v).map(error).fold(0.0, f64::max) < COVERAGE_TOLERANCE {
            break;
        }
        v = wanted_v;
        u = scatter.divide(source_angles, &v);
    }
    let texel = |j: usize| {
        let share =
            |&(i, overlap): &(u32, f32)| source[i as usize].as_dvec3() * (u[i as usize] * f64::from(overlap));
        let flux = gather.row(j).iter().map(share).sum::<DVec3>() * v[j];
        if destination_angles[j] > 0.0 { (flux / destination_angles[j]).as_vec3() } else { Vec3::ZERO }
    };
    (0..destination_angles.len()).into_par_iter().with_min_len(CHUNK).map(texel).collect()
}
