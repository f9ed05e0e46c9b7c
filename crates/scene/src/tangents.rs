//! Tangents for normal maps where the file has none, by the averaging rules of MikkTSpace (Mikkelsen, "Simulation of
//! Wrinkled Surfaces Revisited", 2008, section 3), which glTF asks for.

use std::collections::HashMap;

use glam::{DVec2, DVec3, Vec4};

use crate::Mesh;

/// Corners that share a tangent: same position, normal and texture coordinates (as bits), same orientation of the texture.
type Key = ([u32; 8], bool);

/// The mesh with tangents along increasing u of coordinate set `set`, which it has.
///
/// Each corner's tangent is the sum over the triangles that meet there, projected into the normal's plane, unit length,
/// weighted by the corner's angle. Vertices between mirrored and unmirrored triangles are split. Where texture
/// coordinates span no area, any tangent perpendicular to the normal serves.
pub fn generated(mut mesh: Mesh, set: usize) -> Mesh {
    let key = |mesh: &Mesh, index: u32, upright: bool| -> Key {
        let index = index as usize;
        let (p, n, uv) = (mesh.positions[index], mesh.normals[index], mesh.uvs[set][index]);
        ([p.x, p.y, p.z, n.x, n.y, n.z, uv.x, uv.y].map(f32::to_bits), upright)
    };
    let mut sums: HashMap<Key, DVec3> = HashMap::new();
    let mut uprights = Vec::with_capacity(mesh.triangles.len());
    for triangle in &mesh.triangles {
        let corners = triangle.map(|index| mesh.positions[index as usize].as_dvec3());
        let (along_u, upright) =
            along_u(corners, triangle.map(|index| mesh.uvs[set][index as usize].as_dvec2()));
        uprights.push(upright);
        for (corner, &index) in triangle.iter().enumerate() {
            let normal = mesh.normals[index as usize].as_dvec3();
            let tangent = (along_u - normal * normal.dot(along_u)).normalize_or_zero();
            let before = corners[(corner + 2) % 3] - corners[corner];
            let after = corners[(corner + 1) % 3] - corners[corner];
            let angle =
                if before == DVec3::ZERO || after == DVec3::ZERO { 0.0 } else { before.angle_between(after) };
            *sums.entry(key(&mesh, index, upright)).or_default() += tangent * angle;
        }
    }

    // A vertex keeps its index for the orientation that comes first, and is doubled for the other.
    let mut taken: Vec<Option<bool>> = vec![None; mesh.positions.len()];
    let mut doubles: HashMap<u32, u32> = HashMap::new();
    let mut tangents = vec![Vec4::new(1.0, 0.0, 0.0, 1.0); mesh.positions.len()];
    for (t, upright) in uprights.into_iter().enumerate() {
        for corner in 0..3 {
            let index = mesh.triangles[t][corner];
            let sum = sums.get(&key(&mesh, index, upright)).copied().unwrap_or_default();
            let normal = mesh.normals[index as usize];
            let tangent = (sum.as_vec3() - normal * normal.dot(sum.as_vec3()))
                .try_normalize()
                .unwrap_or_else(|| normal.any_orthonormal_vector())
                .extend(if upright { 1.0 } else { -1.0 });
            let target = if *taken[index as usize].get_or_insert(upright) == upright {
                index
            } else {
                *doubles.entry(index).or_insert_with(|| {
                    tangents.push(Vec4::ZERO);
                    duplicate_vertex(&mut mesh, index)
                })
            };
            tangents[target as usize] = tangent;
            mesh.triangles[t][corner] = target;
        }
    }
    mesh.tangents = tangents;
    mesh
}

