//! Materials and textures (specification, sections 3.8 and 3.9, and the KHR extensions).

use std::f32::consts::TAU;

use glam::{DVec4, Vec3, Vec4};
use gnomon_brdf::Model;
use gnomon_messages::quoted;
use gnomon_picture::tonemap::srgb_decode;
use gnomon_scene::{AlphaMode, Material, Scene, TextureRef};

use super::buffers::Buffers;
use super::schema::{AlphaModeEntry, Anisotropy, Int, MaterialEntry, Root, TextureInfo};
use super::textures::Textures;
use super::{Budget, Fault, Source, specular_glossiness};

/// Which of a primitive's sets of texture coordinates its mesh takes over, and in which order: those that its material needs.
pub type CoordinateSets = [usize; 2];

/// Of materials that need no others.
pub const DEFAULT_SETS: CoordinateSets = [0, 1];

/// Reads every material, so that material `i` of the file is `scene.materials[i]`, and tells which coordinates it takes.
pub fn read(
    root: &Root,
    buffers: &Buffers,
    source: &Source,
    budget: &mut Budget,
    scene: &mut Scene,
) -> Result<Vec<CoordinateSets>, Fault> {
    let mut textures = Textures::new(root, buffers, source);
    let mut all_sets = Vec::with_capacity(root.materials.len());
    for (index, entry) in root.materials.iter().enumerate() {
        let sets = coordinate_sets(entry);
        let mut material = material(index, entry, sets, &mut textures, budget, scene)?;
        material.alpha_mode = alpha_mode(index, entry, &material, root, scene);
        if entry.extensions.unlit.is_some() {
            material = unlit(material);
        }
        scene.materials.push(material);
        all_sets.push(sets);
    }
    Ok(all_sets)
}

