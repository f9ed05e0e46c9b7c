//! Materials and their textures on the GPU.

use std::sync::Arc;

use glam::{Affine2, UVec2, Vec2, Vec4};
use gnomon_brdf::{Model, ROUGHNESS, Surface};
use gnomon_scene::{AlphaMode, Height, Material, Scene, Texture, TextureId, TextureRef, Wrap};
use gnomon_shaders::layout;

mod arrays;
mod far;
pub(crate) mod tables;

pub(crate) use arrays::address;
use arrays::{Plan, TextureArray, TextureUse, Textures, height_range};
pub(crate) use far::FarMaterials;
use tables::{PackedTables, TableTextures, TabulatedMaterials};

use crate::bindings::{Binding, D2_ARRAY};
use crate::{Gpu, RenderError};

/// A scene's materials; the last one is the default material.
pub(crate) struct Materials {
    /// [`layout::Material`] of each, for every pass that draws or reads surfaces.
    pub records: wgpu::Buffer,
    /// [`layout::MaterialTexture`] of each, material after material.
    textures: wgpu::Buffer,
    /// By set of textures.
    bind_groups: Vec<wgpu::BindGroup>,
    plan: Plan,
    used: Vec<Vec<TextureUse>>,
    /// Of the scene.
    scene_textures: Textures,
    arrays: Vec<TextureArray>,
    tabulated: TabulatedMaterials,
    /// Reflectances that are tables.
    pub tables: TableTextures,
    now: MaterialRecords,
    /// Whether the next frame takes over what is now.
    is_changed: bool,
}

/// What the GPU knows of materials beside their textures' texels.
pub(crate) struct MaterialRecords {
    records: Vec<layout::Material>,
    textures: Vec<layout::MaterialTexture>,
    /// Where they are others than before.
    tables: Option<(TabulatedMaterials, PackedTables)>,
}

/// The G-buffer numbers materials with 16 bits.
const MAX_MATERIALS: usize = 1 << 16;

/// How a texture lies on its meshes.
#[derive(Clone, Copy)]
struct Placement {
    uv_from_mesh: Affine2,
    set: usize,
}

/// A material's textures: what each is, a TEXTURE constant, and how it lies. To add a kind: its constant, a line here, and a case in
/// `gbuffer.wgsl`.
fn textures(material: &Material) -> impl Iterator<Item = (u32, TextureUse, Placement)> {
    let metallic_roughness =
        if is_rough(material) { layout::TEXTURE_METALLIC_ROUGHNESS } else { layout::TEXTURE_METALLIC };
    let colors: fn(TextureId) -> TextureUse = TextureUse::Colors;
    let data: fn(TextureId) -> TextureUse = TextureUse::Data;
    let places = [
        (layout::TEXTURE_BASE_COLOR, colors, material.base_color_texture),
        (metallic_roughness, data, material.metallic_roughness_texture),
        (layout::TEXTURE_NORMAL, data, material.normal_texture),
        (layout::TEXTURE_SPECULAR, data, material.specular_texture),
        (layout::TEXTURE_SPECULAR_COLOR, colors, material.specular_color_texture),
        (layout::TEXTURE_EMISSIVE, colors, material.emissive_texture),
        (layout::TEXTURE_ANISOTROPY, data, material.anisotropy_texture),
        (layout::TEXTURE_CLEARCOAT, data, material.clearcoat_texture),
        (layout::TEXTURE_CLEARCOAT_ROUGHNESS, data, material.clearcoat_roughness_texture),
        (layout::TEXTURE_CLEARCOAT_NORMAL, data, material.clearcoat_normal_texture),
        (layout::TEXTURE_SHEEN_COLOR, colors, material.sheen_color_texture),
        (layout::TEXTURE_SHEEN_ROUGHNESS, data, material.sheen_roughness_texture),
    ];
    let pictures = places.into_iter().filter_map(|(kind, used, reference)| {
        let TextureRef { texture, uv_from_mesh, set } = reference?;
        Some((kind, used(texture), Placement { uv_from_mesh, set }))
    });
    let heights = material.height.map(|Height { map, uv_from_mesh, set, .. }| {
        (layout::TEXTURE_HEIGHT, TextureUse::Slopes(map), Placement { uv_from_mesh, set })
    });
    pictures.chain(heights)
}

/// Whether the shape of a material's lobe is a roughness.
fn is_rough(material: &Material) -> bool {
    material.surface.model.shape().is_some_and(|shape| shape.name == ROUGHNESS.name)
}

fn uses(material: &Material) -> Vec<TextureUse> {
    textures(material).map(|(_, used, _)| used).collect()
}

