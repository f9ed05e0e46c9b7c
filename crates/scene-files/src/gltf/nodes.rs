//! Nodes (specification, section 3.5).

use glam::{Affine3A, DVec3, Mat4, Quat, Vec3};
use gnomon_messages::quoted;
use gnomon_scene::{CameraMount, Node, NodeId, Scene};

use super::accessors::Accessors;
use super::meshes::Meshes;
use super::schema::{Int, LightReference, NodeEntry, Root};
use super::skins::Skins;
use super::{Budget, Fault, cameras, get, instancing, lights};
use crate::LoadOptions;

/// A node of the file and its place in the hierarchy.
pub struct Place {
    pub node: usize,
    /// Earlier in the order.
    pub parent: Option<usize>,
    /// False for one that is there for the sake of a joint alone.
    is_shown: bool,
}

/// The nodes of the scene to be shown, parents before children, and those that it lacks of what its skins follow. Loops and nodes with two parents are refused, in the
/// whole file, before anything walks down.
pub fn order(root: &Root, warnings: &mut Vec<String>) -> Result<Vec<Place>, Fault> {
    let mut parents: Vec<Option<usize>> = vec![None; root.nodes.len()];
    for (index, node) in root.nodes.iter().enumerate() {
        for &Int(child) in &node.children {
            get(&root.nodes, child, "node", &format!("node {index}"))?;
            if let Some(other) = parents[child].replace(index) {
                return Err(Fault::Invalid(format!(
                    "node {child} is a child of both node {other} and node {index}"
                )));
            }
        }
    }
    let all_roots: Vec<usize> = (0..root.nodes.len()).filter(|&node| parents[node].is_none()).collect();
    // Every node has one parent at most: what no root reaches runs in a circle.
    let everything = descend(root, &all_roots);
    if everything.len() < root.nodes.len() {
        return Err(Fault::invalid("its nodes form a loop"));
    }
    let shown = match root.scene {
        Some(Int(index)) => Some(get(&root.scenes, index, "scene", "the file")?),
        None => root.scenes.first(),
    };
    let Some(shown) = shown else { return Ok(everything) };
    let mut listed = vec![false; root.nodes.len()];
    for &Int(node) in &shown.nodes {
        get(&root.nodes, node, "node", "the scene")?;
        listed[node] = true;
    }
    // Some tools list nodes that are below others: below listed ones they are there already, else they stand for themselves.
    let mut is_reached = listed.clone();
    for place in &everything {
        is_reached[place.node] |= parents[place.node].is_some_and(|parent| is_reached[parent]);
    }
    let mut roots = Vec::with_capacity(shown.nodes.len());
    for &Int(node) in &shown.nodes {
        let is_below = parents[node].is_some_and(|parent| is_reached[parent]);
        if std::mem::take(&mut listed[node]) && !is_below {
            if let Some(parent) = parents[node] {
                let message = format!(
                    "the scene lists node {node}, but not its parent, node {parent}, which is left out"
                );
                warnings.push(message);
            }
            roots.push(node);
        }
    }
    let mut order = descend(root, &roots);
    add_joints(root, &parents, &mut order)?;
    Ok(order)
}

/// Adds the joints of the skins of nodes in the order, and the nodes above them: tools leave skeletons out of the scene, or in another.
fn add_joints(root: &Root, parents: &[Option<usize>], order: &mut Vec<Place>) -> Result<(), Fault> {
    let mut places: Vec<Option<usize>> = vec![None; root.nodes.len()];
    for (number, place) in order.iter().enumerate() {
        places[place.node] = Some(number);
    }
    let mut seen = vec![false; root.skins.len()];
    for number in 0..order.len() {
        let node = order[number].node;
        let Some(Int(skin)) = root.nodes[node].skin.filter(|_| root.nodes[node].mesh.is_some()) else {
            continue;
        };
        let entry = get(&root.skins, skin, "skin", &format!("node {node}"))?;
        if std::mem::replace(&mut seen[skin], true) {
            continue;
        }
        for &Int(joint) in &entry.joints {
            get(&root.nodes, joint, "node", &format!("skin {skin}"))?;
            // Up to one that is there, and down again.
            let above = std::iter::successors(Some(joint), |&node| parents[node]);
            let missing: Vec<usize> = above.take_while(|&node| places[node].is_none()).collect();
            for &node in missing.iter().rev() {
                let parent = parents[node].and_then(|parent| places[parent]);
                places[node] = Some(order.len());
                order.push(Place { node, parent, is_shown: false });
            }
        }
    }
    Ok(())
}

/// All nodes below the roots, each after its parent. Every node has one parent at most.
fn descend(root: &Root, roots: &[usize]) -> Vec<Place> {
    let mut order: Vec<Place> = Vec::new();
    let mut stack: Vec<Place> =
        roots.iter().rev().map(|&node| Place { node, parent: None, is_shown: true }).collect();
    while let Some(place) = stack.pop() {
        let parent = Some(order.len());
        let children = root.nodes[place.node].children.iter().rev();
        stack.extend(children.map(|&Int(node)| Place { node, parent, is_shown: true }));
        order.push(place);
    }
    order
}

