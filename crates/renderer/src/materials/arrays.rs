//! Textures of a scene as layers of texture arrays, and which arrays a draw binds.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{Vec3, Vec4};
use gnomon_scene::{HeightMap, HeightMapId, Scene, Texture, TextureId, Wrap};

use crate::Gpu;
use crate::bindings::array_view;
use crate::mip_chain::{half_bytes, mip_chain};

/// A texture as it is uploaded: the same file may be used as colour and as data.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum TextureUse {
    /// sRGB.
    Colors(TextureId),
    /// Linear.
    Data(TextureId),
    /// Slopes of heights.
    Slopes(HeightMapId),
}

/// A scene's textures of both kinds.
#[derive(Clone)]
pub(super) struct Textures {
    pub textures: Vec<Arc<Texture>>,
    pub height_maps: Vec<Arc<HeightMap>>,
}

/// What a layer is made of.
#[derive(Clone)]
enum Layer {
    Texels(Arc<Texture>),
    Heights(Arc<HeightMap>),
}

/// What all layers of an array have in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct ArrayKind {
    size: [u32; 2],
    format: wgpu::TextureFormat,
    wrap: [Wrap; 2],
    nearest: bool,
}

impl Textures {
    pub fn of(scene: &Scene) -> Self {
        Self { textures: scene.textures.clone(), height_maps: scene.height_maps.clone() }
    }

    /// Whether these are the very same ones.
    pub fn are_those_of(&self, scene: &Scene) -> bool {
        same(&self.textures, &scene.textures) && same(&self.height_maps, &scene.height_maps)
    }

    /// Addressing of one.
    pub fn wrap(&self, used: TextureUse) -> [Wrap; 2] {
        self.kind(used).wrap
    }

    fn kind(&self, used: TextureUse) -> ArrayKind {
        let of_texture = |texture: TextureId, format| {
            let texture = &self.textures[texture.0];
            let size = [texture.width, texture.height];
            ArrayKind { size, format, wrap: texture.wrap, nearest: texture.nearest }
        };
        match used {
            TextureUse::Colors(texture) => of_texture(texture, wgpu::TextureFormat::Rgba8UnormSrgb),
            TextureUse::Data(texture) => of_texture(texture, wgpu::TextureFormat::Rgba8Unorm),
            TextureUse::Slopes(map) => {
                let map = &self.height_maps[map.0];
                let format = wgpu::TextureFormat::Rgba16Float;
                ArrayKind { size: map.size(), format, wrap: map.wrap(), nearest: false }
            }
        }
    }

    fn layer(&self, used: TextureUse) -> Layer {
        match used {
            TextureUse::Colors(texture) | TextureUse::Data(texture) => {
                Layer::Texels(Arc::clone(&self.textures[texture.0]))
            }
            TextureUse::Slopes(map) => Layer::Heights(Arc::clone(&self.height_maps[map.0])),
        }
    }
}

fn same<T>(a: &[Arc<T>], b: &[Arc<T>]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| Arc::ptr_eq(a, b))
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
        textures: &Textures,
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
                    None => plan.add(&mut kinds, textures.kind(used), used, max_layers),
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
        kind: ArrayKind,
        used: TextureUse,
        max_layers: usize,
    ) -> usize {
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

/// An array and the sampler of all its layers.
#[derive(Clone)]
pub(super) struct TextureArray {
    layers: Vec<Layer>,
    format: wgpu::TextureFormat,
    pub view: wgpu::TextureView,
    pub sampler: wgpu::Sampler,
}

pub(crate) fn address(wrap: Wrap) -> wgpu::AddressMode {
    match wrap {
        Wrap::Repeat => wgpu::AddressMode::Repeat,
        Wrap::MirroredRepeat => wgpu::AddressMode::MirrorRepeat,
        Wrap::ClampToEdge => wgpu::AddressMode::ClampToEdge,
    }
}

impl TextureArray {
    /// Of textures of one kind; `None` without any.
    pub fn new(gpu: &Gpu, textures: &Textures, uses: &[TextureUse]) -> Option<Self> {
        let kind = textures.kind(*uses.first()?);
        let layers: Vec<Layer> = uses.iter().map(|&used| textures.layer(used)).collect();
        let usage = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST;
        let [width, height] = kind.size;
        let level_count = width.max(height).ilog2() + 1;
        let size = [width, height, layers.len() as u32];
        let array = gpu.texture("material textures", size, level_count, kind.format, usage);
        let is_srgb = kind.format == wgpu::TextureFormat::Rgba8UnormSrgb;
        for (layer, texture) in (0..).zip(&layers) {
            for (level, bytes) in (0..).zip(texture.mip_levels(is_srgb)) {
                let size = kind.size.map(|side| (side >> level).max(1));
                gpu.write_texture(&array, [level, layer], size, &bytes);
            }
        }
        let filter = if kind.nearest { wgpu::FilterMode::Nearest } else { wgpu::FilterMode::Linear };
        let sampler = gpu.device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("material textures"),
            address_mode_u: address(kind.wrap[0]),
            address_mode_v: address(kind.wrap[1]),
            mag_filter: filter,
            min_filter: filter,
            mipmap_filter: wgpu::MipmapFilterMode::Linear,
            // Anisotropy is only valid where every filter is linear.
            anisotropy_clamp: if kind.nearest { 1 } else { 8 },
            ..Default::default()
        });
        Some(Self { view: array_view(&array), sampler, layers, format: kind.format })
    }

    /// Whether it is that of these textures.
    pub fn holds(&self, textures: &Textures, uses: &[TextureUse]) -> bool {
        let is_same = |(layer, &used): (&Layer, &TextureUse)| match (layer, textures.layer(used)) {
            (Layer::Texels(a), Layer::Texels(b)) => Arc::ptr_eq(a, &b),
            (Layer::Heights(a), Layer::Heights(b)) => Arc::ptr_eq(a, &b),
            _ => false,
        };
        let format = uses.first().map(|&used| textures.kind(used).format);
        format == Some(self.format)
            && self.layers.len() == uses.len()
            && self.layers.iter().zip(uses).all(is_same)
    }
}