/// Layout of what draws of surfaces bind.
pub(crate) fn material_layout(gpu: &Gpu) -> wgpu::BindGroupLayout {
    let read = Binding::Storage { read_only: true };
    let array = Binding::Texture { dimension: D2_ARRAY, filterable: true };
    let mut bindings = vec![(0, read), (1, read)];
    for slot in 0..layout::TEXTURE_SLOTS {
        bindings.extend([(2 * slot + 2, array), (2 * slot + 3, Binding::Sampler)]);
    }
    gpu.layout("materials", wgpu::ShaderStages::FRAGMENT, &bindings)
}

impl Materials {
    /// The materials of a scene. Arrays of the same textures, by their `Arc`, are those that `before` has.
    pub fn new(
        gpu: &Gpu,
        layout: &wgpu::BindGroupLayout,
        scene: &Scene,
        before: Option<&Self>,
    ) -> Result<Self, RenderError> {
        let over = |what, wanted: u64, limit: u64| RenderError::OverLimit {
            what,
            wanted,
            limit,
            adapter: gpu.adapter().name.clone(),
        };
        let largest = gpu.device.limits().max_texture_dimension_2d;
        let pictures = scene.textures.iter().map(|texture| texture.width.max(texture.height));
        let heights = scene.height_maps.iter().map(|map| map.size()[0].max(map.size()[1]));
        if let Some(side) = pictures.chain(heights).find(|&side| side > largest) {
            return Err(over("texels along a texture's side", side.into(), largest.into()));
        }
        let default = Material::default();
        let used: Vec<_> = scene.materials.iter().chain([&default]).map(uses).collect();
        if used.len() > MAX_MATERIALS {
            return Err(over("materials", used.len() as u64, MAX_MATERIALS as u64));
        }
        let slots = layout::TEXTURE_SLOTS;
        let scene_textures = Textures::of(scene);
        let plan = Plan::new(&scene_textures, &used, gpu.max_layers() as usize, slots as usize).map_err(
            |needed| over("sizes and wrappings of one material's textures", needed as u64, slots.into()),
        )?;

        let tabulated =
            TabulatedMaterials::new(scene.materials.iter(), before.map(|before| &before.tabulated));
        let tables = TableTextures::new(gpu, &tabulated.packed(gpu)?);
        let now = records(scene, &plan, &tabulated);
        let storage = wgpu::BufferUsages::STORAGE;
        let records = gpu.shared_buffer("materials", now.records.as_slice(), storage);
        let references = gpu.shared_buffer("material textures", now.textures.as_slice(), storage);
        let arrays: Vec<_> = plan
            .arrays
            .iter()
            .filter_map(|uses| {
                let mut known = before.into_iter().flat_map(|before| &before.arrays);
                let same = known.find(|array| array.holds(&scene_textures, uses)).cloned();
                same.or_else(|| TextureArray::new(gpu, &scene_textures, uses))
            })
            .collect();
        // For slots that a set leaves free.
        let black =
            Texture { width: 1, height: 1, rgba8: vec![[0; 4]], wrap: [Wrap::Repeat; 2], nearest: false };
        let black = Textures { textures: vec![Arc::new(black)], height_maps: Vec::new() };
        let free = TextureArray::new(gpu, &black, &[TextureUse::Data(TextureId(0))]);
        let bind_groups = plan.sets.iter().map(|set| {
            let mut resources = vec![(0, records.as_entire_binding()), (1, references.as_entire_binding())];
            for slot in 0..slots {
                let array = set.get(slot as usize).map(|&array| &arrays[array]).or(free.as_ref());
                let Some(array) = array else { continue };
                resources.push((2 * slot + 2, wgpu::BindingResource::TextureView(&array.view)));
                resources.push((2 * slot + 3, wgpu::BindingResource::Sampler(&array.sampler)));
            }
            gpu.bind_group("materials", layout, &resources)
        });
        Ok(Self {
            bind_groups: bind_groups.collect(),
            records,
            textures: references,
            plan,
            used,
            scene_textures,
            arrays,
            tabulated,
            tables,
            now,
            is_changed: false,
        })
    }

    /// New parameters of the same materials; `None` where their number or a texture is another, or tables are of other sizes.
    pub fn records_of(&self, gpu: &Gpu, scene: &Scene) -> Option<MaterialRecords> {
        let last = self.used.len() - 1;
        let same_uses = scene.materials.iter().map(uses).eq(self.used[..last].iter().cloned());
        if !same_uses || !self.scene_textures.are_those_of(scene) {
            return None;
        }
        let tabulated = TabulatedMaterials::new(scene.materials.iter(), Some(&self.tabulated));
        let packed = tabulated.packed(gpu).ok().filter(|packed| self.tables.has_room_for(packed))?;
        let records = records(scene, &self.plan, &tabulated);
        let tables = (!tabulated.has_those_of(&self.tabulated)).then_some((tabulated, packed));
        Some(MaterialRecords { tables, ..records })
    }

