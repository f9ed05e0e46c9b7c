//! Nodes and cameras (specification, sections 3.5 and 3.10).

use glam::{Affine3A, DVec3, Mat4, Quat, Vec3};
use gnomon_messages::quoted;
use gnomon_scene::{Camera, Node, NodeId, Projection, Scene, rigid};

use super::accessors::Accessors;
use super::meshes::Meshes;
use super::schema::{CameraEntry, Int, NodeEntry, Root};
use super::skins::Skins;
use super::{Budget, Fault, get};
use crate::LoadOptions;

/// A node of the file and its place in the hierarchy.
pub struct Place {
    pub node: usize,
    /// Earlier in the order.
    pub parent: Option<usize>,
}

/// The nodes of the scene to be shown, parents before children. Loops and nodes with two parents are refused, in the
/// whole file, before anything walks down.
pub fn order(root: &Root) -> Result<Vec<Place>, Fault> {
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
    let mut roots = Vec::with_capacity(shown.nodes.len());
    let mut listed = vec![false; root.nodes.len()];
    for &Int(node) in &shown.nodes {
        get(&root.nodes, node, "node", "the scene")?;
        if let Some(parent) = parents[node] {
            return Err(Fault::Invalid(format!(
                "the scene lists node {node}, which is a child of node {parent}"
            )));
        }
        if !std::mem::replace(&mut listed[node], true) {
            roots.push(node);
        }
    }
    Ok(descend(root, &roots))
}

/// All nodes below the roots, each after its parent. Every node has one parent at most.
fn descend(root: &Root, roots: &[usize]) -> Vec<Place> {
    let mut order: Vec<Place> = Vec::new();
    let mut stack: Vec<Place> = roots.iter().rev().map(|&node| Place { node, parent: None }).collect();
    while let Some(place) = stack.pop() {
        let parent = Some(order.len());
        stack.extend(root.nodes[place.node].children.iter().rev().map(|&Int(node)| Place { node, parent }));
        order.push(place);
    }
    order
}

/// Where the file's nodes and cameras went.
pub struct Places {
    /// The scene's node of every node of the file; `None` for those that are not shown.
    pub nodes: Vec<Option<usize>>,
    /// The node of each of the scene's cameras.
    pub cameras: Vec<NodeId>,
}

/// Adds the nodes, their meshes, skins and cameras to the scene.
pub fn read(
    root: &Root,
    order: &[Place],
    options: &LoadOptions,
    accessors: &Accessors,
    meshes: &mut Meshes,
    budget: &mut Budget,
    scene: &mut Scene,
) -> Result<Places, Fault> {
    budget.take(order.len(), size_of::<Node>() + 2 * size_of::<Affine3A>())?;
    let mut local = Vec::with_capacity(order.len());
    let mut world: Vec<Affine3A> = Vec::with_capacity(order.len());
    let mut places = Places { nodes: vec![None; root.nodes.len()], cameras: Vec::new() };
    for (number, place) in order.iter().enumerate() {
        let parent_from_node = transform(&root.nodes[place.node], place.node)?;
        let parent = place.parent.map_or(Affine3A::IDENTITY, |parent| world[parent]);
        local.push(parent_from_node);
        world.push(parent * parent_from_node);
        places.nodes[place.node] = Some(number);
    }
    let mut skins = Skins::default();
    for (number, place) in order.iter().enumerate() {
        let entry = &root.nodes[place.node];
        let mut node = Node {
            name: entry.name.as_deref().map(quoted).unwrap_or_default(),
            parent: place.parent.map(NodeId),
            parent_from_node: local[number],
            ..Node::default()
        };
        if let Some(Int(mesh)) = entry.mesh {
            node.meshes = meshes.read(mesh, budget, scene)?;
            node.weights = meshes.weights(mesh, entry.weights.as_deref(), budget)?;
            if let Some(Int(skin)) = entry.skin {
                node.skin = skins.read(root, accessors, skin, &places.nodes, budget, scene)?;
            }
            if let Some(skin) = node.skin {
                let joints = scene.skins[skin.0].joints.len();
                meshes.check_joints(mesh, joints)?;
            }
        }
        if let Some(Int(camera)) = entry.camera {
            let label = format!("node {}", place.node);
            let entry = get(&root.cameras, camera, "camera", &label)?;
            match rigid(world[number]) {
                Some(world_from_camera) => {
                    let projection = projection(entry, camera, options)?;
                    let own = entry.name.as_deref().map(quoted).filter(|own| !own.is_empty());
                    let name = own.unwrap_or_else(|| node.name.clone());
                    places.cameras.push(NodeId(number));
                    scene.cameras.push(Camera { name, world_from_camera, origin: DVec3::ZERO, projection });
                }
                None => scene
                    .warnings
                    .push(format!("the camera of {label} has a collapsed transform and is left out")),
            }
        }
        scene.nodes.push(node);
    }
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

fn projection(camera: &CameraEntry, index: usize, options: &LoadOptions) -> Result<Projection, Fault> {
    let bad = |what: &str| Fault::Invalid(format!("camera {index} {what}"));
    match camera.kind.as_str() {
        "perspective" => {
            let lens = camera.perspective.as_ref().ok_or_else(|| bad("has no perspective"))?;
            let aspect = lens.aspect_ratio.unwrap_or(options.aspect);
            if !(lens.yfov > 0.0 && lens.yfov < std::f32::consts::PI && aspect > 0.0 && aspect.is_finite()) {
                return Err(bad("has a field of view or aspect ratio out of range"));
            }
            let fov_x = 2.0 * (f64::from(aspect) * (0.5 * f64::from(lens.yfov)).tan()).atan();
            Ok(Projection::Perspective { fov_x: fov_x as f32 })
        }
        "orthographic" => {
            let lens = camera.orthographic.as_ref().ok_or_else(|| bad("has no orthographic size"))?;
            let half_width = lens.xmag.abs();
            if !(half_width > 0.0 && half_width.is_finite()) {
                return Err(bad("has an orthographic size that is zero or not finite"));
            }
            Ok(Projection::Orthographic { half_width })
        }
        other => Err(bad(&format!("is of the unknown type '{}'", quoted(other)))),
    }
}
