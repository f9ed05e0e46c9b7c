//! Wavefront OBJ: polygons with positions, texture coordinates, normals, vertex colours and material libraries.
//!
//! Polygons of any shape are cut into triangles. Faces with `vn` are smooth, faces without are flat; smoothing groups are not used. One mesh
//! for each material. Lines, points, curves and surfaces are left out with a warning. Vertex colours (three or four numbers after the position) are
//! sRGB, as MeshLab writes them, of 0 to 1 or 0 to 255.
//!
//! A vertex that is no place, or a face of vertices that are not there, is an error: faces count vertices, so nothing behind it can be trusted.
//! All else that is wrong is left out with a warning. A texture coordinate or normal of a face that is not there counts as none, and so does 0.

use std::collections::HashMap;

use glam::{DVec3, Vec2, Vec3, Vec4};
use gnomon_messages::quoted;
use gnomon_scene::{Ground, Height, Material, MaterialId, Mesh, Scene};

use super::mtl::Library;
use super::polygon::Cutter;
use super::{Budget, LoadedScene, Source, color, geometry, text};
use crate::error::Fault;

/// Reads an OBJ file and the material libraries beside it. Missing libraries, materials and textures are warnings.
pub fn read(source: &Source, budget: &mut Budget) -> Result<LoadedScene, Fault> {
    let text = text::decode(source.bytes);
    let mut reader = Reader::default();
    let mut lines = text::lines(&text);
    let mut joined = String::new();
    while let Some((start, first)) = lines.next() {
        let mut line = first;
        // A backslash at the end joins the next line, but not in names or comments, where it is a folder's.
        if line.ends_with('\\') && !["#", "usemtl", "g ", "o "].iter().any(|begin| line.starts_with(begin)) {
            joined.clear();
            while let Some(part) = line.strip_suffix('\\') {
                joined.push_str(part);
                joined.push(' ');
                line = lines.next().map_or("", |(_, next)| next);
            }
            joined.push_str(line);
            line = &joined;
        }
        reader.line(line, budget).map_err(|fault| match fault {
            Fault::Invalid(message) => Fault::Invalid(format!("line {start}: {message}")),
            other => other,
        })?;
    }
    reader.finish(source, budget)
}

/// Corner of a face: indices of position, texture coordinates and normal.
type Corner = (u32, Option<u32>, Option<u32>);

/// Faces that go into one mesh.
#[derive(Default)]
struct Group {
    /// By its name's number.
    material: Option<usize>,
    corners: Vec<Corner>,
    vertex_of: HashMap<Corner, u32>,
    triangles: Vec<[u32; 3]>,
}

/// How much was left out.
#[derive(Default)]
struct LeftOut {
    lines: usize,
    surfaces: usize,
    /// Texture coordinates and normals that faces name and that are not there.
    attributes: usize,
    /// Those that are no numbers.
    values: usize,
}

impl LeftOut {
    fn warnings(&self) -> impl Iterator<Item = String> {
        let told = [
            (self.lines, "left out {} points, lines and faces of fewer than three corners"),
            (self.surfaces, "left out {} curves and surfaces"),
            (
                self.attributes,
                "faces name {} texture coordinates and normals that are not there: they have none",
            ),
            (self.values, "{} texture coordinates and normals are no numbers"),
        ];
        told.into_iter()
            .filter(|(count, _)| *count > 0)
            .map(|(count, text)| text.replace("{}", &count.to_string()))
    }
}

#[derive(Default)]
struct Reader {
    positions: Vec<DVec3>,
    /// As the file has them; shorter than `positions` where the last ones have none.
    colors: Vec<Vec4>,
    uvs: Vec<Vec2>,
    normals: Vec<Vec3>,
    /// By material and whether the corners have normals, in order of first use.
    groups: Vec<Group>,
    group_of: HashMap<(Option<usize>, bool), usize>,
    libraries: Vec<String>,
    /// Names of materials as they are used, in order of first use.
    names: Vec<String>,
    name_of: HashMap<String, usize>,
    material: Option<usize>,
    corners: Vec<Corner>,
    places: Vec<DVec3>,
    cutter: Cutter,
    left_out: LeftOut,
}