    /// Takes such parameters over, for the next frame.
    pub fn change(&mut self, records: MaterialRecords) {
        (self.now, self.is_changed) = (records, true);
    }

    /// Brings what has changed to the GPU, to reflections as well.
    pub fn upload(&mut self, gpu: &Gpu, far: Option<&FarMaterials>) {
        if std::mem::take(&mut self.is_changed) {
            gpu.write(&self.records, self.now.records.as_slice());
            gpu.write(&self.textures, self.now.textures.as_slice());
            if let Some((tabulated, packed)) = self.now.tables.take() {
                self.tables.write(gpu, &packed);
                self.tabulated = tabulated;
            }
            if let Some(far) = far {
                far.write(gpu, self);
            }
        }
    }

    /// The number of one of the scene's materials, or of the default one.
    pub fn number(&self, material: Option<usize>) -> usize {
        material.unwrap_or(self.used.len() - 1)
    }

    /// The bind group that draws with a material take.
    pub fn bind_group(&self, number: usize) -> &wgpu::BindGroup {
        &self.bind_groups[self.plan.set_of(number)]
    }
}

/// Of every material, the default one last.
fn records(scene: &Scene, plan: &Plan, tabulated: &TabulatedMaterials) -> MaterialRecords {
    let scene_textures = Textures::of(scene);
    let (mut records, mut references) = (Vec::new(), Vec::new());
    let default = Material::default();
    for (number, material) in scene.materials.iter().chain([&default]).enumerate() {
        let first_texture = references.len() as u32;
        for (kind, used, placement) in textures(material) {
            let Some((slot, layer)) = plan.place(number, used) else { continue };
            let wrap = scene_textures.wrap(used).map(wrap_code);
            let matrix = placement.uv_from_mesh;
            let (x, y, t) = (matrix.matrix2.x_axis, matrix.matrix2.y_axis, matrix.translation);
            references.push(layout::MaterialTexture {
                uv_rows: [Vec4::new(x.x, y.x, t.x, 0.0), Vec4::new(x.y, y.y, t.y, 0.0)],
                wrap: UVec2::from(wrap),
                uv_set: placement.set as u32,
                kind,
                slot,
                layer,
            });
        }
        let end_texture = references.len() as u32;
        let record = record(material, scene, tabulated.number(number));
        records.push(layout::Material { first_texture, end_texture, ..record });
    }
    MaterialRecords { records, textures: references, tables: None }
}

/// A material without its textures, whose reflectance has the tables of a number.
fn record(material: &Material, scene: &Scene, tables: Option<usize>) -> layout::Material {
    let mut surface = material.surface.of_its_model();
    if surface.model.is_tabulated() && tables.is_none() {
        // Nothing glossy without tables, as on the CPU.
        surface = Surface { model: Model::Lambert, ..surface }.of_its_model();
    }
    let finish = surface.finish();
    let height_slope = material.height.map_or(Vec2::ZERO, |height| {
        let map = &scene.height_maps[height.map.0];
        height.scale * height_range(map) * UVec2::from(map.size()).as_vec2()
    });
    // Where heights are, textures have the whole roughness.
    let shared = material.height.is_some() && is_rough(material);
    let shape = tables.map_or(surface.shape(), |number| number as f32);
    layout::Material {
        base_color: surface.base_color.extend(material.alpha),
        emissive: material.emissive,
        metallic: surface.metallic,
        specular_color: surface.specular_color,
        specular: surface.specular,
        ior: surface.ior,
        normal_scale: material.normal_scale,
        alpha_cutoff: match material.alpha_mode {
            AlphaMode::Opaque => 0.0,
            AlphaMode::Mask { cutoff } => cutoff,
            AlphaMode::Blend => layout::ALPHA_BLENDS,
        },
        emissive_vertex_colors: u32::from(material.emissive_vertex_colors),
        catches: match (material.catches, material.fade) {
            (false, _) => layout::CATCHES_NOT,
            (true, None) => layout::CATCHES,
            (true, Some(_)) => layout::CATCHES_FADING,
        },
        model: surface.model as u32,
        shape: if shared { 1.0 } else { shape },
        roughness: if shared { shape } else { 1.0 },
        height_slope,
        clearcoat: finish.clearcoat,
        clearcoat_roughness: finish.clearcoat_roughness,
        clearcoat_normal_scale: material.clearcoat_normal_scale,
        sheen_color: finish.sheen_color,
        sheen_roughness: finish.sheen_roughness,
        has_sheen_textures: u32::from(material.has_sheen_textures() && finish.clearcoat == 0.0),
        ..Default::default()
    }
}

fn wrap_code(wrap: Wrap) -> u32 {
    match wrap {
        Wrap::Repeat => layout::WRAP_REPEAT,
        Wrap::ClampToEdge => layout::WRAP_CLAMP,
        Wrap::MirroredRepeat => layout::WRAP_MIRROR,
    }
}
