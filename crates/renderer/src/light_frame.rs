use glam::{Mat4, Vec2, Vec3, Vec4};
use gnomon_lights::form_factor::rectangle_vector_irradiance;
use gnomon_lights::{DistantLight, LightShape};
use gnomon_scene::{Bounds, Spread};
use gnomon_shaders::layout;

use crate::casters::PlacedBoxes;
use crate::ground::Ground;
use crate::view_slices::ViewSlice;

/// Texels left free around the scene in every shadow map, so that clamped lookups at the border find no blocker.
pub(crate) const MARGIN_TEXELS: f32 = 2.0;

/// Widest margin for penumbrae around the models, as a share of their width in the map.
const MAX_PENUMBRA_MARGIN: f32 = 0.25;

/// Greatest deviation of simpler meshes, as a share of [`footprint`] at the depth of the map: some hundredth of the widest penumbra.
const OF_FOOTPRINT: f32 = 0.02;

/// Variance, in squared texels of its level, of a bilinear lookup in the mip chain: 1/4 from the chain's kernel
/// [1 3 3 1] / 8 and 1/6 on average from the interpolation.
pub(crate) const LOOKUP_VARIANCE: f32 = 1.0 / 4.0 + 1.0 / 6.0;

/// Width, per metre of blocker distance, of the mip texel whose bilinear lookup has the outline's variance: a disk of radius r
/// has r^2 / 4 along each axis, a box of half widths a, b has (a^2 + b^2) / 6 on average.
pub(crate) fn footprint(light: &DistantLight) -> f32 {
    let half = light.tan_half_extent();
    let variance = match light.shape {
        LightShape::Disk { .. } => half.x * half.x / 4.0,
        LightShape::Rectangle { .. } => half.length_squared() / 6.0,
    };
    (variance / LOOKUP_VARIANCE).sqrt()
}

/// What simpler meshes drawn into the light's map may deviate by: so many texels, and no more than a share of the widest penumbra, so
/// that sharp edges stay as they are [m].
pub(crate) fn hidden_deviation(
    light: &DistantLight,
    uniform: &layout::Light,
    resolution: u32,
    texels: f32,
) -> f32 {
    let texel = uniform.map_width_world / resolution as f32;
    (texels * texel).min(OF_FOOTPRINT * footprint(light) * uniform.depth_range_world)
}

/// What a light's shadow map has to hold.
struct Extent {
    /// Corners along tangent, bitangent and `depth_axis` [m].
    min: Vec3,
    max: Vec3,
    /// Depth is measured along this vector; a metre along the light is a metre of depth.
    depth_axis: Vec3,
}