impl Reader {
    fn line(&mut self, line: &str, budget: &mut Budget) -> Result<(), Fault> {
        let (keyword, rest) = text::statement(line);
        let numbers = || text::without_comment(rest);
        match keyword {
            "v" => {
                budget.take(1, size_of::<DVec3>() + size_of::<Vec4>())?;
                self.position(numbers())?;
            }
            "vt" => {
                budget.take(1, size_of::<Vec2>())?;
                let [u, v] = self.values(numbers(), 1);
                // OBJ counts v from the picture's bottom.
                self.uvs.push(Vec2::new(u, 1.0 - v));
            }
            "vn" => {
                budget.take(1, size_of::<Vec3>())?;
                let normal = self.values(numbers(), 3);
                self.normals.push(normal.into());
            }
            "f" | "fo" => self.face(numbers(), budget)?,
            "l" | "p" => self.left_out.lines += 1,
            "curv" | "curv2" | "surf" | "bsp" | "bzp" | "cdc" | "cdp" | "res" => self.left_out.surfaces += 1,
            "mtllib" => self.libraries.push(rest.to_owned()),
            "usemtl" => self.use_material(rest, budget)?,
            // Groups, objects, smoothing.
            _ => {}
        }
        Ok(())
    }

    fn position(&mut self, rest: &str) -> Result<(), Fault> {
        let (values, count) = text::numbers::<7>(rest, 3).map_err(Fault::Invalid)?;
        self.positions.push(DVec3::new(values[0], values[1], values[2]));
        // Three numbers, or four with a weight, have no colour.
        if count >= 6 {
            self.colors.resize(self.positions.len() - 1, Vec4::ONE);
            let [r, g, b] = [values[3], values[4], values[5]].map(|value| value as f32);
            self.colors.push(Vec4::new(r, g, b, 1.0));
        }
        Ok(())
    }

    /// Numbers of a texture coordinate or normal. Those that are none keep their place: faces count them.
    fn values<const N: usize>(&mut self, rest: &str, least: usize) -> [f32; N] {
        match text::numbers::<N>(rest, least) {
            Ok((values, _)) => values.map(|value| value as f32),
            Err(_) => {
                self.left_out.values += 1;
                [f32::NAN; N]
            }
        }
    }

    fn use_material(&mut self, name: &str, budget: &mut Budget) -> Result<(), Fault> {
        if name.is_empty() {
            self.material = None;
            return Ok(());
        }
        self.material = match self.name_of.get(name) {
            Some(&known) => Some(known),
            None => {
                budget.take(2, name.len() + size_of::<String>())?;
                self.names.push(name.to_owned());
                self.name_of.insert(name.to_owned(), self.names.len() - 1);
                Some(self.names.len() - 1)
            }
        };
        Ok(())
    }

    fn face(&mut self, rest: &str, budget: &mut Budget) -> Result<(), Fault> {
        self.corners.clear();
        for word in rest.split_ascii_whitespace() {
            let corner = self.corner(word)?;
            self.corners.push(corner);
        }
        if self.corners.len() < 3 {
            self.left_out.lines += 1;
            return Ok(());
        }
        budget.take(
            self.corners.len(),
            geometry::VERTEX_BYTES + geometry::TRIANGLE_BYTES + 4 * size_of::<Corner>(),
        )?;
        let smooth = self.corners.iter().all(|corner| corner.2.is_some());
        let groups = &mut self.groups;
        let group = *self.group_of.entry((self.material, smooth)).or_insert_with(|| {
            groups.push(Group { material: self.material, ..Group::default() });
            groups.len() - 1
        });
        let group = &mut self.groups[group];
        self.places.clear();
        self.places.extend(self.corners.iter().map(|corner| self.positions[corner.0 as usize]));
        for triangle in self.cutter.cut(&self.places) {
            group.triangles.push(triangle.map(|corner| {
                let (position, uv, normal) = self.corners[corner as usize];
                let corner = (position, uv, normal.filter(|_| smooth));
                let corners = &mut group.corners;
                *group.vertex_of.entry(corner).or_insert_with(|| {
                    corners.push(corner);
                    corners.len() as u32 - 1
                })
            }));
        }
        Ok(())
    }

