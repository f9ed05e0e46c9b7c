//! What is known of an item beside its pictures.

use std::collections::HashMap;

use glam::{Affine3A, Mat4, Vec3};
use gnomon_lights::LightSet;
use gnomon_metrics::SampledError;
use gnomon_renderer::layers::{Layer, LayerValues, RenderedLayer, RenderedLayers};
use gnomon_scene::{Bounds, Camera, Instance, NodeId, Pose, Scene};
use serde::Serialize;

use crate::{Stage, StudioError};

/// An item's line. Matrices are given by rows; places are in metres, pixels as OpenCV counts them.
#[derive(Serialize)]
pub struct Record {
    item: u64,
    /// The item's table, with what was drawn for it.
    drawn: toml::Table,
    camera: CameraRecord,
    /// Stops that the displayed picture is exposed by.
    exposure: f32,
    /// As they stand in the world.
    lights: Vec<LightRecord>,
    objects: Vec<ObjectRecord>,
    /// How far the picture is from the truth.
    check: Option<SampledError>,
}

#[derive(Serialize)]
struct CameraRecord {
    size: [u32; 2],
    world_from_camera: [[f32; 4]; 4],
    /// Of a pinhole.
    intrinsics: Option<[[f64; 3]; 3]>,
}

#[derive(Serialize)]
struct LightRecord {
    /// Towards it.
    direction: [f32; 3],
    /// [sr]
    solid_angle: f32,
    radiance: [f32; 3],
}

/// A node that places meshes, the ground excepted.
#[derive(Serialize)]
struct ObjectRecord {
    /// Its label in the layer `object`: the node's number plus 1.
    label: usize,
    name: String,
    /// From the space of its box to the world.
    world_from_object: [[f32; 4]; 4],
    /// Smallest and largest corner.
    box_3d: [[f32; 3]; 2],
    /// Left, top, right and bottom of its vertices, hidden ones included, as far as they are in the picture; null where none is.
    box_2d: Option<[f32; 4]>,
    /// Whether part of it is beside the picture or behind the camera.
    is_cut: bool,
    /// Where the layer `object` shows it.
    #[serde(skip_serializing_if = "Option::is_none")]
    visible: Option<VisibleRecord>,
}

/// What is seen of an object through the middles of pixels.
#[derive(Clone, Copy, Serialize)]
struct VisibleRecord {
    pixels: u32,
    /// Left, top, right and bottom edges of these pixels; null without any.
    box_2d: Option<[f32; 4]>,
}

fn rows(matrix: Mat4) -> [[f32; 4]; 4] {
    matrix.transpose().to_cols_array_2d()
}

impl Record {
    /// Of an item that is drawn as `stage` says, under these lights.
    ///
    /// # Errors
    /// As [`Stage::camera`].
    pub fn new(
        (item, drawn): (u64, toml::Table),
        stage: &Stage,
        lights: &LightSet,
        check: Option<SampledError>,
    ) -> Result<Self, StudioError> {
        let camera = stage.camera()?;
        let size = stage.look().picture.size;
        let (turn, grade) = (stage.world_from_environment(), stage.grade());
        let lights = lights.lights.iter().map(|light| LightRecord {
            direction: (turn * light.direction).to_array(),
            solid_angle: light.solid_angle,
            radiance: (light.radiance * grade.light).to_array(),
        });
        let intrinsics = camera.intrinsics(size);
        Ok(Self {
            item,
            drawn,
            exposure: stage.exposure(),
            lights: lights.collect(),
            objects: objects(stage.scene(), &camera, size),
            check,
            camera: CameraRecord {
                size,
                world_from_camera: rows(camera.world_from_camera),
                intrinsics: intrinsics
                    .map(|[fx, fy, cx, cy]| [[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]]),
            },
        })
    }
}

