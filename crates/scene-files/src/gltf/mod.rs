//! glTF 2.0 (Khronos, "glTF 2.0 Specification"), `.gltf` and `.glb`.
//!
//! Read with a schema of our own over `serde_json`: every number from the file is checked before it indexes or sizes
//! anything, damaged files end in one message that names the place, and `KHR_texture_transform` is had on every texture.
//!
//! - The default scene, else the first, else all root nodes. A file with meshes
//!   but no nodes shows each mesh once; one whose nodes place no mesh is empty.
//! - Nodes keep their hierarchy; meshes used by several nodes are shared.
//! - A scene far from its origin is moved ([`Scene::origin`]).
//! - Skins with any number of joints and of sets of weights, morph targets (sparse ones too), animations of nodes and
//!   weights; a damaged animation is left out with a warning.
//! - A picture file that is missing is left out with a warning, a missing buffer is an error.
//! - Points and lines are left out, alpha blending is opaque, occlusion maps are not used (light is computed).
//! - Extensions: `KHR_materials_specular`, `KHR_materials_ior`, `KHR_materials_emissive_strength`,
//!   `KHR_texture_transform`, `KHR_mesh_quantization`. Others are ignored with a warning, or refused where required.

mod accessors;
mod animations;
mod buffers;
mod materials;
mod meshes;
mod nodes;
mod origin;
mod schema;
mod skins;

use gnomon_messages::quoted;
use gnomon_scene::{Ground, Node, Scene};

use self::accessors::Accessors;
use self::buffers::Buffers;
use self::meshes::Meshes;
use self::schema::Root;
use crate::error::Fault;
use crate::{Budget, LoadedScene, Source};

const EXTENSIONS: [&str; 5] = [
    "KHR_materials_specular",
    "KHR_materials_ior",
    "KHR_materials_emissive_strength",
    "KHR_texture_transform",
    "KHR_mesh_quantization",
];

/// Whether the content is a GLB, or JSON (an object).
pub fn recognise(bytes: &[u8]) -> bool {
    let text = super::without_bom(bytes);
    bytes.starts_with(b"glTF") || text.iter().find(|b| !b.is_ascii_whitespace()) == Some(&b'{')
}

/// Reads a glTF file with the buffers and pictures that it names.
pub fn read(source: &Source, budget: &mut Budget) -> Result<LoadedScene, Fault> {
    let mut scene = Scene::default();
    let (json, binary) = buffers::split(source.bytes, &mut scene.warnings)?;
    // The parsed document takes a few times the size of its text.
    budget.take(json.len(), 4)?;
    let root: Root = serde_json::from_slice(super::without_bom(json)).map_err(|error| {
        let what =
            if error.is_data() { "the document does not follow glTF" } else { "the document is no JSON" };
        Fault::Invalid(format!("{what}: {error}"))
    })?;
    check_version(&root)?;
    check_extensions(&root, &mut scene.warnings)?;
    let buffers = Buffers::read(&root, binary, source, budget)?;
    let accessors = Accessors { root: &root, buffers: &buffers };
    materials::read(&root, &buffers, source, budget, &mut scene)?;
    let order = nodes::order(&root)?;
    let mut meshes = Meshes::new(&root, &accessors);
    let places = nodes::read(&root, &order, source.options, &accessors, &mut meshes, budget, &mut scene)?;
    animations::read(&root, &accessors, &meshes, &places.nodes, &places.cameras, budget, &mut scene)?;
    if !root.meshes.is_empty() && root.nodes.is_empty() {
        scene.warnings.push("the file has no nodes: each mesh is shown once, at the origin".to_owned());
        for (index, mesh) in root.meshes.iter().enumerate() {
            let ids = meshes.read(index, budget, &mut scene)?;
            let name = mesh.name.as_deref().map(quoted).unwrap_or_default();
            let weights = meshes.weights(index, None, budget)?;
            scene.nodes.push(Node { name, meshes: ids, weights, ..Node::default() });
        }
    }
    origin::recenter(&root, &order, &places.cameras, &mut scene);
    Ok(source.loaded(scene, Ground::None))
}

fn check_version(root: &Root) -> Result<(), Fault> {
    let parse = |text: &str| -> Result<(u32, u32), Fault> {
        let parts =
            text.split_once('.').and_then(|(major, minor)| Some((major.parse().ok()?, minor.parse().ok()?)));
        parts.ok_or_else(|| Fault::Invalid(format!("'{}' is no glTF version", quoted(text))))
    };
    let (major, minor) = parse(&root.asset.version)?;
    if major != 2 {
        return Err(Fault::Unsupported(format!("glTF version {major}.{minor} (2.0 is known)")));
    }
    if let Some(least) = &root.asset.min_version {
        let least = parse(least)?;
        if least > (2, 0) {
            return Err(Fault::Unsupported(format!("it needs glTF {}.{} (2.0 is known)", least.0, least.1)));
        }
    }
    Ok(())
}

fn check_extensions(root: &Root, warnings: &mut Vec<String>) -> Result<(), Fault> {
    let unknown = |names: &[String]| -> Vec<String> {
        names.iter().filter(|name| !EXTENSIONS.contains(&name.as_str())).map(|name| quoted(name)).collect()
    };
    let required = unknown(&root.extensions_required);
    if !required.is_empty() {
        return Err(Fault::Unsupported(format!("it requires the extension {}", required.join(", "))));
    }
    let used = unknown(&root.extensions_used);
    if !used.is_empty() {
        warnings.push(quoted(&format!("extensions that have no effect here: {}", used.join(", "))));
    }
    Ok(())
}

/// The item that the file means by `index`, or a message naming who refers to it.
fn get<'a, T>(items: &'a [T], index: usize, kind: &str, referrer: &str) -> Result<&'a T, Fault> {
    items.get(index).ok_or_else(|| {
        Fault::Invalid(format!("{referrer} refers to {kind} {index}, but there are {}", items.len()))
    })
}
