//! A ground that gives way to what is behind it, and whether a scene brings a ground of its own.

use glam::{Vec2, Vec3};

use crate::{Bounds, Scene};

/// How a catcher changes with the distance from its middle. Farther out than `to` it shows what is behind it, as any catcher.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GroundFade {
    /// Within this distance nothing of what is behind it is seen, in mesh space.
    pub from: f32,
    /// From this distance on nothing else is.
    pub to: f32,
    /// What is seen there instead: what a camera so high over the middle saw of the ground [m]; `None` for the ground's own matte colour.
    pub camera_height: Option<f32>,
}

/// A [`GroundFade`] in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlacedFade {
    /// Middle of the ground [m].
    pub center: Vec3,
    /// As [`GroundFade::from`] [m].
    pub from: f32,
    /// As [`GroundFade::to`] [m].
    pub to: f32,
    /// As [`GroundFade::camera_height`]; 0 for the ground's own colour [m].
    pub camera_height: f32,
}

impl PlacedFade {
    /// Share of what is seen near the middle in what is seen at a place.
    pub fn share(&self, position: Vec3) -> f32 {
        ground_share((position - self.center).length(), self.from, self.to)
    }

    /// Where in the environment a place of the ground is seen, by a viewer who looks along `direction`. Between both distances the
    /// direction turns from one to the other: two pictures laid over each other would show everything twice.
    pub fn direction(&self, position: Vec3, direction: Vec3) -> Vec3 {
        ground_direction(position - self.center, direction, self.camera_height, self.share(position))
    }
}

/// A smooth step from 1 at the distance `from` to 0 at `to`.
pub fn ground_share(distance: f32, from: f32, to: f32) -> f32 {
    let t = ((distance - from) / (to - from)).clamp(0.0, 1.0);
    1.0 - t * t * (3.0 - 2.0 * t)
}

/// Where in the environment a place of a ground is seen along `direction`: near the middle where a camera so high over it saw the place.
pub fn ground_direction(from_center: Vec3, direction: Vec3, camera_height: f32, share: f32) -> Vec3 {
    if camera_height <= 0.0 {
        return direction;
    }
    let seen = (from_center - camera_height * Vec3::Y).normalize();
    let turned = direction.lerp(seen, share);
    if turned.length_squared() < 1e-12 { direction } else { turned.normalize() }
}

/// Cells along a side of the grid in which [`Scene::has_floor`] and [`Scene::brings_ground`] look at a scene.
const CELLS: usize = 64;

/// Share of the cells that a ground fills at least.
const FILLED: f32 = 0.5;

/// Cells of the rim along a side of it, and the share of the rim that may be covered where a floor reaches beyond what stands on it.
const RIM: usize = 3;
const COVERED: f32 = 0.5;

/// Height of a ground over the lowest point, as a share of the scene's height.
const LOW: f32 = 0.1;

/// Cosine of the steepest slope of a ground.
const LEVEL: f32 = 0.7;

impl Scene {
    /// The fading ground in the current pose.
    pub fn placed_fade(&self) -> Option<PlacedFade> {
        let node = self.ground?;
        let mesh = &self.meshes[self.nodes.get(node.0)?.meshes.first()?.0];
        let fade = self.materials.get(mesh.material?.0)?.fade?;
        let center = Bounds::around(mesh.positions.iter().copied())?.center();
        let world_from_mesh = self.world_from_nodes()[node.0];
        let scale = world_from_mesh.matrix3.x_axis.length();
        Some(PlacedFade {
            center: world_from_mesh.transform_point3(center),
            from: scale * fade.from,
            to: scale * fade.to,
            camera_height: fade.camera_height.unwrap_or(0.0),
        })
    }

