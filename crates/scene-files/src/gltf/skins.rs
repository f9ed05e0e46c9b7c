//! Skins (specification, section 3.7.3).

use std::collections::HashMap;

use glam::{Affine3A, Mat4};
use gnomon_scene::{Influences, NodeId, Scene, Skin, SkinId};

use super::accessors::Accessors;
use super::attributes::Attributes;
use super::schema::{Int, Root};
use super::{Budget, Fault, get};

/// Sums of weights that differ more than this from 1 are worth a warning: four weights in 8 bits stay below it.
const WEIGHT_TOLERANCE: f32 = 0.01;

/// The skins of a file, each read when a node first uses it.
#[derive(Default)]
pub struct Skins {
    known: HashMap<usize, SkinId>,
}

impl Skins {
    /// Skin `index` in `scene.skins`. `places` has the scene's node of every node of the file that is shown or is a joint.
    pub fn read(
        &mut self,
        root: &Root,
        accessors: &Accessors,
        index: usize,
        places: &[Option<usize>],
        budget: &mut Budget,
        scene: &mut Scene,
    ) -> Result<SkinId, Fault> {
        if let Some(known) = self.known.get(&index) {
            return Ok(*known);
        }
        let entry = get(&root.skins, index, "skin", "a node")?;
        let label = format!("skin {index}");
        let binds = match entry.inverse_bind_matrices {
            Some(Int(accessor)) => accessors.floats::<16>(accessor, &label, budget)?,
            None => Vec::new(),
        };
        if entry.inverse_bind_matrices.is_some() && binds.len() < entry.joints.len() {
            return Err(Fault::Invalid(format!("{label} has fewer bind matrices than joints")));
        }
        budget.take(entry.joints.len(), size_of::<Affine3A>() + size_of::<NodeId>())?;
        let name = entry.name.as_deref().map(gnomon_messages::quoted).unwrap_or_default();
        let mut skin = Skin { name, ..Skin::default() };
        for (number, &Int(joint)) in entry.joints.iter().enumerate() {
            get(&root.nodes, joint, "node", &label)?;
            let bind = binds.get(number).map_or(Mat4::IDENTITY, Mat4::from_cols_array);
            if !bind.is_finite() {
                return Err(Fault::Invalid(format!("{label} has a bind matrix that is not finite")));
            }
            let place =
                places[joint].ok_or_else(|| Fault::Invalid(format!("{label} has no joint {joint}")))?;
            skin.joints.push(NodeId(place));
            skin.joint_from_bind.push(Affine3A::from_mat4(bind));
        }
        let id = SkinId(scene.skins.len());
        scene.skins.push(skin);
        self.known.insert(index, id);
        Ok(id)
    }
}

/// Joints and weights of a primitive's vertices, of all their sets. Weights are made to sum to 1.
pub fn influences(
    attributes: &Attributes,
    budget: &mut Budget,
    warnings: &mut Vec<String>,
) -> Result<Influences, Fault> {
    let Attributes { name, count, .. } = *attributes;
    let mut sets = Vec::new();
    loop {
        let mut read = |semantic: &str| attributes.read::<4>(&format!("{semantic}_{}", sets.len()), budget);
        let (Some(joints), Some(weights)) = (read("JOINTS")?, read("WEIGHTS")?) else { break };
        sets.push((joints, weights));
    }
    let mut influences = Influences::default();
    if sets.is_empty() {
        return Ok(influences);
    }
    budget.take(count, size_of::<u32>() + 4 * sets.len() * size_of::<(u32, f32)>())?;
    let (mut repaired, mut free) = (0, 0);
    let mut entries: Vec<(u32, f32)> = Vec::new();
    for vertex in 0..count {
        entries.clear();
        let mut broken = false;
        for (joints, weights) in &sets {
            for (&joint, &weight) in joints[vertex].iter().zip(&weights[vertex]) {
                // False for NaN.
                if weight > 0.0 && weight.is_finite() {
                    entries.push((joint as u32, weight));
                } else {
                    broken |= weight != 0.0;
                }
            }
        }
        let sum: f32 = entries.iter().map(|(_, weight)| weight).sum();
        if !(sum > 0.0 && sum.is_finite()) {
            entries.clear();
            free += 1;
        } else {
            repaired += usize::from(broken || (sum - 1.0).abs() > WEIGHT_TOLERANCE);
            entries.iter_mut().for_each(|(_, weight)| *weight /= sum);
        }
        influences.push(&entries);
    }
    if repaired > 0 {
        warnings.push(format!("{name}: the joint weights of {repaired} vertices were made to sum to 1"));
    }
    if free > 0 {
        warnings.push(format!("{name}: {free} vertices have no joint weights and follow their node"));
    }
    Ok(influences)
}