impl Layer {
    /// The bytes of all levels. Colours are averaged in linear light.
    fn mip_levels(&self, is_srgb: bool) -> Vec<Vec<u8>> {
        match self {
            Self::Texels(texture) => texel_levels(texture, is_srgb),
            Self::Heights(map) => {
                let levels = mip_chain(slopes(map), map.size().map(|side| side as usize));
                half_bytes(&levels).collect()
            }
        }
    }
}

fn texel_levels(texture: &Texture, srgb: bool) -> Vec<Vec<u8>> {
    let decode = |texel: [u8; 4]| {
        let unit = Vec4::from(texel.map(|channel| f32::from(channel) / 255.0));
        if srgb { unit.truncate().map(gnomon_picture::tonemap::srgb_decode).extend(unit.w) } else { unit }
    };
    let encode = |value: Vec4| {
        let rgb: Vec3 = value.truncate();
        let unit = if srgb { rgb.map(gnomon_picture::tonemap::srgb_encode).extend(value.w) } else { value };
        unit.to_array().map(|channel| (channel.clamp(0.0, 1.0) * 255.0 + 0.5) as u8)
    };
    let fine = texture.rgba8.iter().map(|&texel| decode(texel)).collect();
    let levels = mip_chain(fine, [texture.width as usize, texture.height as usize]);
    let coarser = levels.iter().skip(1).map(|level| level.iter().flat_map(|&value| encode(value)).collect());
    std::iter::once(texture.rgba8.as_flattened().to_vec()).chain(coarser).collect()
}

/// Slopes of a map's texels along u and v, where its whole range of heights is 1, and their squares: of a coarser level the means of both tell
/// how the slopes spread (LEAN, Olano and Baker 2010).
fn slopes(map: &HeightMap) -> Vec<Vec4> {
    let range = height_range(map);
    let [width, height] = map.size().map(i64::from);
    let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let slope = |(x, y)| map.texel_slope(x, y) / range;
    places.map(slope).map(|slope| slope.extend(slope.x * slope.x).extend(slope.y * slope.y)).collect()
}

/// From the lowest height of a map to its highest, 1 where it is flat.
pub(super) fn height_range(map: &HeightMap) -> f32 {
    let [lowest, highest] = map.range();
    if highest > lowest { highest - lowest } else { 1.0 }
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

    fn textures_of(textures: Vec<Arc<Texture>>) -> Textures {
        Textures { textures, height_maps: Vec::new() }
    }

    fn colors(ids: &[usize]) -> Vec<TextureUse> {
        ids.iter().map(|&id| TextureUse::Colors(TextureId(id))).collect()
    }

    #[test]
    fn equals_share_an_array_up_to_its_layers() {
        let textures = textures_of([4, 4, 4, 8].map(|width| texture(width, Wrap::Repeat)).into());
        let plan = Plan::new(&textures, &[colors(&[0, 1, 2, 3])], 2, 8).unwrap();
        assert_eq!(plan.arrays, [colors(&[0, 1]), colors(&[2]), colors(&[3])]);
        let data = TextureUse::Data(TextureId(0));
        let plan = Plan::new(&textures, &[vec![colors(&[0])[0], data]], 2, 8).unwrap();
        assert_eq!(plan.arrays.len(), 2, "colour and data are different formats");
        let clamped = textures_of([texture(4, Wrap::Repeat), texture(4, Wrap::ClampToEdge)].into());
        assert_eq!(Plan::new(&clamped, &[colors(&[0, 1])], 2, 8).unwrap().arrays.len(), 2);
    }

    #[test]
    fn materials_share_sets_while_slots_last() {
        let textures = textures_of((1..=6).map(|width| texture(width, Wrap::Repeat)).collect());
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
