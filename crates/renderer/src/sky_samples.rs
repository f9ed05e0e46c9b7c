//! Directions that stand for the sky where reflections meet the scene.

use glam::{Vec2, Vec3};
use gnomon_envmap::Equirect;
use gnomon_lights::DistantLight;
use gnomon_picture::LUMINANCE;
use gnomon_shaders::layout;

use crate::Gpu;
use crate::light_points::{LightPoints, chosen, sobol};

/// A direction in the environment, and what comes from it: irradiance on a surface that faces it.
type SkySample = (Vec3, Vec3);

const COUNT: u32 = layout::SKY_SAMPLES;

/// Directions from each of which comes as much light of a map. Any [`layout::SKY_BLOCK`] that follow a multiple of their number are spread
/// over all of it.
pub(crate) fn of_map(map: &Equirect) -> Vec<SkySample> {
    let (width, height) = (map.width(), map.height());
    let row = |y: u32| -> Vec<f32> {
        // Solid angle of a texel, but for a factor.
        let sine = ((y as f32 + 0.5) / height as f32 * std::f32::consts::PI).sin();
        map.radiance().row(y).iter().map(|texel| texel.dot(LUMINANCE).max(0.0) * sine).collect()
    };
    let rows: Vec<Vec<f32>> = (0..height).map(row).collect();
    let sums: Vec<f32> = rows.iter().map(|row| row.iter().sum()).collect();
    let texel = 2.0 * std::f32::consts::PI * std::f32::consts::PI / (width as f32 * height as f32);
    let share = sums.iter().map(|&sum| f64::from(sum)).sum::<f64>() as f32 * texel / COUNT as f32;
    let sample = |i: u32| {
        let [u, v] = sobol(i, COUNT);
        let (y, t) = chosen(&sums, v);
        let (x, s) = chosen(&rows[y.min(rows.len() - 1)], u);
        let uv = Vec2::new((x as f32 + s) / width as f32, (y as f32 + t) / height as f32);
        (Equirect::direction_from_uv(uv), share * color(map.radiance().get(x as u32, y as u32)))
    };
    (0..COUNT).map(sample).collect()
}

/// The same of lights, whose light comes from their points.
pub(crate) fn of_lights(lights: &[DistantLight], points: &[LightPoints]) -> Vec<SkySample> {
    let fluxes: Vec<f32> =
        lights.iter().map(|light| light.radiance.dot(LUMINANCE).max(0.0) * light.solid_angle).collect();
    let share = fluxes.iter().sum::<f32>() / COUNT as f32;
    let sample = |i: u32| {
        let [u, v] = sobol(i, COUNT);
        let (number, s) = chosen(&fluxes, v);
        let (Some(light), Some(points)) = (lights.get(number), points.get(number)) else {
            return (Vec3::Y, Vec3::ZERO);
        };
        // Both numbers, so that neighbours in the list take others.
        let at = points[(((s + u).fract()) * points.len() as f32) as usize % points.len()];
        let direction = light.direction + at.x * light.tangent + at.y * light.bitangent;
        (direction.normalize(), share * color(light.radiance))
    };
    (0..COUNT).map(sample).collect()
}

/// Radiance of a luminance of 1.
fn color(radiance: Vec3) -> Vec3 {
    let luminance = radiance.dot(LUMINANCE);
    if luminance > 0.0 { radiance / luminance } else { Vec3::ZERO }
}

/// As `reflections_scene.wgsl` reads them.
pub(crate) fn upload(gpu: &Gpu, samples: &[SkySample]) -> wgpu::TextureView {
    let usage = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST;
    let texture = gpu.texture("sky samples", [COUNT, 2, 1], 1, wgpu::TextureFormat::Rgba32Float, usage);
    let directions = samples.iter().map(|(direction, _)| direction.extend(0.0).to_array());
    let texels: Vec<[f32; 4]> =
        directions.chain(samples.iter().map(|(_, light)| light.extend(0.0).to_array())).collect();
    gpu.write_texture(&texture, [0, 0], [COUNT, 2], bytemuck::cast_slice(&texels));
    texture.create_view(&Default::default())
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, DVec3};
    use gnomon_envmap::builtin;

    use super::*;
    use crate::light_points;

    fn irradiance(samples: &[SkySample], n: Vec3) -> Vec3 {
        samples.iter().map(|(direction, light)| *light * direction.dot(n).max(0.0)).sum()
    }

    #[test]
    fn blocks_of_a_map_give_its_irradiance() {
        let map = builtin::by_name("sky").unwrap().resized(512, 256);
        let samples = of_map(&map);
        let of_texels = |n: Vec3| -> Vec3 {
            let texel = |i: u32| {
                let (x, y) = (i % 512, i / 512);
                let uv = Vec2::new((x as f32 + 0.5) / 512.0, (y as f32 + 0.5) / 256.0);
                let solid_angle =
                    (std::f32::consts::PI / 256.0).powi(2) * (uv.y * std::f32::consts::PI).sin();
                map.radiance().get(x, y) * Equirect::direction_from_uv(uv).dot(n).max(0.0) * solid_angle
            };
            (0..512 * 256).map(texel).sum()
        };
        for n in [Vec3::Y, Vec3::new(0.6, 0.8, 0.0), Vec3::new(-0.5, 0.6, 0.62).normalize()] {
            let truth = of_texels(n);
            let all = irradiance(&samples, n);
            assert!((all / truth - 1.0).abs().max_element() < 0.05, "{all} {truth}");
            // A sun takes most of a block: on sides that turn away from it single ones are far off, all of them together are not.
            let blocks = samples.chunks(layout::SKY_BLOCK as usize);
            let share = |block: &[SkySample]| {
                let some = irradiance(block, n) * (samples.len() / block.len()) as f32;
                some.dot(LUMINANCE) / all.dot(LUMINANCE) - 1.0
            };
            let squares: f32 = blocks.clone().map(|block| share(block).powi(2)).sum();
            let spread = (squares / blocks.len() as f32).sqrt();
            assert!(spread < 0.5, "{spread}");
        }
    }

    #[test]
    fn lights_give_their_irradiance() {
        let frame = [DVec3::NEG_X, DVec3::Y, DVec3::Z];
        let light =
            |radiance| DistantLight::rectangle(frame, DVec2::new(-0.6, -0.2), DVec2::new(0.9, 0.7), radiance);
        let lights = [light(DVec3::ONE), light(DVec3::new(0.0, 3.0, 0.0))];
        let points: Vec<_> = lights.iter().map(|light| light_points::of_distant(light, &|_| 1.0)).collect();
        let samples = of_lights(&lights, &points);
        let n = Vec3::new(0.2, 0.3, 0.9).normalize();
        let truth: Vec3 = lights.iter().map(|light| light.radiance * light.irradiance(n)).sum();
        let given = irradiance(&samples, n);
        assert!((given / truth - 1.0).abs().max_element() < 0.02, "{given} {truth}");
    }

    #[test]
    fn darkness_gives_nothing() {
        let black = Equirect::new(gnomon_picture::RgbImage::filled(8, 4, Vec3::ZERO));
        assert_eq!(irradiance(&of_map(&black), Vec3::Y), Vec3::ZERO);
        assert_eq!(irradiance(&of_lights(&[], &[]), Vec3::Y), Vec3::ZERO);
    }
}