    /// `position`, `position/uv`, `position//normal` or `position/uv/normal`; from 1, or negative from the end.
    fn corner(&mut self, word: &str) -> Result<Corner, Fault> {
        let bad = || Fault::Invalid(format!("'{}' is no face corner", quoted(word)));
        let mut parts = word.split('/').map(|text| match text {
            "" => Ok(0),
            number => number.parse::<i64>().map_err(|_| bad()),
        });
        let mut part = || parts.next().unwrap_or(Ok(0));
        let [position, uv, normal] = [part()?, part()?, part()?];
        if parts.next().is_some() || word.starts_with('/') {
            return Err(bad());
        }
        let count = self.positions.len();
        let missing = || Fault::Invalid(format!("a face names vertex {position}, but there are {count}"));
        let mut attribute = |number: i64, count: usize| {
            let index = index_of(number, count);
            self.left_out.attributes += usize::from(number != 0 && index.is_none());
            index
        };
        let uv = attribute(uv, self.uvs.len());
        let normal = attribute(normal, self.normals.len());
        Ok((index_of(position, count).ok_or_else(missing)?, uv, normal))
    }

    fn finish(mut self, source: &Source, budget: &mut Budget) -> Result<LoadedScene, Fault> {
        let axes = source.options.axes;
        let used = self.groups.iter().flat_map(|group| &group.corners).map(|corner| corner.0);
        let mut scene = Scene { origin: axes.settle(&mut self.positions, used), ..Scene::default() };
        axes.turn(&mut self.normals);
        // Scans have holes: their inside should not vanish.
        scene.materials.push(Material { double_sided: true, ..Material::default() });
        let mut library = Library::default();
        for names in &self.libraries {
            library.read(names, source, budget, &mut scene)?;
        }
        scene.warnings.extend(self.left_out.warnings().chain(self.cutter.warning()));
        if self.groups.is_empty() {
            scene.warnings.push("the file has no faces: nothing will be seen of it".to_owned());
        }
        let name = super::stem(source.path);
        let has_colors = !self.colors.is_empty();
        let decode = color::decoder(&self.colors);
        for group in std::mem::take(&mut self.groups) {
            let material = group
                .material
                .map_or(MaterialId(0), |name| library.material(&self.names[name], &mut scene.warnings));
            let corners = || group.corners.iter();
            let mut mesh = Mesh {
                positions: corners().map(|corner| self.positions[corner.0 as usize].as_vec3()).collect(),
                normals: corners().filter_map(|corner| Some(self.normals[corner.2? as usize])).collect(),
                triangles: group.triangles,
                material: Some(material),
                ..Mesh::default()
            };
            if !self.uvs.is_empty() {
                // A corner without coordinates or colour takes a neutral one if others of its mesh have some.
                mesh.uvs[0] =
                    corners().map(|corner| corner.1.map_or(Vec2::ZERO, |uv| self.uvs[uv as usize])).collect();
            }
            if has_colors {
                let color = |corner: &Corner| {
                    self.colors.get(corner.0 as usize).map_or(Vec4::ONE, |color| decode(*color))
                };
                mesh.colors = corners().map(color).collect();
            }
            let tangent_set = scene.materials[material.0].tangent_set();
            let mesh = geometry::finish(mesh, tangent_set, "the mesh", budget, &mut scene.warnings)?;
            scene.push_mesh(&name, mesh);
        }
        // Strengths of heights are in hundredths of the picture's width.
        for material in 0..scene.materials.len() {
            let width = scene.height_extent(material).map(|extent| (extent.x * extent.y).sqrt());
            let height = &mut scene.materials[material].height;
            *height = height
                .zip(width)
                .map(|(height, width)| Height { scale: 0.01 * width * height.scale, ..height });
        }
        if has_colors {
            // Colours multiply the base colour: let grey not darken them.
            scene.materials[0].surface.base_color = Vec3::ONE;
        }
        Ok(source.loaded(scene, Ground::Fade))
    }
}

/// The index that a number of a file means, from 1, or negative from the end, among so many; `None` for 0 and beyond.
fn index_of(number: i64, count: usize) -> Option<u32> {
    let index = if number < 0 { number.checked_add_unsigned(count as u64) } else { number.checked_sub(1) };
    index.and_then(|i| u32::try_from(i).ok()).filter(|&i| (i as usize) < count)
}
