use std::sync::Arc;

use glam::{Mat3, Vec2, Vec3, Vec3A};
use gnomon_brdf::{Finish, Frame, Layers, Surface, Tables};
use gnomon_scene::{
    AlphaMode, Gradients, Material, MeshId, PlacedFade, Scene, WorldVertices, bent_by_heights, mirror_sign,
    normal_matrix,
};
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::leaf_collapser::collapse;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};
use obvhs::ray::RayHit;

use crate::relief::Relief;
use crate::{Ray, ReferenceError};

/// Most placed triangles: the BVH has twice as many nodes and numbers them in 32 bits.
const MAX_TRIANGLES: usize = 1 << 30;

/// The world-space triangles of a scene's current pose in a BVH.
///
/// The binary BVH of `obvhs` rather than its wide one: that one ignores hits nearer than 0.1 mm and has a stack of fixed depth.
pub(crate) struct TracedScene<'a> {
    scene: &'a Scene,
    /// The ground that fades.
    ground: Option<PlacedFade>,
    instances: Vec<Instance>,
    bvh: Bvh2,
    /// In the BVH's leaf order.
    triangles: Vec<Triangle>,
}

/// A placed mesh.
struct Instance {
    mesh: MeshId,
    /// Takes normals of [`Scene::surface_at`], or of deformed vertices, to world space, up to their length.
    normal_from_mesh: Mat3,
    /// -1 where its placement mirrors it, else 1.
    handedness: f32,
    /// Of its material, where its model is tabulated.
    tables: Option<Arc<Tables>>,
    /// Lets rays through, all of them in some places or some of them everywhere.
    has_alpha: bool,
    /// Is a catcher, which blocks no light.
    catches: bool,
    /// Fades, as a catcher that is the scene's ground.
    fades: bool,
    /// Its vertices, where a skin or morph targets move them.
    deformed: Option<WorldVertices>,
}

#[derive(Clone, Copy)]
struct Triangle {
    corners: [Vec3A; 3],
    instance: u32,
    /// Index in its mesh.
    index: u32,
}

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Hit {
    /// Triangle, in BVH order.
    triangle: u32,
    /// Weights of its corners, which sum to 1.
    barycentrics: Vec3,
}

/// A hit, ready for shading.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HitPoint<'a> {
    /// World space [m], on the triangle up to rounding.
    pub(crate) position: Vec3,
    /// Unit normal of the triangle's plane, world space, on the viewer's side.
    pub(crate) geometric_normal: Vec3,
    /// About the shading normal, which is on the same side.
    pub(crate) frame: Frame,
    /// Distance along the normal that clears the rounding of `position` [m].
    pub(crate) clearance: f32,
    pub(crate) surface: Surface,
    /// Normal of the clear coat in `frame`.
    coat_normal: Vec3,
    tables: Option<&'a Tables>,
    pub(crate) emissive: Vec3,
    /// Whether lights of the scene stand for its emission.
    pub(crate) shines: bool,
    /// Shows what is behind the scene; its surface then is matte.
    pub(crate) catches: bool,
    /// As the ground that fades: where, and the matte colour of its own.
    pub(crate) fades: Option<(PlacedFade, Vec3)>,
    /// Bumps, seen from their front, and the place of the hit in their map.
    pub(crate) relief: Option<(Relief<'a>, Vec2)>,
}

impl<'a> HitPoint<'a> {
    /// Its reflectance.
    pub(crate) fn layers(&self) -> Layers<'a> {
        let layers = self.surface.layers().with_tables(self.tables);
        Layers { finish: Finish { clearcoat_normal: self.coat_normal, ..layers.finish }, ..layers }
    }

    /// Start of a shadow ray on the viewer's side of the surface.
    pub(crate) fn lifted(&self) -> Vec3 {
        self.position + self.geometric_normal * self.clearance
    }
}

