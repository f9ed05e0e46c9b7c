//! Small glTF documents made by code.
#![allow(dead_code, reason = "each test binary uses its part")]

use std::path::PathBuf;

use gnomon_scene_files::{LoadOptions, LoadedScene, SceneFileError, load};
use serde_json::{Value, json};

/// A triangle (0,0,0), (1,0,0), (0,1,0) with uv = xy, shown by one node; `change` edits the document.
pub fn triangle(change: impl FnOnce(&mut Value)) -> Value {
    let positions: [f32; 9] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let uvs: [f32; 6] = [0.0, 0.0, 1.0, 0.0, 0.0, 1.0];
    let bytes: Vec<u8> = positions.iter().chain(&uvs).flat_map(|x| x.to_le_bytes()).collect();
    let mut document = json!({
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC2"}
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": 36},
            {"buffer": 0, "byteOffset": 36, "byteLength": 24}
        ],
        "buffers": [{"byteLength": 60, "uri": embedded(&bytes)}]
    });
    change(&mut document);
    document
}

pub fn embedded(bytes: &[u8]) -> String {
    use base64::Engine;
    format!(
        "data:application/octet-stream;base64,{}",
        base64::engine::general_purpose::STANDARD.encode(bytes)
    )
}

/// Appends a buffer with one view and accessor of it, and returns the accessor's index.
pub fn add_accessor(document: &mut Value, bytes: &[u8], component: u32, count: usize, shape: &str) -> usize {
    let list = |document: &mut Value, key: &str, item: Value| -> usize {
        let items = document[key].as_array_mut().unwrap();
        items.push(item);
        items.len() - 1
    };
    let buffer = list(document, "buffers", json!({"byteLength": bytes.len(), "uri": embedded(bytes)}));
    let view = list(document, "bufferViews", json!({"buffer": buffer, "byteLength": bytes.len()}));
    let accessor = json!({"bufferView": view, "componentType": component, "count": count, "type": shape});
    list(document, "accessors", accessor)
}

/// A 1 x 1 PNG of that colour, as a data URI.
pub fn pixel(rgba: [u8; 4]) -> String {
    let mut bytes = Vec::new();
    let picture = image::RgbaImage::from_pixel(1, 1, image::Rgba(rgba));
    picture.write_to(&mut std::io::Cursor::new(&mut bytes), image::ImageFormat::Png).unwrap();
    embedded(&bytes).replace("application/octet-stream", "image/png")
}

pub fn attempt(document: &Value) -> Result<LoadedScene, SceneFileError> {
    let folder = tempfile::tempdir().unwrap();
    let path: PathBuf = folder.path().join("document.gltf");
    std::fs::write(&path, serde_json::to_vec(document).unwrap()).unwrap();
    load(&path, &LoadOptions::default())
}

pub fn read(document: &Value) -> LoadedScene {
    attempt(document).unwrap_or_else(|error| panic!("{error}"))
}

pub fn refusal(document: &Value) -> String {
    attempt(document).unwrap_err().to_string()
}

/// Floats as an accessor's bytes.
pub fn bytes(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|x| x.to_le_bytes()).collect()
}