/// Adds the nodes, their meshes, skins and cameras to the scene. Gives the scene's node of every node of the file; `None` for those that it does
/// not have.
pub fn read(
    root: &Root,
    order: &[Place],
    options: &LoadOptions,
    accessors: &Accessors,
    meshes: &mut Meshes,
    budget: &mut Budget,
    scene: &mut Scene,
) -> Result<Vec<Option<usize>>, Fault> {
    budget.take(order.len(), size_of::<Node>() + 2 * size_of::<Affine3A>())?;
    let mut local = Vec::with_capacity(order.len());
    let mut world: Vec<Affine3A> = Vec::with_capacity(order.len());
    let mut places = vec![None; root.nodes.len()];
    for (number, place) in order.iter().enumerate() {
        let parent_from_node = transform(&root.nodes[place.node], place.node)?;
        let parent = place.parent.map_or(Affine3A::IDENTITY, |parent| world[parent]);
        local.push(parent_from_node);
        world.push(parent * parent_from_node);
        places[place.node] = Some(number);
    }
    let mut skins = Skins::default();
    let mut copies = Vec::new();
    let mut is_visible = vec![true; order.len()];
    for (number, place) in order.iter().enumerate() {
        let entry = &root.nodes[place.node];
        let own = entry.extensions.visibility.as_ref().and_then(|visibility| visibility.visible);
        is_visible[number] = own.unwrap_or(true) && place.parent.is_none_or(|parent| is_visible[parent]);
        let is_shown = place.is_shown && is_visible[number];
        let mut node = Node {
            name: entry.name.as_deref().map(quoted).unwrap_or_default(),
            parent: place.parent.map(NodeId),
            parent_from_node: local[number],
            ..Node::default()
        };
        if let Some(Int(mesh)) = entry.mesh.filter(|_| is_shown) {
            node.meshes = meshes.read(mesh, budget, scene)?;
            node.weights = meshes.weights(mesh, entry.weights.as_deref(), budget)?;
            if let Some(Int(skin)) = entry.skin {
                let skin = skins.read(root, accessors, skin, &places, budget, scene)?;
                meshes.check_joints(mesh, scene.skins[skin.0].joints.len())?;
                node.skin = Some(skin);
            }
            if let Some(instancing) = &entry.extensions.instancing {
                let label = format!("node {}", place.node);
                let places = instancing::read(instancing, accessors, &label, budget, &mut scene.warnings)?;
                copies.extend(instancing::copies(&mut node, NodeId(number), places, budget)?);
            }
        }
        if let Some(LightReference { light: Int(light) }) =
            entry.extensions.light.as_ref().filter(|_| is_shown)
        {
            let lights = root.extensions.lights.as_ref().map_or(&[][..], |extension| &extension.lights);
            let entry = get(lights, *light, "light", &format!("node {}", place.node))?;
            match lights::light(entry, NodeId(number)) {
                Ok(light) => scene.lights.push(light),
                Err(why) => scene.warnings.push(format!("light {light} is left out: {why}")),
            }
        }
        if let Some(Int(camera)) = entry.camera.filter(|_| place.is_shown) {
            let label = format!("node {}", place.node);
            let entry = get(&root.cameras, camera, "camera", &label)?;
            match cameras::camera(entry, (camera, &node.name), world[number], options)? {
                Some(camera) => {
                    scene
                        .camera_mounts
                        .push(CameraMount { camera: scene.cameras.len(), node: NodeId(number) });
                    scene.cameras.push(camera);
                }
                None => scene
                    .warnings
                    .push(format!("the camera of {label} has a collapsed transform and is left out")),
            }
        }
        scene.nodes.push(node);
    }
    // After all nodes of the file, whose numbers are those of the order.
    scene.nodes.extend(copies);
    Ok(places)
}

fn transform(node: &NodeEntry, index: usize) -> Result<Affine3A, Fault> {
    let label = format!("node {index}");
    let affine = match node.matrix {
        Some(matrix) => {
            let matrix = Mat4::from_cols_array(&matrix.map(|entry| entry as f32));
            let bottom = matrix.row(3);
            if (bottom - glam::Vec4::W).abs().max_element() > 1e-4 {
                return Err(Fault::Invalid(format!("the matrix of {label} is not affine")));
            }
            Affine3A::from_mat4(matrix)
        }
        None => {
            let rotation = Quat::from_array(node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]));
            if !(rotation.length_squared() > 0.0 && rotation.length_squared().is_finite()) {
                return Err(Fault::Invalid(format!("the rotation of {label} is no quaternion")));
            }
            Affine3A::from_scale_rotation_translation(
                Vec3::from_array(node.scale.unwrap_or([1.0; 3])),
                rotation.normalize(),
                DVec3::from_array(node.translation.unwrap_or_default()).as_vec3(),
            )
        }
    };
    if affine.is_finite() {
        Ok(affine)
    } else {
        Err(Fault::Invalid(format!("the transform of {label} is not finite")))
    }
}
