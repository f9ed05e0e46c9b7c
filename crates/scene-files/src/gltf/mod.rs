//! glTF 2.0 (Khronos, "glTF 2.0 Specification"), `.gltf` and `.glb`.
//!
//! Read with a schema of our own over `serde_json`: every number from the file is checked before it indexes or sizes
//! anything, damaged files end in one message that names the place, and `KHR_texture_transform` is had on every texture.
//!
//! - The default scene, else the first, else all root nodes. A file with meshes
//!   but no nodes shows each mesh once; one whose nodes place no mesh is empty.
//! - Nodes keep their hierarchy; meshes used by several nodes and instances are shared.
//! - A scene far from its origin is moved ([`Scene::origin`]).
//! - Skins with any number of joints and of sets of weights, morph targets (sparse ones too), animations of nodes and
//!   weights; a damaged animation is left out with a warning.
//! - A picture that is missing, remote or damaged is left out with a warning, a missing buffer is an error.
//! - Points and lines are left out, occlusion maps are not used (light is computed).
//! - Extensions: `extensions.rs` lists those that are read, and those that are shown without what they add. Others are ignored with a
//!   warning, or refused where required.

mod accessors;
mod animations;
mod attributes;
mod buffers;
mod cameras;
mod document;
mod draco;
mod extensions;
mod instancing;
mod lights;
mod materials;
mod meshes;
mod meshopt;
mod nodes;
mod origin;
mod schema;
mod skins;
mod specular_glossiness;
mod textures;
mod uri;

use gnomon_messages::quoted;
use gnomon_scene::{Ground, Node, Scene};

use self::accessors::Accessors;
use self::buffers::Buffers;
use self::meshes::Meshes;
use self::schema::Root;
use crate::error::Fault;
use crate::{Budget, LoadedScene, Source};

/// Whether the content is a GLB, or JSON (an object).
pub fn recognise(bytes: &[u8]) -> bool {
    let text = super::without_bom(bytes);
    bytes.starts_with(b"glTF") || text.iter().find(|b| !b.is_ascii_whitespace()) == Some(&b'{')
}

/// Reads a glTF file with the buffers and pictures that it names.
pub fn read(source: &Source, budget: &mut Budget) -> Result<LoadedScene, Fault> {
    let mut scene = Scene::default();
    let (json, binary) = buffers::split(source.bytes, &mut scene.warnings)?;
    let root = document::parse(json, budget, &mut scene.warnings)?;
    extensions::check(&root, &mut scene.warnings)?;
    let buffers = Buffers::read(&root, binary, source, budget)?;
    let accessors = Accessors { root: &root, buffers: &buffers };
    let sets = materials::read(&root, &buffers, source, budget, &mut scene)?;
    let order = nodes::order(&root, &mut scene.warnings)?;
    scene.variants = variants(&root);
    let shown = source.options.variant.as_ref();
    let variant = shown.and_then(|name| scene.variants.iter().position(|variant| variant == name));
    let mut meshes = Meshes::new(&root, &accessors, &sets, variant);
    let places = nodes::read(&root, &order, source.options, &accessors, &mut meshes, budget, &mut scene)?;
    animations::read(&root, &accessors, &meshes, &places, budget, &mut scene)?;
    if !root.meshes.is_empty() && root.nodes.is_empty() {
        scene.warnings.push("the file has no nodes: each mesh is shown once, at the origin".to_owned());
        for (index, mesh) in root.meshes.iter().enumerate() {
            let ids = meshes.read(index, budget, &mut scene)?;
            let name = mesh.name.as_deref().map(quoted).unwrap_or_default();
            let weights = meshes.weights(index, None, budget)?;
            scene.nodes.push(Node { name, meshes: ids, weights, ..Node::default() });
        }
    }
    if scene.nodes.iter().all(|node| node.meshes.is_empty()) {
        scene.warnings.push("the file shows no meshes: nothing will be seen of it".to_owned());
    }
    origin::recenter(&root, &order, &mut scene);
    Ok(source.loaded(scene, Ground::Fade))
}

/// Names of the file's material variants, in its order.
fn variants(root: &Root) -> Vec<String> {
    let variants = root.extensions.variants.iter().flat_map(|extension| &extension.variants);
    variants.map(|variant| quoted(&variant.name)).collect()
}

/// The item that the file means by `index`, or a message naming who refers to it.
fn get<'a, T>(items: &'a [T], index: usize, kind: &str, referrer: &str) -> Result<&'a T, Fault> {
    items.get(index).ok_or_else(|| {
        Fault::Invalid(format!("{referrer} refers to {kind} {index}, but there are {}", items.len()))
    })
}
