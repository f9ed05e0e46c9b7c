//! Materials as reflections see them: base colours of few texels, of everything else in textures the mean.

use std::collections::HashMap;

use glam::{Vec3, Vec4};
use gnomon_picture::tonemap::{srgb_decode, srgb_encode};
use gnomon_scene::{Texture, TextureId};
use gnomon_shaders::layout;
use rayon::prelude::*;

use super::arrays::TextureUse;
use super::{MaterialRecords, Materials};
use crate::Gpu;
use crate::bindings::array_view;

/// Sides of a base colour [texels]; the second where there are more than [`MANY`] of them.
const SIDES: [u32; 2] = [256, 128];
const MANY: usize = 64;

/// On the GPU, see `hit_surface.wgsl`.
pub(crate) struct FarMaterials {
    texture: wgpu::Texture,
    /// [`layout::FAR_MATERIAL_TEXELS`] of each material: two rows of the base colour's coordinates, in w its layer after 1 and its
    /// wrapping; means of metallic, roughness, specular; of emission; of the base colour.
    pub table: wgpu::TextureView,
    pub colors: wgpu::TextureView,
    pub sampler: wgpu::Sampler,
    layers: HashMap<TextureId, u32>,
    means: HashMap<TextureUse, Vec4>,
}

impl FarMaterials {
    pub fn new(gpu: &Gpu, materials: &Materials) -> Self {
        let textures = &materials.scene_textures.textures;
        let mut colored: Vec<TextureId> = Vec::new();
        let mut used: Vec<TextureUse> = Vec::new();
        for (number, record) in materials.now.records.iter().enumerate() {
            for (texture, reference) in materials.textures_of(number, record) {
                if let TextureUse::Colors(id) = texture
                    && reference.kind == layout::TEXTURE_BASE_COLOR
                    && !colored.contains(&id)
                {
                    colored.push(id);
                }
                if !used.contains(&texture) {
                    used.push(texture);
                }
            }
        }
        colored.truncate(gpu.max_layers() as usize);
        let side = SIDES[usize::from(colored.len() > MANY)];
        let reduced: Vec<Vec<[u8; 4]>> =
            colored.par_iter().map(|id| reduced(&textures[id.0], side)).collect();
        let usage = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST;
        let size = [side, side, (colored.len() as u32).max(1)];
        let array = gpu.texture("far colors", size, 1, wgpu::TextureFormat::Rgba8UnormSrgb, usage);
        for (layer, texels) in (0..).zip(&reduced) {
            gpu.write_texture(&array, [0, layer], [side, side], bytemuck::cast_slice(texels));
        }
        let mean = |used: &TextureUse| match *used {
            TextureUse::Colors(id) => Some((*used, mean(&textures[id.0], true))),
            TextureUse::Data(id) => Some((*used, mean(&textures[id.0], false))),
            TextureUse::Slopes(_) => None,
        };
        let means = used.par_iter().filter_map(mean).collect();
        let [width, height] = table_size(materials.now.records.len());
        let texture =
            gpu.texture("far materials", [width, height, 1], 1, wgpu::TextureFormat::Rgba32Float, usage);
        let far = Self {
            table: texture.create_view(&Default::default()),
            texture,
            colors: array_view(&array),
            sampler: gpu.device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some("far colors"),
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                ..Default::default()
            }),
            layers: colored.into_iter().zip(0..).collect(),
            means,
        };
        far.write(gpu, materials);
        far
    }

    /// Brings other places of textures to the GPU.
    pub fn write(&self, gpu: &Gpu, materials: &Materials) {
        let [width, height] = table_size(materials.now.records.len());
        let mut texels: Vec<[f32; 4]> = Vec::with_capacity((width * height) as usize);
        for (number, record) in materials.now.records.iter().enumerate() {
            texels.extend(self.texels(materials, number, record).map(|texel| texel.to_array()));
        }
        texels.resize((width * height) as usize, [0.0; 4]);
        gpu.write_texture(&self.texture, [0, 0], [width, height], bytemuck::cast_slice(&texels));
    }

    fn texels(
        &self,
        materials: &Materials,
        number: usize,
        record: &layout::Material,
    ) -> [Vec4; layout::FAR_MATERIAL_TEXELS as usize] {
        let mut texels = [Vec4::ZERO, Vec4::ZERO, Vec4::ONE, Vec4::ONE, Vec4::ONE];
        for (used, reference) in materials.textures_of(number, record) {
            let mean = self.means.get(&used).copied().unwrap_or(Vec4::ONE);
            match reference.kind {
                layout::TEXTURE_BASE_COLOR => {
                    texels[4] = mean;
                    let TextureUse::Colors(color) = used else { continue };
                    if let Some(layer) = self.layers.get(&color) {
                        texels[0] = reference.uv_rows[0].with_w((layer + 1) as f32);
                        let wrap = reference.wrap.x + 4 * reference.wrap.y;
                        texels[1] = reference.uv_rows[1].with_w(wrap as f32);
                    }
                }
                layout::TEXTURE_METALLIC_ROUGHNESS => texels[2] = texels[2].with_x(mean.z).with_y(mean.y),
                layout::TEXTURE_METALLIC => texels[2] = texels[2].with_x(mean.z),
                layout::TEXTURE_SPECULAR => texels[2] = texels[2].with_z(mean.w),
                layout::TEXTURE_EMISSIVE => texels[3] = mean,
                _ => {}
            }
        }
        texels
    }
}

