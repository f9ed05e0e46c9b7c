//! Bind group layouts and pipelines with less ceremony. Every binding is visible to all stages its pass has.

use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::{Mutex, PoisonError};

use gnomon_shaders::layout::{self, Shared};

use crate::{Gpu, RenderError};

/// Bytes of a large texture that are on their way at a time.
const PART_BYTES: usize = 1 << 25;

/// One binding of a layout.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Binding {
    Uniform,
    Storage {
        read_only: bool,
    },
    /// `filterable` textures may be sampled; the others are only loaded.
    Texture {
        dimension: wgpu::TextureViewDimension,
        filterable: bool,
    },
    /// Whole numbers, which are only loaded.
    UintTexture,
    Depth {
        dimension: wgpu::TextureViewDimension,
    },
    StorageTexture {
        format: wgpu::TextureFormat,
        dimension: wgpu::TextureViewDimension,
    },
    Sampler,
    /// A sampler that does not filter: the only kind with which depths may be gathered.
    GatheringSampler,
    /// A sampler that compares depths.
    ComparisonSampler,
}

pub(crate) const D2: wgpu::TextureViewDimension = wgpu::TextureViewDimension::D2;
pub(crate) const D2_ARRAY: wgpu::TextureViewDimension = wgpu::TextureViewDimension::D2Array;

impl Binding {
    pub const LOADED: Self = Self::Texture { dimension: D2, filterable: false };
    pub const SAMPLED: Self = Self::Texture { dimension: D2, filterable: true };

    fn ty(self) -> wgpu::BindingType {
        let buffer = |ty| wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None };
        match self {
            Self::Uniform => buffer(wgpu::BufferBindingType::Uniform),
            Self::Storage { read_only } => buffer(wgpu::BufferBindingType::Storage { read_only }),
            Self::Texture { dimension, filterable } => wgpu::BindingType::Texture {
                sample_type: wgpu::TextureSampleType::Float { filterable },
                view_dimension: dimension,
                multisampled: false,
            },
            Self::UintTexture => wgpu::BindingType::Texture {
                sample_type: wgpu::TextureSampleType::Uint,
                view_dimension: D2,
                multisampled: false,
            },
            Self::Depth { dimension } => wgpu::BindingType::Texture {
                sample_type: wgpu::TextureSampleType::Depth,
                view_dimension: dimension,
                multisampled: false,
            },
            Self::StorageTexture { format, dimension } => wgpu::BindingType::StorageTexture {
                access: wgpu::StorageTextureAccess::WriteOnly,
                format,
                view_dimension: dimension,
            },
            Self::Sampler => wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering),
            Self::GatheringSampler => wgpu::BindingType::Sampler(wgpu::SamplerBindingType::NonFiltering),
            Self::ComparisonSampler => wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Comparison),
        }
    }
}

/// A compiled module.
pub(crate) struct Shader {
    pub module: wgpu::ShaderModule,
    /// Names of the module and of what fills its slots.
    key: String,
}

