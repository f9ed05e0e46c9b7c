//! OBJ's material libraries, translated to metallic-roughness. Keywords are compared without case. A statement that cannot be understood is
//! left out with a warning.
//!
//! | MTL | here |
//! |---|---|
//! | `Kd`, `map_Kd` | base colour (`Kd` linear, the map sRGB) |
//! | `map_d` | holes where it is below a half: in its alpha, or in its brightness where it has none |
//! | `Ke`, `map_Ke` | emission |
//! | `Ks` | dielectric reflection: its largest channel is the strength, its hue the tint; black, or `illum` 0 or 1, is exactly Lambert |
//! | `Ns` | roughness: Blinn-Phong's exponent to GGX, `alpha = sqrt(2 / (Ns + 2))`, `roughness = sqrt(alpha)` (Walter et al. 2007, eq. in section 5.3) |
//! | `Ni` | index of refraction |
//! | `Pr`, `Pm`, `norm` | roughness, metallic, normal map (the physically based extension) |
//! | `map_bump`, `bump` | heights: from black to white `-bm` hundredths of the picture's width on the surface, as no unit is given (`obj.rs`) |
//! | `d`, `Tr` below 1 | opaque, with a warning; `d` goes before `Tr`, which some programs write like `d` |
//! | `xyz`, `spectral` colours | CIE XYZ; spectral curves are not read |
//! | `-s`, `-o`, `-clamp`, `-imfchan` of maps, `-bm` of `norm` | as they say |
//! | other maps, turbulence | a warning: they have no effect |
//!
//! A material that is defined twice is the last one of its library, and that of the first library of several.

use std::collections::{BTreeSet, HashMap};
use std::path::Path;

use glam::Vec3;
use gnomon_messages::quoted;
use gnomon_picture::rec709_from_xyz;
use gnomon_scene::{AlphaMode, Material, MaterialId, Scene, Texture};

use super::{Budget, Source, text};
use crate::error::Fault;

mod map;
mod pictures;

pub use map::Map;
pub use pictures::Pictures;

/// Materials by name, and pictures by file name.
#[derive(Default)]
pub struct Library {
    materials: HashMap<String, MaterialId>,
    pictures: Pictures,
}

impl Library {
    /// Reads the libraries that a line names into `scene`: one, or several. One that is missing is a warning.
    pub fn read(
        &mut self,
        names: &str,
        source: &Source,
        budget: &mut Budget,
        scene: &mut Scene,
    ) -> Result<(), Fault> {
        let single = || std::iter::once(names).chain(text::names(names));
        let files = match source.find(single(), &[], budget) {
            Ok(found) => vec![Ok(found)],
            Err(fault @ Fault::TooLarge { .. }) => return Err(fault),
            Err(_) => libraries(names).map(|name| source.find(text::names(name), &[], budget)).collect(),
        };
        for file in files {
            match file {
                Ok((path, bytes)) => self.file(&path, &bytes, source, budget, scene)?,
                Err(fault @ Fault::TooLarge { .. }) => return Err(fault),
                Err(fault) => {
                    scene.warnings.push(format!("materials are left out: {}", fault.at(source.path)))
                }
            }
        }
        Ok(())
    }

    /// The material that is used by this name; the first one, with a warning, where there is none.
    pub fn material(&self, name: &str, warnings: &mut Vec<String>) -> MaterialId {
        let found = text::names(name).find_map(|name| self.materials.get(&key(name)));
        found.copied().unwrap_or_else(|| {
            warnings.push(format!("material '{}' is not defined: grey is used", quoted(name)));
            MaterialId(0)
        })
    }

    fn file(
        &mut self,
        path: &Path,
        bytes: &[u8],
        source: &Source,
        budget: &mut Budget,
        scene: &mut Scene,
    ) -> Result<(), Fault> {
        let folder = path.parent().unwrap_or(Path::new(""));
        let text = text::decode(bytes);
        let mut entries: Vec<Entry> = Vec::new();
        let mut without_effect = BTreeSet::new();
        for (number, line) in
            text::lines(&text).filter(|(_, line)| !line.is_empty() && !line.starts_with('#'))
        {
            let (keyword, rest) = text::statement(line);
            let keyword = keyword.to_ascii_lowercase();
            if keyword == "newmtl" {
                budget.take(1, size_of::<Entry>() + 2 * rest.len())?;
                entries.push(Entry::new(rest));
            } else if let Some(entry) = entries.last_mut()
                && let Err(message) = entry.statement(&keyword, rest, &mut without_effect)
            {
                let file = quoted(&path.file_name().unwrap_or_default().to_string_lossy());
                scene.warnings.push(format!("{file}, line {number} is left out: {message}"));
            }
        }
        if !without_effect.is_empty() {
            let list = without_effect.into_iter().collect::<Vec<_>>().join(", ");
            scene.warnings.push(format!("statements of materials that have no effect here: {list}"));
        }
        let mut own = HashMap::new();
        for entry in entries {
            let names: Vec<String> = text::names(&entry.name).map(key).collect();
            let id = MaterialId(scene.materials.len());
            if own.insert(names[0].clone(), id).is_some() {
                scene
                    .warnings
                    .push(format!("material '{}' is defined twice: the last one counts", quoted(&names[0])));
            }
            // What may be a comment is one where nobody has the whole name.
            for name in names.into_iter().skip(1) {
                own.entry(name).or_insert(id);
            }
            let material = entry.finish(&mut self.pictures, (source, folder), budget, scene)?;
            scene.materials.push(material);
        }
        for (name, id) in own {
            self.materials.entry(name).or_insert(id);
        }
        Ok(())
    }
}

