//! Meshes from arrays.

use glam::{Vec2, Vec3, Vec4};
use gnomon::scene::{LARGEST_COORDINATE, Mesh, triangle_normal};
use pyo3::prelude::*;

use crate::arrays;
use crate::error::refused;

/// A mesh as a program gives it.
#[derive(Clone, Default)]
pub struct Shape {
    /// Places [m].
    pub vertices: Vec<Vec3>,
    /// Corners.
    pub triangles: Vec<[u32; 3]>,
    /// Unit normals; none for flat faces.
    pub normals: Vec<Vec3>,
    /// Texture coordinates, or none.
    pub uvs: Vec<Vec2>,
    /// Linear colours that multiply the base colour, or none.
    pub colors: Vec<Vec4>,
}

impl Shape {
    /// The shape that arrays are, with normals, uvs and colours where they are given.
    ///
    /// # Errors
    /// Arrays of other shapes, numbers that are not finite, corners without a vertex.
    pub fn of(
        vertices: &Bound<'_, PyAny>,
        triangles: &Bound<'_, PyAny>,
        [normals, uvs, colors]: [Option<&Bound<'_, PyAny>>; 3],
    ) -> PyResult<Self> {
        let vertices = arrays::vectors(vertices, "vertices")?;
        Ok(Self {
            triangles: arrays::triangles(triangles, vertices.len(), "triangles")?,
            vertices,
            normals: normals.map_or(Ok(Vec::new()), |array| arrays::vectors(array, "normals"))?,
            uvs: uvs.map_or(Ok(Vec::new()), |array| arrays::pairs(array, "uvs"))?,
            colors: colors.map_or(Ok(Vec::new()), |array| arrays::colors(array, "colors"))?,
        })
    }

    /// The mesh: as it is, or with three vertices of its own for every triangle where it has no normals.
    ///
    /// # Errors
    /// Arrays of other lengths, coordinates beyond what is drawn.
    pub fn mesh(&self) -> PyResult<Mesh> {
        let count = self.vertices.len();
        for (what, length) in
            [("normals", self.normals.len()), ("uvs", self.uvs.len()), ("colors", self.colors.len())]
        {
            if length != 0 && length != count {
                return Err(refused(format!("there are {length} {what} of {count} vertices")));
            }
        }
        if self.vertices.iter().any(|place| place.abs().max_element() > LARGEST_COORDINATE) {
            return Err(refused(format!(
                "a vertex is farther than {LARGEST_COORDINATE:e} m from the origin"
            )));
        }
        let (vertices, uvs, colors) = (self.vertices.clone(), self.uvs.clone(), self.colors.clone());
        if !self.normals.is_empty() {
            let normals =
                self.normals.iter().map(|normal| normal.try_normalize()).collect::<Option<Vec<_>>>();
            let normals = normals.ok_or_else(|| refused("a normal has no length"))?;
            let triangles = self.triangles.clone();
            return Ok(Mesh {
                positions: vertices,
                normals,
                uvs: [uvs, Vec::new()],
                colors,
                triangles,
                ..Mesh::default()
            });
        }
        let corners = || self.triangles.iter().flatten().map(|&corner| corner as usize);
        let positions: Vec<Vec3> = corners().map(|corner| vertices[corner]).collect();
        let normal = |c: &[Vec3]| [triangle_normal([c[0], c[1], c[2]]).unwrap_or(Vec3::Y); 3];
        Ok(Mesh {
            normals: positions.chunks_exact(3).flat_map(normal).collect(),
            uvs: [corners().filter_map(|corner| uvs.get(corner).copied()).collect(), Vec::new()],
            colors: corners().filter_map(|corner| colors.get(corner).copied()).collect(),
            triangles: (0..self.triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect(),
            positions,
            ..Mesh::default()
        })
    }
}
