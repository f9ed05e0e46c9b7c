//! OBJ's material libraries, translated to metallic-roughness.
//!
//! | MTL | here |
//! |---|---|
//! | `Kd`, `map_Kd` | base colour (`Kd` linear, the map sRGB) |
//! | `Ke`, `map_Ke` | emission |
//! | `Ks` | dielectric reflection: its largest channel is the strength, its hue the tint; black, or `illum` 0 or 1, is exactly Lambert |
//! | `Ns` | roughness: Blinn-Phong's exponent to GGX, `alpha = sqrt(2 / (Ns + 2))`, `roughness = sqrt(alpha)` (Walter et al. 2007, eq. in section 5.3) |
//! | `Ni` | index of refraction |
//! | `Pr`, `Pm`, `norm` | roughness, metallic, normal map (the physically based extension) |
//! | `d`, `Tr` below 1 | opaque, with a warning |

use std::collections::HashMap;
use std::sync::Arc;

use glam::{Affine2, Vec3};
use gnomon_messages::quoted;
use gnomon_scene::{Material, MaterialId, Scene, Texture, TextureId, TextureRef, Wrap};

use super::obj::numbers;
use super::{Budget, Source, texture};
use crate::SceneFileError;
use crate::error::Fault;

/// Materials by name, and textures by file name.
#[derive(Default)]
pub struct Library {
    pub materials: HashMap<String, MaterialId>,
    textures: HashMap<String, Option<TextureId>>,
}

impl Library {
    /// Reads the library `name` beside the OBJ file into `scene`. One that is missing is a warning.
    pub fn read(
        &mut self,
        name: &str,
        source: &Source,
        budget: &mut Budget,
        scene: &mut Scene,
    ) -> Result<(), Fault> {
        let path = source.sibling(&name.replace('\\', "/"));
        let bytes = match source.read(&path, budget) {
            Ok(bytes) => bytes,
            Err(Fault::TooLarge { limit_mib }) => return Err(Fault::TooLarge { limit_mib }),
            Err(fault) => {
                scene.warnings.push(format!("materials are left out: {}", fault.at(&path)));
                return Ok(());
            }
        };
        let text = String::from_utf8_lossy(super::without_bom(&bytes)).into_owned();
        let mut entry = Entry::default();
        for (index, line) in text.lines().enumerate() {
            let line = line.split('#').next().unwrap_or_default().trim();
            let (keyword, rest) = line.split_once(|c: char| c.is_ascii_whitespace()).unwrap_or((line, ""));
            if keyword == "newmtl" {
                self.add(std::mem::take(&mut entry), scene);
                entry = Entry::new(rest.trim());
                continue;
            }
            self.statement(&mut entry, keyword, rest.trim(), source, budget, scene).map_err(|fault| {
                match fault {
                    Fault::Invalid(message) => {
                        Fault::Elsewhere(Fault::Invalid(format!("line {}: {message}", index + 1)).at(&path))
                    }
                    other => other,
                }
            })?;
        }
        self.add(entry, scene);
        Ok(())
    }

    fn add(&mut self, entry: Entry, scene: &mut Scene) {
        if let Some(material) = entry.finish(&mut scene.warnings) {
            self.materials.insert(material.name.clone(), MaterialId(scene.materials.len()));
            scene.materials.push(material);
        }
    }

