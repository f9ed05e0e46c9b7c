//! What is worked out of meshes on the CPU, once.

use std::collections::HashMap;
use std::sync::Arc;

use gnomon_scene::{Instance, Mesh, MeshPart, Scene, SimplerTriangles};
use rayon::prelude::*;

use super::address;

/// What is worked out of a mesh once, whatever scenes it is part of.
pub(crate) struct MeshDetail {
    /// Keeps the address that it is known by from being used for another.
    _mesh: Arc<Mesh>,
    pub parts: Vec<MeshPart>,
    /// For shadow maps, where the mesh is one part.
    pub simpler: Vec<SimplerTriangles>,
}

impl MeshDetail {
    fn new(mesh: &Arc<Mesh>) -> Self {
        let parts = mesh.parts();
        let simpler = if parts.len() == 1 { mesh.simplifications() } else { Vec::new() };
        Self { _mesh: Arc::clone(mesh), parts, simpler }
    }
}

/// Details by the address of their mesh.
pub(crate) type MeshDetails = HashMap<usize, Arc<MeshDetail>>;

/// Details of the rigid meshes among those placed; of meshes that were there before, those that are `known`.
pub(super) fn details(scene: &Scene, placed: &[Instance], known: &MeshDetails) -> MeshDetails {
    let rigid = placed.iter().filter(|instance| !scene.is_deformable(instance));
    let meshes: HashMap<usize, &Arc<Mesh>> =
        rigid.map(|instance| &scene.meshes[instance.mesh.0]).map(|mesh| (address(mesh), mesh)).collect();
    let detail = |(address, mesh): (usize, &Arc<Mesh>)| {
        let detail = known.get(&address).cloned();
        (address, detail.unwrap_or_else(|| Arc::new(MeshDetail::new(mesh))))
    };
    meshes.into_par_iter().map(detail).collect()
}