fn table_size(materials: usize) -> [u32; 2] {
    let a_row = layout::FAR_MATERIALS_A_ROW;
    let materials = (materials as u32).max(1);
    [materials.min(a_row) * layout::FAR_MATERIAL_TEXELS, materials.div_ceil(a_row)]
}

fn decoded(texel: [u8; 4], srgb: bool) -> Vec4 {
    let unit = Vec4::from(texel.map(|channel| f32::from(channel) / 255.0));
    if srgb { unit.truncate().map(srgb_decode).extend(unit.w) } else { unit }
}

fn mean(texture: &Texture, srgb: bool) -> Vec4 {
    let count = texture.rgba8.len().max(1) as f32;
    let row = |row: &[[u8; 4]]| row.iter().map(|&texel| decoded(texel, srgb)).sum::<Vec4>();
    texture.rgba8.chunks(texture.width.max(1) as usize).map(row).sum::<Vec4>() / count
}

/// A colour as a square: mean values of what its texels cover, or the texel that they lie in.
fn reduced(texture: &Texture, side: u32) -> Vec<[u8; 4]> {
    let range = |i: u32, of: u32| {
        let (start, end) = (u64::from(i) * u64::from(of), (u64::from(i) + 1) * u64::from(of));
        let first = start / u64::from(side);
        first..end.div_ceil(u64::from(side)).max(first + 1)
    };
    let encode = |value: Vec3| {
        let [r, g, b] = value.map(srgb_encode).to_array().map(|c| (c.clamp(0.0, 1.0) * 255.0 + 0.5) as u8);
        [r, g, b, 255]
    };
    let texel = |x: u32, y: u32| {
        let (mut sum, mut count) = (Vec3::ZERO, 0.0);
        for row in range(y, texture.height) {
            for column in range(x, texture.width) {
                let at = row * u64::from(texture.width) + column;
                sum += decoded(texture.rgba8[at as usize], true).truncate();
                count += 1.0;
            }
        }
        encode(sum / count)
    };
    (0..side * side).map(|i| texel(i % side, i / side)).collect()
}

impl Materials {
    /// The textures of one of the materials, and where they are.
    fn textures_of<'a>(
        &'a self,
        number: usize,
        record: &layout::Material,
    ) -> impl Iterator<Item = (TextureUse, &'a layout::MaterialTexture)> {
        let MaterialRecords { textures, .. } = &self.now;
        let own = textures.get(record.first_texture as usize..record.end_texture as usize);
        self.used[number].iter().copied().zip(own.unwrap_or_default())
    }

    /// Which of a mesh's sets of coordinates the base colour of a material lies in.
    pub fn color_set(&self, number: usize) -> usize {
        let record = &self.now.records[number];
        let mut textures = self.textures_of(number, record);
        let color = textures.find(|(_, reference)| reference.kind == layout::TEXTURE_BASE_COLOR);
        color.map_or(0, |(_, reference)| reference.uv_set as usize)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use gnomon_scene::Wrap;

    use super::*;

    fn texture(width: u32, height: u32, texel: impl Fn(u32, u32) -> u8) -> Arc<Texture> {
        let rgba8 = (0..width * height).map(|i| [texel(i % width, i / width), 0, 0, 255]).collect();
        Arc::new(Texture { width, height, rgba8, wrap: [Wrap::Repeat; 2], nearest: false })
    }

    #[test]
    fn colors_keep_their_places_and_their_mean_in_linear_light() {
        let halves = reduced(&texture(2, 3, |x, _| if x == 0 { 0 } else { 255 }), 8);
        assert_eq!([halves[3][0], halves[4][0]], [0, 255]);
        let fine = texture(512, 512, |x, y| if (x + y) % 2 == 0 { 0 } else { 255 });
        let middle = reduced(&fine, 4)[5][0];
        assert!((i32::from(middle) - 188).abs() <= 1, "half of the light: {middle}");
        assert!((mean(&fine, true).x - 0.5).abs() < 1e-4 && (mean(&fine, false).x - 0.5).abs() < 1e-4);
    }
}
