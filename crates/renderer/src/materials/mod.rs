//! Materials and their textures on the GPU.

use std::sync::Arc;

use glam::{UVec2, Vec4};
use gnomon_brdf::ROUGHNESS;
use gnomon_scene::{AlphaMode, Material, Scene, Texture, TextureRef, Wrap};
use gnomon_shaders::layout;

mod arrays;
mod far;

use arrays::{Plan, TextureArray, TextureUse, same_textures};
pub(crate) use far::FarMaterials;

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
    scene_textures: Vec<Arc<Texture>>,
    arrays: Vec<TextureArray>,
    now: MaterialRecords,
    /// Whether the next frame takes over what is now.
    is_changed: bool,
}

/// What the GPU knows of materials beside their textures' texels.
pub(crate) struct MaterialRecords {
    records: Vec<layout::Material>,
    textures: Vec<layout::MaterialTexture>,
}

/// The G-buffer numbers materials with 16 bits.
const MAX_MATERIALS: usize = 1 << 16;

/// A material's textures: what each is, a TEXTURE constant, and whether it is sRGB. To add a kind: its constant, a line here, and a case in
/// `gbuffer.wgsl`.
fn textures(material: &Material) -> impl Iterator<Item = (u32, bool, TextureRef)> {
    let is_rough = material.surface.model.shape().is_some_and(|shape| shape.name == ROUGHNESS.name);
    let metallic_roughness =
        if is_rough { layout::TEXTURE_METALLIC_ROUGHNESS } else { layout::TEXTURE_METALLIC };
    let places = [
        (layout::TEXTURE_BASE_COLOR, true, material.base_color_texture),
        (metallic_roughness, false, material.metallic_roughness_texture),
        (layout::TEXTURE_NORMAL, false, material.normal_texture),
        (layout::TEXTURE_SPECULAR, false, material.specular_texture),
        (layout::TEXTURE_SPECULAR_COLOR, true, material.specular_color_texture),
        (layout::TEXTURE_EMISSIVE, true, material.emissive_texture),
    ];
    places.into_iter().filter_map(|(kind, srgb, reference)| Some((kind, srgb, reference?)))
}

fn uses(material: &Material) -> Vec<TextureUse> {
    textures(material).map(|(_, srgb, r)| TextureUse { texture: r.texture, srgb }).collect()
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
        if let Some(texture) = scene.textures.iter().find(|t| t.width.max(t.height) > largest) {
            let side = texture.width.max(texture.height);
            return Err(over("texels along a texture's side", side.into(), largest.into()));
        }
        let default = Material::default();
        let used: Vec<_> = scene.materials.iter().chain([&default]).map(uses).collect();
        if used.len() > MAX_MATERIALS {
            return Err(over("materials", used.len() as u64, MAX_MATERIALS as u64));
        }
        let slots = layout::TEXTURE_SLOTS;
        let plan = Plan::new(&scene.textures, &used, gpu.max_layers() as usize, slots as usize).map_err(
            |needed| over("sizes and wrappings of one material's textures", needed as u64, slots.into()),
        )?;

        let now = records(scene, &plan);
        let storage = wgpu::BufferUsages::STORAGE;
        let records = gpu.shared_buffer("materials", now.records.as_slice(), storage);
        let references = gpu.shared_buffer("material textures", now.textures.as_slice(), storage);
        let arrays: Vec<_> = plan
            .arrays
            .iter()
            .filter_map(|layers| {
                let srgb = layers.first()?.srgb;
                let of_layers: Vec<_> =
                    layers.iter().map(|layer| Arc::clone(&scene.textures[layer.texture.0])).collect();
                let mut known = before.into_iter().flat_map(|before| &before.arrays);
                let same = known.find(|array| array.holds(&of_layers, srgb)).cloned();
                same.or_else(|| TextureArray::new(gpu, of_layers, srgb))
            })
            .collect();
        // For slots that a set leaves free.
        let black =
            Texture { width: 1, height: 1, rgba8: vec![[0; 4]], wrap: [Wrap::Repeat; 2], nearest: false };
        let free = TextureArray::new(gpu, vec![Arc::new(black)], false);
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
            scene_textures: scene.textures.clone(),
            arrays,
            now,
            is_changed: false,
        })
    }

    /// New parameters of the same materials; `None` where their number or a texture is another.
    pub fn records_of(&self, scene: &Scene) -> Option<MaterialRecords> {
        let last = self.used.len() - 1;
        let same_uses = scene.materials.iter().map(uses).eq(self.used[..last].iter().cloned());
        (same_uses && same_textures(&scene.textures, &self.scene_textures))
            .then(|| records(scene, &self.plan))
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
fn records(scene: &Scene, plan: &Plan) -> MaterialRecords {
    let (mut records, mut references) = (Vec::new(), Vec::new());
    let default = Material::default();
    for (number, material) in scene.materials.iter().chain([&default]).enumerate() {
        let first_texture = references.len() as u32;
        for (kind, srgb, reference) in textures(material) {
            let used = TextureUse { texture: reference.texture, srgb };
            let Some((slot, layer)) = plan.place(number, used) else { continue };
            let wrap = scene.textures[used.texture.0].wrap.map(wrap_code);
            let matrix = reference.uv_from_mesh;
            let (x, y, t) = (matrix.matrix2.x_axis, matrix.matrix2.y_axis, matrix.translation);
            references.push(layout::MaterialTexture {
                uv_rows: [Vec4::new(x.x, y.x, t.x, 0.0), Vec4::new(x.y, y.y, t.y, 0.0)],
                wrap: UVec2::from(wrap),
                uv_set: reference.set as u32,
                kind,
                slot,
                layer,
            });
        }
        let end_texture = references.len() as u32;
        records.push(layout::Material { first_texture, end_texture, ..record(material) });
    }
    MaterialRecords { records, textures: references }
}

/// A material without its textures.
fn record(material: &Material) -> layout::Material {
    let surface = material.surface.of_its_model();
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
        model: surface.model as u32,
        shape: surface.shape(),
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
