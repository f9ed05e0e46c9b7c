use std::f32::consts::PI;

use glam::{Vec2, Vec3};
use gnomon_envmap::{Equirect, PrefilteredMap, Sh9};
use gnomon_image::RgbImage;
use gnomon_lights::DistantLight;

use crate::ambient::AmbientLights;
use crate::{Gpu, RenderError};

/// Texels along the side of the environment BRDF's table; the outermost ones stand for 0 and 1.
const DFG_SIZE: u32 = 32;
/// Height of the irradiance map: irradiance varies with the cosine of 180 degrees, so 5.6 degrees a texel is ample.
const IRRADIANCE_HEIGHT: u32 = 32;
/// Height of the map that irradiance is integrated from.
const IRRADIANCE_SOURCE_HEIGHT: u32 = 64;
/// Width of the sharpest prefiltered level, and number of levels.
const PREFILTERED_WIDTH: u32 = 512;
const PREFILTERED_LEVELS: u32 = 6;

/// An environment ready to light frames: lights on the CPU, maps on the GPU. Independent of any scene.
pub(crate) struct Lighting {
    pub lights: Vec<DistantLight>,
    /// Lights that only tell how much of the sky is open.
    pub probes: Vec<DistantLight>,
    /// What stays ambient, and what is made of it.
    residual: Equirect,
    pub residual_sh: [[f32; 4]; 9],
    pub full_sh: [[f32; 4]; 9],
    /// The environment with mip levels.
    pub background: wgpu::TextureView,
    pub irradiance_full: wgpu::TextureView,
    pub prefiltered_full: wgpu::TextureView,
    pub prefiltered_residual: wgpu::TextureView,
    pub dfg_table: wgpu::TextureView,
}

impl Lighting {
    pub fn new(gpu: &Gpu, map: &Equirect, ambient: AmbientLights) -> Result<Self, RenderError> {
        let limit = gpu.device.limits().max_texture_dimension_2d;
        let largest = map.width().max(map.height());
        if largest > limit {
            return Err(RenderError::OverLimit {
                what: "texels along the environment's side",
                wanted: u64::from(largest),
                limit: u64::from(limit),
                adapter: gpu.adapter().name.clone(),
            });
        }
        let unit = |i: u32| i as f32 / (DFG_SIZE - 1) as f32;
        let dfg =
            RgbImage::from_fn(DFG_SIZE, DFG_SIZE, |x, y| gnomon_brdf::dfg(unit(x), unit(y)).extend(0.0));
        Ok(Self {
            lights: ambient.lights,
            probes: ambient.probes,
            residual_sh: spherical_harmonics(&ambient.residual),
            full_sh: spherical_harmonics(map),
            background: upload(gpu, "background", mip_levels(map).iter().map(Equirect::radiance)),
            irradiance_full: upload(gpu, "irradiance", &[irradiance_map(map)]),
            prefiltered_full: prefiltered(gpu, map),
            prefiltered_residual: prefiltered(gpu, &ambient.residual),
            residual: ambient.residual,
            dfg_table: upload(gpu, "dfg", &[dfg]),
        })
    }

    /// The same environment with other lights. Maps are made only where another part of it stays ambient.
    pub fn with_lights(self, gpu: &Gpu, ambient: AmbientLights) -> Self {
        let lit = Self { lights: ambient.lights, probes: ambient.probes, ..self };
        if lit.residual == ambient.residual {
            return lit;
        }
        Self {
            residual_sh: spherical_harmonics(&ambient.residual),
            prefiltered_residual: prefiltered(gpu, &ambient.residual),
            residual: ambient.residual,
            ..lit
        }
    }
}

/// The map and its halves down to a height of 2 texels, flux conserved.
fn mip_levels(map: &Equirect) -> Vec<Equirect> {
    let mut levels = vec![map.clone()];
    while let Some(last) = levels.last().filter(|last| last.height() >= 4) {
        levels.push(last.resized(last.width() / 2, last.height() / 2));
    }
    levels
}

fn spherical_harmonics(map: &Equirect) -> [[f32; 4]; 9] {
    Sh9::project(map).coefficients.map(|c| c.extend(0.0).to_array())
}

fn prefiltered(gpu: &Gpu, map: &Equirect) -> wgpu::TextureView {
    let filtered = PrefilteredMap::new(map, PREFILTERED_WIDTH, PREFILTERED_LEVELS);
    upload(gpu, "prefiltered", filtered.levels().iter().map(Equirect::radiance))
}

/// Uploads a picture and its mip levels in full precision: a sun exceeds what 16 bits hold.
fn upload<'a>(gpu: &Gpu, label: &str, levels: impl IntoIterator<Item = &'a RgbImage>) -> wgpu::TextureView {
    let levels: Vec<&RgbImage> = levels.into_iter().collect();
    let size = levels.first().map_or([1, 1, 1], |level| [level.width(), level.height(), 1]);
    let usage = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST;
    let count = (levels.len() as u32).max(1);
    let texture = gpu.texture(label, size, count, wgpu::TextureFormat::Rgba32Float, usage);
    for (i, level) in (0..).zip(levels) {
        let texels: Vec<[f32; 4]> = level.texels().iter().map(|texel| texel.extend(1.0).to_array()).collect();
        gpu.write_texture(&texture, i, [level.width(), level.height()], bytemuck::cast_slice(&texels));
    }
    texture.create_view(&Default::default())
}

/// Irradiance of the whole map for every normal, an equirect map itself, by summing over all texels.
fn irradiance_map(map: &Equirect) -> RgbImage {
    let height = IRRADIANCE_SOURCE_HEIGHT.min(map.height());
    let source = map.resized(2 * height, height);
    let emitters: Vec<(Vec3, f32, Vec3)> = (0..height)
        .flat_map(|y| (0..source.width()).map(move |x| (x, y)))
        .map(|(x, y)| {
            let solid_angle = source.texel_solid_angle(y) as f32;
            (source.texel_direction(x, y), solid_angle, source.radiance().get(x, y))
        })
        .collect();
    RgbImage::from_fn(2 * IRRADIANCE_HEIGHT, IRRADIANCE_HEIGHT, |x, y| {
        let size = Vec2::new(2.0 * IRRADIANCE_HEIGHT as f32, IRRADIANCE_HEIGHT as f32);
        let n = Equirect::direction_from_uv(Vec2::new(x as f32 + 0.5, y as f32 + 0.5) / size);
        let (sum, cosines) =
            emitters.iter().fold((Vec3::ZERO, 0.0), |(sum, cosines), (w, solid_angle, radiance)| {
                let projected = w.dot(n).max(0.0) * solid_angle;
                (sum + *radiance * projected, cosines + projected)
            });
        // The cosines sum to pi only up to discretisation; this makes a constant map exact.
        sum * (PI / cosines)
    })
}
