//! Materials and textures (specification, sections 3.8 and 3.9, and the KHR extensions).

use std::collections::HashMap;
use std::sync::Arc;

use glam::{Affine2, Vec2, Vec3};
use gnomon_messages::quoted;
use gnomon_scene::{AlphaMode, Material, Scene, Texture, TextureId, TextureRef, Wrap};

use super::buffers::{self, Buffers};
use super::schema::{AlphaModeEntry, Int, MaterialEntry, Root, TextureInfo};
use super::{Budget, Fault, Source, get};
use crate::{SceneFileError, texture};

/// Reads every material, so that material `i` of the file is `scene.materials[i]`.
pub fn read(
    root: &Root,
    buffers: &Buffers,
    source: &Source,
    budget: &mut Budget,
    scene: &mut Scene,
) -> Result<(), Fault> {
    let mut textures = Textures { root, buffers, source, known: HashMap::new() };
    for (index, entry) in root.materials.iter().enumerate() {
        let material = material(index, entry, &mut textures, budget, scene)?;
        scene.materials.push(material);
    }
    Ok(())
}

/// The material of a primitive that names none: glTF's defaults, a rough white metal.
pub fn unnamed() -> Material {
    let mut material = Material::default();
    material.surface.base_color = Vec3::ONE;
    material.surface.metallic = 1.0;
    material.surface.specular = 1.0;
    material
}

fn material(
    index: usize,
    entry: &MaterialEntry,
    textures: &mut Textures,
    budget: &mut Budget,
    scene: &mut Scene,
) -> Result<Material, Fault> {
    let name = entry.name.as_deref().map(quoted).unwrap_or_default();
    let label = format!("material {index}");
    let mut texture = |info: &Option<TextureInfo>, scene: &mut Scene| {
        textures.reference(info.as_ref(), &label, budget, scene)
    };
    let mut material = Material { name, double_sided: entry.double_sided, ..unnamed() };
    let pbr = &entry.pbr_metallic_roughness;
    if let Some([r, g, b, a]) = pbr.base_color_factor {
        material.surface.base_color = Vec3::new(unit(r), unit(g), unit(b));
        material.alpha = unit(a);
    }
    material.base_color_texture = texture(&pbr.base_color_texture, scene)?;
    material.surface.metallic = pbr.metallic_factor.map_or(1.0, unit);
    material.surface.roughness = pbr.roughness_factor.map_or(1.0, unit);
    material.metallic_roughness_texture = texture(&pbr.metallic_roughness_texture, scene)?;
    material.normal_texture = texture(&entry.normal_texture, scene)?;
    let normal_scale = entry.normal_texture.as_ref().and_then(|info| info.scale);
    material.normal_scale = normal_scale.filter(|scale| scale.is_finite()).unwrap_or(1.0);
    material.emissive = Vec3::from_array(entry.emissive_factor.map(not_negative));
    material.emissive_texture = texture(&entry.emissive_texture, scene)?;
    if let Some(specular) = &entry.extensions.specular {
        material.surface.specular = specular.specular_factor.map_or(1.0, unit);
        material.specular_texture = texture(&specular.specular_texture, scene)?;
        material.surface.specular_color = Vec3::from_array(
            specular.specular_color_factor.map_or([1.0; 3], |color| color.map(not_negative)),
        );
        material.specular_color_texture = texture(&specular.specular_color_texture, scene)?;
    }
    if let Some(ior) = entry.extensions.ior.as_ref().and_then(|extension| extension.ior) {
        // 0 has a meaning of its own in KHR_materials_ior: full reflection.
        if ior == 0.0 || (ior >= 1.0 && ior.is_finite()) {
            material.surface.ior = ior;
        } else {
            scene.warnings.push(format!("{label}: an index of refraction of {ior} is ignored"));
        }
    }
    if let Some(strength) = entry.extensions.emissive_strength.as_ref().and_then(|e| e.emissive_strength) {
        material.emissive *= not_negative(strength);
    }
    match entry.alpha_mode {
        AlphaModeEntry::Opaque => {}
        AlphaModeEntry::Mask => {
            let cutoff = entry.alpha_cutoff.map_or(0.5, not_negative);
            material.alpha_mode = AlphaMode::Mask { cutoff };
        }
        AlphaModeEntry::Blend => scene.warnings.push(format!("{label}: alpha blending is shown opaque")),
    }
    Ok(material)
}

/// The number in 0..1; one that is not finite counts as 1.
fn unit(value: f32) -> f32 {
    if value.is_finite() { value.clamp(0.0, 1.0) } else { 1.0 }
}

