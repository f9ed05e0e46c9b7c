//! What a model needs to be looked at when its file does not say: a camera, and ground to throw its shadow on.

use std::sync::Arc;

use glam::{Affine3A, Quat, Vec2, Vec3};
use gnomon_options::choices;

use crate::{Bounds, Camera, GroundFade, Material, MaterialId, Mesh, NodeId, Scene, SceneError};

choices! {
    /// What lies under the models.
    pub enum Ground {
        /// Nothing more than the scene brings.
        None = "none",
        /// A matte square, its half side four times the radius of the models' footprint.
        Plane = "plane",
        /// What is seen behind the scene, darkened where the scene shadows a level ground; a level ground of the scene's own becomes that.
        Catcher = "catcher",
        /// A matte ground near the models that fades with the distance into a catcher, so that no edge of it is seen.
        Fade = "fade",
        /// A catcher that shows near its middle what the environment's camera saw of the ground there: its lower half laid on the ground.
        Projected = "projected",
    }
}

impl Ground {
    /// Whether it shows, somewhere, what is behind the scene; such a ground blocks no light.
    fn catches(self) -> bool {
        matches!(self, Self::Catcher | Self::Fade | Self::Projected)
    }
}

/// Height of the environment's camera over the ground unless somebody says otherwise [m]: of a tripod.
pub const CAMERA_HEIGHT: f32 = 1.6;

/// Half the ground's side over the radius of the model's footprint. Shadow maps cover the scene's bounds, so a larger
/// ground would cost them resolution.
const GROUND_HALF_SIDE: f32 = 4.0;

/// The same of a catcher over that: it is not drawn into maps, and where it ends nothing may be seen of it.
const CATCHER_SIDES: f32 = 4.0;

/// How far below a floor that a model brings a ground is laid, over the radius of the model.
const BELOW_FLOOR: f32 = 2e-3;

/// Half the side of the smallest ground [m]: its node's scale can be squared.
const LEAST_HALF_SIDE: f32 = 1e-9;

/// Distances between which a ground fades and between which a projection ends, as shares of half the side of their catcher: matte are two
/// radii of the models' footprint, and eight show something of it.
const FADES: [f32; 2] = [0.125, 0.5];
const PROJECTED: [f32; 2] = [0.3, 0.95];

/// Half the side of a projected ground over the height of its camera at least: at its end that looks six degrees below the horizon.
const PROJECTED_SIDES: f32 = 10.0;

/// Share of its height over a ground by which a model may have sunk into it and still stands on it: feet of a walking model do, and
/// boxes around bent meshes are larger than these.
pub const SUNKEN: f32 = 0.15;

/// Poses in which a clip is looked at: so many a second, but not fewer or more than these, and no more than make so many vertices.
const POSES_PER_SECOND: f32 = 8.0;
const POSES: (usize, usize) = (16, 128);
const POSED_VERTICES: usize = 4_000_000;

/// The longer side of a default camera's picture spans this angle [rad].
const LONG_SIDE_FOV: f32 = 40.0 * std::f32::consts::PI / 180.0;

/// Part of the frame that a default camera leaves free on either side.
const MARGIN: f32 = 0.08;

impl Scene {
    /// Puts `ground` under the scene. A plane is a square of two triangles, Lambert 0.5, centred under the lowest point;
    /// its half side is four times the radius of the models' footprint. A scene without triangles, or one that
    /// has its ground already, stays as it is.
    pub fn add_ground(&mut self, ground: Ground) {
        let has_floor = ground != Ground::None && self.has_floor();
        self.add_ground_under(ground, CAMERA_HEIGHT, self.bounds(), has_floor);
    }