impl<'a> TracedScene<'a> {
    pub(crate) fn new(scene: &'a Scene) -> Result<Self, ReferenceError> {
        let count = scene.triangle_count();
        if count > MAX_TRIANGLES {
            return Err(ReferenceError::TooManyTriangles(count));
        }
        let mut instances = Vec::new();
        let mut triangles = Vec::with_capacity(count);
        let pose = scene.pose();
        let tables: Vec<_> = scene.materials.iter().map(Material::reflectance_tables).collect();
        for placed in scene.instances() {
            let instance = instances.len() as u32;
            let world_from_mesh = placed.world_from_mesh;
            let deformed = scene.is_deformable(&placed).then(|| scene.world_vertices(&pose, &placed));
            let mesh = &scene.meshes[placed.mesh.0];
            for (index, triangle) in mesh.triangles.iter().enumerate() {
                let corners = triangle.map(|vertex| match &deformed {
                    Some(vertices) => vertices.positions[vertex as usize].into(),
                    None => world_from_mesh.transform_point3a(mesh.positions[vertex as usize].into()),
                });
                let [a, b, c] = corners;
                let doubled_area = (b - a).cross(c - a).length();
                // A triangle without area meets no ray, and one that is not finite would spoil the boxes above it.
                if doubled_area > 0.0 && doubled_area.is_finite() && corners.iter().all(|c| c.is_finite()) {
                    triangles.push(Triangle { corners, instance, index: index as u32 });
                }
            }
            // Deformed vertices are in world space already.
            let (normal_from_mesh, handedness) = match deformed {
                Some(_) => (Mat3::IDENTITY, 1.0),
                None => (normal_matrix(&world_from_mesh), mirror_sign(&world_from_mesh)),
            };
            instances.push(Instance {
                mesh: placed.mesh,
                tables: mesh.material.and_then(|material| tables[material.0].clone()),
                normal_from_mesh,
                handedness,
                has_alpha: scene.material(placed.mesh).alpha_mode != AlphaMode::Opaque,
                catches: scene.material(placed.mesh).catches,
                fades: scene.material(placed.mesh).fade.is_some(),
                deformed,
            });
        }
        let (bvh, triangles) = build(triangles);
        Ok(Self { scene, ground: scene.placed_fade(), instances, bvh, triangles })
    }

    /// The surface that a ray stops at: the nearest one, or one behind it where that lets rays through. Then `chance`, uniform in [0, 1),
    /// decides: what of it lies beyond a surface's opacity is the chance at those behind.
    pub(crate) fn closest_hit(&self, ray: &Ray, chance: f64) -> Option<Hit> {
        self.closest(ray, chance, |_| true)
    }

    /// The same among surfaces that block light.
    pub(crate) fn closest_caster(&self, ray: &Ray, chance: f64) -> Option<Hit> {
        self.closest(ray, chance, |index| !self.catches(index))
    }

    fn catches(&self, triangle: usize) -> bool {
        self.instances[self.triangles[triangle].instance as usize].catches
    }

    fn closest(&self, ray: &Ray, mut chance: f64, counts: impl Fn(usize) -> bool) -> Option<Hit> {
        let traversal = traversal_ray(ray)?;
        let mut passed = 0.0;
        loop {
            let mut nearest = RayHit::none();
            self.bvh.ray_traverse(traversal, &mut nearest, |traversal, index| {
                let met = self.met(ray, index).map(|(t, _)| t);
                let met = met.filter(|&t| t > passed && t < traversal.tmax);
                met.filter(|_| counts(index)).unwrap_or(f32::INFINITY)
            });
            let triangle = nearest.primitive_id;
            let (_, barycentrics) = self.triangles.get(triangle as usize)?.intersect(ray)?;
            let hit = Hit { triangle, barycentrics };
            let opacity = f64::from(self.opacity(&hit));
            if chance < opacity {
                return Some(hit);
            }
            chance = (chance - opacity) / (1.0 - opacity);
            passed = nearest.t;
        }
    }

    /// Share of the light along a ray that nothing stops before `distance` [m], which may be infinite.
    pub(crate) fn transmittance(&self, ray: &Ray, distance: f32) -> f32 {
        let Some(mut traversal) = traversal_ray(ray) else { return 1.0 };
        // A lamp may touch what it hangs on: that is behind its front.
        traversal.tmax = distance * (1.0 - END_CLEARANCE);
        let mut left = 1.0;
        let missed = self.bvh.ray_traverse_miss(traversal, |traversal, index| {
            match self.met(ray, index).filter(|_| !self.catches(index)) {
                Some((t, opacity)) if t < traversal.tmax && opacity < 1.0 => {
                    left *= 1.0 - opacity;
                    f32::INFINITY
                }
                met => met.map_or(f32::INFINITY, |(t, _)| t),
            }
        });
        if missed { left } else { 0.0 }
    }

