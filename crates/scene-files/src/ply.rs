//! Polygon File Format (Turk 1994): ASCII and both binary orders.
//!
//! Vertices: `x y z`, optional normals `nx ny nz`, texture coordinates (`u v`, `s t`, `texture_u texture_v`) and colours (`red green blue`,
//! optional `alpha`; integers are sRGB, floats linear, or sRGB where they go to 255). Faces: a `vertex_indices` or `vertex_index` list of polygons of
//! any shape, texture coordinates of their corners (`texcoord`) and textures (`texnumber`, by `comment TextureFile NAME`), colours; or strips in
//! a `tristrips` element. A texture goes before colours, which programs write beside it. All other elements and properties are skipped,
//! and so are comments among the rows of text, and numbers behind a row that has lines of its own.

mod faces;
mod header;
mod values;

use std::collections::HashMap;
use std::path::Path;

use glam::{DVec3, Vec2, Vec3, Vec4};
use gnomon_picture::tonemap::srgb_decode;
use gnomon_scene::{AlphaMode, Ground, Material, MaterialId, Mesh, Scene};

use self::faces::Faces;
use self::header::{Element, Scalar};
use self::values::Values;
use super::mtl::{Map, Pictures};
use super::{Budget, LoadedScene, Source, color, geometry};
use crate::error::Fault;

/// Whether the content starts like a PLY file.
pub fn recognise(bytes: &[u8]) -> bool {
    let text = super::without_bom(bytes);
    text.strip_prefix(b"ply").is_some_and(|rest| rest.first().is_some_and(u8::is_ascii_whitespace))
}

/// Reads a PLY file: a mesh for each texture, matte grey, in its colours or with its texture, seen from both sides.
pub fn read(source: &Source, budget: &mut Budget) -> Result<LoadedScene, Fault> {
    let (header, body) = header::parse(source.bytes)?;
    let mut vertices = Vertices::default();
    let mut faces = Faces::default();
    let place =
        |wanted: &[&str]| header.elements.iter().position(|element| wanted.contains(&element.name.as_str()));
    const FACES: [&str; 2] = ["face", "tristrips"];
    // Polygons are cut by the places of their corners, which must be known.
    let passes: &[&[&str]] = match (place(&["vertex"]), place(&FACES)) {
        (Some(vertex), Some(face)) if face < vertex => &[&["vertex"], &FACES],
        _ => &[&["vertex", "face", "tristrips"]],
    };
    for wanted in passes {
        let mut values = Values::new(&header, body);
        for element in &header.elements {
            values.check_room(element)?;
            match element.name.as_str() {
                name if !wanted.contains(&name) => values.skip_element(element)?,
                "vertex" if vertices.positions.is_empty() => vertices.read(element, &mut values, budget)?,
                "face" => faces.read(element, &mut values, &vertices.positions, budget)?,
                "tristrips" => faces.read_strips(element, &mut values, vertices.positions.len(), budget)?,
                _ => values.skip_element(element)?,
            }
        }
    }
    let mut scene = Scene { warnings: std::mem::take(&mut faces.warnings), ..Scene::default() };
    scene.warnings.extend(header.warnings);
    if vertices.surplus > 0 {
        let count = vertices.surplus;
        scene
            .warnings
            .push(format!("{count} vertices hold more numbers than the header tells of: these are left out"));
    }
    if faces.triangles.is_empty() {
        scene.warnings.push("the file has no faces: nothing will be seen of it".to_owned());
    }
    let axes = source.options.axes;
    scene.origin = axes.settle(&mut vertices.positions, faces.triangles.iter().flatten().copied());
    axes.turn(&mut vertices.normals);
    if header.textures.is_empty() {
        faces.uvs = Vec::new();
    } else if faces.uvs.is_empty() && vertices.uvs.is_empty() {
        scene.warnings.push("its texture is left out: there are no texture coordinates".to_owned());
    }
    let mut pictures = Pictures::default();
    for (texture, mut mesh) in meshes(vertices, faces, budget)? {
        // Scans have holes: their inside should not vanish.
        let mut material = Material { double_sided: true, ..Material::default() };
        let name = usize::try_from(texture).ok().and_then(|texture| header.textures.get(texture));
        if let Some(name) = name.filter(|_| !mesh.uvs[0].is_empty()) {
            let places = (source, source.path.parent().unwrap_or(Path::new("")));
            let map = Map::of(name);
            material.base_color_texture = pictures.texture(Some(&map), None, places, budget, &mut scene)?;
        }
        if material.base_color_texture.is_some() {
            mesh.colors = Vec::new();
        }
        if material.base_color_texture.is_some() || !mesh.colors.is_empty() {
            material.surface.base_color = Vec3::ONE;
        }
        // An alpha of 0 everywhere is one that nobody has set.
        let alphas = || mesh.colors.iter().map(|color| color.w);
        if alphas().any(|alpha| alpha < 1.0) && alphas().any(|alpha| alpha > 0.0) {
            material.alpha_mode = AlphaMode::Blend;
        }
        mesh.material = Some(MaterialId(scene.materials.len()));
        scene.materials.push(material);
        let mesh = geometry::finish(mesh, None, "the mesh", budget, &mut scene.warnings)?;
        scene.push_mesh(&super::stem(source.path), mesh);
    }
    Ok(source.loaded(scene, Ground::Fade))
}