    /// The same under models that reach elsewhere than they do now, such as to [`Scene::bounds_of_clip`], with the height of the camera of a
    /// projected ground [m]; just below the floor that they bring, where they do ([`Scene::has_floor`]). The mesh is that of [`Scene::add_ground`], whatever the reach: its node places and scales it, so that another
    /// reach is but another pose.
    pub fn add_ground_under(
        &mut self,
        ground: Ground,
        camera_height: f32,
        reach: Option<Bounds>,
        has_floor: bool,
    ) {
        if let (Ground::Catcher | Ground::Projected, Some(node)) = (ground, self.ground) {
            self.make_catcher(node, (ground == Ground::Projected).then_some(camera_height));
        }
        let (false, None, Some(own), Some(reach)) =
            (ground == Ground::None, self.ground, self.bounds(), reach)
        else {
            return;
        };
        let catches = ground.catches();
        // Models that are a point at rest leave no size to scale.
        let unit = Some(half_side(own)).filter(|half| *half > LEAST_HALF_SIDE).unwrap_or(1.0);
        let camera_height = Some(camera_height).filter(|_| ground == Ground::Projected);
        let fade = match ground {
            Ground::Fade => Some(faded(unit, FADES, None)),
            Ground::Projected => Some(faded(unit, PROJECTED, camera_height)),
            _ => None,
        };
        let material =
            Material { name: "ground".to_owned(), double_sided: true, catches, fade, ..Material::default() };
        self.materials.push(material);
        // A floor in the ground's plane would fight with it for every pixel.
        let below = if has_floor { BELOW_FLOOR * reach.radius() } else { 0.0 };
        let half = half_side(reach) * if catches { CATCHER_SIDES } else { 1.0 };
        let half = half.max(camera_height.map_or(0.0, |height| PROJECTED_SIDES * height));
        let mut mesh = square(Vec3::ZERO, unit);
        mesh.material = Some(MaterialId(self.materials.len() - 1));
        let node = self.push_mesh("ground", mesh);
        self.nodes[node.0].parent_from_node = Affine3A::from_scale_rotation_translation(
            Vec3::splat(half / unit),
            Quat::IDENTITY,
            reach.center().with_y(reach.min.y - below),
        );
        self.ground = Some(node);
    }

    /// Makes catchers of the meshes of a node that are level, on which the environment is projected from a height where there is one.
    fn make_catcher(&mut self, node: NodeId, camera_height: Option<f32>) {
        for mesh in self.nodes[node.0].meshes.clone() {
            let own = Arc::make_mut(&mut self.meshes[mesh.0]);
            if !own.normals.is_empty() && own.normals.iter().all(|normal| normal.y.abs() > 0.9999) {
                let material = own.material.and_then(|material| self.materials.get(material.0)).cloned();
                let half = Bounds::around(own.positions.iter().copied()).map_or(0.0, |bounds| {
                    let size = bounds.max - bounds.min;
                    0.5 * size.x.min(size.z)
                });
                let fade = camera_height.map(|height| faded(half, PROJECTED, Some(height)));
                self.materials.push(Material { catches: true, fade, ..material.unwrap_or_default() });
                own.material = Some(MaterialId(self.materials.len() - 1));
            }
        }
    }

    /// Whether everything stands on one level surface that reaches out under all of it: a ground that was laid, or the scene's own, be it
    /// part of a mesh. Models may have sunk into it a little.
    pub fn stands_on_ground(&self) -> bool {
        let boxes = self.world_part_boxes();
        let bears_all = |ground: usize, bounds: &Bounds| {
            let height = bounds.max.y;
            bounds.flat_axis() == Some(1)
                && boxes.iter().enumerate().filter(|(other, _)| *other != ground).all(|(_, other)| {
                    let within = other.min.cmpge(bounds.min) & other.max.cmple(bounds.max);
                    within.x && within.z && other.min.y - height >= -SUNKEN * (other.max.y - height)
                })
        };
        boxes.len() > 1 && boxes.iter().enumerate().any(|(i, bounds)| bears_all(i, bounds))
    }

    /// Box around what is to be framed: the models without the ground, or the ground where there is nothing else.
    pub fn bounds_to_frame(&self) -> Option<Bounds> {
        self.bounds_without_ground().or_else(|| self.bounds())
    }

