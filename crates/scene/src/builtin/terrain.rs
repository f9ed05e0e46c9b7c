use glam::Vec3;

use crate::Mesh;

/// Half the side of the square [m].
const HALF_SIDE: f32 = 3.0;

/// Cells along a side: 32,768 triangles.
const CELLS: u32 = 128;

/// Seed of the noise; another one is another landscape.
const SEED: u32 = 2008;

/// Height of a ridge of the coarsest octave [m].
const AMPLITUDE: f32 = 1.0;

/// Cells of the coarsest octave's lattice per metre.
const FREQUENCY: f32 = 0.4;

const OCTAVES: u32 = 4;

/// Ridges are rounded over about half of this [m]: less would fall between two cells.
const BLUNTNESS: f32 = 0.3;

/// The land falls to y = 0 over this distance from its border [m].
const SHORE: f32 = 1.2;

/// A mountain landscape of ridged noise, lowest point at y = 0, with the height field's own normals.
pub(super) fn mesh() -> Mesh {
    let step = 2.0 * HALF_SIDE / CELLS as f32;
    let row = CELLS + 1;
    // One cell more on every side, for the slopes at the border.
    let padded = row + 2;
    let place = |i: u32| (i as f32 - 1.0) * step - HALF_SIDE;
    let heights: Vec<f32> =
        (0..padded * padded).map(|i| height(place(i % padded), place(i / padded))).collect();
    let at = |x: u32, z: u32| heights[(z * padded + x) as usize];
    let vertices = || (1..=row).flat_map(|z| (1..=row).map(move |x| (x, z)));
    let lowest = vertices().map(|(x, z)| at(x, z)).fold(f32::INFINITY, f32::min);
    let mut mesh = Mesh::default();
    for (x, z) in vertices() {
        mesh.positions.push(Vec3::new(place(x), at(x, z) - lowest, place(z)));
        let slope = [at(x + 1, z) - at(x - 1, z), at(x, z + 1) - at(x, z - 1)];
        mesh.normals.push(Vec3::new(-slope[0], 2.0 * step, -slope[1]).normalize());
    }
    for (x, z) in (0..CELLS).flat_map(|z| (0..CELLS).map(move |x| (x, z))) {
        let first = z * row + x;
        let [a, b, c, d] = [first, first + row, first + row + 1, first + 1];
        mesh.triangles.extend([[a, b, c], [a, c, d]]);
    }
    mesh
}

/// Ridged multifractal (Musgrave, in Ebert et al., Texturing and Modeling, 2003, chapter 16): creases of the noise become ridges,
/// and fine ridges grow on high ground only.
fn height(x: f32, z: f32) -> f32 {
    let (mut sum, mut weight, mut amplitude, mut frequency) = (0.0, 1.0_f32, AMPLITUDE, FREQUENCY);
    for octave in 0..OCTAVES {
        let signed = 2.0 * noise(frequency * x, frequency * z, octave) - 1.0;
        let crease = (1.0 - signed.hypot(BLUNTNESS * frequency)).max(0.0);
        let ridge = crease * crease * weight;
        sum += amplitude * ridge;
        weight = (2.0 * ridge).clamp(0.0, 1.0);
        amplitude *= 0.45;
        frequency *= 2.1;
    }
    let border = ((HALF_SIDE - x.abs().max(z.abs())) / SHORE).clamp(0.0, 1.0);
    sum * border * border * (3.0 - 2.0 * border)
}

/// Value noise in 0..1 with continuous curvature.
fn noise(x: f32, z: f32, octave: u32) -> f32 {
    let fade = |t: f32| t * t * t * (t * (6.0 * t - 15.0) + 10.0);
    let (left, back) = (x.floor(), z.floor());
    let (u, v) = (fade(x - left), fade(z - back));
    let corner = |i: i32, j: i32| lattice(left as i32 + i, back as i32 + j, octave);
    let along = |j: i32| corner(0, j) + u * (corner(1, j) - corner(0, j));
    along(0) + v * (along(1) - along(0))
}

/// A hash in 0..1.
fn lattice(x: i32, z: i32, octave: u32) -> f32 {
    let mut bits = x.cast_unsigned().wrapping_mul(0x9E37_79B1)
        ^ z.cast_unsigned().wrapping_mul(0x85EB_CA77)
        ^ octave.wrapping_mul(0xC2B2_AE3D)
        ^ SEED.wrapping_mul(0x27D4_EB2F);
    bits = (bits ^ (bits >> 15)).wrapping_mul(0x2C1B_3C6D);
    bits = (bits ^ (bits >> 12)).wrapping_mul(0x297A_2D39);
    (bits ^ (bits >> 15)) as f32 / u32::MAX as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::triangle_normal;

    #[test]
    fn the_terrain_is_mountainous_and_faces_up() {
        let mesh = mesh();
        assert_eq!(mesh.triangles.len(), 2 * (CELLS * CELLS) as usize);
        let heights: Vec<f32> = mesh.positions.iter().map(|position| position.y).collect();
        let highest = heights.iter().copied().fold(0.0, f32::max);
        assert!((0.8..2.5).contains(&highest), "{highest}");
        let mut steep = 0;
        for triangle in &mesh.triangles {
            let normal = triangle_normal(triangle.map(|i| mesh.positions[i as usize])).unwrap();
            assert!(normal.y > 0.1);
            steep += usize::from(normal.y < 0.7);
            for i in triangle {
                let smooth = mesh.normals[*i as usize];
                assert!(smooth.is_normalized() && smooth.dot(normal) > 0.5, "{smooth} {normal}");
            }
        }
        // Slopes of more than 45 degrees throw shadows on others under most of a sky.
        assert!(steep > mesh.triangles.len() / 20, "{steep}");
    }
}
