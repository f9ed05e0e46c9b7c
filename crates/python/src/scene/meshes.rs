//! Meshes of nodes, and their vertices that move.

use std::sync::Arc;

use glam::{Affine3A, Mat4, Vec3};
use gnomon::brdf::Surface;
use gnomon::scene::{Material, MaterialId, Mesh, MeshId, NodeId};
use pyo3::prelude::*;

use super::Scene;
use crate::error::refused;
use crate::mesh::Shape;

impl Scene {
    /// Adds a node at the root, with a material of its name. Gives its number.
    pub(super) fn add_shape(
        &mut self,
        name: &str,
        shape: Shape,
        pose: Mat4,
        surface: Surface,
    ) -> PyResult<usize> {
        let mesh = shape.mesh()?;
        let scene = &mut self.project.scene;
        scene.materials.push(Material { name: name.to_owned(), surface, ..Material::default() });
        let material = Some(MaterialId(scene.materials.len() - 1));
        let NodeId(node) = scene.push_mesh(name, Mesh { material, ..mesh });
        scene.nodes[node].parent_from_node = Affine3A::from_mat4(pose);
        self.rest.push(Affine3A::from_mat4(pose));
        self.shapes.insert(node, Arc::new(shape));
        Ok(node)
    }

    /// The only mesh of a node.
    pub(super) fn mesh_of(&self, node: usize) -> PyResult<&Mesh> {
        self.mesh_number(node).map(|MeshId(mesh)| &*self.project.scene.meshes[mesh])
    }

    fn mesh_number(&self, node: usize) -> PyResult<MeshId> {
        match *self.project.scene.nodes[node].meshes {
            [mesh] => Ok(mesh),
            ref meshes => Err(refused(format!("node {node} places {} meshes, not one", meshes.len()))),
        }
    }

    fn replace(&mut self, node: usize, mesh: Mesh) -> PyResult<()> {
        let MeshId(place) = self.mesh_number(node)?;
        let material = self.project.scene.meshes[place].material;
        self.project.scene.meshes[place] = Arc::new(Mesh { material, ..mesh });
        Ok(())
    }

    /// Moves the vertices of a node's mesh; `normals` are empty where faces are flat.
    pub(super) fn bend(&mut self, node: usize, vertices: Vec<Vec3>, normals: Vec<Vec3>) -> PyResult<()> {
        let own = match self.shapes.get(&node) {
            Some(shape) => Shape::clone(shape),
            None => {
                let mesh = self.mesh_of(node)?;
                Shape {
                    vertices: mesh.positions.clone(),
                    triangles: mesh.triangles.clone(),
                    normals: mesh.normals.clone(),
                    ..Shape::default()
                }
            }
        };
        if vertices.len() != own.vertices.len() {
            return Err(refused(format!(
                "the mesh has {} vertices, not {}",
                own.vertices.len(),
                vertices.len()
            )));
        }
        if normals.is_empty() && !own.normals.is_empty() {
            return Err(refused("the mesh has smooth normals: give those of the moved vertices"));
        }
        let shape = Shape { vertices, normals, ..own };
        if self.shapes.contains_key(&node) {
            self.replace(node, shape.mesh()?)?;
            self.shapes.insert(node, Arc::new(shape));
            return Ok(());
        }
        let Mesh { positions, normals, .. } = shape.mesh()?;
        let mesh = Mesh { positions, normals, ..self.mesh_of(node)?.clone() };
        self.replace(node, mesh)?;
        if !self.bent.contains(&node) {
            self.bent.push(node);
        }
        Ok(())
    }
}
