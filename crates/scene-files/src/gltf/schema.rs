//! The parts of a glTF document that are used, as the specification's JSON schema names them. Unknown members are ignored.

use std::collections::HashMap;

use serde::Deserialize;
use serde::de::{Deserializer, Error, Visitor};

mod material;

pub use material::{AlphaModeEntry, Anisotropy, HeightEntry, MaterialEntry, SpecularGlossiness, TextureInfo};

/// A non-negative integer; JSON may write it `2`, `2.0` or `2e0`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Int(pub usize);

impl<'de> Deserialize<'de> for Int {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct IntVisitor;
        impl Visitor<'_> for IntVisitor {
            type Value = Int;

            fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
                f.write_str("a non-negative integer")
            }

            fn visit_u64<E: Error>(self, value: u64) -> Result<Int, E> {
                usize::try_from(value).map(Int).map_err(|_| E::custom(format!("{value} is too large")))
            }

            fn visit_f64<E: Error>(self, value: f64) -> Result<Int, E> {
                // 2^53: beyond, f64 has no unit steps.
                if value.fract() == 0.0 && (0.0..9_007_199_254_740_992.0).contains(&value) {
                    self.visit_u64(value as u64)
                } else {
                    Err(E::custom(format!("{value} is no non-negative integer")))
                }
            }
        }
        deserializer.deserialize_any(IntVisitor)
    }
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Root {
    pub scene: Option<Int>,
    #[serde(default)]
    pub scenes: Vec<SceneEntry>,
    #[serde(default)]
    pub nodes: Vec<NodeEntry>,
    #[serde(default)]
    pub meshes: Vec<MeshEntry>,
    #[serde(default)]
    pub accessors: Vec<Accessor>,
    #[serde(default)]
    pub buffer_views: Vec<BufferView>,
    #[serde(default)]
    pub buffers: Vec<Buffer>,
    #[serde(default)]
    pub materials: Vec<MaterialEntry>,
    #[serde(default)]
    pub textures: Vec<TextureEntry>,
    #[serde(default)]
    pub images: Vec<ImageEntry>,
    #[serde(default)]
    pub samplers: Vec<Sampler>,
    #[serde(default)]
    pub cameras: Vec<CameraEntry>,
    #[serde(default)]
    pub skins: Vec<Skin>,
    #[serde(default)]
    pub animations: Vec<AnimationEntry>,
    #[serde(default)]
    pub extensions_used: Vec<String>,
    #[serde(default)]
    pub extensions_required: Vec<String>,
    #[serde(default)]
    pub extensions: RootExtensions,
}

#[derive(Debug, Default, Deserialize)]
pub struct RootExtensions {
    #[serde(rename = "KHR_materials_variants")]
    pub variants: Option<Variants>,
    #[serde(rename = "KHR_lights_punctual")]
    pub lights: Option<Lights>,
}

#[derive(Debug, Deserialize)]
pub struct Lights {
    #[serde(default)]
    pub lights: Vec<LightEntry>,
}

