//! Scenes whose nodes lie far from the origin. Translations count in double precision, so that those of a hierarchy may cancel.

use std::sync::Arc;

use glam::{DMat3, DVec3, Mat3};
use gnomon_scene::{Interpolation, Keys, Node, NodeId, Scene, rigid};

use super::nodes::Place;
use super::schema::{NodeEntry, Root};

/// Moves a scene that is far from its origin. `order` has the places of its first nodes.
///
/// Nodes keep their transforms below their parents, so that clips and skins mean the same. But groups at the top that nothing moves stand at the
/// scene's origin, wherever they were, and what they hold moves: large translations cancel here and not in single precision.
pub fn recenter(root: &Root, order: &[Place], scene: &mut Scene) {
    let origin = scene.suitable_origin();
    if origin == DVec3::ZERO {
        return;
    }
    let stands =
        |(node, placed): (usize, &Node)| (NodeId(node), placed.parent_from_node.translation.as_dvec3());
    let mut places: Vec<(NodeId, DVec3)> = scene.nodes.iter().enumerate().map(stands).collect();
    for (place, (_, at)) in order.iter().zip(&mut places) {
        *at = translation(&root.nodes[place.node]);
    }
    hold_groups(origin, &places, scene);
    scene.move_origin(origin, &places);
    move_clips(scene);
    let world = scene.world_from_nodes();
    for mount in &scene.camera_mounts {
        if let Some(world_from_camera) = rigid(world[mount.node.0]) {
            scene.cameras[mount.camera].world_from_camera = world_from_camera;
        }
    }
}

fn translation(entry: &NodeEntry) -> DVec3 {
    let of_matrix = entry.matrix.map(|matrix| DVec3::new(matrix[12], matrix[13], matrix[14]));
    of_matrix.unwrap_or_else(|| entry.translation.unwrap_or_default().into())
}

/// Gives groups at the top the origin that puts them at the scene's.
fn hold_groups(origin: DVec3, places: &[(NodeId, DVec3)], scene: &mut Scene) {
    let mut held: Vec<bool> = scene.nodes.iter().map(|node| node.meshes.is_empty()).collect();
    let joints = scene.skins.iter().flat_map(|skin| &skin.joints);
    let carriers = scene.camera_mounts.iter().map(|mount| &mount.node);
    let carried = carriers.chain(scene.lights.iter().map(|light| &light.node));
    let animated = scene.animated.iter().map(|animated| &animated.node);
    joints.chain(carried).chain(animated).for_each(|node| held[node.0] = false);
    let mut world: Vec<(DMat3, DVec3)> = Vec::with_capacity(places.len());
    for &(node, translation) in places {
        let parent = scene.nodes[node.0].parent;
        let (linear, at) = parent.map_or((DMat3::IDENTITY, DVec3::ZERO), |parent| world[parent.0]);
        let at = linear * translation + at;
        let linear = linear * Mat3::from(scene.nodes[node.0].parent_from_node.matrix3).as_dmat3();
        world.push((linear, at));
        let own = linear.inverse() * (origin - at);
        held[node.0] &= parent.is_none_or(|parent| held[parent.0]) && own.is_finite();
        if held[node.0] {
            scene.nodes[node.0].origin = own;
        }
    }
}

/// Keys of translations, and poses at rest, of nodes whose parents' origins have moved.
fn move_clips(scene: &mut Scene) {
    let moved: Vec<DVec3> = (0..scene.nodes.len()).map(|node| scene.parent_origin(NodeId(node))).collect();
    let by = |node: NodeId, at: glam::Vec3| (at.as_dvec3() - moved[node.0]).as_vec3();
    for animated in &mut scene.animated {
        animated.parent_from_node = scene.nodes[animated.node.0].parent_from_node;
        animated.translation = by(animated.node, animated.translation);
    }
    for animation in &mut scene.animations {
        for channel in &mut Arc::make_mut(animation).channels {
            let Keys::Translation(keys) = &mut channel.keys else { continue };
            // Of a spline's three values a key the middle one is a place, the others are speeds.
            let (first, step) =
                if channel.interpolation == Interpolation::CubicSpline { (1, 3) } else { (0, 1) };
            keys.iter_mut().skip(first).step_by(step).for_each(|key| *key = by(channel.node, *key));
        }
    }
}
