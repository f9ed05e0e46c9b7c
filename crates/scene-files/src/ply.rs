//! Polygon File Format (Turk 1994): ASCII and both binary orders.
//!
//! Vertices: `x y z`, optional normals `nx ny nz`, texture coordinates (`u v`, `s t`, `texture_u texture_v`) and colours
//! (`red green blue`, optional `alpha`; integers are sRGB, floats linear). Faces: a `vertex_indices` or `vertex_index`
//! list (polygons become fans), or strips in a `tristrips` element. All other elements and properties are skipped.

mod header;

use glam::{Vec2, Vec3, Vec4};
use gnomon_picture::tonemap::srgb_decode;
use gnomon_scene::{Ground, Material, MaterialId, Mesh, Scene};

use self::header::{Element, Encoding, Property, Scalar};
use super::{Budget, LoadedScene, Source, geometry};
use crate::error::Fault;

/// Whether the content starts like a PLY file.
pub fn recognise(bytes: &[u8]) -> bool {
    bytes.starts_with(b"ply\n") || bytes.starts_with(b"ply\r")
}

/// Reads a PLY file: one mesh, matte grey (or its vertex colours), seen from both sides.
pub fn read(source: &Source, budget: &mut Budget) -> Result<LoadedScene, Fault> {
    let (header, body) = header::parse(source.bytes)?;
    let mut values = Values { encoding: header.encoding, rest: body };
    let mut mesh = Mesh::default();
    let mut scene = Scene::default();
    let mut faces = Faces::default();
    let mut has_vertices = false;
    for element in &header.elements {
        values.check_room(element)?;
        match element.name.as_str() {
            "vertex" if !has_vertices => {
                has_vertices = true;
                read_vertices(element, &mut values, budget, &mut mesh)?;
            }
            "face" => faces.read(element, &mut values, budget)?,
            "tristrips" => faces.read_strips(element, &mut values, budget)?,
            _ => skip(element, &mut values)?,
        }
    }
    let vertex_count = mesh.positions.len();
    if let Some(index) = faces.triangles.iter().flatten().find(|&&index| index as usize >= vertex_count) {
        return Err(Fault::Invalid(format!("a face names vertex {index}, but there are {vertex_count}")));
    }
    if faces.skipped > 0 {
        scene.warnings.push(format!("left out {} faces of fewer than three corners", faces.skipped));
    }
    if faces.triangles.is_empty() {
        scene.warnings.push("the file has no faces: nothing will be seen of it".to_owned());
    }
    mesh.triangles = faces.triangles;
    // Scans have holes: their inside should not vanish.
    let mut material = Material { double_sided: true, ..Material::default() };
    if !mesh.colors.is_empty() {
        material.surface.base_color = Vec3::ONE;
    }
    mesh.material = Some(MaterialId(0));
    scene.materials.push(material);
    let name = super::stem(source.path);
    let mesh = geometry::finish(mesh, None, "the mesh", budget, &mut scene.warnings)?;
    scene.push_mesh(&name, mesh);
    Ok(Source::loaded(scene, Ground::Plane))
}

/// What a vertex property means.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Role {
    Position(usize),
    Normal(usize),
    Uv(usize),
    Color(usize),
}

fn role(name: &str) -> Option<Role> {
    Some(match name {
        "x" => Role::Position(0),
        "y" => Role::Position(1),
        "z" => Role::Position(2),
        "nx" => Role::Normal(0),
        "ny" => Role::Normal(1),
        "nz" => Role::Normal(2),
        "u" | "s" | "texture_u" => Role::Uv(0),
        "v" | "t" | "texture_v" => Role::Uv(1),
        "red" | "r" | "diffuse_red" => Role::Color(0),
        "green" | "g" | "diffuse_green" => Role::Color(1),
        "blue" | "b" | "diffuse_blue" => Role::Color(2),
        "alpha" | "a" | "diffuse_alpha" => Role::Color(3),
        _ => return None,
    })
}

