//! Textures of a scene as layers of texture arrays, and which arrays a draw binds.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{Vec3, Vec4};
use gnomon_scene::{Texture, TextureId, Wrap};

use crate::Gpu;
use crate::bindings::array_view;

/// A texture as it is uploaded: the same file may be used as colour and as data.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct TextureUse {
    pub texture: TextureId,
    pub srgb: bool,
}

/// What all layers of an array have in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct ArrayKind {
    size: [u32; 2],
    srgb: bool,
    wrap: [Wrap; 2],
    nearest: bool,
}

/// Where every texture is.
pub(super) struct Plan {
    /// Layers of every array.
    pub arrays: Vec<Vec<TextureUse>>,
    /// Arrays that are bound together, slot by slot.
    pub sets: Vec<Vec<usize>>,
    /// Set of every material.
    set_of: Vec<usize>,
    /// Array and layer.
    places: HashMap<TextureUse, (usize, u32)>,
}

impl Plan {
    /// Of the textures that each material uses. Materials share sets as long as `slots` arrays are enough: draws of a set need no other
    /// bind group. Where one material alone needs more, the error says how many.
    pub fn new(
        textures: &[Arc<Texture>],
        materials: &[Vec<TextureUse>],
        max_layers: usize,
        slots: usize,
    ) -> Result<Self, usize> {
        let mut plan = Self {
            arrays: Vec::new(),
            sets: Vec::new(),
            set_of: Vec::with_capacity(materials.len()),
            places: HashMap::new(),
        };
        let mut kinds: Vec<ArrayKind> = Vec::new();
        for uses in materials {
            let mut needed: Vec<usize> = Vec::new();
            for &used in uses {
                let array = match plan.places.get(&used) {
                    Some((array, _)) => *array,
                    None => plan.add(&mut kinds, &textures[used.texture.0], used, max_layers),
                };
                if !needed.contains(&array) {
                    needed.push(array);
                }
            }
            if needed.len() > slots {
                return Err(needed.len());
            }
            plan.set_of.push(plan.sets.len());
            let missing = |set: &Vec<usize>| needed.iter().filter(|array| !set.contains(array)).count();
            let fitting = plan.sets.iter().enumerate().filter(|(_, set)| set.len() + missing(set) <= slots);
            match fitting.min_by_key(|(_, set)| missing(set)).map(|(number, _)| number) {
                Some(number) => {
                    let set = &mut plan.sets[number];
                    needed.retain(|array| !set.contains(array));
                    set.append(&mut needed);
                    if let Some(of_material) = plan.set_of.last_mut() {
                        *of_material = number;
                    }
                }
                None => plan.sets.push(needed),
            }
        }
        Ok(plan)
    }

    /// Gives a texture a layer and says of which array.
    fn add(
        &mut self,
        kinds: &mut Vec<ArrayKind>,
        texture: &Texture,
        used: TextureUse,
        max_layers: usize,
    ) -> usize {
        let kind = ArrayKind {
            size: [texture.width, texture.height],
            srgb: used.srgb,
            wrap: texture.wrap,
            nearest: texture.nearest,
        };
        let with_room = |(array, other): (usize, &ArrayKind)| {
            (*other == kind && self.arrays[array].len() < max_layers).then_some(array)
        };
        let array = kinds.iter().enumerate().find_map(with_room).unwrap_or_else(|| {
            kinds.push(kind);
            self.arrays.push(Vec::new());
            kinds.len() - 1
        });
        self.places.insert(used, (array, self.arrays[array].len() as u32));
        self.arrays[array].push(used);
        array
    }

    /// Number of the set whose bind group a material's draws take.
    pub fn set_of(&self, material: usize) -> usize {
        self.set_of[material]
    }

    /// Slot and layer of a texture that a material uses.
    pub fn place(&self, material: usize, used: TextureUse) -> Option<(u32, u32)> {
        let (array, layer) = self.places.get(&used)?;
        let slot = self.sets[self.set_of[material]].iter().position(|bound| bound == array)?;
        Some((slot as u32, *layer))
    }
}

/// Whether these are the very same textures.
pub(super) fn same_textures(a: &[Arc<Texture>], b: &[Arc<Texture>]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| Arc::ptr_eq(a, b))
}

/// An array and the sampler of all its layers.
#[derive(Clone)]
pub(super) struct TextureArray {
    layers: Vec<Arc<Texture>>,
    srgb: bool,
    pub view: wgpu::TextureView,
    pub sampler: wgpu::Sampler,
}

fn address(wrap: Wrap) -> wgpu::AddressMode {
    match wrap {
        Wrap::Repeat => wgpu::AddressMode::Repeat,
        Wrap::MirroredRepeat => wgpu::AddressMode::MirrorRepeat,
        Wrap::ClampToEdge => wgpu::AddressMode::ClampToEdge,
    }
}

