//! Scenes and cameras for the tests of this crate.
#![allow(dead_code, reason = "each test file uses a part")]

use std::path::Path;

use glam::{Affine3A, Vec3};
use gnomon_brdf::Surface;
use gnomon_envmap::Equirect;
use gnomon_image::RgbImage;
use gnomon_scene::{Camera, Material, MaterialId, Mesh, MeshId, Node, Scene};
use serde_json::Value;

/// A scene of meshes, each with its surface, placed where they are.
pub fn scene(parts: Vec<(Mesh, Surface)>) -> Scene {
    let mut scene = Scene::default();
    for (index, (mut mesh, surface)) in parts.into_iter().enumerate() {
        mesh.material = Some(MaterialId(index));
        scene.meshes.push(mesh);
        scene.materials.push(Material { surface, ..Material::default() });
        scene.nodes.push(node(MeshId(index), Affine3A::IDENTITY));
    }
    scene
}

pub fn node(mesh: MeshId, parent_from_node: Affine3A) -> Node {
    Node { name: String::new(), parent: None, parent_from_node, meshes: vec![mesh] }
}

/// A flat convex polygon, without normals: the triangles' own serve.
pub fn polygon(corners: &[Vec3]) -> Mesh {
    let triangles = (2..corners.len() as u32).map(|i| [0, i - 1, i]).collect();
    Mesh { positions: corners.to_vec(), triangles, ..Mesh::default() }
}

/// A horizontal square around the origin at height `y`.
pub fn floor(half: f32, y: f32) -> Mesh {
    polygon(&[[-half, y, half], [half, y, half], [half, y, -half], [-half, y, -half]].map(Vec3::from))
}

/// A unit sphere about the origin with exact vertex normals.
pub fn sphere(rings: u32, sectors: u32) -> Mesh {
    let mut mesh = Mesh::default();
    for ring in 0..=rings {
        let (sin, cos) = (std::f32::consts::PI * ring as f32 / rings as f32).sin_cos();
        for sector in 0..=sectors {
            let (s, c) = (std::f32::consts::TAU * sector as f32 / sectors as f32).sin_cos();
            mesh.positions.push(Vec3::new(sin * c, cos, sin * s));
            if ring < rings && sector < sectors {
                let a = ring * (sectors + 1) + sector;
                let b = a + sectors + 1;
                mesh.triangles.extend([[a, a + 1, b], [a + 1, b + 1, b]]);
            }
        }
    }
    mesh.normals = mesh.positions.clone();
    mesh
}

pub fn lambert(albedo: f32) -> Surface {
    Surface { base_color: Vec3::splat(albedo), ..Surface::default() }
}

pub fn constant_environment(radiance: Vec3) -> Equirect {
    Equirect::new(RgbImage::filled(16, 8, radiance))
}

/// Looks straight down at the origin from `height`, seeing about `width` metres there.
pub fn downward_camera(height: f32, width: f32) -> Camera {
    Camera::look_at(Vec3::new(0.0, height, 0.0), Vec3::ZERO, 2.0 * (0.5 * width / height).atan())
}

pub fn read_environment(path: &Path) -> Equirect {
    Equirect::new(gnomon_image::read(path).unwrap().image)
}

/// The meshes of a glTF binary whose primitives have positions and 32-bit indices and nothing else, Lambert 0.5.
pub fn read_plain_glb(path: &Path) -> Scene {
    let bytes = std::fs::read(path).unwrap();
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
    let json_length = word(12) as usize;
    let json: Value = serde_json::from_slice(&bytes[20..20 + json_length]).unwrap();
    let binary = 20 + json_length + 8;
    let words = |accessor: &Value, per_item: usize| -> Vec<u32> {
        let accessor = &json["accessors"][accessor.as_u64().unwrap() as usize];
        let view = &json["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
        let start = binary + view["byteOffset"].as_u64().unwrap_or(0) as usize;
        let count = accessor["count"].as_u64().unwrap() as usize * per_item;
        (0..count).map(|i| word(start + 4 * i)).collect()
    };
    let parts = json["meshes"].as_array().unwrap().iter().map(|mesh| {
        let primitive = &mesh["primitives"][0];
        let positions = words(&primitive["attributes"]["POSITION"], 3);
        let positions =
            positions.chunks_exact(3).map(|p| Vec3::from([p[0], p[1], p[2]].map(f32::from_bits))).collect();
        let indices = words(&primitive["indices"], 1);
        let triangles = indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
        (Mesh { positions, triangles, ..Mesh::default() }, lambert(0.5))
    });
    scene(parts.collect())
}