/// Bind group layouts of a pipeline, each with its number, one of the GROUP constants.
pub(crate) type Groups<'a> = &'a [(u32, &'a wgpu::BindGroupLayout)];

/// Bindings of a layout by their numbers, and the stages that see them.
type LayoutKey = (wgpu::ShaderStages, Vec<(u32, Binding)>);
/// Shader, entry point and bind group layouts.
type PipelineKey = (String, String, Vec<(u32, wgpu::BindGroupLayout)>);

/// What has been made for a device, each once: drivers take up to half a second for a pipeline's first dispatch.
#[derive(Default)]
pub(crate) struct Compiled {
    layouts: Mutex<HashMap<LayoutKey, wgpu::BindGroupLayout>>,
    modules: Mutex<HashMap<String, wgpu::ShaderModule>>,
    pipelines: Mutex<HashMap<PipelineKey, wgpu::ComputePipeline>>,
}

impl Gpu {
    /// The layout with these `(binding number, binding)` entries, made once for a device.
    pub(crate) fn layout(
        &self,
        label: &str,
        stages: wgpu::ShaderStages,
        bindings: &[(u32, Binding)],
    ) -> wgpu::BindGroupLayout {
        let new_layout = || {
            let entry = |&(binding, kind): &(u32, Binding)| wgpu::BindGroupLayoutEntry {
                binding,
                visibility: stages,
                ty: kind.ty(),
                count: None,
            };
            let entries: Vec<_> = bindings.iter().map(entry).collect();
            let descriptor = wgpu::BindGroupLayoutDescriptor { label: Some(label), entries: &entries };
            self.device.create_bind_group_layout(&descriptor)
        };
        let mut layouts = self.compiled.layouts.lock().unwrap_or_else(PoisonError::into_inner);
        layouts.entry((stages, bindings.to_vec())).or_insert_with(new_layout).clone()
    }

    pub(crate) fn bind_group(
        &self,
        label: &str,
        layout: &wgpu::BindGroupLayout,
        resources: &[(u32, wgpu::BindingResource<'_>)],
    ) -> wgpu::BindGroup {
        let entries: Vec<_> = resources
            .iter()
            .map(|(binding, resource)| wgpu::BindGroupEntry { binding: *binding, resource: resource.clone() })
            .collect();
        self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(label),
            layout,
            entries: &entries,
        })
    }

    pub(crate) fn shader(
        &self,
        module: &str,
        slots: &[gnomon_shaders::Slot<'_>],
    ) -> Result<Shader, RenderError> {
        let models = self.models.names();
        let source = gnomon_shaders::resolve(module, &[slots, &[("brdf_models", &models)]].concat())?;
        // Most shaders know of no model: the text tells which are the same.
        let mut hasher = DefaultHasher::new();
        source.hash(&mut hasher);
        let key = format!("{module} {:016x}", hasher.finish());
        let mut modules = self.compiled.modules.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(module) = modules.get(&key) {
            return Ok(Shader { module: module.clone(), key });
        }
        let module = self.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(module),
            source: wgpu::ShaderSource::Wgsl(source.into()),
        });
        modules.insert(key.clone(), module.clone());
        Ok(Shader { module, key })
    }

    pub(crate) fn pipeline_layout(&self, groups: Groups<'_>) -> wgpu::PipelineLayout {
        let count = groups.iter().map(|&(group, _)| group as usize + 1).max().unwrap_or(0);
        let mut layouts = vec![None; count];
        for &(group, layout) in groups {
            layouts[group as usize] = Some(layout);
        }
        self.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: None,
            bind_group_layouts: &layouts,
            immediate_size: 0,
        })
    }

    /// The pipeline of an entry point, made once for a device.
    pub(crate) fn compute_pipeline(
        &self,
        shader: &Shader,
        entry: &str,
        groups: Groups<'_>,
    ) -> wgpu::ComputePipeline {
        let mut pipelines = self.compiled.pipelines.lock().unwrap_or_else(PoisonError::into_inner);
        let layouts = groups.iter().map(|&(group, layout)| (group, layout.clone())).collect();
        pipelines
            .entry((shader.key.clone(), entry.to_owned(), layouts))
            .or_insert_with(|| self.new_compute_pipeline(&shader.module, entry, groups))
            .clone()
    }

    pub(crate) fn new_compute_pipeline(
        &self,
        module: &wgpu::ShaderModule,
        entry: &str,
        groups: Groups<'_>,
    ) -> wgpu::ComputePipeline {
        self.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(entry),
            layout: Some(&self.pipeline_layout(groups)),
            module,
            entry_point: Some(entry),
            compilation_options: Default::default(),
            cache: None,
        })
    }

    /// A buffer that holds a shared value or a slice of them, as shaders read it.
    pub(crate) fn shared_buffer<T: Shared + ?Sized>(
        &self,
        label: &str,
        value: &T,
        usage: wgpu::BufferUsages,
    ) -> wgpu::Buffer {
        self.buffer_with(label, &layout::bytes(value), usage)
    }

    /// Writes a shared value or a slice of them to the start of a buffer.
    pub(crate) fn write<T: Shared + ?Sized>(&self, buffer: &wgpu::Buffer, value: &T) {
        self.write_bytes(buffer, 0, &layout::bytes(value));
    }

    /// Writes bytes to a buffer.
    pub(crate) fn write_bytes(&self, buffer: &wgpu::Buffer, offset: u64, bytes: &[u8]) {
        if !bytes.is_empty() {
            self.count_upload(bytes);
            self.queue.write_buffer(buffer, offset, bytes);
        }
    }

    /// A buffer that holds `bytes`; never empty, because an empty buffer cannot be bound.
    pub(crate) fn buffer_with(&self, label: &str, bytes: &[u8], usage: wgpu::BufferUsages) -> wgpu::Buffer {
        let buffer = self.empty_buffer(label, bytes.len() as u64, usage | wgpu::BufferUsages::COPY_DST);
        self.write_bytes(&buffer, 0, bytes);
        buffer
    }

    pub(crate) fn empty_buffer(&self, label: &str, size: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
        self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size: size.next_multiple_of(16).max(256),
            usage,
            mapped_at_creation: false,
        })
    }

    pub(crate) fn texture(
        &self,
        label: &str,
        [width, height, layers]: [u32; 3],
        mip_level_count: u32,
        format: wgpu::TextureFormat,
        usage: wgpu::TextureUsages,
    ) -> wgpu::Texture {
        self.device.create_texture(&wgpu::TextureDescriptor {
            label: Some(label),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: layers },
            mip_level_count,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage,
            view_formats: &[],
        })
    }

    /// Writes one mip level of one layer.
    pub(crate) fn write_texture(
        &self,
        texture: &wgpu::Texture,
        [mip_level, layer]: [u32; 2],
        [width, height]: [u32; 2],
        bytes: &[u8],
    ) {
        self.write_rows(texture, [mip_level, layer, 0], [width, height], bytes);
    }

    /// The same of a large texture without levels, part by part, so that copies on the way to the device stay small.
    pub(crate) fn write_texture_in_parts(
        &self,
        texture: &wgpu::Texture,
        [width, height]: [u32; 2],
        bytes: &[u8],
    ) {
        let row = bytes.len() / height.max(1) as usize;
        let rows = (PART_BYTES / row.max(1)).max(1);
        for (part, bytes) in bytes.chunks(rows * row.max(1)).enumerate() {
            let size = [width, (bytes.len() / row.max(1)) as u32];
            self.write_rows(texture, [0, 0, (part * rows) as u32], size, bytes);
            // What was copied is let go once it has arrived.
            self.queue.submit([]);
        }
    }

    fn write_rows(
        &self,
        texture: &wgpu::Texture,
        [mip_level, layer, y]: [u32; 3],
        [width, height]: [u32; 2],
        bytes: &[u8],
    ) {
        self.count_upload(bytes);
        self.queue.write_texture(
            wgpu::TexelCopyTextureInfo {
                texture,
                mip_level,
                origin: wgpu::Origin3d { x: 0, y, z: layer },
                aspect: wgpu::TextureAspect::All,
            },
            bytes,
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(bytes.len() as u32 / height.max(1)),
                rows_per_image: Some(height),
            },
            wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        );
    }
}