    /// The same over a whole clip: in poses from its first to its last, evenly spread and at most an eighth of a second apart
    /// unless the clip is long or the models are large. Poses that [`Scene::animate`] refuses do not count. The scene then is at rest.
    ///
    /// # Errors
    /// [`SceneError::Request`] where there is no such clip.
    pub fn bounds_of_clip(&mut self, animation: usize) -> Result<Option<Bounds>, SceneError> {
        self.check_clip(animation, 0.0)?;
        let duration = self.animations[animation].duration();
        let vertices: usize =
            self.instances().iter().map(|instance| self.meshes[instance.mesh.0].positions.len()).sum();
        let affordable = (POSED_VERTICES / vertices.max(1)).clamp(POSES.0, POSES.1);
        let count = ((duration * POSES_PER_SECOND).ceil() as usize).clamp(POSES.0, affordable);
        let mut all: Option<Bounds> = None;
        for pose in 0..count {
            let seconds = duration * (pose as f32 / (count - 1) as f32);
            if self.animate(animation, seconds).is_ok() {
                all = all.into_iter().chain(self.bounds_to_frame()).reduce(Bounds::union);
            }
        }
        self.rest();
        Ok(all.or_else(|| self.bounds_to_frame()))
    }
}

/// A fade over shares of half the side of its mesh.
fn faded(half: f32, [from, to]: [f32; 2], camera_height: Option<f32>) -> GroundFade {
    GroundFade { from: from * half, to: to * half, camera_height }
}

/// Half the side of the ground under models within these bounds [m].
fn half_side(bounds: Bounds) -> f32 {
    let footprint = 0.5 * Vec2::new(bounds.max.x - bounds.min.x, bounds.max.z - bounds.min.z).length();
    // Something upright and flat, seen edge-on from above, still gets some ground.
    (GROUND_HALF_SIDE * footprint.max(0.25 * bounds.radius())).max(LEAST_HALF_SIDE)
}

/// A horizontal square facing up.
pub(crate) fn square(center: Vec3, half: f32) -> Mesh {
    let corner = |x: f32, z: f32| center + Vec3::new(x * half, 0.0, z * half);
    Mesh {
        positions: vec![corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0)],
        normals: vec![Vec3::Y; 4],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    }
}

/// A camera for a scene without one: three quarters from the front and slightly from above, so that the models (not the
/// ground) fill a picture of width over height `aspect` up to a small margin. An empty scene is taken for a unit
/// box on the ground; an aspect that is not positive and finite for 1.
pub fn default_camera(scene: &Scene, aspect: f32) -> Camera {
    Camera { origin: scene.origin, ..camera_around(scene.bounds_to_frame(), aspect) }
}

