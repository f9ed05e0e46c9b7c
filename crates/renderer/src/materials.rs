use glam::{Vec3, Vec4};
use gnomon_scene::{AlphaMode, Material, Scene, Texture, TextureId, TextureRef, Wrap};
use gnomon_shaders::layout;

use crate::bindings::Binding;
use crate::{Gpu, RenderError};

/// Bind groups of a scene's materials; the last one is the default material.
pub(crate) struct Materials {
    bind_groups: Vec<wgpu::BindGroup>,
    /// [`layout::Material`] of each.
    parameters: Vec<wgpu::Buffer>,
    textures: Vec<[Option<TextureId>; 6]>,
}

/// The six textures of a material in the order of `gbuffer.wgsl`, and whether each is sRGB.
fn textures(material: &Material) -> [(Option<TextureRef>, bool); 6] {
    [
        (material.base_color_texture, true),
        (material.metallic_roughness_texture, false),
        (material.normal_texture, false),
        (material.specular_texture, false),
        (material.specular_color_texture, true),
        (material.emissive_texture, true),
    ]
}

fn texture_ids(material: &Material) -> [Option<TextureId>; 6] {
    textures(material).map(|(reference, _)| reference.map(|reference| reference.texture))
}

pub(crate) fn material_layout(gpu: &Gpu) -> wgpu::BindGroupLayout {
    let mut bindings = vec![(0, Binding::Uniform)];
    for texture in 0..6 {
        bindings.push((2 * texture + 1, Binding::SAMPLED));
        bindings.push((2 * texture + 2, Binding::Sampler));
    }
    gpu.layout("material", wgpu::ShaderStages::FRAGMENT, &bindings)
}

impl Materials {
    pub fn new(gpu: &Gpu, layout: &wgpu::BindGroupLayout, scene: &Scene) -> Result<Self, RenderError> {
        let largest = gpu.device.limits().max_texture_dimension_2d;
        if let Some(texture) = scene.textures.iter().find(|t| t.width.max(t.height) > largest) {
            return Err(RenderError::OverLimit {
                what: "texels along a texture's side",
                wanted: u64::from(texture.width.max(texture.height)),
                limit: u64::from(largest),
                adapter: gpu.adapter().name.clone(),
            });
        }
        let white =
            Texture { width: 1, height: 1, rgba8: vec![[255; 4]], wrap: [Wrap::Repeat; 2], nearest: false };
        let white = upload(gpu, &white, false);
        // The same file may be used as colour and as data, hence one upload a use.
        let mut uploads: Vec<[Option<(wgpu::TextureView, wgpu::Sampler)>; 2]> =
            scene.textures.iter().map(|_| [None, None]).collect();
        let default = Material::default();
        let all = scene.materials.iter().chain([&default]);
        let mut bind_groups = Vec::with_capacity(scene.materials.len() + 1);
        let mut buffers = Vec::with_capacity(scene.materials.len() + 1);
        for material in all.clone() {
            let parameters = gpu.shared_buffer("material", &uniform(material), wgpu::BufferUsages::UNIFORM);
            for (reference, srgb) in textures(material) {
                if let Some(id) = reference.map(|reference| reference.texture.0) {
                    uploads[id][usize::from(srgb)]
                        .get_or_insert_with(|| upload(gpu, &scene.textures[id], srgb));
                }
            }
            let mut resources = vec![(0, parameters.as_entire_binding())];
            for (i, (reference, srgb)) in textures(material).into_iter().enumerate() {
                let (view, sampler) = reference
                    .and_then(|reference| uploads[reference.texture.0][usize::from(srgb)].as_ref())
                    .unwrap_or(&white);
                resources.push((2 * i as u32 + 1, wgpu::BindingResource::TextureView(view)));
                resources.push((2 * i as u32 + 2, wgpu::BindingResource::Sampler(sampler)));
            }
            bind_groups.push(gpu.bind_group("material", layout, &resources));
            buffers.push(parameters);
        }
        Ok(Self { bind_groups, parameters: buffers, textures: all.map(texture_ids).collect() })
    }