/// The number, or 0 where it is negative, and 1 where it is not finite.
fn not_negative(value: f32) -> f32 {
    if value.is_finite() { value.max(0.0) } else { 1.0 }
}

struct Textures<'a> {
    root: &'a Root,
    buffers: &'a Buffers<'a>,
    source: &'a Source<'a>,
    /// By picture and sampling.
    known: HashMap<(usize, [Wrap; 2], bool), TextureId>,
}

impl Textures<'_> {
    fn reference(
        &mut self,
        info: Option<&TextureInfo>,
        referrer: &str,
        budget: &mut Budget,
        scene: &mut Scene,
    ) -> Result<Option<TextureRef>, Fault> {
        let Some(info) = info else { return Ok(None) };
        let Some(texture) = self.texture(info.index.0, referrer, budget, scene)? else { return Ok(None) };
        let transform = info.extensions.transform.as_ref();
        let set = transform.and_then(|transform| transform.tex_coord).unwrap_or(info.tex_coord).0;
        if set > 1 {
            scene.warnings.push(format!(
                "{referrer}: a texture on coordinate set {set} is left out (0 and 1 are read)"
            ));
            return Ok(None);
        }
        let mut uv_from_mesh = Affine2::IDENTITY;
        if let Some(transform) = transform {
            let scale = transform.scale.map_or(Vec2::ONE, Vec2::from_array);
            // Counter-clockwise as the picture is seen, with v pointing down: the negative angle in (u, v).
            let affine = Affine2::from_scale_angle_translation(
                scale,
                -transform.rotation,
                Vec2::from_array(transform.offset),
            );
            if affine.is_finite() {
                uv_from_mesh = affine;
            } else {
                scene.warnings.push(format!("{referrer}: a texture transform that is not finite is ignored"));
            }
        }
        Ok(Some(TextureRef { texture, uv_from_mesh, set }))
    }

    fn texture(
        &mut self,
        index: usize,
        referrer: &str,
        budget: &mut Budget,
        scene: &mut Scene,
    ) -> Result<Option<TextureId>, Fault> {
        let texture = get(&self.root.textures, index, "texture", referrer)?;
        let name = format!("texture {index}");
        let Some(Int(image)) = texture.source else {
            scene.warnings.push(format!("{name} has no PNG or JPEG picture and is left out"));
            return Ok(None);
        };
        let (mut wrap, mut nearest) = ([Wrap::Repeat; 2], false);
        if let Some(Int(sampler)) = texture.sampler {
            let sampler = get(&self.root.samplers, sampler, "sampler", &name)?;
            wrap = [wrap_mode(sampler.wrap_s), wrap_mode(sampler.wrap_t)];
            nearest = sampler.mag_filter == Some(Int(9728));
        }
        if let Some(&known) = self.known.get(&(image, wrap, nearest)) {
            return Ok(Some(known));
        }
        let picture = match self.picture(image, &name, budget) {
            Ok(picture) => picture,
            // The geometry is whole: as with OBJ, it is shown without the picture.
            Err(Fault::Elsewhere(error @ SceneFileError::Io { .. })) => {
                scene.warnings.push(format!("{name} is left out: {error}"));
                return Ok(None);
            }
            Err(fault) => return Err(fault),
        };
        let id = TextureId(scene.textures.len());
        scene.textures.push(Arc::new(Texture {
            width: picture.width,
            height: picture.height,
            rgba8: picture.rgba8,
            wrap,
            nearest,
        }));
        self.known.insert((image, wrap, nearest), id);
        Ok(Some(id))
    }

    fn picture(&self, index: usize, referrer: &str, budget: &mut Budget) -> Result<texture::Texels, Fault> {
        let image = get(&self.root.images, index, "image", referrer)?;
        let name = format!("image {index}");
        let owned;
        let bytes = match (&image.uri, image.buffer_view) {
            (Some(uri), None) => {
                owned = buffers::resolve(uri, self.source, budget)?;
                owned.as_slice()
            }
            (None, Some(view)) => self.buffers.view(view.0, &name)?,
            _ => return Err(Fault::Invalid(format!("{name} needs either a URI or a buffer view"))),
        };
        texture::decode(bytes, budget).map_err(|fault| match fault {
            Fault::Invalid(message) => Fault::Invalid(format!("{name}: {message}")),
            Fault::Unsupported(message) => Fault::Unsupported(format!("{name}: {message}")),
            other => other,
        })
    }
}

fn wrap_mode(code: Option<Int>) -> Wrap {
    match code {
        Some(Int(33_071)) => Wrap::ClampToEdge,
        Some(Int(33_648)) => Wrap::MirroredRepeat,
        // 10497, or nothing.
        _ => Wrap::Repeat,
    }
}