/// [`default_camera`] of a scene whose models have these bounds, and which was not moved.
pub fn camera_around(bounds: Option<Bounds>, aspect: f32) -> Camera {
    let aspect = if aspect.is_finite() && aspect > 0.0 { aspect.clamp(1e-3, 1e3) } else { 1.0 };
    let unit = Bounds { min: Vec3::new(-0.5, 0.0, -0.5), max: Vec3::new(0.5, 1.0, 0.5) };
    let bounds = bounds.unwrap_or(unit);
    let center = bounds.center();
    let radius = bounds.radius();
    // A single point is framed like a small thing.
    let radius = if radius > 1e-6 * center.length() { radius } else { (1e-3 * center.length()).max(1e-3) };
    let (azimuth, elevation) = (33_f32.to_radians(), 20_f32.to_radians());
    let back = Vec3::new(azimuth.sin() * elevation.cos(), elevation.sin(), azimuth.cos() * elevation.cos());
    let right = Vec3::Y.cross(back).normalize();
    let up = back.cross(right);
    let tan_long = (0.5 * LONG_SIDE_FOV).tan();
    let (tan_x, tan_y) =
        if aspect >= 1.0 { (tan_long, tan_long / aspect) } else { (tan_long * aspect, tan_long) };
    let usable = 1.0 - 2.0 * MARGIN;
    let half = 0.5 * (bounds.max - bounds.min);
    let mut distance = radius;
    for corner in 0..8 {
        let sign = |bit: u32| if corner >> bit & 1 == 1 { 1.0 } else { -1.0 };
        let offset = half * Vec3::new(sign(0), sign(1), sign(2));
        let (x, y, z) = (right.dot(offset).abs(), up.dot(offset).abs(), back.dot(offset));
        distance = distance.max(z + (x / tan_x).max(y / tan_y) / usable);
    }
    Camera::look_at(center + distance * back, center, 2.0 * tan_x.atan())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Projection, builtin};

    fn scene(min: Vec3, max: Vec3) -> Scene {
        let mut scene = Scene::default();
        let mesh = Mesh {
            positions: vec![min, max, Vec3::new(min.x, max.y, min.z)],
            normals: vec![Vec3::Y; 3],
            triangles: vec![[0, 1, 2]],
            ..Mesh::default()
        };
        scene.push_mesh("triangle", mesh);
        scene
    }

    /// Largest |x| and |y| of the bounds' corners on a picture that spans -1 to 1.
    fn extent(camera: &Camera, bounds: Bounds, aspect: f32) -> (f32, f32) {
        let Projection::Perspective { fov_x } = camera.projection else { panic!("perspective") };
        let tan = (0.5 * fov_x).tan();
        let view = camera.world_from_camera.inverse();
        let mut most = (0.0_f32, 0.0_f32);
        for corner in 0..8_u32 {
            let pick = |bit: u32, a: f32, b: f32| if corner >> bit & 1 == 1 { a } else { b };
            let p = Vec3::new(
                pick(0, bounds.min.x, bounds.max.x),
                pick(1, bounds.min.y, bounds.max.y),
                pick(2, bounds.min.z, bounds.max.z),
            );
            let p = view.transform_point3(p);
            assert!(p.z < 0.0, "behind the camera");
            most = (most.0.max((p.x / -p.z / tan).abs()), most.1.max((p.y / -p.z / tan * aspect).abs()));
        }
        most
    }

    #[test]
    fn the_whole_model_is_in_frame_for_every_shape_and_aspect() {
        for size in [
            Vec3::ONE,
            Vec3::new(0.01, 5.0, 0.01),
            Vec3::new(9.0, 0.1, 9.0),
            Vec3::splat(1e-4),
            Vec3::splat(1e5),
        ] {
            let mut scene = scene(Vec3::splat(3.0), Vec3::splat(3.0) + size);
            let bounds = scene.bounds().unwrap();
            let before = default_camera(&scene, 1.5);
            scene.add_ground(Ground::Plane);
            assert_eq!(default_camera(&scene, 1.5), before, "the ground does not count");
            for aspect in [0.1, 0.5, 1.0, 1.5, 4.0, 20.0] {
                let (x, y) = extent(&default_camera(&scene, aspect), bounds, aspect);
                let fill = x.max(y);
                assert!(fill < 0.9, "size {size}, aspect {aspect}: the model leaves the frame ({x}, {y})");
                assert!(
                    fill > 0.5,
                    "size {size}, aspect {aspect}: the model is lost in the frame ({x}, {y})"
                );
            }
        }
    }

    #[test]
    fn a_default_camera_always_exists() {
        let point = scene(Vec3::splat(7.0), Vec3::splat(7.0));
        for scene in [Scene::default(), point] {
            for aspect in [1.0, 0.0, -1.0, f32::NAN, f32::INFINITY] {
                assert!(default_camera(&scene, aspect).world_from_camera.is_finite());
            }
        }
    }

    #[test]
    fn the_ground_lies_under_the_lowest_point_and_is_laid_once() {
        let mut scene = scene(Vec3::new(1.0, 2.0, 3.0), Vec3::new(2.0, 4.0, 4.0));
        scene.add_ground(Ground::None);
        assert_eq!(scene.triangle_count(), 1);
        scene.add_ground(Ground::Plane);
        scene.add_ground(Ground::Plane);
        assert_eq!(scene.triangle_count(), 3);
        let bounds = scene.bounds().unwrap();
        assert_eq!(bounds.min.y, 2.0);
        assert_eq!(bounds.max.y, 4.0);
        assert!((bounds.center() - Vec3::new(1.5, 3.0, 3.5)).length() < 1e-5);
        // The footprint's radius is half of sqrt 2.
        assert!((bounds.max.x - bounds.min.x - 8.0 * std::f32::consts::FRAC_1_SQRT_2).abs() < 1e-4);
        let up = crate::triangle_normal(
            scene.meshes[1].triangles[0].map(|i| scene.meshes[1].positions[i as usize]),
        );
        assert_eq!(up, Some(Vec3::Y));
    }

    #[test]
    fn scenes_with_nothing_or_their_own_ground_get_none() {
        let mut empty = Scene::default();
        empty.add_ground(Ground::Plane);
        assert_eq!(empty, Scene::default());
        let mut boxes = builtin::by_name("three-boxes").unwrap();
        boxes.add_ground(Ground::Plane);
        assert_eq!(boxes.triangle_count(), 38);
    }

    #[test]
    fn a_catcher_is_laid_or_made_of_a_level_ground() {
        let mut laid = scene(Vec3::ZERO, Vec3::ONE);
        laid.add_ground(Ground::Catcher);
        assert!(laid.materials[0].catches);
        let mut boxes = builtin::by_name("three-boxes").unwrap();
        let count = boxes.materials.len();
        boxes.add_ground(Ground::Catcher);
        assert_eq!((boxes.triangle_count(), boxes.materials.len()), (38, count + 1));
        let caught = boxes.instances().iter().filter(|i| boxes.material(i.mesh).catches).count();
        assert_eq!(caught, 1);
    }

    #[test]
    fn a_scene_stands_on_what_bears_all_of_it() {
        let with = |flat: Vec3, at: Vec3| {
            let mut scene = scene(Vec3::ZERO, Vec3::ONE);
            let plate = self::scene(at - 0.5 * flat, at + 0.5 * flat);
            scene.append(plate, crate::Node::default());
            scene.stands_on_ground()
        };
        let within_one_mesh = |flat: Vec3, at: Vec3| {
            let mut scene = scene(Vec3::ZERO, Vec3::ONE);
            let plate = self::scene(at - 0.5 * flat, at + 0.5 * flat);
            let mesh = Arc::make_mut(&mut scene.meshes[0]);
            mesh.positions.extend(&plate.meshes[0].positions);
            mesh.triangles.push([3, 4, 5]);
            scene.stands_on_ground()
        };
        assert!(!scene(Vec3::ZERO, Vec3::ONE).stands_on_ground() && !Scene::default().stands_on_ground());
        let under = Vec3::new(0.5, 0.0, 0.5);
        let level = Vec3::new(4.0, 0.0, 4.0);
        assert!(with(level, under));
        assert!(with(level, under + 0.1 * Vec3::Y), "a little sunk in");
        assert!(!with(level, under + 0.5 * Vec3::Y), "a shelf");
        assert!(!with(level, under + Vec3::Y), "a ceiling");
        assert!(!with(level, under + 2.0 * Vec3::X), "the model stands half beside it");
        assert!(!with(Vec3::new(4.0, 1.0, 4.0), under), "not level");
        assert!(!with(Vec3::new(4.0, 4.0, 0.0), under), "a wall");
        assert!(within_one_mesh(level, under));
        assert!(!within_one_mesh(level, under + 1.1 * Vec3::Y));
        let mut laid = scene(Vec3::ZERO, Vec3::ONE);
        laid.add_ground(Ground::Plane);
        assert!(laid.stands_on_ground());
    }
}