    /// Everything about a hit that shading needs, for a viewer towards `wo`.
    pub(crate) fn hit_point(&self, hit: &Hit, wo: Vec3) -> HitPoint<'_> {
        let triangle = &self.triangles[hit.triangle as usize];
        let instance = &self.instances[triangle.instance as usize];
        let index = triangle.index as usize;
        let point = match &instance.deformed {
            Some(vertices) => self.scene.surface_in_world(instance.mesh, vertices, index, hit.barycentrics),
            None => self.scene.surface_at(instance.mesh, index, hit.barycentrics),
        };
        let [a, b, c] = triangle.corners;
        let geometric_normal = towards(wo, Vec3::from((b - a).cross(c - a).normalize_or(Vec3A::Y)));
        let to_world =
            |normal: Vec3| (instance.normal_from_mesh * normal).try_normalize().unwrap_or(geometric_normal);
        let (mut shading_normal, smooth_normal) =
            (to_world(point.shading_normal), to_world(point.smooth_normal));
        let relief = self.relief(triangle, smooth_normal, point.uvs);
        if let Some((relief, uv)) = &relief {
            let rise = relief.gradients.rise(relief.scale * relief.map.slope(*uv));
            shading_normal = bent_by_heights(shading_normal, smooth_normal, rise);
        }
        let is_front = smooth_normal.dot(geometric_normal) >= 0.0;
        let n = towards(geometric_normal, shading_normal);
        // The bitangent is the mesh's, whichever side is seen.
        let bitangent_sign = point.tangent.w * instance.handedness * n.dot(shading_normal);
        let tangent = instance.normal_from_mesh * point.tangent.truncate();
        let frame = Frame::from_tangent(n, tangent.extend(bitangent_sign));
        // Bumps bend the coat with them.
        let has_own_normal = point.surface.clearcoat > 0.0 && relief.is_none();
        let coat_normal = match has_own_normal {
            true => frame.local_from_world(towards(geometric_normal, to_world(point.coat_normal))),
            false => Vec3::Z,
        };
        let weights = hit.barycentrics;
        let largest = a.abs().max(b.abs()).max(c.abs()).max_element();
        HitPoint {
            position: (a * weights.x + b * weights.y + c * weights.z).into(),
            geometric_normal,
            frame,
            coat_normal,
            clearance: CLEARANCE * largest,
            surface: if instance.catches { Surface::default() } else { point.surface },
            tables: instance.tables.as_deref().filter(|_| !instance.catches),
            emissive: point.emissive,
            shines: self.scene.meshes[instance.mesh.0].shines,
            catches: instance.catches,
            fades: self
                .ground
                .filter(|_| instance.fades)
                .map(|ground| (ground, point.surface.layers().diffuse)),
            relief: relief.filter(|_| is_front),
        }
    }

    /// The heights around a point of a triangle, and its place in their map.
    fn relief(&self, triangle: &Triangle, n: Vec3, uvs: [Vec2; 2]) -> Option<(Relief<'a>, Vec2)> {
        let scene: &'a Scene = self.scene;
        let mesh = self.instances[triangle.instance as usize].mesh;
        let height = scene.material(mesh).height?;
        let of_mesh = &scene.meshes[mesh.0];
        let coordinates = of_mesh.uvs.get(height.set).filter(|set| !set.is_empty())?;
        let corner_uvs = of_mesh.triangles[triangle.index as usize]
            .map(|corner| height.transform(coordinates[corner as usize]));
        let gradients = Gradients::new(triangle.corners.map(Vec3::from), corner_uvs, n)?;
        let map = &*scene.height_maps[height.map.0];
        Some((Relief { map, scale: height.scale, gradients, n }, height.transform(uvs[height.set])))
    }

    /// Distance to a triangle, and its opacity there, where it has any.
    fn met(&self, ray: &Ray, index: usize) -> Option<(f32, f32)> {
        let (t, barycentrics) = self.triangles[index].intersect(ray)?;
        let opacity = self.opacity(&Hit { triangle: index as u32, barycentrics });
        (opacity > 0.0).then_some((t, opacity))
    }

    fn opacity(&self, hit: &Hit) -> f32 {
        let triangle = &self.triangles[hit.triangle as usize];
        let instance = &self.instances[triangle.instance as usize];
        match instance.has_alpha {
            true => self.scene.opacity_at(instance.mesh, triangle.index as usize, hit.barycentrics),
            false => 1.0,
        }
    }
}