/// The whole texture, seen as an array.
pub(crate) fn array_view(texture: &wgpu::Texture) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor { dimension: Some(D2_ARRAY), ..Default::default() })
}

/// One mip level of all layers.
pub(crate) fn level_view(texture: &wgpu::Texture, level: u32) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(D2_ARRAY),
        base_mip_level: level,
        mip_level_count: Some(1),
        ..Default::default()
    })
}

/// Binds groups, each with its number.
pub(crate) fn set_groups(pass: &mut wgpu::ComputePass<'_>, groups: &[(u32, &wgpu::BindGroup)]) {
    for &(number, group) in groups {
        pass.set_bind_group(number, group, &[]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pipelines_are_kept_by_shader_entry_and_layouts() {
        let Some(gpu) = crate::twins::gpu_or_skip() else { return };
        let shader = gpu.shader("downsample", &[]).unwrap();
        let fine = (0, Binding::Texture { dimension: D2_ARRAY, filterable: true });
        let coarse =
            (2, Binding::StorageTexture { format: wgpu::TextureFormat::R32Float, dimension: D2_ARRAY });
        let pipeline = |bindings: &[(u32, Binding)]| {
            let layout = gpu.layout("downsample", wgpu::ShaderStages::COMPUTE, bindings);
            gpu.compute_pipeline(&shader, "downsample_r32", &[(layout::GROUP_PASS, &layout)])
        };
        let used = [fine, coarse, (3, Binding::Sampler)];
        let one_more = [fine, coarse, (3, Binding::Sampler), (9, Binding::Uniform)];
        assert_eq!(pipeline(&used), pipeline(&used));
        assert_ne!(pipeline(&used), pipeline(&one_more));
        gpu.check().unwrap();
    }
}
