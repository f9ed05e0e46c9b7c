use std::f32::consts::PI;

use glam::{Mat4, Vec2, Vec3, Vec4};
use gnomon_scene::{AreaLightShape, PlacedLight, Spread};
use gnomon_shaders::layout;

use crate::casters::{PlacedBox, PlacedBoxes};
use crate::light_frame::MARGIN_TEXELS;

/// Tangent of half the widest field of view of a map, 150 degrees: beyond it texels at the rim grow too coarse. What lies outside
/// is lit.
const MAX_TANGENT: f32 = 3.732_05;

/// Nearest a near plane comes to the light, as a share of the distance to the far plane, and of the light's half extent: what is
/// nearer than half the light is wide casts no shadow that a map from its centre could tell.
const NEAREST_OF_FAR: f32 = 0.01;
const NEAREST_OF_EXTENT: f32 = 0.5;

/// A light in the scene as shaders see it, its perspective shadow map fitted around what casts shadows as seen from its
/// centre.
pub(crate) fn near_light_uniform(
    light: &PlacedLight,
    scene: &PlacedBoxes,
    resolution: u32,
    normal_offset_texels: f32,
) -> layout::Light {
    let half_extent = light.shape.half_extent();
    let [tangent, bitangent, axis] = map_axes(light, scene);
    let frustum = Frustum::around(light, scene, [tangent, bitangent, axis]);
    let Frustum { near, far, center, half_side } = frustum;
    let resolution = resolution as f32;
    let map_width = 2.0 * half_side * resolution / (resolution - 2.0 * MARGIN_TEXELS);

    // Rows: x and y to [-w, w] for what is inside, z to [0, w], w the distance along the axis.
    let scale = 2.0 / map_width;
    let row = |v: Vec3, offset: f32| v.extend(offset - v.dot(light.center));
    let depth = far / (far - near);
    let light_from_world = Mat4::from_cols(
        row((tangent - axis * center.x) * scale, 0.0),
        row((bitangent - axis * center.y) * scale, 0.0),
        row(axis * depth, -near * depth),
        row(axis, 0.0),
    )
    .transpose();

    let (kind, shape, seen_area) = match light.shape {
        AreaLightShape::Sphere { radius } => (layout::KIND_SPHERE, layout::SHAPE_DISK, PI * radius * radius),
        AreaLightShape::Disk { .. } | AreaLightShape::Sun { .. } => {
            (layout::KIND_FLAT, layout::SHAPE_DISK, light.shape.area())
        }
        AreaLightShape::Rectangle { .. } => (layout::KIND_FLAT, layout::SHAPE_RECTANGLE, light.shape.area()),
    };
    let (profile_end, values) = light.spread.profile();
    let (across, along) = (tangent * half_extent.x, bitangent * half_extent.y);
    let corners = [-across - along, along - across, across + along, across - along];
    layout::Light {
        direction: -axis,
        shape,
        tangent,
        angular_radius: if shape == layout::SHAPE_DISK { half_extent.x.atan() } else { 0.0 },
        bitangent,
        solid_angle: seen_area,
        radiance: light.radiance,
        corners: corners.map(|corner| (corner - axis).normalize().extend(0.0)),
        light_from_world,
        map_width_world: map_width,
        depth_range_world: far - near,
        normal_offset_world: normal_offset_texels * map_width / resolution,
        near_world: near,
        position: light.center,
        kind,
        half_extent,
        role: layout::ROLE_LIGHT,
        caster_deviation_world: 0.0,
        from_distance: 0.0,
        to_distance: f32::MAX,
        bias_scale: 1.0,
        vector_irradiance: Vec3::ZERO,
        number: 0,
        group: 0,
        front: light.normal,
        profile_end,
        profile: std::array::from_fn(|i| Vec4::from_slice(&values[4 * i..])),
        cone: light.spread.cone(),
    }
}

/// Tangent, bitangent and axis of the map. A flat light's and a spot's own; a sphere looks where most of the scene lies, or down.
fn map_axes(light: &PlacedLight, scene: &PlacedBoxes) -> [Vec3; 3] {
    if light.spread != Spread::Even || !matches!(light.shape, AreaLightShape::Sphere { .. }) {
        return [light.tangent, light.bitangent, light.normal];
    }
    let mean: Vec3 = scene.corners().map(|corner| (corner - light.center).normalize_or_zero()).sum();
    let axis = mean.try_normalize().unwrap_or(Vec3::NEG_Y);
    let tangent = axis.any_orthonormal_vector();
    [tangent, tangent.cross(axis), axis]
}

