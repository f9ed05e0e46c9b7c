//! Emitting surfaces as area lights: flat ones become rectangles and disks that light the scene.

mod cells;

use std::collections::BTreeMap;
use std::f32::consts::PI;
use std::sync::Arc;

use glam::{Affine3A, Mat3, Vec2, Vec3};
use gnomon_options::choices;

use self::cells::{Cell, Picture};
use crate::parts::{first_vertices, root_of};
use crate::{AreaLight, AreaLightShape, Instance, Mesh, Node, NodeId, Scene, Spread, triangle_normal};

choices! {
    /// What becomes of surfaces that emit light.
    pub enum Emission {
        /// Flat ones light the scene, as rectangles and disks that have their picture; others are seen.
        Lights = "lights",
        /// They are seen, and reflected, but light nothing else.
        Seen = "seen",
    }
}

/// Most flat parts, each side of one counted, that light the scene. A mesh with more, such as a curved one, is only seen.
const MOST_PARTS: usize = 32;

/// Most lights that all parts become, and one of them.
const MOST_LIGHTS: usize = 64;
const MOST_CELLS: usize = 16;

/// A part of more triangles has no picture: each place of it would ask all of them.
const PICTURED_TRIANGLES: usize = 1024;

/// Cosine between neighbouring triangles of one part, and distance of its vertices from its plane as a share of its extent.
const SAME_PLANE: f32 = 0.9999;
const FLAT: f32 = 1e-3;

/// Most edges that are tried as the direction of a rectangle.
const MOST_EDGES: usize = 256;

/// A disk is between these shares of the square around it, and its sides differ by less than this share.
const DISK_SHARES: std::ops::RangeInclusive<f32> = 0.70..=0.80;
const ROUND: f32 = 0.05;

/// Distance of a light before its surface, as a share of its smaller side: the surface lies behind it whatever is rounded.
const BEFORE: f32 = 1e-4;

/// Samples of a triangle's emission along each of its sides.
const SAMPLES: usize = 4;

/// A flat part of an emitting mesh, in world space.
struct Flat {
    /// Width and height along x and y, front along -z, around its middle, in the surface.
    world_from_light: Affine3A,
    shape: AreaLightShape,
    radiance: Vec3,
    /// Of the rectangle around it, where it has one.
    picture: Option<Picture>,
    double_sided: bool,
}

impl Flat {
    fn sides(&self) -> usize {
        if self.double_sided { 2 } else { 1 }
    }

    /// Its lights: at most so many of a side.
    fn lights(&self, most: usize) -> Vec<(Affine3A, AreaLightShape, Vec3)> {
        let cells = self.picture.as_ref().map(|picture| picture.cells(most));
        let Some(cells) = cells.filter(|cells| cells.len() > 1) else {
            return self.on_sides(self.world_from_light, self.shape, self.radiance);
        };
        let size = 2.0 * self.shape.half_extent();
        let light = |cell: &Cell| {
            let place = size * (0.5 * (cell.min + cell.max) - 0.5);
            let world_from_light = self.world_from_light * Affine3A::from_translation(place.extend(0.0));
            let shape = AreaLightShape::Rectangle { size: size * (cell.max - cell.min) };
            self.on_sides(world_from_light, shape, cell.radiance)
        };
        let shining = cells.iter().filter(|cell| cell.radiance.max_element() > 0.0);
        shining.flat_map(light).collect()
    }

    fn on_sides(
        &self,
        world_from_light: Affine3A,
        shape: AreaLightShape,
        radiance: Vec3,
    ) -> Vec<(Affine3A, AreaLightShape, Vec3)> {
        let before = Affine3A::from_translation(-2.0 * BEFORE * shape.half_extent().min_element() * Vec3::Z);
        let turns = [Affine3A::IDENTITY, Affine3A::from_rotation_y(PI)].into_iter().take(self.sides());
        turns.map(|turn| (world_from_light * turn * before, shape, radiance)).collect()
    }
}