/// Direction of increasing u on the surface (not normalized), and whether the texture stands upright: seen from the
/// front, v (which points down in glTF's pictures) runs clockwise from u. Then the bitangent `N x T` points up in the
/// picture, as normal maps have it.
fn along_u(p: [DVec3; 3], uv: [DVec2; 3]) -> (DVec3, bool) {
    let (p1, p2) = (p[1] - p[0], p[2] - p[0]);
    let (uv1, uv2) = (uv[1] - uv[0], uv[2] - uv[0]);
    let determinant = uv1.perp_dot(uv2);
    let along = p1 * uv2.y - p2 * uv1.y;
    // Only the direction counts; dividing by the determinant would overflow where it is small.
    (along * determinant.signum() * f64::from(u8::from(determinant != 0.0)), determinant <= 0.0)
}

/// Appends a copy of a vertex and returns its index.
fn duplicate_vertex(mesh: &mut Mesh, index: u32) -> u32 {
    fn double<T: Copy>(values: &mut Vec<T>, index: u32) {
        if let Some(&value) = values.get(index as usize) {
            values.push(value);
        }
    }
    let copy = mesh.positions.len() as u32;
    double(&mut mesh.positions, index);
    double(&mut mesh.normals, index);
    double(&mut mesh.colors, index);
    mesh.uvs.iter_mut().for_each(|set| double(set, index));
    for target in &mut mesh.targets {
        double(&mut target.positions, index);
        double(&mut target.normals, index);
    }
    if !mesh.influences.is_empty() {
        let entries = mesh.influences.of(index as usize).to_vec();
        mesh.influences.push(&entries);
    }
    copy
}

#[cfg(test)]
mod tests {
    use glam::{Vec2, Vec3};

    use super::*;

    /// A unit square in the xy plane facing +z with the given texture coordinates at its corners
    /// (0,0), (1,0), (1,1), (0,1).
    fn square(uvs: [[f32; 2]; 4]) -> Mesh {
        let positions = vec![Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y];
        Mesh {
            normals: vec![Vec3::Z; 4],
            positions,
            uvs: [uvs.map(Vec2::from_array).to_vec(), Vec::new()],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Mesh::default()
        }
    }

    #[test]
    fn an_upright_texture_has_its_tangent_right_and_bitangent_up() {
        // v points down: the picture stands upright on the square.
        let mesh = generated(square([[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]]), 0);
        assert_eq!(mesh.positions.len(), 4);
        for tangent in &mesh.tangents {
            assert!((*tangent - Vec4::new(1.0, 0.0, 0.0, 1.0)).length() < 1e-6, "{tangent}");
            let bitangent = Vec3::Z.cross(tangent.truncate()) * tangent.w;
            assert!((bitangent - Vec3::Y).length() < 1e-6);
        }
    }

    #[test]
    fn a_mirrored_texture_turns_the_sign() {
        let mesh = generated(square([[1.0, 1.0], [0.0, 1.0], [0.0, 0.0], [1.0, 0.0]]), 0);
        for tangent in &mesh.tangents {
            assert!((*tangent - Vec4::new(-1.0, 0.0, 0.0, -1.0)).length() < 1e-6, "{tangent}");
        }
    }

    #[test]
    fn vertices_between_mirrored_halves_are_split() {
        let mut mesh = square([[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [1.0, 1.0]]);
        // The second triangle, mapped as the mirror image of the first.
        mesh.triangles = vec![[0, 1, 2], [0, 2, 3]];
        let mesh = generated(mesh, 0);
        assert_eq!(mesh.positions.len(), 6);
        assert_eq!(mesh.tangents.len(), 6);
        assert_eq!(mesh.uvs[0].len(), 6);
        let sign = |t: usize| mesh.triangles[t].map(|index| mesh.tangents[index as usize].w);
        assert_eq!(sign(0), [1.0; 3]);
        assert_eq!(sign(1), [-1.0; 3]);
    }

    #[test]
    fn coordinates_without_area_give_some_unit_tangent() {
        for tangent in generated(square([[0.5, 0.5]; 4]), 0).tangents {
            assert!(tangent.truncate().is_normalized() && tangent.truncate().dot(Vec3::Z).abs() < 1e-6);
        }
    }
}