/// A square pyramid from the light's centre, cut off at both ends.
struct Frustum {
    /// Distances along the axis [m].
    near: f32,
    far: f32,
    /// Middle and half side of the map on the plane one metre away [m].
    center: Vec2,
    half_side: f32,
}

impl Frustum {
    fn around(light: &PlacedLight, scene: &PlacedBoxes, axes: [Vec3; 3]) -> Self {
        let local = |corner: Vec3| Vec3::from(axes.map(|axis| axis.dot(corner - light.center)));
        let depths = scene.corners().map(|corner| local(corner).z);
        let far = depths.fold(0.0, f32::max);
        // Nothing in front: any finite frame will do.
        let far = if far > 0.0 && far.is_finite() { 1.001 * far } else { 2.0 };
        let extent = light.shape.half_extent().max_element();
        let share =
            if matches!(light.shape, AreaLightShape::Sphere { .. }) { 1.0 } else { NEAREST_OF_EXTENT };
        let floor = (NEAREST_OF_FAR * far).max(share * extent).min(0.5 * far);
        let blockers: Vec<[Vec3; 8]> =
            blockers(light, scene).iter().map(|place| place.corners.map(local)).collect();
        let nearest = blockers.iter().flatten().map(|corner| corner.z).fold(f32::INFINITY, f32::min);
        let near = (0.999 * nearest).clamp(floor, 0.9 * far);

        let widest = Vec2::splat(match light.spread {
            Spread::Cone { outer, .. } if outer < 0.5 * PI => outer.tan().min(MAX_TANGENT),
            _ => MAX_TANGENT,
        });
        let (mut min, mut max) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
        for place in blockers.iter().flat_map(|corners| in_front(corners, near)) {
            // Around a blocker's outline lies half a penumbra, at most that on the farthest receiver.
            let penumbra = Vec2::splat(extent * (1.0 / place.z - 1.0 / far).max(0.0));
            let place = place.truncate() / place.z;
            min = min.min((place - penumbra).clamp(-widest, widest));
            max = max.max((place + penumbra).clamp(-widest, widest));
        }
        if !(max - min).is_finite() {
            (min, max) = (Vec2::splat(-1.0), Vec2::ONE);
        }
        let half_side = (0.5 * (max - min).max_element()).max(1e-4);
        Self { near, far, center: 0.5 * (min + max), half_side }
    }
}

/// The boxes without the planes, such as a ground, that have the light and everything else on one side: those block nothing, and what
/// lies outside the map is lit.
fn blockers<'b>(light: &PlacedLight, scene: &'b PlacedBoxes) -> Vec<&'b PlacedBox> {
    let blocks = |place: &&PlacedBox| {
        place.ground.is_none_or(|ground| {
            let height = ground.normal.dot(light.center - ground.center);
            height.abs() <= scene.tolerance || !ground.bears_towards(height * ground.normal)
        })
    };
    let blocking: Vec<&PlacedBox> = scene.boxes.iter().filter(|place| place.casts && blocks(place)).collect();
    if blocking.is_empty() { scene.boxes.iter().collect() } else { blocking }
}

/// Of the eight corners of a box those beyond the plane at distance `near`, and where its edges meet that plane.
fn in_front(corners: &[Vec3], near: f32) -> impl Iterator<Item = Vec3> {
    let edges = (0..corners.len()).flat_map(|from| (0..3).map(move |axis| (from, from ^ (1 << axis))));
    edges.filter_map(move |(from, to)| {
        let (a, b) = (corners[from], corners[to]);
        match (a.z >= near, b.z >= near) {
            (true, _) => Some(a),
            (false, true) => Some(a.lerp(b, (near - a.z) / (b.z - a.z)).with_z(near)),
            (false, false) => None,
        }
    })
}

#[cfg(test)]
mod tests {
    use glam::Affine3A;
    use gnomon_scene::Bounds;

    use super::*;
    use crate::casters::InstanceBox;

    fn boxes() -> Vec<InstanceBox> {
        vec![InstanceBox {
            bounds: Bounds { min: Vec3::new(-1.0, 0.0, -2.0), max: Vec3::new(1.0, 1.5, 2.0) },
            indices: None,
            simpler: Vec::new(),
            instance: 0,
            placement: 0,
            world_from_mesh: Affine3A::from_rotation_y(0.7),
            casts: true,
        }]
    }