impl Record {
    /// Adds what the layer `object` tells, where it was drawn.
    pub(super) fn find_in(&mut self, layers: &RenderedLayers) {
        let Some(RenderedLayer { values: LayerValues::Labels(labels), .. }) = layers.get(Layer::Object)
        else {
            return;
        };
        let width = layers.size[0].max(1) as usize;
        let mut seen: HashMap<u32, VisibleRecord> = HashMap::new();
        for (place, &label) in labels.iter().enumerate() {
            let [x, y] = [place % width, place / width].map(|number| number as f32);
            let found = seen.entry(label).or_insert(VisibleRecord { pixels: 0, box_2d: None });
            let [left, top, right, bottom] = found.box_2d.unwrap_or([x, y, x, y]);
            found.pixels += 1;
            found.box_2d =
                Some([left.min(x - 0.5), top.min(y - 0.5), right.max(x + 0.5), bottom.max(y + 0.5)]);
        }
        let nothing = VisibleRecord { pixels: 0, box_2d: None };
        for object in &mut self.objects {
            object.visible = Some(seen.get(&(object.label as u32)).copied().unwrap_or(nothing));
        }
    }
}

fn objects(scene: &Scene, camera: &Camera, size: [u32; 2]) -> Vec<ObjectRecord> {
    let pose = scene.pose();
    let instances = scene.instances();
    let of_node = |node: NodeId| instances.iter().filter(move |instance| instance.node == node);
    let nodes = (0..scene.nodes.len()).map(NodeId).filter(|node| Some(*node) != scene.ground);
    nodes.filter_map(|node| object(scene, &pose, node, of_node(node), (camera, size))).collect()
}

/// `None` for a node without vertices.
fn object<'a>(
    scene: &Scene,
    pose: &Pose,
    node: NodeId,
    instances: impl Iterator<Item = &'a Instance> + Clone,
    (camera, size): (&Camera, [u32; 2]),
) -> Option<ObjectRecord> {
    // What bends has its box in the world.
    let is_rigid = instances.clone().all(|instance| !scene.is_deformable(instance));
    let world_from_object = if is_rigid { pose.world_from_nodes[node.0] } else { Affine3A::IDENTITY };
    let vertices: Vec<Vec3> = instances
        .flat_map(|instance| match is_rigid {
            true => scene.meshes[instance.mesh.0].positions.clone(),
            false => scene.world_vertices(pose, instance).positions,
        })
        .collect();
    let Bounds { min, max } = Bounds::around(vertices.iter().copied())?;
    let (box_2d, is_cut) =
        seen(vertices.iter().map(|&place| world_from_object.transform_point3(place)), camera, size);
    Some(ObjectRecord {
        label: node.0 + 1,
        name: scene.nodes[node.0].name.clone(),
        world_from_object: rows(Mat4::from(world_from_object)),
        box_3d: [min.to_array(), max.to_array()],
        box_2d,
        is_cut,
        visible: None,
    })
}

/// Box around places in the picture, and whether some of them lie elsewhere.
fn seen(places: impl Iterator<Item = Vec3>, camera: &Camera, size: [u32; 2]) -> (Option<[f32; 4]>, bool) {
    let (least, most) = (glam::Vec2::splat(-0.5), glam::Vec2::from(size.map(|side| side as f32 - 0.5)));
    let is_behind = |seen: &Vec3| seen.z <= 0.0;
    let seen: Vec<Vec3> = places.map(|place| camera.project(place, size)).collect();
    let cut = |at: glam::Vec2| at.cmplt(least).any() || at.cmpgt(most).any();
    let is_cut = seen.iter().any(|at| is_behind(at) || cut(at.truncate()));
    let in_front =
        Bounds::around(seen.into_iter().filter(|at| !is_behind(at)).map(|at| at.truncate().extend(0.0)));
    let box_2d = in_front.and_then(|bounds| {
        let (min, max) = (bounds.min.truncate().max(least), bounds.max.truncate().min(most));
        min.cmple(max).all().then_some([min.x, min.y, max.x, max.y])
    });
    (box_2d, is_cut)
}
