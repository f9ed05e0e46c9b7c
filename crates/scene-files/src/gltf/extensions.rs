//! Which extensions are known, and what becomes of those that are not drawn.

use gnomon_messages::quoted;

use super::schema::Root;
use crate::error::Fault;

/// Extensions that are read.
const READ: [&str; 21] = [
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_texture_webp",
    "KHR_animation_pointer",
    "KHR_draco_mesh_compression",
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_node_visibility",
    "KHR_texture_basisu",
    "KHR_texture_transform",
    // Says who made a model.
    "KHR_xmp_json_ld",
];

/// Extensions without which the model is still itself, and what is not drawn. Files that require them are shown so, too.
const PLAIN: [(&str, &str); 6] = [
    ("KHR_materials_diffuse_transmission", "no light comes through"),
    ("KHR_materials_dispersion", "light is not split into colours"),
    ("KHR_materials_iridescence", "thin films are not drawn"),
    ("KHR_materials_transmission", "surfaces that let light through are shown opaque"),
    ("KHR_materials_volume", "what light crosses is not drawn"),
    ("KHR_materials_volume_scatter", "what light crosses is not drawn"),
];

/// Says what is not drawn of the extensions that the file uses, and refuses those that it requires and nothing can stand for.
pub fn check(root: &Root, warnings: &mut Vec<String>) -> Result<(), Fault> {
    let is_known = |name: &str| READ.contains(&name) || PLAIN.iter().any(|(plain, _)| *plain == name);
    let unknown = |names: &[String]| -> Vec<String> {
        names.iter().filter(|name| !is_known(name)).map(|name| quoted(name)).collect()
    };
    let required = unknown(&root.extensions_required);
    if !required.is_empty() {
        return Err(Fault::Unsupported(format!("it requires the extension {}", required.join(", "))));
    }
    let is_used =
        |name| root.extensions_used.iter().chain(&root.extensions_required).any(|used| used == name);
    for (name, effect) in PLAIN.iter().filter(|(name, _)| is_used(name)) {
        warnings.push(format!("{name}: {effect}"));
    }
    let used = unknown(&root.extensions_used);
    if !used.is_empty() {
        warnings.push(quoted(&format!("extensions that have no effect here: {}", used.join(", "))));
    }
    Ok(())
}