    fn lamp(shape: AreaLightShape, center: Vec3) -> PlacedLight {
        let normal = Vec3::new(0.1, -1.0, 0.2).normalize();
        let tangent = normal.any_orthonormal_vector();
        let bitangent = tangent.cross(normal);
        PlacedLight {
            shape,
            center,
            normal,
            tangent,
            bitangent,
            radiance: Vec3::ONE,
            spread: Default::default(),
        }
    }

    const SHAPES: [AreaLightShape; 3] = [
        AreaLightShape::Disk { radius: 0.2 },
        AreaLightShape::Rectangle { size: Vec2::new(0.4, 0.1) },
        AreaLightShape::Sphere { radius: 0.2 },
    ];

    #[test]
    fn the_whole_scene_lies_inside_the_map_of_a_light_above_it() {
        for shape in SHAPES {
            let light = lamp(shape, Vec3::new(0.3, 4.0, -0.2));
            let uniform = near_light_uniform(&light, &PlacedBoxes::new(&boxes()), 256, 1.0);
            let light_from_world = uniform.light_from_world;
            let axis = -uniform.direction;
            for corner in boxes().iter().flat_map(|b| b.corners()) {
                let p = light_from_world * corner.extend(1.0);
                assert!((p.w - axis.dot(corner - light.center)).abs() < 1e-5, "{shape:?}");
                assert!(p.w > uniform.near_world && p.w < uniform.near_world + uniform.depth_range_world);
                let ndc = p.truncate() / p.w;
                assert!(ndc.truncate().abs().max_element() < 1.0 && ndc.z > 0.0 && ndc.z < 1.0, "{ndc}");
            }
            // A tenth of a metre aside on the plane one metre away.
            let tangent = uniform.tangent;
            let step = light_from_world * (light.center + axis + 0.1 * tangent).extend(1.0)
                - light_from_world * (light.center + axis).extend(1.0);
            assert!((step.x - 0.2 / uniform.map_width_world).abs() < 1e-5);
        }
    }

    #[test]
    fn maps_are_finite_wherever_the_light_is() {
        for center in
            [Vec3::ZERO, Vec3::new(0.0, 0.7, 0.0), Vec3::new(0.0, -5.0, 0.0), Vec3::new(1e6, 1.0, 0.0)]
        {
            for shape in SHAPES {
                for boxes in [boxes(), Vec::new()] {
                    let scene = PlacedBoxes::new(&boxes);
                    let uniform = near_light_uniform(&lamp(shape, center), &scene, 64, 1.0);
                    assert!(uniform.light_from_world.is_finite(), "{shape:?} {center}");
                    assert!(uniform.near_world > 0.0 && uniform.depth_range_world > 0.0);
                    assert!(uniform.map_width_world > 0.0 && uniform.map_width_world < 10.0);
                }
            }
        }
    }

    #[test]
    fn a_ground_takes_no_part_of_the_map() {
        let ground = InstanceBox {
            indices: None,
            simpler: Vec::new(),
            bounds: Bounds { min: Vec3::new(-9.0, 0.0, -9.0), max: Vec3::new(9.0, 0.0, 9.0) },
            instance: 1,
            placement: 0,
            world_from_mesh: Affine3A::IDENTITY,
            casts: true,
        };
        let light = lamp(SHAPES[0], Vec3::new(0.3, 4.0, -0.2));
        let framed = |boxes: &[InstanceBox]| near_light_uniform(&light, &PlacedBoxes::new(boxes), 256, 1.0);
        let with = framed(&[boxes(), vec![ground.clone()]].concat());
        let alone = framed(&[ground]);
        assert!(with.map_width_world < 0.6 * alone.map_width_world);
        // Its depths are in the map's range nevertheless.
        assert!(with.near_world + with.depth_range_world > 5.0);
    }

    #[test]
    fn a_light_inside_the_scene_sees_what_is_in_front_of_it() {
        let light = lamp(SHAPES[0], Vec3::new(0.0, 0.7, 0.0));
        let uniform = near_light_uniform(&light, &PlacedBoxes::new(&boxes()), 256, 1.0);
        // The box reaches past the widest field of view.
        assert!((uniform.map_width_world / (2.0 * MAX_TANGENT) - 1.0).abs() < 0.05);
        assert!(uniform.near_world >= 0.1);
    }
}
