//! Emitting surfaces as area lights: flat ones become rectangles and disks that light the scene.

use std::collections::BTreeMap;
use std::f32::consts::PI;
use std::sync::Arc;

use glam::{Affine3A, Mat3, Vec2, Vec3};
use gnomon_options::choices;

use crate::parts::{first_vertices, root_of};
use crate::{
    AreaLight, AreaLightShape, Instance, MaterialId, Mesh, MeshId, Node, NodeId, Scene, Spread,
    triangle_normal,
};

choices! {
    /// What becomes of surfaces that emit light.
    pub enum Emission {
        /// Flat ones light the scene, as rectangles or disks of their mean radiance; others are seen.
        Lights = "lights",
        /// They are seen, and reflected, but light nothing else.
        Seen = "seen",
    }
}

/// Most lights that surfaces become. A mesh with more parts, such as a curved one, is only seen.
const MOST_LIGHTS: usize = 32;

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
    /// Width and height along x and y, front along -z, around its middle.
    world_from_light: Affine3A,
    shape: AreaLightShape,
    radiance: Vec3,
}

impl Scene {
    /// Gives flat emitting surfaces lights, at rest; their materials no longer show in reflections, where the lights do. One that is seen from
    /// both sides lights both.
    pub fn light_emission(&mut self) {
        let mut left = MOST_LIGHTS;
        let mut placed = Vec::new();
        let mut by_mesh: BTreeMap<usize, bool> = BTreeMap::new();
        for instance in self.instances() {
            let shines = self.material(instance.mesh).emissive.max_element() > 0.0;
            if !shines || self.is_deformable(&instance) {
                continue;
            }
            // All copies of a mesh, or none: they share its material.
            let parts = self.flat_parts(&instance).filter(|parts| parts.len() <= left);
            let Some(parts) = parts.filter(|_| by_mesh.get(&instance.mesh.0) != Some(&false)) else {
                by_mesh.insert(instance.mesh.0, false);
                continue;
            };
            left -= parts.len();
            by_mesh.insert(instance.mesh.0, true);
            placed.push((instance, parts));
        }
        let world = self.world_from_nodes();
        for (instance, parts) in placed {
            if by_mesh.get(&instance.mesh.0) != Some(&true) {
                continue;
            }
            for Flat { world_from_light, shape, radiance } in parts {
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
            let mut material = self.material(MeshId(mesh)).clone();
            material.shines = true;
            self.materials.push(material);
            Arc::make_mut(&mut self.meshes[mesh]).material = Some(MaterialId(self.materials.len() - 1));
        }
    }

    /// The parts of an instance as lights; `None` unless all of them are flat.
    fn flat_parts(&self, instance: &Instance) -> Option<Vec<Flat>> {
        let mesh = &self.meshes[instance.mesh.0];
        let double_sided = self.material(instance.mesh).double_sided;
        let mut flats = Vec::new();
        for triangles in coplanar_parts(mesh, MOST_LIGHTS)? {
            flats.push(self.flat(instance, &triangles)?);
            if double_sided && let Some(front) = flats.last() {
                let turned = front.world_from_light * Affine3A::from_rotation_y(PI);
                flats.push(Flat { world_from_light: turned, ..*front });
            }
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
        let before = middle + BEFORE * rectangle.min_element() * normal;
        let emitted: Vec3 =
            triangles.iter().map(|triangle| self.emitted(instance, *triangle, corners_of(triangle))).sum();
        Some(Flat {
            world_from_light: Affine3A::from_mat3_translation(
                Mat3::from_cols(axes[0], axes[1], -normal),
                before,
            ),
            shape,
            radiance: emitted / shape.area(),
        })
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
mod tests {
    use super::*;
    use crate::{Material, builtin};

    /// Triangles of a polygon around a centre, counter-clockwise seen from +z.
    fn polygon(corners: &[Vec3]) -> Mesh {
        let triangles = (1..corners.len() as u32 - 1).map(|i| [0, i, i + 1]).collect();
        Mesh { positions: corners.to_vec(), triangles, material: Some(MaterialId(0)), ..Mesh::default() }
    }

    fn glowing(mesh: Mesh, parent_from_node: Affine3A, double_sided: bool) -> Scene {
        let material = Material { emissive: Vec3::new(4.0, 2.0, 1.0), double_sided, ..Material::default() };
        let mut scene = Scene { materials: vec![material], ..Scene::default() };
        let node = scene.push_mesh("panel", mesh);
        scene.nodes[node.0].parent_from_node = parent_from_node;
        scene
    }

    #[test]
    fn a_quad_becomes_a_rectangle_that_shines_from_its_front() {
        let quad = [Vec3::ZERO, Vec3::new(2.0, 0.0, 0.0), Vec3::new(2.0, 0.5, 0.0), Vec3::new(0.0, 0.5, 0.0)];
        for mirror in [1.0, -1.0] {
            let place = Affine3A::from_translation(Vec3::Y)
                * Affine3A::from_rotation_x(0.5 * PI)
                * Affine3A::from_scale(Vec3::new(2.0 * mirror, 2.0, 2.0));
            let mut scene = glowing(polygon(&quad), place, false);
            scene.light_emission();
            let [light] = scene.placed_lights()[..] else { panic!("one light") };
            let AreaLightShape::Rectangle { size } = light.shape else { panic!("{:?}", light.shape) };
            assert!(
                (size.max_element() - 4.0).abs() < 1e-5 && (size.min_element() - 1.0).abs() < 1e-5,
                "{size}"
            );
            assert!(light.center.abs_diff_eq(Vec3::new(2.0 * mirror, 1.0, 0.5), 2e-3), "{}", light.center);
            // From +z a quarter turn about x, and a mirror across turns no front.
            assert!(light.normal.abs_diff_eq(Vec3::NEG_Y, 1e-5), "{mirror}: {}", light.normal);
            assert!(light.radiance.abs_diff_eq(Vec3::new(4.0, 2.0, 1.0), 1e-5));
            assert!(scene.material(MeshId(0)).shines);
        }
    }

    #[test]
    fn both_sides_shine_where_both_are_seen() {
        let triangle = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let mut scene = glowing(polygon(&triangle), Affine3A::IDENTITY, true);
        scene.light_emission();
        let [front, back] = scene.placed_lights()[..] else { panic!("two lights") };
        assert!(front.normal.abs_diff_eq(Vec3::Z, 1e-6) && back.normal.abs_diff_eq(Vec3::NEG_Z, 1e-6));
        // Half of the rectangle around it.
        assert!((front.radiance.x - 2.0).abs() < 1e-5, "{}", front.radiance);
    }

    #[test]
    fn a_round_plate_becomes_a_disk_of_its_area() {
        let corners: Vec<Vec3> =
            (0..32).map(|i| (Vec2::from_angle(2.0 * PI * i as f32 / 32.0) * 0.5).extend(1.0)).collect();
        let mut scene = glowing(polygon(&corners), Affine3A::IDENTITY, false);
        scene.light_emission();
        let [light] = scene.placed_lights()[..] else { panic!("one light") };
        assert!(
            matches!(light.shape, AreaLightShape::Disk { radius } if (radius - 0.4984).abs() < 1e-3),
            "{:?}",
            light.shape
        );
        assert!(light.center.abs_diff_eq(Vec3::Z, 2e-3) && (light.radiance.x - 4.0).abs() < 1e-4);
    }

    #[test]
    fn sides_of_a_box_are_lights_and_what_is_curved_is_only_seen() {
        let mut boxes = builtin::without_ground("three-boxes").unwrap();
        boxes.materials = vec![Material { emissive: Vec3::ONE, ..Material::default() }];
        boxes.meshes.iter_mut().for_each(|mesh| Arc::make_mut(mesh).material = Some(MaterialId(0)));
        let before = boxes.clone();
        boxes.light_emission();
        assert_eq!(boxes.placed_lights().len(), 3 * 6);
        assert_eq!(boxes.triangle_count(), before.triangle_count());
        // A strip that bends a little from piece to piece.
        let mut strip = Mesh { material: Some(MaterialId(0)), ..Mesh::default() };
        for i in 0..200_u32 {
            let (sin, cos) = (0.01 * i as f32).sin_cos();
            strip.positions.extend([Vec3::new(sin, 0.0, cos), Vec3::new(sin, 1.0, cos)]);
            if i > 0 {
                strip.triangles.extend([[2 * i - 2, 2 * i, 2 * i - 1], [2 * i - 1, 2 * i, 2 * i + 1]]);
            }
        }
        let mut curved = glowing(strip, Affine3A::IDENTITY, false);
        curved.light_emission();
        assert!(curved.lights.is_empty() && !curved.materials[0].shines);
    }
}