impl TextureArray {
    /// Of textures with the same size and sampling; `None` without any.
    pub fn new(gpu: &Gpu, layers: Vec<Arc<Texture>>, srgb: bool) -> Option<Self> {
        let first = layers.first()?;
        let format = if srgb { wgpu::TextureFormat::Rgba8UnormSrgb } else { wgpu::TextureFormat::Rgba8Unorm };
        let usage = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST;
        let size = [first.width, first.height, layers.len() as u32];
        let level_count = first.width.max(first.height).ilog2() + 1;
        let array = gpu.texture("material textures", size, level_count, format, usage);
        for (layer, texture) in (0..).zip(&layers) {
            for (level, texels) in (0..).zip(mip_chain(texture, srgb)) {
                let size = [(texture.width >> level).max(1), (texture.height >> level).max(1)];
                gpu.write_texture(&array, [level, layer], size, bytemuck::cast_slice(&texels));
            }
        }
        let filter = if first.nearest { wgpu::FilterMode::Nearest } else { wgpu::FilterMode::Linear };
        let sampler = gpu.device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("material textures"),
            address_mode_u: address(first.wrap[0]),
            address_mode_v: address(first.wrap[1]),
            mag_filter: filter,
            min_filter: filter,
            mipmap_filter: wgpu::MipmapFilterMode::Linear,
            // Anisotropy is only valid where every filter is linear.
            anisotropy_clamp: if first.nearest { 1 } else { 8 },
            ..Default::default()
        });
        Some(Self { view: array_view(&array), sampler, layers, srgb })
    }

    /// Whether it is that of these textures.
    pub fn holds(&self, layers: &[Arc<Texture>], srgb: bool) -> bool {
        self.srgb == srgb && same_textures(&self.layers, layers)
    }
}

/// Box-filtered mip levels down to one texel, colours averaged in linear light. Odd sizes drop their last row or column.
fn mip_chain(texture: &Texture, srgb: bool) -> Vec<Vec<[u8; 4]>> {
    let decode = |texel: [u8; 4]| {
        let unit = Vec4::from(texel.map(|channel| f32::from(channel) / 255.0));
        if srgb { unit.truncate().map(gnomon_picture::tonemap::srgb_decode).extend(unit.w) } else { unit }
    };
    let encode = |value: Vec4| {
        let rgb: Vec3 = value.truncate();
        let unit = if srgb { rgb.map(gnomon_picture::tonemap::srgb_encode).extend(value.w) } else { value };
        unit.to_array().map(|channel| (channel.clamp(0.0, 1.0) * 255.0 + 0.5) as u8)
    };
    let mut levels = vec![texture.rgba8.clone()];
    let mut fine: Vec<Vec4> = texture.rgba8.iter().map(|&texel| decode(texel)).collect();
    let (mut width, mut height) = (texture.width as usize, texture.height as usize);
    while width > 1 || height > 1 {
        let (w, h) = ((width / 2).max(1), (height / 2).max(1));
        let at = |x: usize, y: usize| fine[y.min(height - 1) * width + x.min(width - 1)];
        let coarse: Vec<Vec4> = (0..w * h)
            .map(|i| {
                let (x, y) = (2 * (i % w), 2 * (i / w));
                0.25 * (at(x, y) + at(x + 1, y) + at(x, y + 1) + at(x + 1, y + 1))
            })
            .collect();
        levels.push(coarse.iter().map(|&value| encode(value)).collect());
        (fine, width, height) = (coarse, w, h);
    }
    levels
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texture(width: u32, wrap: Wrap) -> Arc<Texture> {
        Arc::new(Texture {
            width,
            height: 1,
            rgba8: vec![[0; 4]; width as usize],
            wrap: [wrap; 2],
            nearest: false,
        })
    }

    fn colors(ids: &[usize]) -> Vec<TextureUse> {
        ids.iter().map(|&id| TextureUse { texture: TextureId(id), srgb: true }).collect()
    }

    #[test]
    fn equals_share_an_array_up_to_its_layers() {
        let textures: Vec<_> = [4, 4, 4, 8].map(|width| texture(width, Wrap::Repeat)).into();
        let plan = Plan::new(&textures, &[colors(&[0, 1, 2, 3])], 2, 8).unwrap();
        assert_eq!(plan.arrays, [colors(&[0, 1]), colors(&[2]), colors(&[3])]);
        let data = TextureUse { texture: TextureId(0), srgb: false };
        let plan = Plan::new(&textures, &[vec![colors(&[0])[0], data]], 2, 8).unwrap();
        assert_eq!(plan.arrays.len(), 2, "colour and data are different formats");
        let clamped = [texture(4, Wrap::Repeat), texture(4, Wrap::ClampToEdge)];
        assert_eq!(Plan::new(&clamped, &[colors(&[0, 1])], 2, 8).unwrap().arrays.len(), 2);
    }

    #[test]
    fn materials_share_sets_while_slots_last() {
        let textures: Vec<_> = (1..=6).map(|width| texture(width, Wrap::Repeat)).collect();
        let materials = [&[0, 1][..], &[2], &[3], &[1, 0], &[4, 5], &[2, 3], &[]].map(colors);
        let plan = Plan::new(&textures, &materials, 256, 3).unwrap();
        assert_eq!(plan.set_of, [0, 0, 1, 0, 1, 2, 0]);
        for (material, uses) in materials.iter().enumerate() {
            for &used in uses {
                let (slot, layer) = plan.place(material, used).unwrap();
                let array = plan.sets[plan.set_of(material)][slot as usize];
                assert_eq!(plan.arrays[array][layer as usize], used);
            }
        }
        assert!(plan.sets.iter().all(|set| set.len() <= 3));
        assert_eq!(Plan::new(&textures, &materials, 256, 1).err(), Some(2));
    }
}
