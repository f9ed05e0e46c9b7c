//! Points of lights that shadow rays go to.

use glam::{Vec2, Vec3};
use gnomon_envmap::Equirect;
use gnomon_lights::{DistantLight, LightShape};
use gnomon_picture::LUMINANCE;
use gnomon_scene::{AreaLightShape, PlacedLight};
use gnomon_shaders::layout;
use rayon::prelude::*;

use crate::Gpu;
use crate::light_uniforms::{FrameLight, distant};

/// Of one light, on the plane that its tangents span about its centre: at a distance of 1 of a distant light, in metres of one in the scene.
/// Any 4, 8, 16 that follow a multiple of their number are spread over the whole light.
pub(crate) type LightPoints = [Vec2; layout::LIGHT_POINTS as usize];

/// Cells along each side of the grid over a light's outline that tells where its light comes from.
const GRID: usize = 48;

/// Texels across a map that points are chosen by.
const SOURCE_WIDTH: u32 = 2048;

/// What of a map tells where light comes from.
pub(crate) fn source(map: &Equirect) -> Equirect {
    match map.width() > SOURCE_WIDTH {
        true => map.resized(SOURCE_WIDTH, SOURCE_WIDTH / 2),
        false => map.clone(),
    }
}

/// Points of lights that stand for the parts of a map that they cover: the brighter a place, the more of them.
pub(crate) fn of_cells(lights: &[DistantLight], map: &Equirect) -> Vec<LightPoints> {
    let radiance = |direction: Vec3| map.lookup(direction).dot(LUMINANCE);
    lights.par_iter().map(|light| of_distant(light, &radiance)).collect()
}

/// Points of a distant light from each of which comes as much of its light, if it has this radiance.
pub(crate) fn of_distant(light: &DistantLight, radiance: &dyn Fn(Vec3) -> f32) -> LightPoints {
    let place = |s: f32, t: f32| match light.shape {
        LightShape::Disk { angular_radius } => disk_place(s, t) * angular_radius.tan(),
        LightShape::Rectangle { corners } => {
            let on_plane = corners.map(|corner| {
                Vec2::new(corner.dot(light.tangent), corner.dot(light.bitangent))
                    / corner.dot(light.direction)
            });
            let [a, b, c, d] = on_plane;
            a.lerp(b, s).lerp(d.lerp(c, s), t)
        }
    };
    let step = 1.0 / GRID as f32;
    let middle = |i: usize| (i as f32 + 0.5) * step;
    let weight = |i: usize, j: usize| {
        let (s, t) = (middle(i), middle(j));
        let at = place(s, t);
        // A piece of the plane, as the scene sees it.
        let (across, along) = (
            place(s + 0.5 * step, t) - place(s - 0.5 * step, t),
            place(s, t + 0.5 * step) - place(s, t - 0.5 * step),
        );
        let direction = light.direction + at.x * light.tangent + at.y * light.bitangent;
        let distance = direction.length();
        across.perp_dot(along).abs() / distance.powi(3) * radiance(direction / distance).max(0.0)
    };
    let rows: Vec<Vec<f32>> = (0..GRID).map(|j| (0..GRID).map(|i| weight(i, j)).collect()).collect();
    let sums: Vec<f32> = rows.iter().map(|row| row.iter().sum()).collect();
    std::array::from_fn(|i| {
        let [u, v] = sobol(i as u32, layout::LIGHT_POINTS);
        let (row, t) = chosen(&sums, v);
        let (column, s) = chosen(&rows[row], u);
        place((column as f32 + s) * step, (row as f32 + t) * step)
    })
}

/// Mean of the directions to points of a distant light: its length tells how far they lie apart.
pub(crate) fn mean_direction(light: &DistantLight, points: &LightPoints) -> Vec3 {
    let towards = |at: &Vec2| (light.direction + at.x * light.tangent + at.y * light.bitangent).normalize();
    points.iter().map(towards).sum::<Vec3>() / points.len() as f32
}

/// Points of a light in the scene, evenly spread over its area as seen straight on.
pub(crate) fn of_near(light: &PlacedLight) -> LightPoints {
    let half_extent = light.shape.half_extent();
    std::array::from_fn(|i| {
        let [s, t] = sobol(i as u32, layout::LIGHT_POINTS);
        let place = match light.shape {
            AreaLightShape::Rectangle { .. } => 2.0 * Vec2::new(s, t) - 1.0,
            _ => disk_place(s, t),
        };
        place * half_extent
    })
}

/// A place in the unit disk: equal areas stay equal.
fn disk_place(s: f32, t: f32) -> Vec2 {
    Vec2::from_angle(std::f32::consts::TAU * t) * s.max(0.0).sqrt()
}

/// Which of some weights a number from 0 to 1 falls on, and where there; all are the same where none is above 0.
pub(crate) fn chosen(weights: &[f32], u: f32) -> (usize, f32) {
    let sum: f32 = weights.iter().sum();
    if !(sum > 0.0 && sum.is_finite()) {
        let place = u * weights.len() as f32;
        return (place as usize, place.fract());
    }
    let mut left = u * sum;
    for (i, &weight) in weights.iter().enumerate() {
        if left < weight {
            return (i, left / weight);
        }
        left -= weight;
    }
    // Rounding: the last one that has any.
    (weights.iter().rposition(|&weight| weight > 0.0).unwrap_or(0), 0.5)
}

/// Point `i` of the first `count` of Sobol's sequence in two dimensions, in the middle of its part.
pub(crate) fn sobol(i: u32, count: u32) -> [f32; 2] {
    let mut second = 0;
    let mut direction = 1u32 << 31;
    for bit in 0..32 {
        if i >> bit & 1 == 1 {
            second ^= direction;
        }
        direction ^= direction >> 1;
    }
    [i.reverse_bits(), second].map(|bits| (bits >> 8) as f32 / 16_777_216.0 + 0.5 / count as f32)
}

