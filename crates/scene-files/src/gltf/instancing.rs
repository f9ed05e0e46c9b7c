//! Copies of a node's meshes (`EXT_mesh_gpu_instancing`): a node each, which shares the meshes.

use glam::{Affine3A, Quat, Vec3};
use gnomon_scene::{MeshId, Node, NodeId};

use super::accessors::Accessors;
use super::schema::{Instancing, Int};
use super::{Budget, Fault};

/// The transforms of the copies to the node's space.
pub fn read(
    entry: &Instancing,
    accessors: &Accessors,
    label: &str,
    budget: &mut Budget,
    warnings: &mut Vec<String>,
) -> Result<Vec<Affine3A>, Fault> {
    let attribute = |semantic: &str| entry.attributes.get(semantic);
    let vectors = |semantic: &str, budget: &mut Budget| match attribute(semantic) {
        Some(&Int(index)) => accessors.floats::<3>(index, label, budget).map(Some),
        None => Ok(None),
    };
    let (translations, scales) = (vectors("TRANSLATION", budget)?, vectors("SCALE", budget)?);
    let rotations = match attribute("ROTATION") {
        Some(&Int(index)) => Some(accessors.floats::<4>(index, label, budget)?),
        None => None,
    };
    let counts = [
        translations.as_ref().map(Vec::len),
        scales.as_ref().map(Vec::len),
        rotations.as_ref().map(Vec::len),
    ];
    let mut counts = counts.into_iter().flatten();
    let count = counts.next().unwrap_or(0);
    if counts.any(|other| other != count) {
        return Err(Fault::Invalid(format!("the instances of {label} have attributes of different lengths")));
    }
    budget.take(count, size_of::<Affine3A>())?;
    let vector = |values: &Option<Vec<[f32; 3]>>, i: usize, default: Vec3| {
        values.as_ref().map_or(default, |values| Vec3::from_array(values[i]))
    };
    let places = (0..count).map(|i| {
        let rotation = rotations.as_ref().map_or(Quat::IDENTITY, |values| Quat::from_array(values[i]));
        // Bytes and shorts need not be normalized to turn.
        let rotation =
            if rotation.length_recip().is_normal() { rotation.normalize() } else { Quat::IDENTITY };
        Affine3A::from_scale_rotation_translation(
            vector(&scales, i, Vec3::ONE),
            rotation,
            vector(&translations, i, Vec3::ZERO),
        )
    });
    let finite: Vec<Affine3A> = places.filter(|place| place.is_finite()).collect();
    if finite.len() < count {
        warnings.push(format!("{label}: {} instances are not finite and left out", count - finite.len()));
    }
    Ok(finite)
}

/// Nodes below `id`, the number of `node`, that place what the node itself then does not. A skinned mesh follows its joints and is there once.
pub fn copies(
    node: &mut Node,
    id: NodeId,
    places: Vec<Affine3A>,
    budget: &mut Budget,
) -> Result<Vec<Node>, Fault> {
    if node.skin.is_some() {
        return Ok(Vec::new());
    }
    let each =
        size_of::<Node>() + node.meshes.len() * size_of::<MeshId>() + node.weights.len() * size_of::<f32>();
    budget.take(places.len(), each)?;
    let (meshes, weights) = (std::mem::take(&mut node.meshes), node.weights.clone());
    let copy = |parent_from_node| Node {
        parent: Some(id),
        parent_from_node,
        meshes: meshes.clone(),
        weights: weights.clone(),
        ..Node::default()
    };
    Ok(places.into_iter().map(copy).collect())
}
