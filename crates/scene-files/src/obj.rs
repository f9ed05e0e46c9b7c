//! Wavefront OBJ: polygons with positions, texture coordinates, normals, vertex colours and a material library.
//!
//! Polygons become fans. Faces with `vn` are smooth, faces without are flat; smoothing groups are not used. One mesh
//! for each material. Lines, points, curves and surfaces are left out. Vertex colours (three or four numbers after the
//! position) are sRGB, as MeshLab writes them.

use std::collections::HashMap;

use glam::{Vec2, Vec3, Vec4};
use gnomon_messages::quoted;
use gnomon_picture::tonemap::srgb_decode;
use gnomon_scene::{Ground, Material, MaterialId, Mesh, Scene};

use super::mtl::Library;
use super::{Budget, LoadedScene, Source, geometry};
use crate::error::Fault;

/// Reads an OBJ file and the material libraries beside it. Missing libraries, materials and textures are warnings.
pub fn read(source: &Source, budget: &mut Budget) -> Result<LoadedScene, Fault> {
    let text = String::from_utf8_lossy(super::without_bom(source.bytes));
    let mut reader = Reader::default();
    // Scans have holes: their inside should not vanish.
    reader.scene.materials.push(Material { double_sided: true, ..Material::default() });
    let mut number = 0;
    let mut lines = text.lines();
    while let Some(first) = lines.next() {
        number += 1;
        let (start, mut line) = (number, first.to_owned());
        // A backslash at the end joins the next line.
        while line.trim_end().ends_with('\\') {
            line.truncate(line.trim_end().len() - 1);
            let Some(next) = lines.next() else { break };
            number += 1;
            line.push(' ');
            line.push_str(next);
        }
        reader.line(&line, source, budget).map_err(|fault| match fault {
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
    mesh: Mesh,
    vertices: HashMap<Corner, u32>,
}

#[derive(Default)]
struct Reader {
    positions: Vec<Vec3>,
    colors: Vec<Vec4>,
    uvs: Vec<Vec2>,
    normals: Vec<Vec3>,
    /// By material and whether the corners have normals, in order of first use.
    groups: Vec<Group>,
    group_of: HashMap<(usize, bool), usize>,
    library: Library,
    material: usize,
    scene: Scene,
    corners: Vec<Corner>,
    skipped: usize,
}

impl Reader {
    fn line(&mut self, line: &str, source: &Source, budget: &mut Budget) -> Result<(), Fault> {
        let line = line.split('#').next().unwrap_or_default().trim();
        let (keyword, rest) = line.split_once(|c: char| c.is_ascii_whitespace()).unwrap_or((line, ""));
        match keyword {
            "v" => {
                budget.take(1, size_of::<Vec3>() + size_of::<Vec4>())?;
                self.position(rest)?;
            }
            "vt" => {
                budget.take(1, size_of::<Vec2>())?;
                let uv = numbers::<2>(rest, 1)?.0;
                // OBJ counts v from the picture's bottom.
                self.uvs.push(Vec2::new(uv[0], 1.0 - uv[1]));
            }
            "vn" => {
                budget.take(1, size_of::<Vec3>())?;
                self.normals.push(Vec3::from_array(numbers::<3>(rest, 3)?.0));
            }
            "f" | "fo" => self.face(rest, budget)?,
            "l" | "p" => self.skipped += 1,
            "mtllib" => self.library.read(rest.trim(), source, budget, &mut self.scene)?,
            "usemtl" => self.use_material(rest.trim()),
            // Groups, objects, smoothing, and the free-form geometry that few files have.
            _ => {}
        }
        Ok(())
    }

    fn position(&mut self, rest: &str) -> Result<(), Fault> {
        let (values, count) = numbers::<7>(rest, 3)?;
        self.positions.push(Vec3::new(values[0], values[1], values[2]));
        // Three numbers, or four with a weight, have no colour.
        if count >= 6 {
            self.colors.resize(self.positions.len() - 1, Vec4::ONE);
            let [r, g, b] = [values[3], values[4], values[5]].map(srgb_decode);
            self.colors.push(Vec4::new(r, g, b, 1.0));
        }
        Ok(())
    }

    fn use_material(&mut self, name: &str) {
        self.material = match self.library.materials.get(name) {
            Some(material) => material.0,
            None => {
                let warning = format!("material '{}' is not defined: grey is used", quoted(name));
                self.scene.warnings.push(warning);
                0
            }
        };
    }

    fn face(&mut self, rest: &str, budget: &mut Budget) -> Result<(), Fault> {
        self.corners.clear();
        for word in rest.split_ascii_whitespace() {
            let corner = self.corner(word)?;
            self.corners.push(corner);
        }
        if self.corners.len() < 3 {
            self.skipped += 1;
            return Ok(());
        }
        budget.take(
            self.corners.len(),
            geometry::VERTEX_BYTES + geometry::TRIANGLE_BYTES + 3 * size_of::<Corner>(),
        )?;
        let smooth = self.corners.iter().all(|corner| corner.2.is_some());
        let groups = &mut self.groups;
        let group = *self.group_of.entry((self.material, smooth)).or_insert_with(|| {
            groups.push(Group::default());
            groups.len() - 1
        });
        let group = &mut self.groups[group];
        group.mesh.material = Some(MaterialId(self.material));
        let mut first_two = [0; 2];
        for (place, &(position, uv, normal)) in self.corners.iter().enumerate() {
            let normal = normal.filter(|_| smooth);
            let mesh = &mut group.mesh;
            let index = *group.vertices.entry((position, uv, normal)).or_insert_with(|| {
                mesh.positions.push(self.positions[position as usize]);
                // A corner without coordinates or colour takes a neutral one if others of its mesh have some.
                mesh.uvs[0].push(uv.map_or(Vec2::ZERO, |uv| self.uvs[uv as usize]));
                mesh.colors.push(self.colors.get(position as usize).copied().unwrap_or(Vec4::ONE));
                mesh.normals.extend(normal.map(|normal| self.normals[normal as usize]));
                mesh.positions.len() as u32 - 1
            });
            match place {
                0 | 1 => first_two[place] = index,
                _ => {
                    mesh.triangles.push([first_two[0], first_two[1], index]);
                    first_two[1] = index;
                }
            }
        }
        Ok(())
    }

    /// `position`, `position/uv`, `position//normal` or `position/uv/normal`; from 1, or negative from the end.
    fn corner(&self, word: &str) -> Result<Corner, Fault> {
        let mut parts = word.split('/');
        let mut part = |count: usize, what: &str| -> Result<Option<u32>, Fault> {
            let Some(text) = parts.next().filter(|text| !text.is_empty()) else { return Ok(None) };
            let number: i64 =
                text.parse().map_err(|_| Fault::Invalid(format!("'{}' is no face corner", quoted(word))))?;
            let index = if number < 0 { (count as i64).checked_add(number) } else { number.checked_sub(1) };
            let index = index.and_then(|i| u32::try_from(i).ok()).filter(|&i| (i as usize) < count);
            let missing = || Fault::Invalid(format!("a face names {what} {number}, but there are {count}"));
            index.ok_or_else(missing).map(Some)
        };
        let position = part(self.positions.len(), "vertex")?;
        let uv = part(self.uvs.len(), "texture coordinate")?;
        let normal = part(self.normals.len(), "normal")?;
        match (position, parts.next()) {
            (Some(position), None) => Ok((position, uv, normal)),
            _ => Err(Fault::Invalid(format!("'{}' is no face corner", quoted(word)))),
        }
    }

    fn finish(mut self, source: &Source, budget: &mut Budget) -> Result<LoadedScene, Fault> {
        if self.skipped > 0 {
            self.scene.warnings.push(format!(
                "left out {} points, lines and faces of fewer than three corners",
                self.skipped
            ));
        }
        if self.groups.is_empty() {
            self.scene.warnings.push("the file has no faces: nothing will be seen of it".to_owned());
        }
        let name = super::stem(source.path);
        let (has_uvs, has_colors) = (!self.uvs.is_empty(), !self.colors.is_empty());
        for mut group in self.groups {
            if !has_uvs {
                group.mesh.uvs = [Vec::new(), Vec::new()];
            }
            if !has_colors {
                group.mesh.colors = Vec::new();
            }
            let material = group.mesh.material.and_then(|id| self.scene.materials.get(id.0));
            let tangent_set = material.and_then(Material::tangent_set);
            let mesh =
                geometry::finish(group.mesh, tangent_set, "the mesh", budget, &mut self.scene.warnings)?;
            self.scene.push_mesh(&name, mesh);
        }
        if has_colors {
            // Colours multiply the base colour: let grey not darken them.
            self.scene.materials[0].surface.base_color = Vec3::ONE;
        }
        Ok(Source::loaded(self.scene, Ground::Plane))
    }
}

/// Up to `N` numbers and how many there were (more are ignored); at least `least` of them must be there.
pub fn numbers<const N: usize>(text: &str, least: usize) -> Result<([f32; N], usize), Fault> {
    let mut values = [0.0; N];
    let mut count = 0;
    for word in text.split_ascii_whitespace().take(N) {
        values[count] =
            word.parse().map_err(|_| Fault::Invalid(format!("'{}' is no number", quoted(word))))?;
        count += 1;
    }
    if count < least {
        return Err(Fault::Invalid(format!("{least} numbers expected, {count} found")));
    }
    Ok((values, count))
}