/// A plane such as a ground that has everything else on one side neither needs to be in the map to receive shadows nor, where
/// the light shines on that side, to cast them: what lies outside the map is lit. That leaves the map's texels and depths
/// to the models.
fn extent(light: &DistantLight, scene: &PlacedBoxes, seen: &ViewSlice) -> Extent {
    let mut held: Vec<Vec3> = Vec::new();
    let mut blocking = Vec::new();
    let is_lit = |ground: &Ground| ground.bears_towards(light.direction);
    let receives_outside =
        scene.boxes.iter().any(|place| !place.casts || place.ground.as_ref().is_some_and(is_lit));
    for place in &scene.boxes {
        match &place.ground {
            _ if !place.casts => {}
            Some(ground) if is_lit(ground) => {}
            // A roof over it blocks beside the models, too.
            Some(ground) if !receives_outside && ground.bears_towards(-light.direction) => {
                blocking.push((ground, &place.corners));
            }
            _ => held.extend(place.corners),
        }
    }
    if held.is_empty() {
        held = scene.corners().collect();
    }
    let (tangent, bitangent, direction) = (light.tangent, light.bitangent, light.direction);
    let (mut min, mut max) =
        Bounds::around(held.iter().map(|p| Vec3::new(tangent.dot(*p), bitangent.dot(*p), 0.0)))
            .map_or((Vec3::ZERO, Vec3::ONE), |around| (around.min, around.max));
    // Where receivers lie outside the map: around the models' outline is half a penumbra, as wide as the models are deep, and no
    // wider than leaves them their texels.
    if held.len() < 8 * scene.boxes.len() {
        let (front, back) = range_of(held.iter().map(|p| direction.dot(*p))).unwrap_or((0.0, 0.0));
        let penumbra = (light.tan_half_extent() * (back - front)).extend(0.0);
        let penumbra = penumbra.min(MAX_PENUMBRA_MARGIN * (max - min));
        min -= penumbra;
        max += penumbra;
    }
    if let Some(around) = seen.around {
        // Receivers are what is seen; what blocks their light lies no farther beside them than half a penumbra.
        let places = around.map(|p| Vec3::new(tangent.dot(p), bitangent.dot(p), 0.0));
        let [low, high] = places.iter().fold([Vec3::INFINITY, Vec3::NEG_INFINITY], |[low, high], place| {
            [low.min(*place), high.max(*place)]
        });
        let (front, back) = range_of(held.iter().map(|p| direction.dot(*p))).unwrap_or((0.0, 0.0));
        let penumbra = (light.tan_half_extent() * (back - front)).extend(0.0);
        let penumbra = penumbra.min(MAX_PENUMBRA_MARGIN * (high - low));
        min = min.max(low - penumbra);
        max = max.min(high + penumbra).max(min);
    }

    let depths = |axis: Vec3| {
        let (mut near, mut far) = range_of(held.iter().map(|p| axis.dot(*p))).unwrap_or((0.0, 1.0));
        for (ground, own) in &blocking {
            // Only what lies before the map blocks anything in it.
            let whole = range_of(own.iter().map(|p| axis.dot(*p))).unwrap_or((near, far));
            let over_map = range_of(
                [(min.x, min.y), (min.x, max.y), (max.x, min.y), (max.x, max.y)].into_iter().map(|(u, v)| {
                    let p = u * tangent + v * bitangent;
                    axis.dot(
                        p + direction
                            * ((ground.center - p).dot(ground.normal) / ground.normal.dot(direction)),
                    )
                }),
            )
            .filter(|(low, high)| low.is_finite() && high.is_finite())
            .unwrap_or(whole);
            near = near.min(over_map.0.max(whole.0));
            far = far.max(over_map.1.min(whole.1));
        }
        (near, far)
    };
    // Across a plane that blocks the light from the other side the plane itself has one depth, and nothing that touches it
    // leaks. From the lit side of a ground, walls would pay for that with self-shadows.
    let axes = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| axis / axis.dot(direction));
    let (depth_axis, (near, far)) =
        (axes.into_iter().filter(|axis| axis.is_finite() && !blocking.is_empty()))
            .map(|axis| (axis, depths(axis)))
            .fold((direction, depths(direction)), |best, next| {
                if next.1.1 - next.1.0 < best.1.1 - best.1.0 { next } else { best }
            });
    Extent { min: min.with_z(near), max: max.with_z(far), depth_axis }
}

fn range_of(values: impl Iterator<Item = f32>) -> Option<(f32, f32)> {
    values.map(|v| (v, v)).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
}

/// The light as shaders see it, its shadow map fitted around the scene.
pub(crate) fn light_uniform(
    light: &DistantLight,
    scene: &PlacedBoxes,
    seen: &ViewSlice,
    resolution: u32,
    normal_offset_texels: f32,
) -> layout::Light {
    let Extent { mut min, mut max, depth_axis } = extent(light, scene, seen);
    let axes = [light.tangent, light.bitangent, depth_axis];
    if !(max - min).is_finite() {
        (min, max) = (Vec3::ZERO, Vec3::ONE);
    }
    let resolution = resolution as f32;
    let extent = (max - min).max_element().max(1e-6);
    let side = (max - min).truncate().max_element().max(1e-3 * extent);
    let map_width = side * resolution / (resolution - 2.0 * MARGIN_TEXELS);
    // A little air before the first and behind the last point keeps both inside the clip volume.
    let range = 1.002 * (max.z - min.z) + 1e-3 * extent;
    let near = 0.5 * (max.z + min.z) + 0.5 * range;
    let center = Vec2::new(0.5 * (min.x + max.x), 0.5 * (min.y + max.y));

    // Rows: x and y to [-1, 1], z from 0 at the near plane (towards the light) to 1.
    let scale = 2.0 / map_width;
    let light_from_world = Mat4::from_cols(
        (axes[0] * scale).extend(-center.x * scale),
        (axes[1] * scale).extend(-center.y * scale),
        (-axes[2] / range).extend(near / range),
        Vec4::W,
    )
    .transpose();

    let vector_irradiance = match light.shape {
        LightShape::Disk { .. } => Vec3::ZERO,
        LightShape::Rectangle { corners } => rectangle_vector_irradiance(corners),
    };
    let (shape, angular_radius, corners) = match light.shape {
        LightShape::Disk { angular_radius } => (layout::SHAPE_DISK, angular_radius, [Vec4::ZERO; 4]),
        LightShape::Rectangle { corners } => {
            (layout::SHAPE_RECTANGLE, 0.0, corners.map(|corner| corner.extend(0.0)))
        }
    };
    layout::Light {
        direction: light.direction,
        shape,
        tangent: light.tangent,
        angular_radius,
        bitangent: light.bitangent,
        solid_angle: light.solid_angle,
        radiance: light.radiance,
        corners,
        light_from_world,
        map_width_world: map_width,
        depth_range_world: range,
        normal_offset_world: normal_offset_texels * map_width / resolution,
        near_world: 0.0,
        position: Vec3::ZERO,
        kind: layout::KIND_DISTANT,
        half_extent: light.tan_half_extent(),
        role: layout::ROLE_LIGHT,
        caster_deviation_world: 0.0,
        from_distance: seen.distance[0],
        to_distance: seen.distance[1],
        bias_scale: if seen.around.is_some() { (map_width / range).min(1.0) } else { 1.0 },
        vector_irradiance,
        number: 0,
        group: 0,
        front: Vec3::ZERO,
        profile_end: 0.0,
        profile: [Vec4::ZERO; 6],
        cone: Spread::Even.cone(),
    }
}

