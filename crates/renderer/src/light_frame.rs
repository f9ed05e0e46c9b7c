use glam::{Mat4, Vec2, Vec3, Vec4};
use gnomon_lights::{DistantLight, LightShape};
use gnomon_shaders::layout;

use crate::geometry::InstanceBox;

/// Texels left free around the scene in every shadow map, so that clamped lookups at the border find no blocker.
const MARGIN_TEXELS: f32 = 2.0;

/// Variance, in squared texels of its level, of a bilinear lookup in the mip chain: 1/4 from the chain's kernel
/// [1 3 3 1] / 8 and 1/6 on average from the interpolation.
const LOOKUP_VARIANCE: f32 = 1.0 / 4.0 + 1.0 / 6.0;

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

/// The light as shaders see it, its shadow map fitted around the scene.
pub(crate) fn light_uniform(
    light: &DistantLight,
    boxes: &[InstanceBox],
    resolution: u32,
    normal_offset_texels: f32,
) -> layout::Light {
    let axes = [light.tangent, light.bitangent, light.direction];
    let (mut min, mut max) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for corner in boxes.iter().flat_map(InstanceBox::corners) {
        let p = Vec3::from(axes.map(|axis| axis.dot(corner)));
        min = min.min(p);
        max = max.max(p);
    }
    if !(max - min).is_finite() || boxes.is_empty() {
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

    let (shape, angular_radius, corners) = match light.shape {
        LightShape::Disk { angular_radius } => (layout::SHAPE_DISK, angular_radius, [[0.0; 4]; 4]),
        LightShape::Rectangle { corners } => {
            (layout::SHAPE_RECTANGLE, 0.0, corners.map(|corner| corner.extend(0.0).to_array()))
        }
    };
    layout::Light {
        direction: light.direction.to_array(),
        shape,
        tangent: light.tangent.to_array(),
        angular_radius,
        bitangent: light.bitangent.to_array(),
        solid_angle: light.solid_angle,
        radiance: light.radiance.to_array(),
        footprint: footprint(light),
        corners,
        light_from_world: light_from_world.to_cols_array_2d(),
        map_width_world: map_width,
        depth_range_world: range,
        normal_offset_world: normal_offset_texels * map_width / resolution,
        padding: 0.0,
    }
}

#[cfg(test)]
mod tests {
    use glam::{Affine3A, DVec3};

    use super::*;

    fn boxes() -> Vec<InstanceBox> {
        vec![InstanceBox {
            min: Vec3::new(-1.0, 0.0, -2.0),
            max: Vec3::new(1.0, 3.0, 2.0),
            world_from_mesh: Affine3A::from_rotation_y(0.7),
        }]
    }

    #[test]
    fn the_whole_scene_lies_inside_the_map_and_nearer_points_are_shallower() {
        let light = DistantLight::disk(DVec3::new(0.3, 0.8, -0.5).normalize(), 0.1, DVec3::ONE);
        let uniform = light_uniform(&light, &boxes(), 256, 1.0);
        let light_from_world = Mat4::from_cols_array_2d(&uniform.light_from_world);
        for corner in boxes().iter().flat_map(|b| b.corners().collect::<Vec<_>>()) {
            let p = light_from_world.transform_point3(corner);
            assert!(p.truncate().abs().max_element() < 1.0 && p.z > 0.0 && p.z < 1.0, "{p}");
            let towards = light_from_world.transform_point3(corner + 0.1 * light.direction);
            let step = (p.z - towards.z) * uniform.depth_range_world;
            assert!((step - 0.1).abs() < 1e-5 && (towards - p).truncate().length() < 1e-5);
        }
    }

    #[test]
    fn a_scene_without_triangles_still_gives_a_finite_frame() {
        let light = DistantLight::disk(DVec3::Y, 0.1, DVec3::ONE);
        let uniform = light_uniform(&light, &[], 64, 1.0);
        assert!(bytemuck::cast_slice::<_, f32>(&uniform.light_from_world).iter().all(|v| v.is_finite()));
    }
}