/// One mesh for each texture that faces name; a file without faces has one.
fn meshes(vertices: Vertices, faces: Faces, budget: &mut Budget) -> Result<Vec<(i32, Mesh)>, Fault> {
    if faces.uvs.is_empty() && faces.colors.is_empty() && faces.textures.iter().all(|texture| *texture == 0) {
        let mesh = Mesh {
            positions: vertices.positions.iter().map(|position| position.as_vec3()).collect(),
            normals: vertices.normals,
            uvs: [vertices.uvs, Vec::new()],
            colors: vertices.colors,
            triangles: faces.triangles,
            ..Mesh::default()
        };
        return Ok(vec![(0, mesh)]);
    }
    let mut meshes: Vec<(i32, Mesh)> = Vec::new();
    let mut mesh_of = HashMap::new();
    // Corners of one vertex share it where their faces say the same of it.
    let mut known: HashMap<(usize, u32, [u32; 2], [u32; 4]), u32> = HashMap::new();
    budget.take(faces.triangles.len(), 3 * (geometry::VERTEX_BYTES + 48) + geometry::TRIANGLE_BYTES)?;
    for (index, triangle) in faces.triangles.iter().enumerate() {
        let texture = faces.textures.get(index).copied().unwrap_or(0);
        let number = *mesh_of.entry(texture).or_insert_with(|| {
            meshes.push((texture, Mesh::default()));
            meshes.len() - 1
        });
        let mesh = &mut meshes[number].1;
        let face_color = faces.colors.get(index).copied();
        let corner = |corner: usize| {
            let vertex = triangle[corner] as usize;
            let uv =
                faces.uvs.get(index).map(|uvs| uvs[corner]).or_else(|| vertices.uvs.get(vertex).copied());
            let color = face_color.or_else(|| vertices.colors.get(vertex).copied());
            let uv_bits = uv.unwrap_or_default().to_array().map(f32::to_bits);
            let color_bits = face_color.unwrap_or_default().to_array().map(f32::to_bits);
            *known.entry((number, triangle[corner], uv_bits, color_bits)).or_insert_with(|| {
                mesh.positions.push(vertices.positions[vertex].as_vec3());
                mesh.normals.extend(vertices.normals.get(vertex));
                mesh.uvs[0].extend(uv);
                mesh.colors.extend(color);
                mesh.positions.len() as u32 - 1
            })
        };
        let triangle = [0, 1, 2].map(corner);
        mesh.triangles.push(triangle);
    }
    Ok(meshes)
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
        name => Role::Color(color_channel(name)?),
    })
}

