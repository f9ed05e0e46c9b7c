//! What the experiments of this suite share.

use glam::{Affine3A, Vec2, Vec3};
use gnomon_envmap::Equirect;
use gnomon_lights::LightSet;
use gnomon_picture::RgbImage;
use gnomon_renderer::{RenderSettings, ShadowSizing};
use gnomon_scene::{AreaLight, AreaLightShape, Camera, Node, NodeId, Scene};

use crate::{Setup, View};

/// The light fits that are compared, in the order of tables.
pub(super) const FITS: [&str; 5] = ["disks", "squares", "rectangles", "partition", "optimized"];

/// A frame in which all shadow maps have `resolution` texels a side: what times at a stated resolution are measured with.
pub(super) fn uniform_maps(resolution: u32) -> RenderSettings {
    maps_by_footprint(resolution).with(|s| s.techniques.shadow_sizing = ShadowSizing::Uniform)
}

/// A frame in which wider lights have coarser shadow maps, `resolution` texels a side at most: the renderer's own choice, which
/// errors are measured with.
pub(super) fn maps_by_footprint(resolution: u32) -> RenderSettings {
    RenderSettings::default().with(|s| s.techniques.shadow_resolution = resolution)
}

/// A scene in the dark with one square lamp over it, ten degrees wide from the models' centre, high on the left of a default
/// camera. Irradiance from the lamp is near pi there, so that a white surface has radiance 1.
pub(super) struct Lamp {
    pub view: View,
    lights: LightSet,
    map: Equirect,
}

/// Half the lamp's side over its distance: tan 5 degrees.
const HALF_SIDE: f32 = 0.087_488_66;

/// The lamp's distance over the radius of the models.
const DISTANCE: f32 = 3.0;

impl Lamp {
    pub fn over(view: &View) -> Self {
        let bounds = view.scene.bounds_without_ground();
        let (center, radius) = bounds.map_or((Vec3::ZERO, 1.0), |bounds| (bounds.center(), bounds.radius()));
        let direction = Vec3::new(-0.5, 1.1, 0.5).normalize();
        let distance = DISTANCE * radius.max(f32::MIN_POSITIVE);
        let mut view = view.clone();
        let lamp = square_lamp(center, direction, distance, HALF_SIDE);
        add_light(&mut view.scene, lamp);
        Self::new(view)
    }

    /// A view that its own lights alone light.
    pub fn new(view: View) -> Self {
        let map = Equirect::new(RgbImage::filled(64, 32, Vec3::ZERO));
        Self { view, lights: LightSet::new("the scene's own", Vec::new(), map.clone()), map }
    }

    /// Pictures of it of `size` pixels.
    pub fn setup(&self, size: [u32; 2]) -> Setup<'_> {
        Setup { view: &self.view, map: &self.map, lights: &self.lights, size }
    }
}

/// A square light at `distance` from `target` that faces it; its side is twice `half_side` times the distance. A white surface at the
/// target that faces the light, as long as the light is small, has radiance 1.
pub(super) fn square_lamp(
    target: Vec3,
    direction: Vec3,
    distance: f32,
    half_side: f32,
) -> (Affine3A, AreaLightShape, Vec3) {
    let world_from_lamp =
        Affine3A::from_mat4(Camera::look_at(target + distance * direction, target, 1.0).world_from_camera);
    let shape = AreaLightShape::Rectangle { size: Vec2::splat(2.0 * half_side * distance) };
    // Irradiance, radiance times solid angle, is then pi.
    let radiance = std::f32::consts::PI / (4.0 * half_side * half_side);
    (world_from_lamp, shape, Vec3::splat(radiance))
}

/// Adds a light on a node of its own.
pub(super) fn add_light(scene: &mut Scene, (place, shape, radiance): (Affine3A, AreaLightShape, Vec3)) {
    let node = NodeId(scene.nodes.len());
    let name = "lamp".to_owned();
    scene.nodes.push(Node { name, parent_from_node: place, ..Node::default() });
    scene.lights.push(AreaLight { node, shape, radiance, spread: Default::default() });
}