fn read_vertices(
    element: &Element,
    values: &mut Values,
    budget: &mut Budget,
    mesh: &mut Mesh,
) -> Result<(), Fault> {
    let roles: Vec<Option<Role>> =
        element.properties.iter().map(|p| p.count_type.is_none().then(|| role(&p.name)).flatten()).collect();
    let has = |wanted: &[Role]| wanted.iter().all(|role| roles.contains(&Some(*role)));
    if !has(&[Role::Position(0), Role::Position(1), Role::Position(2)]) {
        return Err(Fault::invalid("its vertices have no x, y and z"));
    }
    let with_normals = has(&[Role::Normal(0), Role::Normal(1), Role::Normal(2)]);
    let with_uvs = has(&[Role::Uv(0), Role::Uv(1)]);
    let with_colors = has(&[Role::Color(0), Role::Color(1), Role::Color(2)]);
    let count = usize::try_from(element.count).map_err(|_| Fault::invalid("too many vertices"))?;
    budget.take(count, geometry::VERTEX_BYTES)?;
    mesh.positions.reserve_exact(count);
    for _ in 0..count {
        let (mut position, mut normal, mut uv, mut color) = (Vec3::ZERO, Vec3::ZERO, Vec2::ZERO, Vec4::ONE);
        for (property, role) in element.properties.iter().zip(&roles) {
            if property.count_type.is_some() {
                values.skip_list(property)?;
                continue;
            }
            let value = values.next(property.scalar)?;
            match *role {
                Some(Role::Position(axis)) => position[axis] = value as f32,
                Some(Role::Normal(axis)) => normal[axis] = value as f32,
                Some(Role::Uv(axis)) => uv[axis] = value as f32,
                Some(Role::Color(channel)) => color[channel] = linear_color(value, property.scalar, channel),
                None => {}
            }
        }
        mesh.positions.push(position);
        if with_normals {
            mesh.normals.push(normal);
        }
        if with_uvs {
            // The file counts v from the picture's bottom.
            mesh.uvs[0].push(Vec2::new(uv.x, 1.0 - uv.y));
        }
        if with_colors {
            mesh.colors.push(color);
        }
    }
    Ok(())
}

/// Linear colour or alpha for a stored one: integers are sRGB over their full range, floats linear already.
fn linear_color(value: f64, scalar: Scalar, channel: usize) -> f32 {
    let Some(largest) = scalar.largest_integer() else { return value as f32 };
    let encoded = (value / largest) as f32;
    if channel < 3 { srgb_decode(encoded) } else { encoded }
}

#[derive(Default)]
struct Faces {
    triangles: Vec<[u32; 3]>,
    skipped: usize,
}

impl Faces {
    fn read(&mut self, element: &Element, values: &mut Values, budget: &mut Budget) -> Result<(), Fault> {
        let list = index_list(element)?;
        let mut corners = Vec::new();
        for face in 0..element.count {
            for (column, property) in element.properties.iter().enumerate() {
                if column != list {
                    values.skip(property)?;
                    continue;
                }
                values.list(property, &mut corners)?;
                let [first, rest @ ..] = corners.as_slice() else {
                    self.skipped += 1;
                    continue;
                };
                if rest.len() < 2 {
                    self.skipped += 1;
                    continue;
                }
                let index = |value: &f64| vertex_index(*value).ok_or_else(|| bad_index("face", face, *value));
                budget.take(rest.len() - 1, geometry::TRIANGLE_BYTES)?;
                for pair in rest.windows(2) {
                    self.triangles.push([index(first)?, index(&pair[0])?, index(&pair[1])?]);
                }
            }
        }
        Ok(())
    }

    /// Triangle strips, -1 beginning a new one; every second triangle is turned over.
    fn read_strips(
        &mut self,
        element: &Element,
        values: &mut Values,
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
                            *corner = vertex_index(value).ok_or_else(|| bad_index("strip", strip, value))?;
                        }
                        if step % 2 == 1 {
                            triangle.swap(0, 1);
                        }
                        self.triangles.push(triangle);
                    }
                }
            }
        }
        Ok(())
    }
}

/// Column of the list that holds vertex indices.
fn index_list(element: &Element) -> Result<usize, Fault> {
    let is_list =
        |p: &Property| p.count_type.is_some() && matches!(p.name.as_str(), "vertex_indices" | "vertex_index");
    let found = element.properties.iter().position(is_list);
    found.ok_or_else(|| Fault::Invalid(format!("its {} element has no vertex_indices list", element.name)))
}