/// The names of several libraries, each of which ends in `.mtl`.
fn libraries(names: &str) -> impl Iterator<Item = &str> {
    let mut start = 0;
    let mut ends: Vec<usize> = text::words(names)
        .map(|word| word.end)
        .filter(|&end| names[..end].trim_end_matches('"').to_ascii_lowercase().ends_with(".mtl"))
        .collect();
    if ends.is_empty() {
        ends.push(names.len());
    }
    ends.into_iter().map(move |end| {
        let name = names[start..end].trim();
        start = end;
        name
    })
}

/// What names are compared by: blanks are as good as any other number of them.
fn key(name: &str) -> String {
    name.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Maps that are no part of a material here, by their keywords.
const WITHOUT_EFFECT: [(&str, &str); 12] = [
    ("disp", "disp"),
    ("map_disp", "disp"),
    ("decal", "decal"),
    ("refl", "refl"),
    ("map_refl", "refl"),
    ("map_ks", "map_Ks"),
    ("map_ns", "map_Ns"),
    ("map_pr", "map_Pr"),
    ("map_pm", "map_Pm"),
    ("map_ps", "map_Ps"),
    ("map_tr", "map_Tr"),
    ("map_opacity", "map_opacity"),
];

/// A material while its lines are read.
#[derive(Default)]
struct Entry {
    name: String,
    material: Material,
    base: Option<Map>,
    holes: Option<Map>,
    emission: Option<Map>,
    normals: Option<Map>,
    heights: Option<Map>,
    specular: Option<Vec3>,
    exponent: Option<f32>,
    roughness: Option<f32>,
    opacity: Option<f32>,
    transparency: Option<f32>,
    matte: bool,
}

impl Entry {
    fn new(name: &str) -> Self {
        let material = Material { double_sided: true, ..Material::default() };
        Self { name: name.to_owned(), material, ..Self::default() }
    }

    /// Takes a statement over, or says why not. `keyword` is lower case.
    fn statement(
        &mut self,
        keyword: &str,
        rest: &str,
        without_effect: &mut BTreeSet<&'static str>,
    ) -> Result<(), String> {
        let number = || number(rest.trim_start_matches("-halo"));
        let mut map = || {
            let map = Map::parse(rest);
            without_effect.extend(&map.ignored);
            Some(map).filter(|map| !map.name.is_empty()).ok_or("it names no picture").map(Some)
        };
        let surface = &mut self.material.surface;
        match keyword {
            "kd" => surface.base_color = color(rest)?.min(Vec3::ONE),
            "ke" => self.material.emissive = color(rest)?,
            "ks" => self.specular = Some(color(rest)?),
            "ns" => self.exponent = Some(number()?),
            "ni" => surface.ior = number()?.clamp(1.0, 10.0),
            "pr" => self.roughness = Some(number()?.clamp(0.0, 1.0)),
            "pm" => surface.metallic = number()?.clamp(0.0, 1.0),
            "d" => self.opacity = Some(number()?),
            "tr" => self.transparency = Some(number()?),
            "illum" => self.matte = number()? <= 1.0,
            "map_kd" => self.base = map()?,
            "map_d" => self.holes = map()?,
            "map_ke" => self.emission = map()?,
            "bump" | "map_bump" => self.heights = map()?,
            "norm" | "map_norm" | "map_kn" => self.normals = map()?,
            _ => without_effect
                .extend(WITHOUT_EFFECT.iter().filter(|(name, _)| *name == keyword).map(|(_, what)| what)),
        }
        Ok(())
    }

    fn finish(
        self,
        pictures: &mut Pictures,
        places: (&Source, &Path),
        budget: &mut Budget,
        scene: &mut Scene,
    ) -> Result<Material, Fault> {
        let name = text::names(&self.name).next().map(quoted).unwrap_or_default();
        let mut material = Material { name, ..self.material };
        let specular = self.specular.filter(|_| !self.matte).unwrap_or(Vec3::ZERO);
        let strength = specular.max_element();
        if strength > 0.0 {
            material.surface.specular = strength.min(1.0);
            material.surface.specular_color = specular / strength;
        }
        if let Some(exponent) = self.exponent {
            let alpha = (2.0 / (exponent.max(0.0) + 2.0)).sqrt();
            material.surface.roughness = alpha.sqrt();
        }
        if let Some(roughness) = self.roughness {
            material.surface.roughness = roughness;
        }
        // A transparency of 1 alone is an opacity: nobody describes what is not seen.
        let from_transparency =
            self.transparency.filter(|tr| *tr < 1.0).map(|transparency| 1.0 - transparency);
        material.alpha = self.opacity.or(from_transparency).unwrap_or(1.0).clamp(0.0, 1.0);
        if material.alpha == 0.0 {
            scene.warnings.push(format!("material '{}' would not be seen: shown opaque", material.name));
            material.alpha = 1.0;
        }
        if material.alpha < 1.0 {
            material.alpha_mode = AlphaMode::Blend;
        }
        let lies_alike =
            |holes: &&Map| self.base.as_ref().is_none_or(|base| base.uv_from_mesh == holes.uv_from_mesh);
        let holes = self.holes.as_ref().filter(lies_alike);
        if self.holes.is_some() && holes.is_none() {
            scene.warnings.push(format!(
                "material '{}' has no holes: map_d lies on the surface otherwise than map_Kd",
                material.name
            ));
        }
        material.base_color_texture = pictures.texture(self.base.as_ref(), holes, places, budget, scene)?;
        if let (Some(texture), Some(_), AlphaMode::Opaque) =
            (material.base_color_texture, holes, material.alpha_mode)
        {
            material.alpha_mode = alpha_mode(&scene.textures[texture.texture.0]);
        }
        if self.base.is_some()
            && material.base_color_texture.is_some()
            && material.surface.base_color == Vec3::ZERO
        {
            // Exporters write a black factor beside a map, meaning the map alone.
            material.surface.base_color = Vec3::ONE;
        }
        material.emissive_texture = pictures.texture(self.emission.as_ref(), None, places, budget, scene)?;
        if material.emissive_texture.is_some() && material.emissive == Vec3::ZERO {
            material.emissive = Vec3::ONE;
        }
        material.normal_texture = pictures.texture(self.normals.as_ref(), None, places, budget, scene)?;
        material.normal_scale = self.normals.map_or(1.0, |map| map.strength);
        if let Some(map) = &self.heights {
            material.height = pictures.heights(map, places, budget, scene)?;
        }
        Ok(material)
    }
}

/// What the alpha of a texture asks for: holes with smooth edges are holes.
fn alpha_mode(texture: &Texture) -> AlphaMode {
    let count = |wanted: std::ops::RangeInclusive<u8>| {
        texture.rgba8.iter().filter(|texel| wanted.contains(&texel[3])).count()
    };
    match (count(0..=254), count(32..=223), count(224..=255)) {
        (0, ..) => AlphaMode::Opaque,
        (_, between, whole) if between > whole / 8 => AlphaMode::Blend,
        _ => AlphaMode::Mask { cutoff: 0.5 },
    }
}

/// One number, 0 where it is not finite.
fn number(text: &str) -> Result<f32, String> {
    let numbers = text::numbers::<1>(text::without_comment(text), 1)?;
    Ok(sane(numbers.0[0]))
}

fn color(text: &str) -> Result<Vec3, String> {
    let (space, rest) = text::statement(text);
    match space.to_ascii_lowercase().as_str() {
        "spectral" => Err("spectral curves are not read".to_owned()),
        "xyz" => Ok(rec709_from_xyz(three(rest)?).max(Vec3::ZERO)),
        _ => Ok(three(text)?.max(Vec3::ZERO)),
    }
}

/// Three numbers; a single one stands for all.
fn three(text: &str) -> Result<Vec3, String> {
    let (values, count) = text::numbers::<3>(text::without_comment(text), 1)?;
    let values = if count < 3 { [values[0]; 3] } else { values };
    Ok(Vec3::from_array(values.map(sane)))
}

/// The number, 0 where it is not finite.
fn sane(value: f64) -> f32 {
    let value = value as f32;
    if value.is_finite() { value } else { 0.0 }
}