impl Scene {
    /// Gives flat emitting surfaces lights, at rest: of what has a picture several. Their emission no longer shows in reflections, where the lights do. One that is seen from
    /// both sides lights both.
    pub fn light_emission(&mut self) {
        let world = self.world_from_nodes();
        let mut left = MOST_PARTS;
        let mut placed = Vec::new();
        let mut by_mesh: BTreeMap<usize, bool> = BTreeMap::new();
        for instance in self.instances() {
            let shines = self.material(instance.mesh).emissive.max_element() > 0.0;
            // A light in the space of a node that is flattened has no place.
            let has_space = world[instance.node.0].inverse().is_finite();
            if !shines || !has_space || self.is_deformable(&instance) {
                continue;
            }
            // All copies of a mesh, or none: they share its material.
            let sides = |parts: &[Flat]| parts.iter().map(Flat::sides).sum::<usize>();
            let parts = self.flat_parts(&instance).filter(|parts| sides(parts) <= left);
            let Some(parts) = parts.filter(|_| by_mesh.get(&instance.mesh.0) != Some(&false)) else {
                by_mesh.insert(instance.mesh.0, false);
                continue;
            };
            left -= sides(&parts);
            by_mesh.insert(instance.mesh.0, true);
            placed.push((instance, parts));
        }
        let most = (MOST_LIGHTS / (MOST_PARTS - left).max(1)).clamp(1, MOST_CELLS);
        for (instance, parts) in placed {
            if by_mesh.get(&instance.mesh.0) != Some(&true) {
                continue;
            }
            for (world_from_light, shape, radiance) in parts.iter().flat_map(|flat| flat.lights(most)) {
                let light_node = Node {
                    name: "emission".to_owned(),
                    parent: Some(instance.node),
                    parent_from_node: world[instance.node.0].inverse() * world_from_light,
                    ..Node::default()
                };
                self.nodes.push(light_node);
                let node = NodeId(self.nodes.len() - 1);
                self.lights.push(AreaLight { node, shape, radiance, spread: Spread::Even });
            }
        }
        for (mesh, _) in by_mesh.into_iter().filter(|(_, lights)| *lights) {
            // Of the mesh, as others may have its material: labels count the materials of the file.
            Arc::make_mut(&mut self.meshes[mesh]).shines = true;
        }
    }

    /// The parts of an instance as lights; `None` unless all of them are flat.
    fn flat_parts(&self, instance: &Instance) -> Option<Vec<Flat>> {
        let mesh = &self.meshes[instance.mesh.0];
        let double_sided = self.material(instance.mesh).double_sided;
        let mut flats = Vec::new();
        for triangles in coplanar_parts(mesh, MOST_PARTS)? {
            flats.push(Flat { double_sided, ..self.flat(instance, &triangles)? });
        }
        flats.retain(|flat| flat.radiance.max_element() > 0.0);
        (!flats.is_empty()).then_some(flats)
    }

    fn flat(&self, instance: &Instance, triangles: &[usize]) -> Option<Flat> {
        let mesh = &self.meshes[instance.mesh.0];
        let affine = instance.world_from_mesh;
        let corners_of = |&triangle: &usize| {
            mesh.triangles[triangle].map(|index| affine.transform_point3(mesh.positions[index as usize]))
        };
        // Fronts stay fronts where a placement mirrors.
        let mirrored = crate::mirror_sign(&affine);
        let doubled: Vec3 =
            (triangles.iter().map(corners_of)).map(|[a, b, c]| mirrored * (b - a).cross(c - a)).sum();
        let (area, normal) = (0.5 * doubled.length(), doubled.try_normalize()?);
        let places: Vec<Vec3> = triangles.iter().flat_map(corners_of).collect();
        let (rectangle, axes, middle) = smallest_rectangle(&places, normal)?;
        let depth = places.iter().map(|place| (*place - middle).dot(normal).abs()).fold(0.0, f32::max);
        if depth > FLAT * rectangle.max_element() || rectangle.min_element() <= 0.0 {
            return None;
        }
        let filled = area / (rectangle.x * rectangle.y);
        let is_round =
            (rectangle.x - rectangle.y).abs() < ROUND * rectangle.x && DISK_SHARES.contains(&filled);
        let shape = match is_round {
            true => AreaLightShape::Disk { radius: (area / PI).sqrt() },
            false => AreaLightShape::Rectangle { size: rectangle },
        };
        let local = |place: Vec3| {
            let place = place - middle;
            0.5 + Vec2::new(place.dot(axes[0]), place.dot(axes[1])) / rectangle
        };
        let corners = |triangle: &usize| (*triangle, corners_of(triangle).map(local));
        let placed: Vec<_> = triangles.iter().map(corners).collect();
        let material = self.material(instance.mesh);
        let has_picture = (material.emissive_texture.is_some() || material.emissive_vertex_colors)
            && triangles.len() <= PICTURED_TRIANGLES;
        let picture =
            has_picture.then(|| Picture::new(rectangle, |at| self.emitted_at(instance, &placed, at)));
        let emitted = match &picture {
            Some(picture) => picture.mean() * (rectangle.x * rectangle.y),
            None => {
                triangles.iter().map(|triangle| self.emitted(instance, *triangle, corners_of(triangle))).sum()
            }
        };
        Some(Flat {
            picture,
            double_sided: false,
            world_from_light: Affine3A::from_mat3_translation(
                Mat3::from_cols(axes[0], axes[1], -normal),
                middle,
            ),
            shape,
            radiance: emitted / shape.area(),
        })
    }

