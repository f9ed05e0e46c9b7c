//! Cameras (specification, section 3.10).

use glam::{Affine3A, DVec3};
use gnomon_messages::quoted;
use gnomon_scene::{Camera, Film, Projection, rigid};

use super::Fault;
use super::schema::CameraEntry;
use crate::LoadOptions;

/// The camera of a node, `index` and the node's name for what it is called; `None` where the node's transform is collapsed.
pub fn camera(
    entry: &CameraEntry,
    (index, node): (usize, &str),
    world_from_node: Affine3A,
    options: &LoadOptions,
) -> Result<Option<Camera>, Fault> {
    let Some(world_from_camera) = rigid(world_from_node) else { return Ok(None) };
    let projection = projection(entry, index, options)?;
    let own = entry.name.as_deref().map(quoted).filter(|own| !own.is_empty());
    let name = own.unwrap_or_else(|| node.to_owned());
    Ok(Some(Camera { name, world_from_camera, origin: DVec3::ZERO, projection, film: Film::default() }))
}

/// What the camera shows is all in the picture, which shows more above and below, or at the sides, where its shape is another (section
/// 3.10.2 asks that nothing be cropped or stretched).
fn projection(camera: &CameraEntry, index: usize, options: &LoadOptions) -> Result<Projection, Fault> {
    let bad = |what: &str| Fault::Invalid(format!("camera {index} {what}"));
    match camera.kind.as_str() {
        "perspective" => {
            let lens = camera.perspective.as_ref().ok_or_else(|| bad("has no perspective"))?;
            let own = lens.aspect_ratio.unwrap_or(options.aspect);
            let aspect = own.max(options.aspect);
            if !(lens.yfov > 0.0 && lens.yfov < std::f32::consts::PI && own > 0.0 && aspect.is_finite()) {
                return Err(bad("has a field of view or aspect ratio out of range"));
            }
            let fov_x = 2.0 * (f64::from(aspect) * (0.5 * f64::from(lens.yfov)).tan()).atan();
            Ok(Projection::Perspective { fov_x: fov_x as f32 })
        }
        "orthographic" => {
            let lens = camera.orthographic.as_ref().ok_or_else(|| bad("has no orthographic size"))?;
            let half_height = lens.ymag.unwrap_or(0.0).abs();
            let half_width = lens.xmag.abs().max(half_height * options.aspect);
            if !(half_width > 0.0 && half_width.is_finite()) {
                return Err(bad("has an orthographic size that is zero or not finite"));
            }
            Ok(Projection::Orthographic { half_width })
        }
        other => Err(bad(&format!("is of the unknown type '{}'", quoted(other)))),
    }
}
