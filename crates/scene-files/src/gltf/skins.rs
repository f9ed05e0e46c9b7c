//! Skins (specification, section 3.7.3).

use std::collections::HashMap;

use glam::{Affine3A, Mat4};
use gnomon_scene::{Influences, NodeId, Scene, Skin, SkinId};

use super::accessors::Accessors;
use super::schema::{Int, Primitive, Root};
use super::{Budget, Fault, get};

/// Sums of weights that differ more than this from 1 are worth a warning: four weights in 8 bits stay below it.
const WEIGHT_TOLERANCE: f32 = 0.01;

/// The skins of a file, each read when a node first uses it.
#[derive(Default)]
pub struct Skins {
    known: HashMap<usize, Option<SkinId>>,
}

impl Skins {
    /// Skin `index` in `scene.skins`; `None`, with a warning, where one of its joints is not in the scene. `places` has
    /// the scene's node of every node of the file.
    pub fn read(
        &mut self,
        root: &Root,
        accessors: &Accessors,
        index: usize,
        places: &[Option<usize>],
        budget: &mut Budget,
        scene: &mut Scene,
    ) -> Result<Option<SkinId>, Fault> {
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
        let mut complete = true;
        for (number, &Int(joint)) in entry.joints.iter().enumerate() {
            get(&root.nodes, joint, "node", &label)?;
            let bind = binds.get(number).map_or(Mat4::IDENTITY, Mat4::from_cols_array);
            if !bind.is_finite() {
                return Err(Fault::Invalid(format!("{label} has a bind matrix that is not finite")));
            }
            match places[joint] {
                Some(place) => skin.joints.push(NodeId(place)),
                None => complete = false,
            }
            skin.joint_from_bind.push(Affine3A::from_mat4(bind));
        }
        let id = complete.then(|| {
            scene.skins.push(skin);
            SkinId(scene.skins.len() - 1)
        });
        if id.is_none() {
            scene.warnings.push(format!("{label}: joints are not in the scene, it is ignored"));
        }
        self.known.insert(index, id);
        Ok(id)
    }
}

/// Joints and weights of a primitive's `count` vertices, of all its sets. Weights are made to sum to 1.
pub fn influences(
    primitive: &Primitive,
    accessors: &Accessors,
    name: &str,
    count: usize,
    budget: &mut Budget,
    warnings: &mut Vec<String>,
) -> Result<Influences, Fault> {
    let mut sets = Vec::new();
    loop {
        let attribute = |semantic: &str| primitive.attributes.get(&format!("{semantic}_{}", sets.len()));
        let (Some(joints), Some(weights)) = (attribute("JOINTS"), attribute("WEIGHTS")) else { break };
        let joints = accessors.floats::<4>(joints.0, name, budget)?;
        let weights = accessors.floats::<4>(weights.0, name, budget)?;
        if joints.len() != count || weights.len() != count {
            return Err(Fault::Invalid(format!("{name} has not as many joints and weights as positions")));
        }
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