/// Channel of a colour, 3 for alpha.
fn color_channel(name: &str) -> Option<usize> {
    Some(match name {
        "red" | "r" | "diffuse_red" => 0,
        "green" | "g" | "diffuse_green" => 1,
        "blue" | "b" | "diffuse_blue" => 2,
        "alpha" | "a" | "diffuse_alpha" => 3,
        _ => return None,
    })
}

/// Arrays as long as `positions`, or empty. Coordinates are the file's.
#[derive(Default)]
struct Vertices {
    positions: Vec<DVec3>,
    normals: Vec<Vec3>,
    uvs: Vec<Vec2>,
    /// Linear.
    colors: Vec<Vec4>,
    /// Rows that held more numbers than the header tells of.
    surplus: u64,
}

impl Vertices {
    fn read(&mut self, element: &Element, values: &mut Values, budget: &mut Budget) -> Result<(), Fault> {
        let roles: Vec<Option<Role>> = element
            .properties
            .iter()
            .map(|p| p.count_type.is_none().then(|| role(&p.name)).flatten())
            .collect();
        let has = |wanted: &[Role]| wanted.iter().all(|role| roles.contains(&Some(*role)));
        if !has(&[Role::Position(0), Role::Position(1), Role::Position(2)]) {
            return Err(Fault::invalid("its vertices have no x, y and z"));
        }
        let with_normals = has(&[Role::Normal(0), Role::Normal(1), Role::Normal(2)]);
        let with_uvs = has(&[Role::Uv(0), Role::Uv(1)]);
        let with_colors = has(&[Role::Color(0), Role::Color(1), Role::Color(2)]);
        let count = usize::try_from(element.count).map_err(|_| Fault::invalid("too many vertices"))?;
        let bytes_each = size_of::<DVec3>()
            + size_of::<Vec3>()
            + if with_normals { size_of::<Vec3>() } else { 0 }
            + if with_uvs { size_of::<Vec2>() } else { 0 }
            + if with_colors { size_of::<Vec4>() } else { 0 };
        budget.take(count, bytes_each)?;
        self.positions.reserve_exact(count);
        for _ in 0..count {
            let (mut position, mut normal, mut uv, mut color) =
                (DVec3::ZERO, Vec3::ZERO, Vec2::ZERO, Vec4::ONE);
            for (property, role) in element.properties.iter().zip(&roles) {
                let Some(role) = *role else {
                    values.skip(property)?;
                    continue;
                };
                let value = values.next(property.scalar)?;
                match role {
                    Role::Position(axis) => position[axis] = value,
                    Role::Normal(axis) => normal[axis] = value as f32,
                    Role::Uv(axis) => uv[axis] = value as f32,
                    Role::Color(channel) => color[channel] = linear_color(value, property.scalar, channel),
                }
            }
            self.surplus += u64::from(values.end_row());
            self.positions.push(position);
            if with_normals {
                self.normals.push(normal);
            }
            if with_uvs {
                // The file counts v from the picture's bottom.
                self.uvs.push(Vec2::new(uv.x, 1.0 - uv.y));
            }
            if with_colors {
                self.colors.push(color);
            }
        }
        linear_colors(element, &mut self.colors);
        Ok(())
    }
}

/// Linear colour or alpha for a stored one: integers are sRGB over their full range, floats are left as they are.
fn linear_color(value: f64, scalar: Scalar, channel: usize) -> f32 {
    let Some(largest) = scalar.largest_integer() else { return value as f32 };
    let encoded = (value / largest) as f32;
    if channel < 3 { srgb_decode(encoded) } else { encoded }
}

/// Takes floats of an element's colours that are sRGB of 0 to 255 to linear ones. Others are linear already.
fn linear_colors(element: &Element, colors: &mut [Vec4]) {
    let is_red = |name: &str| color_channel(name) == Some(0);
    let are_floats = element
        .properties
        .iter()
        .any(|property| is_red(&property.name) && property.scalar.largest_integer().is_none());
    if are_floats && color::is_of_bytes(colors) {
        let decode = color::decoder(colors);
        colors.iter_mut().for_each(|color| *color = decode(*color));
    }
}
