//! Animations (specification, section 3.11). One that cannot be played does not keep a model from being shown: what is
//! damaged is left out with a warning.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{DVec3, Quat, Vec3};
use gnomon_messages::quoted;
use gnomon_scene::{AnimatedNode, Animation, Channel, Interpolation, Keys, NodeId, Scene};

use super::accessors::Accessors;
use super::meshes::Meshes;
use super::schema::{AnimationEntry, ChannelEntry, ChannelTarget, Int, NodeEntry, Pointer, Root};
use super::{Budget, Fault, get};

/// Adds the file's animations to its scene. `places` has the scene's node of every node of the file.
pub fn read(
    root: &Root,
    accessors: &Accessors,
    meshes: &Meshes,
    places: &[Option<usize>],
    budget: &mut Budget,
    scene: &mut Scene,
) -> Result<(), Fault> {
    let reader = Reader { root, accessors, meshes, places };
    let mut animated: HashMap<usize, AnimatedNode> = HashMap::new();
    for (index, entry) in root.animations.iter().enumerate() {
        budget.take(1, size_of::<Animation>())?;
        let name = entry.name.as_deref().map(quoted).unwrap_or_default();
        let mut animation = Animation { name, channels: Vec::new() };
        for (number, channel) in entry.channels.iter().enumerate() {
            budget.take(1, size_of::<Channel>())?;
            match reader.channel(entry, channel, budget) {
                Ok(None) => {}
                Ok(Some((node, channel))) => {
                    if let std::collections::hash_map::Entry::Vacant(vacant) = animated.entry(node) {
                        budget.take(1, size_of::<AnimatedNode>())?;
                        if root.nodes[node].matrix.is_some() {
                            scene
                                .warnings
                                .push(format!("node {node} is animated and has a matrix: its shear is lost"));
                        }
                        vacant.insert(at_rest(&root.nodes[node], channel.node, scene));
                    }
                    animation.channels.push(channel);
                }
                Err(Fault::Invalid(message) | Fault::Unsupported(message)) => {
                    let channel = format!("animation {index}, channel {number}");
                    scene.warnings.push(quoted(&format!("{channel} is left out: {message}")));
                }
                Err(fault) => return Err(fault),
            }
        }
        scene.animations.push(Arc::new(animation));
    }
    scene.animated = animated.into_values().collect();
    scene.animated.sort_by_key(|animated| animated.node.0);
    Ok(())
}

fn at_rest(entry: &NodeEntry, node: NodeId, scene: &Scene) -> AnimatedNode {
    let placed = &scene.nodes[node.0];
    let parent_from_node = placed.parent_from_node;
    let (mut scale, mut rotation, mut translation) = parent_from_node.to_scale_rotation_translation();
    if entry.matrix.is_none() {
        // As written: taking a matrix apart loses what a scale of 0 hides.
        scale = Vec3::from_array(entry.scale.unwrap_or([1.0; 3]));
        rotation = Quat::from_array(entry.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0])).normalize();
        translation = DVec3::from_array(entry.translation.unwrap_or_default()).as_vec3();
    }
    if !(rotation.is_finite() && scale.is_finite()) {
        (scale, rotation) = (Vec3::ONE, Quat::IDENTITY);
    }
    AnimatedNode { node, parent_from_node, translation, rotation, scale, weights: placed.weights.clone() }
}

impl ChannelTarget {
    /// What it moves of which node; `None` for no node.
    fn node_and_path(&self) -> Result<Option<(usize, &str)>, Fault> {
        let Some(Pointer { pointer }) = &self.extensions.pointer else {
            return Ok(self.node.map(|Int(node)| (node, self.path.as_str())));
        };
        let mut parts = pointer.strip_prefix("/nodes/").unwrap_or_default().splitn(2, '/');
        let node = parts.next().and_then(|node| node.parse().ok());
        let moved = node.zip(parts.next());
        moved.map(Some).ok_or_else(|| Fault::Invalid(format!("it moves '{pointer}', which stays here")))
    }
}

struct Reader<'a> {
    root: &'a Root,
    accessors: &'a Accessors<'a>,
    meshes: &'a Meshes<'a>,
    places: &'a [Option<usize>],
}