fn vertex_index(value: f64) -> Option<u32> {
    (value >= 0.0 && value <= f64::from(u32::MAX) && value.fract() == 0.0).then_some(value as u32)
}

fn bad_index(what: &str, number: u64, value: f64) -> Fault {
    Fault::Invalid(format!("{what} {number} names vertex {value}, which is no index"))
}

fn skip(element: &Element, values: &mut Values) -> Result<(), Fault> {
    if element.properties.is_empty() {
        return Ok(());
    }
    for _ in 0..element.count {
        for property in &element.properties {
            values.skip(property)?;
        }
    }
    Ok(())
}

/// The numbers after the header, in file order.
struct Values<'a> {
    encoding: Encoding,
    rest: &'a [u8],
}

impl Values<'_> {
    /// Refuses an element that promises more than the rest of the file can hold, before anything is allocated for it.
    fn check_room(&self, element: &Element) -> Result<(), Fault> {
        let smallest = |p: &Property| match self.encoding {
            // One digit and a separator.
            Encoding::Ascii => 2,
            Encoding::Little | Encoding::Big => p.count_type.unwrap_or(p.scalar).size() as u64,
        };
        let row: u64 = element.properties.iter().map(smallest).sum();
        // The last separator may be missing.
        let room = self.rest.len() as u64 + 1;
        if element.count.checked_mul(row).is_none_or(|bytes| bytes > room) {
            return Err(Fault::Invalid(format!(
                "the header promises {} {} elements, more than the file has room for",
                element.count, element.name
            )));
        }
        Ok(())
    }

    fn next(&mut self, scalar: Scalar) -> Result<f64, Fault> {
        let truncated = || Fault::invalid("the file ends too early");
        if self.encoding == Encoding::Ascii {
            let start = self.rest.iter().position(|b| !b.is_ascii_whitespace()).ok_or_else(truncated)?;
            let token = &self.rest[start..];
            let end = token.iter().position(u8::is_ascii_whitespace).unwrap_or(token.len());
            let (token, rest) = token.split_at(end);
            self.rest = rest;
            let text = std::str::from_utf8(token).ok();
            return text.and_then(|text| text.parse().ok()).ok_or_else(|| {
                let text = String::from_utf8_lossy(&token[..token.len().min(40)]).into_owned();
                Fault::Invalid(format!("'{text}' stands where a number should"))
            });
        }
        let (bytes, rest) = self.rest.split_at_checked(scalar.size()).ok_or_else(truncated)?;
        self.rest = rest;
        let mut word = [0; 8];
        let word = &mut word[..bytes.len()];
        word.copy_from_slice(bytes);
        if self.encoding == Encoding::Big {
            word.reverse();
        }
        Ok(scalar.decode(word))
    }

    fn count(&mut self, count_type: Scalar, item: Scalar) -> Result<usize, Fault> {
        let count = self.next(count_type)?;
        let smallest = if self.encoding == Encoding::Ascii { 2 } else { item.size() };
        let room = (self.rest.len() + 1) / smallest;
        if !(count >= 0.0 && count.fract() == 0.0 && count <= room as f64) {
            return Err(Fault::Invalid(format!(
                "a list promises {count} items, but the file has room for {room}"
            )));
        }
        Ok(count as usize)
    }

    fn list(&mut self, property: &Property, items: &mut Vec<f64>) -> Result<(), Fault> {
        items.clear();
        let count = self.count(property.count_type.unwrap_or(Scalar::U8), property.scalar)?;
        for _ in 0..count {
            items.push(self.next(property.scalar)?);
        }
        Ok(())
    }

    fn skip_list(&mut self, property: &Property) -> Result<(), Fault> {
        let count = self.count(property.count_type.unwrap_or(Scalar::U8), property.scalar)?;
        for _ in 0..count {
            self.next(property.scalar)?;
        }
        Ok(())
    }

    fn skip(&mut self, property: &Property) -> Result<(), Fault> {
        if property.count_type.is_some() {
            self.skip_list(property)
        } else {
            self.next(property.scalar).map(|_| ())
        }
    }
}