    fn statement(
        &mut self,
        entry: &mut Entry,
        keyword: &str,
        rest: &str,
        source: &Source,
        budget: &mut Budget,
        scene: &mut Scene,
    ) -> Result<(), Fault> {
        let number = || -> Result<f32, Fault> { Ok(sane(numbers::<1>(rest, 1)?.0[0])) };
        let material = &mut entry.material;
        match keyword {
            "Kd" => material.surface.base_color = color(rest)?.min(Vec3::ONE),
            "Ke" => material.emissive = color(rest)?,
            "Ks" => entry.specular = Some(color(rest)?),
            "Ns" => entry.exponent = Some(number()?),
            "Ni" => material.surface.ior = number()?.clamp(1.0, 10.0),
            "Pr" => entry.roughness = Some(number()?.clamp(0.0, 1.0)),
            "Pm" => material.surface.metallic = number()?.clamp(0.0, 1.0),
            "d" => entry.opacity = number()?,
            "Tr" => entry.opacity = 1.0 - number()?,
            "illum" => entry.matte = number()? <= 1.0,
            "map_Kd" => {
                material.base_color_texture = self.texture(rest, source, budget, scene)?;
                if entry.material.base_color_texture.is_some()
                    && entry.material.surface.base_color == Vec3::ZERO
                {
                    // Exporters write a black factor beside a map, meaning the map alone.
                    entry.material.surface.base_color = Vec3::ONE;
                }
            }
            "map_Ke" => {
                material.emissive_texture = self.texture(rest, source, budget, scene)?;
                if entry.material.emissive_texture.is_some() && entry.material.emissive == Vec3::ZERO {
                    entry.material.emissive = Vec3::ONE;
                }
            }
            "norm" => material.normal_texture = self.texture(rest, source, budget, scene)?,
            _ => {}
        }
        Ok(())
    }

    /// A texture by file name, read once; `None` with a warning where it cannot be had.
    fn texture(
        &mut self,
        rest: &str,
        source: &Source,
        budget: &mut Budget,
        scene: &mut Scene,
    ) -> Result<Option<TextureRef>, Fault> {
        // Options (-s 1 1 1 ...) stand before the name; a name may hold blanks where there are none.
        let name = if rest.starts_with('-') {
            rest.split_ascii_whitespace().next_back().unwrap_or("")
        } else {
            rest
        };
        let id = match self.textures.get(name) {
            Some(&known) => known,
            None => {
                let path = source.sibling(&name.replace('\\', "/"));
                let picture = source.read(&path, budget).and_then(|bytes| texture::decode(&bytes, budget));
                let id = match picture {
                    Ok(picture) => {
                        scene.textures.push(Arc::new(Texture {
                            width: picture.width,
                            height: picture.height,
                            rgba8: picture.rgba8,
                            wrap: [Wrap::Repeat; 2],
                            nearest: false,
                        }));
                        Some(TextureId(scene.textures.len() - 1))
                    }
                    Err(Fault::TooLarge { limit_mib }) => return Err(Fault::TooLarge { limit_mib }),
                    Err(fault) => {
                        let error: SceneFileError = fault.at(&path);
                        scene.warnings.push(format!("a texture is left out: {error}"));
                        None
                    }
                };
                self.textures.insert(name.to_owned(), id);
                id
            }
        };
        Ok(id.map(|texture| TextureRef { texture, uv_from_mesh: Affine2::IDENTITY, set: 0 }))
    }
}

/// A material while its lines are read.
#[derive(Default)]
struct Entry {
    named: bool,
    material: Material,
    specular: Option<Vec3>,
    exponent: Option<f32>,
    roughness: Option<f32>,
    opacity: f32,
    matte: bool,
}

impl Entry {
    fn new(name: &str) -> Self {
        let material = Material { name: quoted(name), double_sided: true, ..Material::default() };
        Self { named: true, material, opacity: 1.0, ..Self::default() }
    }

    /// The material; `None` for statements before the first `newmtl`.
    fn finish(self, warnings: &mut Vec<String>) -> Option<Material> {
        if !self.named {
            return None;
        }
        let mut material = self.material;
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
        if self.opacity < 1.0 {
            warnings.push(format!("material '{}' is transparent: shown opaque", material.name));
        }
        Some(material)
    }
}

fn color(text: &str) -> Result<Vec3, Fault> {
    let (values, count) = numbers::<3>(text, 1)?;
    // One number stands for grey.
    let values = if count < 3 { [values[0]; 3] } else { values };
    Ok(Vec3::from_array(values.map(|value| sane(value).max(0.0))))
}

/// The number, 0 where it is not finite.
fn sane(value: f32) -> f32 {
    if value.is_finite() { value } else { 0.0 }
}