    /// Whether models stand on a ground of the scene's own ([`Scene::has_floor`]) that reaches well beyond them: of the rim of the rectangle around the
    /// scene at most half is under something higher. A floor that ends with its walls is no ground but a part of the model. A scene that has a camera
    /// within it is a place, whatever its floor is like.
    pub fn brings_ground(&self) -> bool {
        let Some(bounds) = self.bounds() else { return false };
        let is_within = |eye: Vec3| eye.cmpge(bounds.min).all() && eye.cmple(bounds.max).all();
        let has_view_within =
            || self.cameras.iter().any(|camera| is_within(camera.relative_to(self.origin).eye()));
        self.ground.is_some() || has_view_within() || (self.has_floor() && self.floor_reaches_out(&bounds))
    }

    /// Whether there is something large, flat and low under the rest: a level surface that bears all, or, seen straight from below, half of the
    /// rectangle around the scene is the back of something level, not far above the lowest point. Below a model that stands on nothing are its own
    /// outsides.
    pub fn has_floor(&self) -> bool {
        let Some(cells) = self.bounds().and_then(|bounds| Cells::around(&bounds)) else { return false };
        if self.stands_on_ground() {
            return true;
        }
        // Of each cell the height of what is lowest, and whether it faces up.
        let mut seen = vec![(f32::INFINITY, false); CELLS * CELLS];
        self.visit_triangles(
            |bounds| bounds.min.y <= cells.lowest,
            |corners, mirrored| {
                if corners.iter().all(|corner| corner.y > cells.lowest) {
                    return;
                }
                let normal = mirrored * (corners[1] - corners[0]).cross(corners[2] - corners[0]);
                let faces_up = normal.y > LEVEL * normal.length();
                visit_cells(cells.of(corners), |index, height| {
                    if height < seen[index].0 {
                        seen[index] = (height, faces_up);
                    }
                });
            },
        );
        let filled = seen.iter().filter(|(height, faces_up)| *faces_up && *height <= cells.lowest).count();
        filled as f32 >= FILLED * seen.len() as f32
    }

    /// Whether most of the rim of the rectangle around the scene is under nothing but the sky.
    fn floor_reaches_out(&self, bounds: &Bounds) -> bool {
        let Some(cells) = Cells::around(bounds) else { return false };
        let mut covered = vec![false; CELLS * CELLS];
        self.visit_triangles(
            |bounds| bounds.max.y > cells.lowest,
            |corners, _| {
                if corners.iter().all(|corner| corner.y <= cells.lowest) {
                    return;
                }
                let local = cells.of(corners);
                visit_cells(local, |index, _| covered[index] = true);
                // Walls are edges, seen from above.
                for (from, to) in [(local[0], local[1]), (local[1], local[2]), (local[2], local[0])] {
                    let (from, to) = (from.truncate(), to.truncate());
                    let steps = (to - from).abs().max_element().ceil().clamp(1.0, 2.0 * CELLS as f32);
                    for step in 0..=steps as u32 {
                        let at = from.lerp(to, step as f32 / steps).floor();
                        let [x, y] = at.to_array().map(|at| (at.max(0.0) as usize).min(CELLS - 1));
                        covered[y * CELLS + x] = true;
                    }
                }
            },
        );
        let is_rim =
            |index: usize| [index % CELLS, index / CELLS].iter().any(|at| !(RIM..CELLS - RIM).contains(at));
        let rim: Vec<bool> = (0..CELLS * CELLS).filter(|&index| is_rim(index)).map(|i| covered[i]).collect();
        rim.iter().filter(|covered| **covered).count() as f32 <= COVERED * rim.len() as f32
    }

    /// Calls for each triangle of the instances whose bounds are wanted, in world space, with the sign of its placement.
    fn visit_triangles(&self, is_wanted: impl Fn(&Bounds) -> bool, mut visit: impl FnMut([Vec3; 3], f32)) {
        let pose = self.pose();
        for instance in self.instances_in(&pose.world_from_nodes) {
            if !self.instance_bounds(&pose, &instance).is_some_and(|bounds| is_wanted(&bounds)) {
                continue;
            }
            let vertices = self.world_vertices(&pose, &instance);
            let mirrored = crate::mirror_sign(&instance.world_from_mesh);
            for triangle in &self.meshes[instance.mesh.0].triangles {
                visit(triangle.map(|index| vertices.positions[index as usize]), mirrored);
            }
        }
    }
}