/// A texture of the points of all lights of a frame, a row each: see `shadow_rays.wgsl`.
pub(crate) struct PointsOfLights {
    texture: wgpu::Texture,
    pub view: wgpu::TextureView,
}

/// Texels of a row: the points; the number of rays and the solid angle, see `shadow_rays.wgsl`; least and greatest coordinates of the points.
const ROW: u32 = layout::LIGHT_POINTS + 3;

impl PointsOfLights {
    pub fn new(gpu: &Gpu, lights: usize) -> Self {
        let usage = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST;
        let size = [ROW, (lights as u32).max(1), 1];
        let texture = gpu.texture("light points", size, 1, wgpu::TextureFormat::Rg32Float, usage);
        Self { view: texture.create_view(&Default::default()), texture }
    }

    /// Writes the points of lights in the order of the frame's list. `usual` is the number of rays to a light that gives as much as others do.
    pub fn write(&self, gpu: &Gpu, lights: &[FrameLight<'_>], usual: u32) {
        let total: f32 = lights.iter().map(FrameLight::flux).sum();
        let row = |light: &FrameLight<'_>| {
            // Of an even light the outline tells all.
            let (points, solid_angle) = match light {
                FrameLight::Distant { light, points: Some(points), .. } => (**points, light.solid_angle),
                FrameLight::Distant { light, .. } => (of_distant(light, &|_| 1.0), 0.0),
                FrameLight::Near(light) => match distant(light) {
                    Some(sun) => (of_distant(&sun, &|_| 1.0), 0.0),
                    None => (of_near(light), 0.0),
                },
            };
            let rays = match (light, light.flux()) {
                // A light of the scene may outshine all others where it is near, and its grain is averaged over nothing.
                (FrameLight::Near(_), _) => ray_count(f32::MAX, 1, usual),
                // One that only tells how much of the sky is open.
                (_, 0.0) => ray_count(1.0, 1, usual),
                (_, flux) => ray_count(flux / total.max(f32::MIN_POSITIVE), lights.len(), usual),
            };
            // Rows of maps run against the bitangent.
            let on_map = points.map(|at| Vec2::new(at.x, -at.y));
            let least = on_map.into_iter().reduce(Vec2::min).unwrap_or_default();
            let most = on_map.into_iter().reduce(Vec2::max).unwrap_or_default();
            let texels = on_map.into_iter().chain([Vec2::new(rays as f32, solid_angle), least, most]);
            texels.map(|texel| texel.to_array()).collect::<Vec<_>>()
        };
        let texels: Vec<[f32; 2]> = lights.iter().flat_map(row).collect();
        if !texels.is_empty() {
            let size = [ROW, lights.len() as u32];
            gpu.write_texture(&self.texture, [0, 0], size, bytemuck::cast_slice(&texels));
        }
    }
}

/// Number of rays to a light that gives a `share` of all that `lights` lights give, `usual` to one that gives as much as the others: a power
/// of two, because as many points that follow one another are spread over the whole light.
pub(crate) fn ray_count(share: f32, lights: usize, usual: u32) -> u32 {
    let wanted = share * lights as f32 * usual as f32;
    let power = wanted.max(1.0).log2().round().min(31.0) as u32;
    (1 << power).min((4 * usual).next_power_of_two()).min(layout::LIGHT_POINTS)
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, DVec3};

    use super::*;

    fn cell() -> DistantLight {
        let frame = [DVec3::NEG_X, DVec3::Y, DVec3::Z];
        DistantLight::rectangle(frame, DVec2::new(-0.6, -0.2), DVec2::new(0.9, 0.7), DVec3::ONE)
    }

    fn direction(light: &DistantLight, at: Vec2) -> Vec3 {
        (light.direction + at.x * light.tangent + at.y * light.bitangent).normalize()
    }

    #[test]
    fn points_of_an_even_light_give_its_irradiance() {
        let disk = DistantLight::disk(DVec3::new(0.3, 0.5, 0.8).normalize(), 0.7, DVec3::ONE);
        for light in [cell(), disk] {
            let points = of_distant(&light, &|_| 1.0);
            let n = Vec3::new(0.2, 0.3, 0.9).normalize();
            let cosine = |at: &Vec2| direction(&light, *at).dot(n).max(0.0);
            for count in [4, 16, 64] {
                for some in points.chunks(count) {
                    let mean = some.iter().map(cosine).sum::<f32>() / count as f32;
                    let exact = light.irradiance(n) / light.solid_angle;
                    assert!((mean / exact - 1.0).abs() < 0.35 / count as f32, "{count}: {mean} {exact}");
                }
            }
        }
    }

    #[test]
    fn points_lie_where_the_light_comes_from() {
        let light = cell();
        let bright = |direction: Vec3| if direction.x < -0.3 { 1.0 } else { 0.0 };
        let points = of_distant(&light, &bright);
        assert!(points.iter().all(|at| direction(&light, *at).x < -0.28));
        assert!(of_distant(&light, &|_| 0.0).iter().all(|at| light.contains(direction(&light, *at))));
    }

    #[test]
    fn lights_that_give_more_have_more_rays() {
        let counts = [0.0, 0.25, 1.0, 2.0, 100.0].map(|times: f32| ray_count(times / 50.0, 50, 4));
        assert_eq!(counts, [1, 1, 4, 8, 16]);
        assert_eq!(ray_count(1.0, 1, 1000), 64);
    }
}
