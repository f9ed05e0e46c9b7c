//! Scenes and cameras for the tests of this crate.
#![allow(dead_code, reason = "each test file uses a part")]

use std::path::Path;

use glam::{Affine3A, Vec3};
use gnomon_brdf::Surface;
use gnomon_envmap::Equirect;
use gnomon_picture::RgbImage;
use gnomon_scene::{Camera, Material, MaterialId, Mesh, MeshId, Node, Projection, Scene};

/// A scene of meshes, each with its surface, placed where they are.
pub fn scene(parts: Vec<(Mesh, Surface)>) -> Scene {
    let mut scene = Scene::default();
    for (index, (mut mesh, surface)) in parts.into_iter().enumerate() {
        mesh.material = Some(MaterialId(index));
        scene.meshes.push(mesh.into());
        scene.materials.push(Material { surface, ..Material::default() });
        scene.nodes.push(node(MeshId(index), Affine3A::IDENTITY));
    }
    scene
}

pub fn node(mesh: MeshId, parent_from_node: Affine3A) -> Node {
    Node { parent_from_node, meshes: vec![mesh], ..Node::default() }
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

/// A parallel camera at `height` over the origin that looks straight down at a strip `width` metres across.
pub fn downward_strip(height: f32, width: f32) -> Camera {
    let camera = Camera::look_at(Vec3::new(0.0, height, 0.0), Vec3::ZERO, 1.0);
    Camera { projection: Projection::Orthographic { half_width: 0.5 * width }, ..camera }
}

pub fn read_environment(path: &Path) -> Equirect {
    Equirect::new(gnomon_picture::read(path).unwrap().image)
}