/// A grid over the rectangle around a scene, seen from above.
struct Cells {
    corner: Vec2,
    cell: Vec2,
    /// Up to this height lies what is low.
    lowest: f32,
}

impl Cells {
    /// `None` for what has no area from above.
    fn around(bounds: &Bounds) -> Option<Self> {
        let size = bounds.max - bounds.min;
        let cell = Vec2::new(size.x, size.z) / CELLS as f32;
        let corner = Vec2::new(bounds.min.x, bounds.min.z);
        (cell.min_element() > 0.0).then_some(Self { corner, cell, lowest: bounds.min.y + LOW * size.y })
    }

    /// A triangle in cells, with its heights.
    fn of(&self, corners: [Vec3; 3]) -> [Vec3; 3] {
        corners.map(|p| ((Vec2::new(p.x, p.z) - self.corner) / self.cell).extend(p.y))
    }
}

/// Calls for each cell with its middle in a triangle, seen along its third axis, with the depth there.
fn visit_cells([a, b, c]: [Vec3; 3], mut visit: impl FnMut(usize, f32)) {
    let flat = [a, b, c].map(|p| p.truncate());
    let doubled = (flat[1] - flat[0]).perp_dot(flat[2] - flat[0]);
    if doubled == 0.0 || !doubled.is_finite() {
        return;
    }
    let last = Vec2::splat(CELLS as f32 - 1.0);
    let min = (flat[0].min(flat[1]).min(flat[2]) - 0.5).ceil().max(Vec2::ZERO).as_usizevec2();
    let max = (flat[0].max(flat[1]).max(flat[2]) - 0.5).floor().min(last);
    if max.min_element() < 0.0 {
        return;
    }
    let max = max.as_usizevec2();
    for y in min.y..=max.y {
        for x in min.x..=max.x {
            let p = Vec2::new(x as f32, y as f32) + 0.5;
            let weight =
                |i: usize| (flat[(i + 2) % 3] - flat[(i + 1) % 3]).perp_dot(p - flat[(i + 1) % 3]) / doubled;
            let weights = [0, 1, 2].map(weight);
            if weights.iter().all(|weight| *weight >= -1e-6) {
                visit(y * CELLS + x, weights[0] * a.z + weights[1] * b.z + weights[2] * c.z);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::Affine3A;

    use super::*;
    use crate::framing::square;
    use crate::{Ground, Mesh, Node, builtin};

    /// A closed box, wound outwards.
    fn block(min: Vec3, max: Vec3) -> Mesh {
        let positions = Bounds { min, max }.corners().to_vec();
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        Mesh { positions, triangles, ..Mesh::default() }
    }

    fn of(meshes: Vec<Mesh>) -> Scene {
        let mut scene = Scene::default();
        for mesh in meshes {
            scene.push_mesh("", mesh);
        }
        scene
    }

    #[test]
    fn a_ground_is_large_flat_and_low() {
        let cube = || block(Vec3::ZERO, Vec3::ONE);
        let plate = |height: f32| square(Vec3::new(0.5, height, 0.5), 2.0);
        let slab = block(Vec3::new(-1.0, -0.1, -1.0), Vec3::new(2.0, 0.0, 2.0));
        assert!(!of(vec![cube()]).brings_ground(), "a cube stands on nothing");
        assert!(!of(vec![cube(), slab]).brings_ground(), "a slab stands on nothing either");
        assert!(!of(vec![cube(), plate(0.8)]).brings_ground(), "a roof is no ground");
        assert!(!of(vec![cube(), square(Vec3::new(9.0, 0.0, 0.5), 0.4)]).brings_ground(), "a small plate");
        assert!(of(vec![cube(), plate(0.0)]).brings_ground());
        // Walls along the edges of a plate, but for one side; one wall alone.
        let wall = |min: [f32; 2], max: [f32; 2]| {
            block(Vec3::new(min[0], 0.0, min[1]), Vec3::new(max[0], 1.0, max[1]))
        };
        let far = wall([-1.4, -1.4], [2.4, -1.3]);
        let sides = [wall([-1.4, -1.4], [-1.3, 2.4]), wall([2.3, -1.4], [2.4, 2.4])];
        assert!(of(vec![cube(), plate(0.0), far.clone()]).brings_ground());
        let [left, right] = sides;
        assert!(
            !of(vec![cube(), plate(0.0), far, left, right]).brings_ground(),
            "a box that is open in front"
        );
        // Of a plate whose corner is bent up, no box is flat.
        let mut bent = plate(0.0);
        bent.positions[0].y = 0.05;
        assert!(of(vec![cube(), bent]).brings_ground());
        // The inside of a room.
        let mut room = block(Vec3::splat(-3.0), Vec3::splat(4.0));
        room.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
        let roomy = of(vec![cube(), room.clone()]);
        assert!(roomy.has_floor() && !roomy.brings_ground(), "a floor that ends with its walls");
        assert!(!of(vec![cube()]).has_floor());
        // Mirrored it is the outside.
        let mut mirrored = of(vec![room]);
        mirrored.nodes[0] = Node {
            parent_from_node: Affine3A::from_scale(Vec3::new(-1.0, 1.0, 1.0)),
            ..mirrored.nodes[0].clone()
        };
        assert!(mirrored.has_floor(), "a placement that mirrors turns no room inside out");
        // One with a thick floor is a place where it is looked at from within.
        let mut looked_at = of(vec![block(Vec3::splat(-3.0), Vec3::splat(4.0))]);
        looked_at.cameras.push(crate::Camera::look_at(Vec3::new(1.0, 0.0, 6.0), Vec3::ZERO, 1.0));
        assert!(!looked_at.brings_ground());
        looked_at.cameras.push(crate::Camera::look_at(Vec3::new(1.0, 0.0, 2.0), Vec3::ZERO, 1.0));
        assert!(looked_at.brings_ground());
        assert!(builtin::by_name("three-boxes").is_ok_and(|scene| scene.brings_ground()));
        assert!(!Scene::default().brings_ground());
    }

    #[test]
    fn a_fade_is_placed_with_its_ground() {
        let mut scene = of(vec![block(Vec3::new(1.0, 2.0, 3.0), Vec3::new(2.0, 3.0, 4.0))]);
        assert_eq!(scene.placed_fade(), None);
        scene.add_ground(Ground::Fade);
        let fade = scene.placed_fade().unwrap();
        assert!(fade.center.abs_diff_eq(Vec3::new(1.5, 2.0, 3.5), 1e-5));
        let radius = std::f32::consts::FRAC_1_SQRT_2;
        assert!(fade.from > radius && fade.to > 2.0 * fade.from && fade.camera_height == 0.0, "{fade:?}");
        assert_eq!((fade.share(fade.center), fade.share(fade.center + fade.to * Vec3::X)), (1.0, 0.0));
        let half = fade.center + 0.5 * (fade.from + fade.to) * Vec3::Z;
        assert!((fade.share(half) - 0.5).abs() < 1e-5);
        let along = Vec3::new(0.6, -0.8, 0.0);
        assert_eq!(fade.direction(half, along), along);
        let projected = PlacedFade { camera_height: 2.0, ..fade };
        assert!(projected.direction(fade.center, along).abs_diff_eq(Vec3::NEG_Y, 1e-6));
        assert!(projected.direction(fade.center + fade.to * Vec3::X, along).abs_diff_eq(along, 1e-6));
    }
}