    /// Takes new parameters of the same materials over, for the next frame; `false` where their number or a texture is another.
    pub fn rewrite(&self, gpu: &Gpu, scene: &Scene) -> bool {
        let last = self.textures.len() - 1;
        if !scene.materials.iter().map(texture_ids).eq(self.textures[..last].iter().copied()) {
            return false;
        }
        for (material, buffer) in scene.materials.iter().zip(&self.parameters) {
            gpu.write(buffer, &uniform(material));
        }
        true
    }

    /// The bind group of one of the scene's materials, or of the default one.
    pub fn bind_group(&self, material: Option<usize>) -> Option<&wgpu::BindGroup> {
        material.and_then(|index| self.bind_groups.get(index)).or(self.bind_groups.last())
    }
}

fn uniform(material: &Material) -> layout::Material {
    let surface = material.surface.of_its_model();
    let mut uv_rows = [Vec4::ZERO; 12];
    for (i, (reference, _)) in textures(material).into_iter().enumerate() {
        let (matrix, set) = reference.map_or(Default::default(), |r| (r.uv_from_mesh, r.set as f32));
        let (x, y, t) = (matrix.matrix2.x_axis, matrix.matrix2.y_axis, matrix.translation);
        uv_rows[2 * i] = Vec4::new(x.x, y.x, t.x, set);
        uv_rows[2 * i + 1] = Vec4::new(x.y, y.y, t.y, set);
    }
    let has_normal_texture = material.normal_texture.is_some();
    layout::Material {
        base_color: surface.base_color.extend(material.alpha),
        emissive: material.emissive,
        metallic: surface.metallic,
        specular_color: surface.specular_color,
        specular: surface.specular,
        roughness: surface.roughness,
        ior: surface.ior,
        normal_scale: if has_normal_texture { material.normal_scale } else { 0.0 },
        alpha_cutoff: match material.alpha_mode {
            AlphaMode::Opaque => 0.0,
            AlphaMode::Mask { cutoff } => cutoff,
        },
        model: surface.model as u32,
        lobe_parameter: surface.shape(),
        uv_rows,
    }
}

fn address(wrap: Wrap) -> wgpu::AddressMode {
    match wrap {
        Wrap::Repeat => wgpu::AddressMode::Repeat,
        Wrap::MirroredRepeat => wgpu::AddressMode::MirrorRepeat,
        Wrap::ClampToEdge => wgpu::AddressMode::ClampToEdge,
    }
}

fn upload(gpu: &Gpu, texture: &Texture, srgb: bool) -> (wgpu::TextureView, wgpu::Sampler) {
    let format = if srgb { wgpu::TextureFormat::Rgba8UnormSrgb } else { wgpu::TextureFormat::Rgba8Unorm };
    let levels = mip_chain(texture, srgb);
    let usage = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST;
    let size = [texture.width, texture.height, 1];
    let uploaded = gpu.texture("material texture", size, levels.len() as u32, format, usage);
    for (level, texels) in levels.iter().enumerate() {
        let size = [(texture.width >> level).max(1), (texture.height >> level).max(1)];
        gpu.write_texture(&uploaded, level as u32, size, bytemuck::cast_slice(texels));
    }
    let filter = if texture.nearest { wgpu::FilterMode::Nearest } else { wgpu::FilterMode::Linear };
    let sampler = gpu.device.create_sampler(&wgpu::SamplerDescriptor {
        label: Some("material texture"),
        address_mode_u: address(texture.wrap[0]),
        address_mode_v: address(texture.wrap[1]),
        mag_filter: filter,
        min_filter: filter,
        mipmap_filter: wgpu::MipmapFilterMode::Linear,
        // Anisotropy is only valid where every filter is linear.
        anisotropy_clamp: if texture.nearest { 1 } else { 8 },
        ..Default::default()
    });
    (uploaded.create_view(&Default::default()), sampler)
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
