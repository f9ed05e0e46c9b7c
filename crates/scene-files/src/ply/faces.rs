//! Faces of a PLY file: polygons and strips, what they say of their corners, their colours.

use glam::{DVec3, Vec2, Vec4};

use super::header::{Element, Property};
use super::values::Values;
use super::{color_channel, linear_color, linear_colors};
use crate::error::Fault;
use crate::polygon::Cutter;
use crate::{Budget, geometry};

/// Triangles, and what belongs to each. Lists are as long as `triangles` or empty.
#[derive(Default)]
pub struct Faces {
    /// Vertices of the corners.
    pub triangles: Vec<[u32; 3]>,
    /// Texture coordinates of the corners, v from the top.
    pub uvs: Vec<[Vec2; 3]>,
    /// Number of the texture.
    pub textures: Vec<i32>,
    /// Linear colours.
    pub colors: Vec<Vec4>,
    pub warnings: Vec<String>,
    cutter: Cutter,
    places: Vec<DVec3>,
}

/// What a face property means.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Role {
    Corners,
    Uvs,
    Texture,
    Color(usize),
}

fn role(property: &Property) -> Option<Role> {
    match (property.name.as_str(), property.count_type) {
        ("vertex_indices" | "vertex_index", Some(_)) => Some(Role::Corners),
        ("texcoord", Some(_)) => Some(Role::Uvs),
        ("texnumber", None) => Some(Role::Texture),
        (name, None) => color_channel(name).map(Role::Color),
        _ => None,
    }
}

impl Faces {
    /// Reads polygons of vertices at `positions`.
    pub fn read(
        &mut self,
        element: &Element,
        values: &mut Values,
        positions: &[DVec3],
        budget: &mut Budget,
    ) -> Result<(), Fault> {
        index_list(element)?;
        let roles: Vec<Option<Role>> = element.properties.iter().map(role).collect();
        let has = |role: Role| roles.contains(&Some(role));
        let has_colors = (0..3).all(|channel| has(Role::Color(channel)));
        let bytes_each = geometry::TRIANGLE_BYTES
            + if has(Role::Uvs) { size_of::<[Vec2; 3]>() } else { 0 }
            + if has(Role::Texture) { size_of::<i32>() } else { 0 }
            + if has_colors { size_of::<Vec4>() } else { 0 };
        let mut row = Row::default();
        let (mut skipped, mut surplus) = (0_u64, 0_u64);
        for face in 0..element.count {
            for (property, role) in element.properties.iter().zip(&roles) {
                match role {
                    Some(Role::Corners) => values.list(property, &mut row.corners)?,
                    Some(Role::Uvs) => values.list(property, &mut row.uvs)?,
                    Some(Role::Texture) => row.texture = values.next(property.scalar)? as i32,
                    Some(Role::Color(channel)) => {
                        let value = values.next(property.scalar)?;
                        row.color[*channel] = linear_color(value, property.scalar, *channel);
                    }
                    None => values.skip(property)?,
                }
            }
            surplus += u64::from(values.end_row());
            if row.corners.len() < 3 {
                skipped += 1;
                continue;
            }
            budget.take(row.corners.len() - 2, bytes_each)?;
            self.places.clear();
            for &value in &row.corners {
                let index = vertex_index(value, positions.len())
                    .map_err(|why| bad_index("face", face, value, &why))?;
                self.places.push(positions[index as usize]);
            }
            for triangle in self.cutter.cut(&self.places) {
                self.triangles.push(triangle.map(|corner| row.corners[corner as usize] as u32));
                if has(Role::Uvs) {
                    self.uvs.push(triangle.map(|corner| row.uv(corner as usize)));
                }
                if has(Role::Texture) {
                    self.textures.push(row.texture);
                }
                if has_colors {
                    self.colors.push(row.color);
                }
            }
        }
        if skipped > 0 {
            self.warnings.push(format!("left out {skipped} faces of fewer than three corners"));
        }
        self.warnings.extend(self.cutter.warning());
        linear_colors(element, &mut self.colors);
        if surplus > 0 {
            // MeshLab writes colours of corners that the header does not tell of: no column behind them is what the header says.
            self.colors = Vec::new();
            self.warnings.push(format!(
                "{surplus} faces hold more numbers than the header tells of: these, and colours of faces, are left out"
            ));
        }
        Ok(())
    }

    /// Triangle strips, -1 beginning a new one; every second triangle is turned over.
    pub fn read_strips(
        &mut self,
        element: &Element,
        values: &mut Values,
        vertex_count: usize,
        budget: &mut Budget,
    ) -> Result<(), Fault> {
        let list = index_list(element)?;
        let mut corners = Vec::new();
        for strip in 0..element.count {
            for (column, property) in element.properties.iter().enumerate() {
                if column != list {
                    values.skip(property)?;
                    continue;
                }
                values.list(property, &mut corners)?;
                budget.take(corners.len(), geometry::TRIANGLE_BYTES)?;
                for run in corners.split(|&value| value == -1.0) {
                    for (step, window) in run.windows(3).enumerate() {
                        let mut triangle = [0; 3];
                        for (corner, &value) in triangle.iter_mut().zip(window) {
                            *corner = vertex_index(value, vertex_count)
                                .map_err(|why| bad_index("strip", strip, value, &why))?;
                        }
                        if step % 2 == 1 {
                            triangle.swap(0, 1);
                        }
                        self.triangles.push(triangle);
                    }
                }
            }
            values.end_row();
        }
        Ok(())
    }
}

/// One face as its row has it.
struct Row {
    corners: Vec<f64>,
    uvs: Vec<f64>,
    texture: i32,
    color: Vec4,
}

impl Default for Row {
    fn default() -> Self {
        Self { corners: Vec::new(), uvs: Vec::new(), texture: 0, color: Vec4::ONE }
    }
}

impl Row {
    /// Texture coordinates of a corner, which the file counts from the picture's bottom; 0 where it gives none.
    fn uv(&self, corner: usize) -> Vec2 {
        match self.uvs.get(2 * corner..2 * corner + 2) {
            Some(&[u, v]) => Vec2::new(u as f32, 1.0 - v as f32),
            _ => Vec2::ZERO,
        }
    }
}

/// Column of the list that holds vertex indices.
fn index_list(element: &Element) -> Result<usize, Fault> {
    let found = element.properties.iter().position(|property| role(property) == Some(Role::Corners));
    found.ok_or_else(|| Fault::Invalid(format!("its {} element has no vertex_indices list", element.name)))
}

/// The index that a number is, or why it is none.
fn vertex_index(value: f64, count: usize) -> Result<u32, String> {
    if !(value >= 0.0 && value <= f64::from(u32::MAX) && value.fract() == 0.0) {
        return Err("which is no index".to_owned());
    }
    if value >= count as f64 {
        return Err(format!("but there are {count}"));
    }
    Ok(value as u32)
}

fn bad_index(what: &str, number: u64, value: f64, why: &str) -> Fault {
    Fault::Invalid(format!("{what} {number} names vertex {value}, {why}"))
}
