use std::collections::HashMap;

use glam::Vec3;

use crate::Mesh;

impl Mesh {
    /// Replaces the normals by the area-weighted mean of the triangles that meet at each position, whether or not they share its
    /// vertices: for scans whose files have no normals. Positions that only triangles without area touch keep theirs.
    pub fn smooth_normals(&mut self) {
        // Adding 0 makes one zero of two.
        let key = |position: Vec3| (position + 0.0).to_array().map(f32::to_bits);
        let mut sums: HashMap<[u32; 3], Vec3> = HashMap::new();
        for triangle in &self.triangles {
            let corners =
                triangle.map(|index| self.positions.get(index as usize).copied().unwrap_or_default());
            let [a, b, c] = corners;
            let twice_area = (b - a).cross(c - a);
            for corner in corners {
                *sums.entry(key(corner)).or_default() += twice_area;
            }
        }
        if self.normals.is_empty() {
            self.normals = vec![Vec3::Y; self.positions.len()];
        }
        for (normal, position) in self.normals.iter_mut().zip(&self.positions) {
            if let Some(mean) = sums.get(&key(*position)).and_then(|sum| sum.try_normalize()) {
                *normal = mean;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flat_shaded_octahedron_becomes_round() {
        let corner = |i: usize| [Vec3::X, Vec3::Y, Vec3::Z][i % 3] * if i < 3 { 1.0 } else { -1.0 };
        let mut mesh = Mesh::default();
        for x in [0, 3] {
            for y in [1, 4] {
                for z in [2, 5] {
                    let odd = (x == 3) ^ (y == 4) ^ (z == 5);
                    let corners = if odd { [y, x, z] } else { [x, y, z] }.map(corner);
                    let first = mesh.positions.len() as u32;
                    mesh.normals.extend([(corners[0] + corners[1] + corners[2]).normalize(); 3]);
                    mesh.positions.extend(corners);
                    mesh.triangles.push([first, first + 1, first + 2]);
                }
            }
        }
        mesh.smooth_normals();
        for (position, normal) in mesh.positions.iter().zip(&mesh.normals) {
            assert!((*position - *normal).length() < 1e-6, "{position} {normal}");
        }
    }

    #[test]
    fn what_has_no_area_keeps_its_normals() {
        let mut mesh = Mesh {
            positions: vec![Vec3::ZERO; 3],
            normals: vec![Vec3::Y; 3],
            triangles: vec![[0, 1, 2]],
            ..Default::default()
        };
        mesh.smooth_normals();
        assert_eq!(mesh.normals, [Vec3::Y; 3]);
    }
}