#[cfg(test)]
mod tests {
    use glam::{Affine3A, DVec3};

    use super::*;
    use crate::casters::InstanceBox;

    fn boxes() -> PlacedBoxes {
        PlacedBoxes::new(&[InstanceBox {
            bounds: Bounds { min: Vec3::new(-1.0, 0.0, -2.0), max: Vec3::new(1.0, 3.0, 2.0) },
            indices: None,
            simpler: Vec::new(),
            instance: 0,
            placement: 0,
            world_from_mesh: Affine3A::from_rotation_y(0.7),
            casts: true,
        }])
    }

    #[test]
    fn the_whole_scene_lies_inside_the_map_and_nearer_points_are_shallower() {
        let light = DistantLight::disk(DVec3::new(0.3, 0.8, -0.5).normalize(), 0.1, DVec3::ONE);
        let uniform = light_uniform(&light, &boxes(), &ViewSlice::WHOLE, 256, 1.0);
        let light_from_world = uniform.light_from_world;
        for corner in boxes().corners() {
            let p = light_from_world.transform_point3(corner);
            assert!(p.truncate().abs().max_element() < 1.0 && p.z > 0.0 && p.z < 1.0, "{p}");
            let towards = light_from_world.transform_point3(corner + 0.1 * light.direction);
            let step = (p.z - towards.z) * uniform.depth_range_world;
            assert!((step - 0.1).abs() < 1e-5 && (towards - p).truncate().length() < 1e-5);
        }
    }

    #[test]
    fn a_roof_over_a_ground_lies_in_the_map() {
        let place = |min: Vec3, max: Vec3| crate::casters::tests::placed(min, max);
        let p = Vec3::new;
        let model = place(p(-0.3, 0.0, -0.3), p(0.3, 0.6, 0.3));
        let [floor, roof] =
            [(-3.0, 0.0), (1.0, 1.0)].map(|(from, y)| place(p(from, y, -3.0), p(3.0, y, 3.0)));
        let boxes = PlacedBoxes::new(&[floor, model, roof]);
        let light = DistantLight::disk(DVec3::new(0.2, 0.9, 0.1).normalize(), 0.05, DVec3::ONE);
        let uniform = light_uniform(&light, &boxes, &ViewSlice::WHOLE, 256, 1.0);
        let corner = uniform.light_from_world.transform_point3(p(3.0, 1.0, 3.0));
        assert!(corner.abs().max_element() < 1.0, "{corner}");
    }

    #[test]
    fn a_scene_without_triangles_still_gives_a_finite_frame() {
        let light = DistantLight::disk(DVec3::Y, 0.1, DVec3::ONE);
        let uniform = light_uniform(&light, &PlacedBoxes::default(), &ViewSlice::WHOLE, 64, 1.0);
        assert!(uniform.light_from_world.is_finite());
    }
}
