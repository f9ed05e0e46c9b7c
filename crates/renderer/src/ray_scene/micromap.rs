//! Alpha as rays see it: every triangle is divided into small ones, each with its opacity (an opacity micromap).

use glam::Vec3;
use gnomon_scene::{AlphaMode, MeshId, Scene};
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
    /// Of an opacity: 1 where there are only holes, else 8.
    pub bits: u32,
    /// Opacities, `words_each` words a triangle.
    pub words: Vec<u32>,
}

impl Micromaps {
    /// Of a mesh whose material has alpha.
    pub fn new(scene: &Scene, mesh: MeshId) -> Self {
        let triangles = scene.meshes[mesh.0].triangles.len();
        let material = scene.material(mesh);
        let affordable = (IN_MESH / (triangles.max(1) as u32)).isqrt();
        let is_even = material.base_color_texture.is_none() && scene.meshes[mesh.0].colors.is_empty();
        let divisions = if is_even { 1 } else { affordable.clamp(1, MOST_DIVISIONS) };
        let bits = if material.alpha_mode == AlphaMode::Blend { 8 } else { 1 };
        let greatest = ((1u32 << bits) - 1) as f32;
        let opacities = |triangle: usize| {
            let mut words = vec![0u32; words_each(divisions, bits) as usize];
            let side = 1.0 / divisions as f32;
            for (row, column) in (0..divisions).flat_map(|row| (0..divisions - row).map(move |c| (row, c))) {
                // The middle of a small triangle, and of the one beyond its long side.
                for third in [1.0, 2.0] {
                    let v = (column as f32 + third / 3.0) * side;
                    let w = (row as f32 + third / 3.0) * side;
                    if v + w < 1.0 {
                        let opacity = scene.opacity_at(mesh, triangle, Vec3::new(1.0 - v - w, v, w));
                        let bit = bits * micro_triangle(v, w, divisions);
                        words[(bit / 32) as usize] |= ((opacity * greatest).round() as u32) << (bit % 32);
                    }
                }
            }
            words
        };
        Self { divisions, bits, words: (0..triangles).into_par_iter().flat_map_iter(opacities).collect() }
    }

    /// Words of a triangle, a multiple of 4.
    pub fn words_each(&self) -> u32 {
        words_each(self.divisions, self.bits)
    }
}

fn words_each(divisions: u32, bits: u32) -> u32 {
    (2 * divisions * divisions * bits).div_ceil(128) * 4
}
