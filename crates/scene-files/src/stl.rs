//! STL, ASCII (comments behind `#` included) and binary: triangles without shared corners, lit flat. Their stored normals are not used: programs write zeros there, or wrong ones.
//!
//! Colours of triangles in binary files are sRGB of five bits a channel in the two bytes behind each: as VisCAM and SolidView write them, blue first,
//! valid where the highest bit is set; or as Materialise Magics does, whose header has `COLOR=` and the colour of all, red first, where it is not.

use glam::{DVec3, Vec3, Vec4};
use gnomon_picture::tonemap::srgb_decode;
use gnomon_scene::{Ground, Material, MaterialId, Mesh, Scene};

use super::polygon::Cutter;
use super::{Budget, LoadedScene, Source, geometry, text};
use crate::error::Fault;

const HEADER: usize = 80;
/// Normal, three corners and two bytes.
const TRIANGLE: usize = 50;

/// Reads an STL file: one mesh, matte grey or in its colours, seen from both sides.
pub fn read(source: &Source, budget: &mut Budget) -> Result<LoadedScene, Fault> {
    let Triangles { mut corners, colors } =
        if is_text(source.bytes) { ascii(source.bytes, budget)? } else { binary(source.bytes, budget)? };
    let axes = source.options.axes;
    let count = u32::try_from(corners.len()).map_err(|_| Fault::invalid("too many triangles"))?;
    let mut scene = Scene { origin: axes.settle(&mut corners, 0..count), ..Scene::default() };
    if corners.is_empty() {
        scene.warnings.push("the file has no triangles: nothing will be seen of it".to_owned());
    }
    // Scans have holes: their inside should not vanish.
    let mut material = Material { double_sided: true, ..Material::default() };
    if !colors.is_empty() {
        material.surface.base_color = Vec3::ONE;
    }
    scene.materials.push(material);
    let mesh = Mesh {
        triangles: (0..count / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect(),
        positions: corners.iter().map(|corner| corner.as_vec3()).collect(),
        colors,
        material: Some(MaterialId(0)),
        ..Mesh::default()
    };
    let mesh = geometry::finish(mesh, None, "the mesh", budget, &mut scene.warnings)?;
    scene.push_mesh(&super::stem(source.path), mesh);
    Ok(source.loaded(scene, Ground::Fade))
}

/// Three corners a triangle, and linear colours of all corners, or none.
#[derive(Default)]
struct Triangles {
    corners: Vec<DVec3>,
    colors: Vec<Vec4>,
}

/// Number of triangles that a binary file announces.
fn announced(bytes: &[u8]) -> Option<usize> {
    let count = bytes.get(HEADER..HEADER + 4)?.first_chunk()?;
    Some(u32::from_le_bytes(*count) as usize)
}

/// Whether a file is text: binary ones may begin with `solid` too, but are as long as they say.
fn is_text(bytes: &[u8]) -> bool {
    let is_binary = announced(bytes).is_some_and(|count| HEADER + 4 + TRIANGLE * count == bytes.len());
    let begin = text::decode(&bytes[..bytes.len().min(4096) & !1]).to_ascii_lowercase();
    let first =
        text::lines(&begin).map(|(_, line)| line).find(|line| !line.is_empty() && !line.starts_with('#'));
    let is_solid = first.is_some_and(|line| line.starts_with("solid"));
    !is_binary && is_solid && (begin.contains("facet") || begin.contains("endsolid"))
}

fn binary(bytes: &[u8], budget: &mut Budget) -> Result<Triangles, Fault> {
    let count =
        announced(bytes).ok_or_else(|| Fault::invalid("it is no STL: neither text nor long enough"))?;
    let (rows, _) = bytes[HEADER + 4..].as_chunks::<TRIANGLE>();
    if rows.len() < count {
        return Err(Fault::Invalid(format!(
            "it promises {count} triangles, but has room for {}",
            rows.len()
        )));
    }
    let rows = &rows[..count];
    budget.take(count, 3 * (size_of::<DVec3>() + geometry::VERTEX_BYTES) + geometry::TRIANGLE_BYTES)?;
    let mut triangles = Triangles { corners: Vec::with_capacity(3 * count), ..Triangles::default() };
    let colors = Colors::of(&bytes[..HEADER], rows);
    for row in rows {
        let (words, _) = row[12..48].as_chunks::<4>();
        let [x, y, z] = [0, 1, 2].map(|axis| words.iter().skip(axis).step_by(3));
        for ((x, y), z) in x.zip(y).zip(z) {
            let place = [x, y, z].map(|word| f64::from(f32::from_le_bytes(*word)));
            triangles.corners.push(place.into());
        }
        triangles.colors.extend(colors.iter().flat_map(|colors| [colors.linear(attribute(row)); 3]));
    }
    Ok(triangles)
}

fn attribute(row: &[u8; TRIANGLE]) -> u16 {
    u16::from_le_bytes([row[48], row[49]])
}

/// Which colours a binary file has.
enum Colors {
    /// Blue in the lowest bits.
    VisCam,
    /// Red in the lowest bits; the colour of what has none of its own.
    Materialise(Vec4),
}

impl Colors {
    /// `None` for a file without any.
    fn of(header: &[u8], rows: &[[u8; TRIANGLE]]) -> Option<Self> {
        const MARK: &[u8] = b"COLOR=";
        let marked = header.windows(MARK.len() + 4).find(|window| window.starts_with(MARK));
        if let Some(window) = marked {
            let [r, g, b] =
                [0, 1, 2].map(|channel| srgb_decode(f32::from(window[MARK.len() + channel]) / 255.0));
            return Some(Self::Materialise(Vec4::new(r, g, b, 1.0)));
        }
        rows.iter().any(|row| attribute(row) & 0x8000 != 0).then_some(Self::VisCam)
    }

    fn linear(&self, attribute: u16) -> Vec4 {
        let channel = |shift: u16| srgb_decode(f32::from(attribute >> shift & 31) / 31.0);
        let [low, middle, high] = [channel(0), channel(5), channel(10)];
        match (self, attribute & 0x8000 != 0) {
            (Self::VisCam, true) => Vec4::new(high, middle, low, 1.0),
            // As grey as without colours.
            (Self::VisCam, false) => Material::default().surface.base_color.extend(1.0),
            (Self::Materialise(_), false) => Vec4::new(low, middle, high, 1.0),
            (Self::Materialise(all), true) => *all,
        }
    }
}

fn ascii(bytes: &[u8], budget: &mut Budget) -> Result<Triangles, Fault> {
    let text = text::decode(bytes);
    let mut triangles = Triangles::default();
    let (mut polygon, mut cutter) = (Vec::new(), Cutter::default());
    for (number, line) in text::lines(&text) {
        let at = |message: String| Fault::Invalid(format!("line {number}: {message}"));
        let mut rest = text::without_comment(line);
        while !rest.is_empty() {
            let (keyword, after) = text::statement(rest);
            rest = after;
            match keyword.to_ascii_lowercase().as_str() {
                // A name follows, or nothing.
                "solid" | "endsolid" => rest = "",
                "vertex" => {
                    let (place, _) = text::numbers::<3>(rest, 3).map_err(at)?;
                    budget.take(1, size_of::<DVec3>())?;
                    polygon.push(DVec3::from_array(place));
                    rest = text::words(rest).nth(3).map_or("", |word| &rest[word.start..]);
                }
                "endloop" | "endfacet" => {
                    for triangle in cutter.cut(&polygon) {
                        budget.take(3, size_of::<DVec3>() + geometry::VERTEX_BYTES)?;
                        triangles.corners.extend(triangle.map(|corner| polygon[corner as usize]));
                    }
                    polygon.clear();
                }
                // Facets with their normals, loops.
                _ => {}
            }
        }
    }
    if polygon.is_empty() { Ok(triangles) } else { Err(Fault::invalid("the file ends within a facet")) }
}
