//! Holes of alpha masks, as rays see them: every triangle is divided into small ones, each open or not (an opacity micromap).

use glam::Vec3;
use gnomon_scene::{MeshId, Scene};
use gnomon_shaders::twin::micromap::micro_triangle;
use rayon::prelude::*;

/// Most small triangles along an edge.
const MOST_DIVISIONS: u32 = 64;
/// Small triangles of a mesh altogether, where it has few triangles or many.
const IN_MESH: u32 = 1 << 22;

/// Of all triangles of a mesh.
#[derive(Debug, PartialEq)]
pub(crate) struct Micromaps {
    /// Small triangles along an edge.
    pub divisions: u32,
    /// A bit for each that is no hole, `words_each` words a triangle.
    pub words: Vec<u32>,
}

impl Micromaps {
    /// Of a mesh whose material has a mask.
    pub fn new(scene: &Scene, mesh: MeshId) -> Self {
        let triangles = scene.meshes[mesh.0].triangles.len();
        let affordable = (IN_MESH / (triangles.max(1) as u32)).isqrt();
        let divisions = affordable.clamp(1, MOST_DIVISIONS);
        let bits = |triangle: usize| {
            let mut words = vec![0u32; words_each(divisions) as usize];
            let side = 1.0 / divisions as f32;
            for (row, column) in (0..divisions).flat_map(|row| (0..divisions - row).map(move |c| (row, c))) {
                // The middle of a small triangle, and of the one beyond its long side.
                for third in [1.0, 2.0] {
                    let v = (column as f32 + third / 3.0) * side;
                    let w = (row as f32 + third / 3.0) * side;
                    if v + w < 1.0 && scene.visible_at(mesh, triangle, Vec3::new(1.0 - v - w, v, w)) {
                        let bit = micro_triangle(v, w, divisions);
                        words[(bit / 32) as usize] |= 1 << (bit % 32);
                    }
                }
            }
            words
        };
        Self { divisions, words: (0..triangles).into_par_iter().flat_map_iter(bits).collect() }
    }

    /// Words of a triangle, a multiple of 4.
    pub fn words_each(&self) -> u32 {
        words_each(self.divisions)
    }
}

fn words_each(divisions: u32) -> u32 {
    (2 * divisions * divisions).div_ceil(128) * 4
}