impl Reader<'_> {
    /// The file's node and the channel; `None` for one that moves nothing in the scene.
    fn channel(
        &self,
        animation: &AnimationEntry,
        entry: &ChannelEntry,
        budget: &mut Budget,
    ) -> Result<Option<(usize, Channel)>, Fault> {
        let Some((node, path)) = entry.target.node_and_path()? else { return Ok(None) };
        let target = get(&self.root.nodes, node, "node", "it")?;
        let Some(place) = self.places[node] else { return Ok(None) };
        let sampler = entry.sampler.ok_or_else(|| Fault::invalid("it has no sampler"))?;
        let sampler = get(&animation.samplers, sampler.0, "sampler", "it")?;
        let interpolation = match sampler.interpolation.as_deref() {
            None | Some("LINEAR") => Interpolation::Linear,
            Some("STEP") => Interpolation::Step,
            Some("CUBICSPLINE") => Interpolation::CubicSpline,
            Some(other) => return Err(Fault::Invalid(format!("its interpolation '{other}' is unknown"))),
        };
        let (Some(Int(input)), Some(Int(output))) = (sampler.input, sampler.output) else {
            return Err(Fault::invalid("its sampler lacks times or values"));
        };
        let times: Vec<f32> =
            self.accessors.floats::<1>(input, "it", budget)?.into_iter().flatten().collect();
        if times.is_empty() {
            return Err(Fault::invalid("it has no keys"));
        }
        if !times.iter().all(|time| time.is_finite()) || !times.is_sorted() {
            return Err(Fault::invalid("its times are not finite or decrease"));
        }
        let vectors = |budget: &mut Budget| -> Result<Vec<Vec3>, Fault> {
            let values = self.accessors.floats::<3>(output, "it", budget)?;
            Ok(values.into_iter().map(Vec3::from_array).collect())
        };
        let mut width = 1;
        let keys = match path {
            "translation" => Keys::Translation(vectors(budget)?),
            "scale" => Keys::Scale(vectors(budget)?),
            "rotation" => {
                let values = self.accessors.floats::<4>(output, "it", budget)?;
                Keys::Rotation(values.into_iter().map(Quat::from_array).collect())
            }
            "weights" => {
                width = target.mesh.map_or(0, |Int(mesh)| self.meshes.targets(mesh));
                if width == 0 {
                    return Err(Fault::Invalid(format!("node {node} has no morph targets")));
                }
                let values =
                    self.accessors.floats::<1>(output, "it", budget)?.into_iter().flatten().collect();
                Keys::Weights { values, targets: width }
            }
            other => return Err(Fault::Invalid(format!("it moves '{other}', which is unknown"))),
        };
        let wanted =
            times.len().checked_mul(width * if interpolation == Interpolation::CubicSpline { 3 } else { 1 });
        check(&keys, wanted, interpolation)?;
        Ok(Some((node, Channel { node: NodeId(place), times, interpolation, keys })))
    }
}

/// Refuses keys that are not finite or not as many as `wanted`, and rotations that are none.
fn check(keys: &Keys, wanted: Option<usize>, interpolation: Interpolation) -> Result<(), Fault> {
    let (count, finite) = match keys {
        Keys::Translation(values) | Keys::Scale(values) => {
            (values.len(), values.iter().all(|value| value.is_finite()))
        }
        Keys::Rotation(values) => (values.len(), values.iter().all(|value| value.is_finite())),
        Keys::Weights { values, .. } => (values.len(), values.iter().all(|value| value.is_finite())),
    };
    if wanted != Some(count) {
        let wanted = wanted.map_or("more".to_owned(), |wanted| wanted.to_string());
        return Err(Fault::Invalid(format!("it has {count} values where its times want {wanted}")));
    }
    if !finite {
        return Err(Fault::invalid("its values are not finite"));
    }
    if let Keys::Rotation(values) = keys {
        // Tangents of a spline may be 0; keys may not.
        let (step, first) = if interpolation == Interpolation::CubicSpline { (3, 1) } else { (1, 0) };
        let unusable = |value: &Quat| !value.length_recip().is_normal();
        if values.iter().skip(first).step_by(step).any(unusable) {
            return Err(Fault::invalid("a rotation is no quaternion"));
        }
    }
    Ok(())
}
