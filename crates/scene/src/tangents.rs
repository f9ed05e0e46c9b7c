//! Tangents for normal maps where the file has none: MikkTSpace (Mikkelsen, "Simulation of Wrinkled Surfaces Revisited", 2008), which
//! glTF asks for and other tools bake with.

use std::collections::HashMap;

use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};
use glam::{Vec3, Vec4};

use crate::Mesh;

/// A mesh as MikkTSpace reads it, and the tangents of its triangles' corners.
struct Corners<'a> {
    mesh: &'a Mesh,
    set: usize,
    tangents: Vec<[Option<Vec4>; 3]>,
}

impl Corners<'_> {
    fn index(&self, triangle: usize, corner: usize) -> usize {
        self.mesh.triangles[triangle][corner] as usize
    }
}

impl Geometry for Corners<'_> {
    fn num_faces(&self) -> usize {
        self.mesh.triangles.len()
    }

    fn num_vertices_of_face(&self, _: usize) -> usize {
        3
    }

    fn position(&self, triangle: usize, corner: usize) -> [f32; 3] {
        self.mesh.positions[self.index(triangle, corner)].to_array()
    }

    fn normal(&self, triangle: usize, corner: usize) -> [f32; 3] {
        self.mesh.normals[self.index(triangle, corner)].to_array()
    }

    fn tex_coord(&self, triangle: usize, corner: usize) -> [f32; 2] {
        self.mesh.uvs[self.set][self.index(triangle, corner)].to_array()
    }

    fn set_tangent(&mut self, space: Option<TangentSpace>, triangle: usize, corner: usize) {
        // MikkTSpace counts v upwards, glTF downwards.
        let tangent = space.map(|space| Vec4::from(space.tangent_encoded()) * Vec4::new(1.0, 1.0, 1.0, -1.0));
        // False for NaN. Where coordinates span no area there is none, or a default.
        let normal = Vec3::from(self.normal(triangle, corner));
        let serves = |t: Vec3| t.length_squared() > 0.5 && t.dot(normal).abs() < 0.01;
        self.tangents[triangle][corner] = tangent.filter(|tangent| serves(tangent.truncate()));
    }
}

/// The mesh with tangents along increasing u of coordinate set `set`, which it has.
///
/// Vertices between triangles that need different tangents, as mirrored and unmirrored ones do, are split. Where texture coordinates span
/// no area, any tangent perpendicular to the normal serves.
pub fn generated(mut mesh: Mesh, set: usize) -> Mesh {
    let mut corners = Corners { mesh: &mesh, set, tangents: vec![[None; 3]; mesh.triangles.len()] };
    // There is no way to fail: the error has no cases.
    let _ = generate_tangents(&mut corners);
    let of_corners = corners.tangents;

    // A vertex keeps its index for the tangent that comes first, and is doubled for others.
    let mut tangents: Vec<Option<Vec4>> = vec![None; mesh.positions.len()];
    let mut doubles: HashMap<(u32, [u32; 4]), u32> = HashMap::new();
    for (triangle, of_triangle) in of_corners.into_iter().enumerate() {
        for (corner, tangent) in of_triangle.into_iter().enumerate() {
            let index = mesh.triangles[triangle][corner];
            let tangent =
                tangent.unwrap_or_else(|| mesh.normals[index as usize].any_orthonormal_vector().extend(1.0));
            if *tangents[index as usize].get_or_insert(tangent) != tangent {
                let double =
                    *doubles.entry((index, tangent.to_array().map(f32::to_bits))).or_insert_with(|| {
                        tangents.push(Some(tangent));
                        duplicate_vertex(&mut mesh, index)
                    });
                mesh.triangles[triangle][corner] = double;
            }
        }
    }
    mesh.tangents =
        tangents.into_iter().map(|tangent| tangent.unwrap_or(Vec4::new(1.0, 0.0, 0.0, 1.0))).collect();
    mesh
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