#[derive(Debug, Deserialize)]
pub struct LightEntry {
    pub color: Option<[f32; 3]>,
    pub intensity: Option<f32>,
    #[serde(rename = "type")]
    pub kind: String,
    pub spot: Option<SpotEntry>,
    /// The application's own; anything may stand there.
    #[serde(default)]
    pub extras: serde_json::Value,
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct SpotEntry {
    pub inner_cone_angle: Option<f32>,
    pub outer_cone_angle: Option<f32>,
}

#[derive(Debug, Deserialize)]
pub struct Variants {
    #[serde(default)]
    pub variants: Vec<Variant>,
}

#[derive(Debug, Deserialize)]
pub struct Variant {
    #[serde(default)]
    pub name: String,
}

#[derive(Debug, Deserialize)]
pub struct SceneEntry {
    #[serde(default)]
    pub nodes: Vec<Int>,
}

#[derive(Debug, Deserialize)]
pub struct NodeEntry {
    pub name: Option<String>,
    #[serde(default)]
    pub children: Vec<Int>,
    pub mesh: Option<Int>,
    pub camera: Option<Int>,
    pub skin: Option<Int>,
    pub matrix: Option<[f64; 16]>,
    pub translation: Option<[f64; 3]>,
    pub rotation: Option<[f32; 4]>,
    pub scale: Option<[f32; 3]>,
    pub weights: Option<Vec<f32>>,
    #[serde(default)]
    pub extensions: NodeExtensions,
}

#[derive(Debug, Default, Deserialize)]
pub struct NodeExtensions {
    #[serde(rename = "EXT_mesh_gpu_instancing")]
    pub instancing: Option<Instancing>,
    #[serde(rename = "KHR_node_visibility")]
    pub visibility: Option<Visibility>,
    #[serde(rename = "KHR_lights_punctual")]
    pub light: Option<LightReference>,
}

#[derive(Debug, Deserialize)]
pub struct LightReference {
    pub light: Int,
}

#[derive(Debug, Deserialize)]
pub struct Instancing {
    #[serde(default)]
    pub attributes: HashMap<String, Int>,
}

#[derive(Debug, Deserialize)]
pub struct Visibility {
    pub visible: Option<bool>,
}

#[derive(Debug, Deserialize)]
pub struct MeshEntry {
    pub name: Option<String>,
    #[serde(default)]
    pub primitives: Vec<Primitive>,
    pub weights: Option<Vec<f32>>,
}

#[derive(Debug, Deserialize)]
pub struct Primitive {
    #[serde(default)]
    pub attributes: HashMap<String, Int>,
    pub indices: Option<Int>,
    pub material: Option<Int>,
    pub mode: Option<Int>,
    #[serde(default)]
    pub targets: Vec<HashMap<String, Int>>,
    #[serde(default)]
    pub extensions: PrimitiveExtensions,
}

#[derive(Debug, Default, Deserialize)]
pub struct PrimitiveExtensions {
    #[serde(rename = "KHR_draco_mesh_compression")]
    pub draco: Option<Draco>,
    #[serde(rename = "KHR_materials_variants")]
    pub variants: Option<Mappings>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Draco {
    pub buffer_view: Int,
    #[serde(default)]
    pub attributes: HashMap<String, Int>,
}

#[derive(Debug, Deserialize)]
pub struct Mappings {
    #[serde(default)]
    pub mappings: Vec<Mapping>,
}

#[derive(Debug, Deserialize)]
pub struct Mapping {
    pub material: Option<Int>,
    #[serde(default)]
    pub variants: Vec<Int>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Accessor {
    pub buffer_view: Option<Int>,
    #[serde(default)]
    pub byte_offset: Int,
    pub component_type: Int,
    #[serde(default)]
    pub normalized: bool,
    pub count: Int,
    #[serde(rename = "type")]
    pub shape: String,
    pub sparse: Option<Sparse>,
}

#[derive(Debug, Deserialize)]
pub struct Sparse {
    pub count: Int,
    pub indices: SparseIndices,
    pub values: SparseValues,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct SparseIndices {
    pub buffer_view: Int,
    #[serde(default)]
    pub byte_offset: Int,
    pub component_type: Int,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct SparseValues {
    pub buffer_view: Int,
    #[serde(default)]
    pub byte_offset: Int,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct BufferView {
    pub buffer: Int,
    #[serde(default)]
    pub byte_offset: Int,
    pub byte_length: Int,
    pub byte_stride: Option<Int>,
    #[serde(default)]
    pub extensions: BufferViewExtensions,
}

#[derive(Debug, Default, Deserialize)]
pub struct BufferViewExtensions {
    #[serde(rename = "EXT_meshopt_compression", alias = "KHR_meshopt_compression")]
    pub meshopt: Option<Meshopt>,
}

/// Where a view's bytes lie, compressed, and how.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Meshopt {
    pub buffer: Int,
    #[serde(default)]
    pub byte_offset: Int,
    pub byte_length: Int,
    pub byte_stride: Int,
    pub count: Int,
    pub mode: String,
    pub filter: Option<String>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Buffer {
    pub uri: Option<String>,
    pub byte_length: Int,
}

#[derive(Debug, Deserialize)]
pub struct TextureEntry {
    pub source: Option<Int>,
    pub sampler: Option<Int>,
    #[serde(default)]
    pub extensions: TextureExtensions,
}

#[derive(Debug, Default, Deserialize)]
pub struct TextureExtensions {
    #[serde(rename = "EXT_texture_webp")]
    pub webp: Option<TextureSource>,
    #[serde(rename = "KHR_texture_basisu")]
    pub basisu: Option<TextureSource>,
}

#[derive(Debug, Deserialize)]
pub struct TextureSource {
    pub source: Option<Int>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct ImageEntry {
    pub uri: Option<String>,
    pub buffer_view: Option<Int>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Sampler {
    pub mag_filter: Option<Int>,
    pub wrap_s: Option<Int>,
    pub wrap_t: Option<Int>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Skin {
    pub name: Option<String>,
    #[serde(default)]
    pub joints: Vec<Int>,
    pub inverse_bind_matrices: Option<Int>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct CameraEntry {
    pub name: Option<String>,
    #[serde(rename = "type")]
    pub kind: String,
    pub perspective: Option<Perspective>,
    pub orthographic: Option<Orthographic>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Perspective {
    pub yfov: f32,
    pub aspect_ratio: Option<f32>,
}

#[derive(Debug, Deserialize)]
pub struct Orthographic {
    pub xmag: f32,
    pub ymag: Option<f32>,
}

#[derive(Debug, Deserialize)]
pub struct AnimationEntry {
    pub name: Option<String>,
    #[serde(default)]
    pub channels: Vec<ChannelEntry>,
    #[serde(default)]
    pub samplers: Vec<AnimationSampler>,
}

#[derive(Debug, Deserialize)]
pub struct ChannelEntry {
    pub sampler: Option<Int>,
    #[serde(default)]
    pub target: ChannelTarget,
}

#[derive(Debug, Default, Deserialize)]
pub struct ChannelTarget {
    pub node: Option<Int>,
    #[serde(default)]
    pub path: String,
    #[serde(default)]
    pub extensions: TargetExtensions,
}

#[derive(Debug, Default, Deserialize)]
pub struct TargetExtensions {
    #[serde(rename = "KHR_animation_pointer")]
    pub pointer: Option<Pointer>,
}

#[derive(Debug, Deserialize)]
pub struct Pointer {
    #[serde(default)]
    pub pointer: String,
}

#[derive(Debug, Deserialize)]
pub struct AnimationSampler {
    pub input: Option<Int>,
    pub output: Option<Int>,
    pub interpolation: Option<String>,
}