/// Interpolating a point of a triangle errs by at most 8 roundings of the largest coordinate; twice that is safe.
const CLEARANCE: f32 = 16.0 * f32::EPSILON;

/// Share of a shadow ray's length that is left free before a light: rounding at grazing angles, where distances lose digits.
const END_CLEARANCE: f32 = 1e-4;

/// `normal` or its opposite, whichever is on the side of `side`.
fn towards(side: Vec3, normal: Vec3) -> Vec3 {
    if normal.dot(side) < 0.0 { -normal } else { normal }
}

/// The ray as the BVH wants it; `None` unless it is finite.
fn traversal_ray(ray: &Ray) -> Option<obvhs::ray::Ray> {
    let finite = ray.origin.is_finite() && ray.direction.is_finite();
    finite.then(|| obvhs::ray::Ray::new_inf(ray.origin.into(), ray.direction.into()))
}

impl Triangle {
    /// Distance and barycentrics of the hit, from both sides.
    ///
    /// The signs of the ray's Pluecker products with the three edges decide (as in Embree's robust mode): neighbours compute the
    /// same number for a shared edge but for its sign, so no ray passes between them.
    fn intersect(&self, ray: &Ray) -> Option<(f32, Vec3)> {
        let (origin, direction) = (Vec3A::from(ray.origin), Vec3A::from(ray.direction));
        let [v0, v1, v2] = self.corners.map(|corner| corner - origin);
        let (e0, e1, e2) = (v2 - v0, v0 - v1, v1 - v2);
        let u = e0.cross(v2 + v0).dot(direction);
        let v = e1.cross(v0 + v1).dot(direction);
        let w = e2.cross(v1 + v2).dot(direction);
        let sum = u + v + w;
        // Signs agree along an edge but not always around a corner, where all three may round the wrong way.
        let rounding = f32::EPSILON * sum.abs();
        if u.min(v).min(w) < -rounding && u.max(v).max(w) > rounding {
            return None;
        }
        let normal = e1.cross(e0);
        let denominator = normal.dot(direction);
        if sum == 0.0 || denominator == 0.0 {
            return None;
        }
        let numerator = v0.dot(normal);
        // A ray that starts in the triangle's plane, up to the rounding of this product, does not meet it again.
        if numerator.abs() <= 4.0 * f32::EPSILON * v0.abs().dot(normal.abs()) {
            return None;
        }
        let t = numerator / denominator;
        (t > 0.0 && t.is_finite()).then(|| (t, Vec3::new(w, u, v) / sum))
    }
}

/// The BVH, and the triangles in the order of its leaves.
fn build(triangles: Vec<Triangle>) -> (Bvh2, Vec<Triangle>) {
    // The slab test rounds; boxes a little larger than their triangles make it conservative.
    let largest = triangles
        .iter()
        .flat_map(|t| t.corners)
        .fold(0.0f32, |largest, c| largest.max(c.abs().max_element()));
    let pad = Vec3A::splat((4.0 * f32::EPSILON * largest).max(f32::MIN_POSITIVE));
    let boxes: Vec<Aabb> = triangles
        .iter()
        .map(|Triangle { corners: [a, b, c], .. }| Aabb {
            min: a.min(*b).min(*c) - pad,
            max: a.max(*b).max(*c) + pad,
        })
        .collect();
    let indices = (0..triangles.len() as u32).collect();
    let mut bvh = PlocBuilder::with_capacity(boxes.len()).build(
        PlocSearchDistance::Medium,
        &boxes,
        indices,
        SortPrecision::U64,
        SEARCH_DEPTH,
    );
    let mut optimizer = ReinsertionOptimizer::default();
    optimizer.run(&mut bvh, REINSERTION_RATIO, None);
    collapse(&mut bvh, MAX_LEAF_TRIANGLES, TRAVERSAL_COST);
    let ordered = bvh.primitive_indices.iter().map(|&index| triangles[index as usize]).collect();
    (bvh, ordered)
}

/// `obvhs`'s own settings for a medium build, which takes 0.1 s for 70,000 triangles.
const SEARCH_DEPTH: usize = 3;
const REINSERTION_RATIO: f32 = 0.05;
const MAX_LEAF_TRIANGLES: u32 = 8;
const TRAVERSAL_COST: f32 = 3.0;

#[cfg(test)]
mod tests;