    /// Radiance at a place among triangles, all in shares of the rectangle around them; none beside them.
    fn emitted_at(&self, instance: &Instance, triangles: &[(usize, [Vec2; 3])], at: Vec2) -> Vec3 {
        let weights = |[a, b, c]: [Vec2; 3]| {
            let weights =
                Vec3::new((b - at).perp_dot(c - at), (c - at).perp_dot(a - at), (a - at).perp_dot(b - at));
            weights / weights.element_sum()
        };
        let inside = |(triangle, corners): &(usize, [Vec2; 3])| {
            let weights = weights(*corners);
            (weights.min_element() >= 0.0).then_some((*triangle, weights))
        };
        let Some((triangle, weights)) = triangles.iter().find_map(inside) else { return Vec3::ZERO };
        let point = self.surface_at(instance.mesh, triangle, weights);
        point.opacity * point.emissive
    }

    /// Radiance of a triangle times its area, the mean of places that are spread evenly.
    fn emitted(&self, instance: &Instance, triangle: usize, [a, b, c]: [Vec3; 3]) -> Vec3 {
        let area = 0.5 * (b - a).cross(c - a).length();
        let mut sum = Vec3::ZERO;
        let step = 1.0 / SAMPLES as f32;
        for i in 0..SAMPLES {
            for j in 0..SAMPLES {
                let (mut u, mut v) = ((i as f32 + 0.5) * step, (j as f32 + 0.5) * step);
                if u + v > 1.0 {
                    (u, v) = (1.0 - u, 1.0 - v);
                }
                let point = self.surface_at(instance.mesh, triangle, Vec3::new(1.0 - u - v, u, v));
                sum += point.opacity * point.emissive;
            }
        }
        sum * area * step * step
    }
}

/// Triangles of a mesh that hang together and lie in a plane; `None` where there are more parts than that.
fn coplanar_parts(mesh: &Mesh, most: usize) -> Option<Vec<Vec<usize>>> {
    let firsts = first_vertices(&mesh.positions);
    let normals: Vec<Option<Vec3>> = (mesh.triangles.iter())
        .map(|triangle| triangle_normal(triangle.map(|index| mesh.positions[index as usize])))
        .collect();
    let mut parents: Vec<usize> = (0..mesh.triangles.len()).collect();
    // Of every vertex one triangle of each plane.
    let mut around: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (number, triangle) in mesh.triangles.iter().enumerate() {
        let Some(normal) = normals[number] else { continue };
        for &index in triangle {
            let others = around.entry(firsts[index as usize]).or_default();
            let same = others
                .iter()
                .copied()
                .find(|&other| normals[other].is_some_and(|n| n.dot(normal) > SAME_PLANE));
            match same {
                Some(other) => {
                    let (root, other) = (root_of(&mut parents, number), root_of(&mut parents, other));
                    parents[other] = root;
                }
                None => others.push(number),
            }
        }
    }
    let mut parts: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for number in (0..mesh.triangles.len()).filter(|&number| normals[number].is_some()) {
        let root = root_of(&mut parents, number);
        parts.entry(root).or_default().push(number);
        if parts.len() > most {
            return None;
        }
    }
    Some(parts.into_values().collect())
}

/// Size, axes of width and height (the normal is their cross product's opposite: a light looks along its -z) and middle of the smallest
/// rectangle around places of a plane that has an edge of theirs as a side.
fn smallest_rectangle(places: &[Vec3], normal: Vec3) -> Option<(Vec2, [Vec3; 2], Vec3)> {
    let edges = places
        .chunks_exact(3)
        .flat_map(|corners| [corners[1] - corners[0], corners[2] - corners[1], corners[0] - corners[2]]);
    let around = |edge: Vec3| {
        let across = (edge - normal * edge.dot(normal)).try_normalize()?;
        // x, y and z = -normal are right-handed.
        let up = across.cross(normal);
        let local = |place: &Vec3| Vec2::new(across.dot(*place), up.dot(*place));
        let first = local(places.first()?);
        let (min, max) =
            places.iter().map(local).fold((first, first), |(min, max), p| (min.min(p), max.max(p)));
        let middle = 0.5 * (min + max);
        let height = normal * normal.dot(*places.first()?);
        Some((max - min, [across, up], across * middle.x + up * middle.y + height))
    };
    let found = edges.take(MOST_EDGES).filter_map(around);
    found.min_by(|(a, ..), (b, ..)| (a.x * a.y).total_cmp(&(b.x * b.y)))
}

#[cfg(test)]
mod tests;