/// The two sets of coordinates that a material's textures take; those beyond them are left out.
fn coordinate_sets(entry: &MaterialEntry) -> CoordinateSets {
    let height = entry.height().and_then(Result::ok).map(|height| height.texture.set());
    let used: Vec<usize> = entry.texture_infos().map(TextureInfo::set).chain(height).collect();
    let mut sets = DEFAULT_SETS;
    for set in &used {
        if !sets.contains(set)
            && let Some(free) = sets.iter_mut().find(|free| !used.contains(free))
        {
            *free = *set;
        }
    }
    sets
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
    sets: CoordinateSets,
    textures: &mut Textures,
    budget: &mut Budget,
    scene: &mut Scene,
) -> Result<Material, Fault> {
    let name = entry.name.as_deref().map(quoted).unwrap_or_default();
    let label = format!("material {index}");
    let mut texture = |info: &Option<TextureInfo>, scene: &mut Scene| {
        textures.reference(info.as_ref(), (sets, &label), budget, scene)
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
    if let Some(coat) = &entry.extensions.clearcoat {
        material.surface.clearcoat = coat.clearcoat_factor.map_or(0.0, unit);
        material.surface.clearcoat_roughness = coat.clearcoat_roughness_factor.map_or(0.0, unit);
        if material.surface.clearcoat > 0.0 {
            material.clearcoat_texture = texture(&coat.clearcoat_texture, scene)?;
            material.clearcoat_roughness_texture = texture(&coat.clearcoat_roughness_texture, scene)?;
            material.clearcoat_normal_texture = texture(&coat.clearcoat_normal_texture, scene)?;
            let scale = coat.clearcoat_normal_texture.as_ref().and_then(|info| info.scale);
            material.clearcoat_normal_scale = scale.filter(|scale| scale.is_finite()).unwrap_or(1.0);
        }
    }
    if let Some(sheen) = &entry.extensions.sheen {
        material.surface.sheen_color =
            Vec3::from_array(sheen.sheen_color_factor.map_or([0.0; 3], |color| color.map(unit)));
        material.surface.sheen_roughness = sheen.sheen_roughness_factor.map_or(0.0, unit);
        if material.surface.sheen_color != Vec3::ZERO {
            material.sheen_color_texture = texture(&sheen.sheen_color_texture, scene)?;
            material.sheen_roughness_texture = texture(&sheen.sheen_roughness_texture, scene)?;
        }
        if material.surface.clearcoat > 0.0 && material.has_sheen_textures() {
            even_sheen(&mut material, scene);
            scene
                .warnings
                .push(format!("{label}: under its clear coat sheen is even, the mean of its textures"));
        }
    }
    if let Some(anisotropy) = &entry.extensions.anisotropy {
        material.anisotropy_texture = texture(&anisotropy.anisotropy_texture, scene)?;
        make_anisotropic(&mut material, anisotropy, scene);
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
    if let Some(gloss) = &entry.extensions.specular_glossiness {
        specular_glossiness::convert(gloss, &mut material, textures, (sets, &label), budget, scene)?;
    }
    match entry.height() {
        None => {}
        Some(Ok(height)) if height.scale.is_finite() => {
            material.height = textures.height(&height, (sets, &label), budget, scene)?;
        }
        Some(Ok(_)) => {
            scene.warnings.push(format!("{label}: heights whose scale is not finite are left out"))
        }
        Some(Err(reason)) => scene.warnings.push(format!("{label}: heights are left out: {reason}")),
    }
    Ok(material)
}

/// Sheen of the mean of its textures: the G-buffer has room for those of a clear coat or those of sheen.
fn even_sheen(material: &mut Material, scene: &Scene) {
    let (color, roughness) = (material.sheen_color_texture.take(), material.sheen_roughness_texture.take());
    material.surface.sheen_color *= mean(color, srgb_decode, scene).truncate();
    material.surface.sheen_roughness *= mean(roughness, |value| value, scene).w;
}

/// Mean of a texture whose colours are decoded so; white for none.
fn mean(texture: Option<TextureRef>, decode: fn(f32) -> f32, scene: &Scene) -> Vec4 {
    let Some(texture) = texture else { return Vec4::ONE };
    let texels = &scene.textures[texture.texture.0].rgba8;
    let texel = |texel: &[u8; 4]| {
        let unit = Vec4::from(texel.map(|channel| f32::from(channel) / 255.0));
        unit.truncate().map(decode).extend(unit.w)
    };
    // Row by row in 32 bits: a sum over millions of texels would lose their digits.
    let rows = texels.chunks(4096).map(|row| row.iter().map(texel).sum::<Vec4>().as_dvec4());
    (rows.sum::<DVec4>() / texels.len().max(1) as f64).as_vec4()
}

/// `KHR_materials_anisotropy`: another model, whose tables have one roughness and strength a material. Textures vary its direction; of roughness
/// and strength they give the mean.
fn make_anisotropic(material: &mut Material, entry: &Anisotropy, scene: &Scene) {
    let strength = entry.anisotropy_strength.map_or(0.0, unit);
    let linear = |value: f32| value;
    material.surface.anisotropy = strength * mean(material.anisotropy_texture, linear, scene).z;
    if material.surface.anisotropy == 0.0 {
        material.anisotropy_texture = None;
        return;
    }
    material.surface.model = Model::AnisotropicGgx;
    let rotation = entry.anisotropy_rotation.filter(|rotation| rotation.is_finite()).unwrap_or(0.0);
    material.surface.anisotropy_rotation = rotation.rem_euclid(TAU);
    material.surface.roughness *= mean(material.metallic_roughness_texture, linear, scene).y;
}

fn alpha_mode(
    index: usize,
    entry: &MaterialEntry,
    material: &Material,
    root: &Root,
    scene: &Scene,
) -> AlphaMode {
    match entry.alpha_mode {
        AlphaModeEntry::Opaque => AlphaMode::Opaque,
        AlphaModeEntry::Mask => AlphaMode::Mask { cutoff: entry.alpha_cutoff.map_or(0.5, not_negative) },
        // Tools write BLEND for all that they export.
        AlphaModeEntry::Blend if is_opaque(index, material, root, scene) => AlphaMode::Opaque,
        AlphaModeEntry::Blend => AlphaMode::Blend,
    }
}

/// Whether alpha is 1 everywhere.
fn is_opaque(index: usize, material: &Material, root: &Root, scene: &Scene) -> bool {
    let has_alpha = |accessor: usize| root.accessors.get(accessor).is_none_or(|color| color.shape == "VEC4");
    let mut primitives = root.meshes.iter().flat_map(|mesh| &mesh.primitives);
    // By variants, any primitive may have any material.
    let may_use = |material: Option<Int>| material == Some(Int(index)) || root.extensions.variants.is_some();
    let vertex_alpha = primitives.any(|primitive| {
        let color = primitive.attributes.get("COLOR_0");
        may_use(primitive.material) && color.is_some_and(|color| has_alpha(color.0))
    });
    let texture = material.base_color_texture.map(|texture| &scene.textures[texture.texture.0].rgba8);
    material.alpha == 1.0
        && !vertex_alpha
        && texture.is_none_or(|texels| texels.iter().all(|[.., alpha]| *alpha == 255))
}

/// `KHR_materials_unlit`: the colour is emitted as it is, and nothing is reflected.
fn unlit(lit: Material) -> Material {
    let mut material = Material {
        emissive: lit.surface.base_color,
        emissive_texture: lit.base_color_texture,
        emissive_vertex_colors: true,
        // Its alpha may cut holes.
        base_color_texture: lit.base_color_texture.filter(|_| lit.alpha_mode != AlphaMode::Opaque),
        metallic_roughness_texture: None,
        normal_texture: None,
        height: None,
        specular_texture: None,
        specular_color_texture: None,
        clearcoat_texture: None,
        clearcoat_roughness_texture: None,
        clearcoat_normal_texture: None,
        sheen_color_texture: None,
        sheen_roughness_texture: None,
        anisotropy_texture: None,
        surface: lit.surface.without_finish(),
        ..lit
    };
    material.surface.model = Model::default();
    material.surface.base_color = Vec3::ZERO;
    (material.surface.metallic, material.surface.specular) = (0.0, 0.0);
    material
}

/// The number in 0..1; one that is not finite counts as 1.
pub fn unit(value: f32) -> f32 {
    if value.is_finite() { value.clamp(0.0, 1.0) } else { 1.0 }
}

/// The number, or 0 where it is negative, and 1 where it is not finite.
pub fn not_negative(value: f32) -> f32 {
    if value.is_finite() { value.max(0.0) } else { 1.0 }
}
