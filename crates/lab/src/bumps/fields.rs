use std::sync::Arc;

use glam::{Affine2, Vec2, Vec3};
use gnomon_scene::{
    Camera, Height, HeightMap, HeightMapId, Material, MaterialId, Mesh, MeshId, Node, Scene, Wrap,
};

use crate::{LabError, View};

/// A height field by code.
pub(super) struct Field {
    pub name: &'static str,
    /// Height [m] at a place of a square of 1 m.
    height: fn(Vec2) -> f32,
}

/// Every field.
pub(super) const FIELDS: [Field; 3] = [
    Field { name: "hemispheres", height: hemispheres },
    Field { name: "grooves", height: grooves },
    Field { name: "blocks", height: blocks },
];

/// Three by three, 0.13 m high.
fn hemispheres(p: Vec2) -> f32 {
    let squared = ((3.0 * p).fract() / 3.0 - 1.0 / 6.0).length_squared();
    (0.13 * 0.13 - squared).max(0.0).sqrt()
}

/// Four, 0.1 m deep.
fn grooves(p: Vec2) -> f32 {
    0.05 * (std::f32::consts::TAU * 4.0 * p.x).cos()
}

/// Of bricks in two rows, with joints 0.03 m deep.
fn blocks(p: Vec2) -> f32 {
    let row = (4.0 * p.y).floor();
    let place = Vec2::new((2.0 * p.x + 0.5 * row).fract(), (4.0 * p.y).fract());
    let to_edge = (place.min(1.0 - place) / Vec2::new(2.0, 4.0)).min_element();
    0.03 * (to_edge / 0.02).min(1.0)
}

impl Field {
    /// A square of 2 m under the field, twice along each side.
    ///
    /// # Errors
    /// A field that is no height map.
    pub fn view(&self, side: u32) -> Result<View, LabError> {
        let place = |i: u32| Vec2::new((i % side) as f32 + 0.5, (i / side) as f32 + 0.5) / side as f32;
        let values = (0..side * side).map(|i| (self.height)(place(i))).collect();
        let map = HeightMap::new(side, side, values, [Wrap::Repeat; 2]).map_err(LabError::Request)?;
        let corners = [[-1.0, -1.0], [-1.0, 1.0], [1.0, 1.0], [1.0, -1.0]].map(Vec2::from_array);
        let mesh = Mesh {
            positions: corners.map(|p| Vec3::new(p.x, 0.0, p.y)).to_vec(),
            normals: vec![Vec3::Y; 4],
            uvs: [corners.map(|p| p + 1.0).to_vec(), Vec::new()],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            material: Some(MaterialId(0)),
            ..Mesh::default()
        };
        let mut material = Material::default();
        material.surface.base_color = Vec3::new(0.8, 0.7, 0.6);
        material.height =
            Some(Height { map: HeightMapId(0), uv_from_mesh: Affine2::IDENTITY, set: 0, scale: 1.0 });
        let scene = Scene {
            meshes: vec![Arc::new(mesh)],
            materials: vec![material],
            height_maps: vec![Arc::new(map)],
            nodes: vec![Node { meshes: vec![MeshId(0)], ..Node::default() }],
            ..Scene::default()
        };
        let camera = Camera::look_at(Vec3::new(0.3, 1.7, 1.5), Vec3::new(0.0, 0.0, 0.05), 1.0);
        Ok(View::new(self.name, scene, camera))
    }
}
