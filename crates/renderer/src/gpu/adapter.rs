//! Adapters: which there are, what they can do, which one to take.

use serde::Serialize;

use crate::{Gpu, RenderError};

/// How to choose an adapter.
#[derive(Clone, Debug, Default)]
pub struct GpuOptions {
    /// Part of the adapter's name or backend, in any case (`"llvmpipe"`, `"vulkan"`); `None` takes the fastest.
    pub adapter: Option<String>,
}

/// One adapter as `gnomon info` lists it.
#[derive(Clone, Debug, Serialize)]
pub struct AdapterSummary {
    /// Name that the driver gives.
    pub name: String,
    /// Graphics API.
    pub backend: String,
    /// `discrete GPU`, `integrated GPU`, `virtual GPU`, `software` or `other`.
    pub kind: &'static str,
    /// Driver and its version.
    pub driver: String,
    /// Whether it has everything that a frame needs.
    pub usable: bool,
    /// Largest picture side in texels.
    pub max_texture_size: u32,
    /// Most lights that can have a shadow map.
    pub max_shadow_maps: u32,
}

/// A limit that frames reach.
struct RequiredLimit {
    name: &'static str,
    least: u64,
    of: fn(&wgpu::Limits) -> u64,
}

const fn required_limit(name: &'static str, least: u64, of: fn(&wgpu::Limits) -> u64) -> RequiredLimit {
    RequiredLimit { name, least, of }
}

/// All within WebGPU's defaults.
const REQUIRED_LIMITS: [RequiredLimit; 7] = [
    required_limit("bind groups", 4, |l| l.max_bind_groups as u64),
    required_limit("storage textures a shader", 4, |l| l.max_storage_textures_per_shader_stage as u64),
    required_limit("storage buffers a shader", 8, |l| l.max_storage_buffers_per_shader_stage as u64),
    required_limit("sampled textures a shader", 12, |l| l.max_sampled_textures_per_shader_stage as u64),
    required_limit("bytes of a uniform buffer", 1 << 16, |l| l.max_uniform_buffer_binding_size),
    required_limit("colour attachments", 2, |l| l.max_color_attachments as u64),
    required_limit("invocations of a workgroup", 256, |l| l.max_compute_invocations_per_workgroup as u64),
];

fn kind(device_type: wgpu::DeviceType) -> &'static str {
    match device_type {
        wgpu::DeviceType::DiscreteGpu => "discrete GPU",
        wgpu::DeviceType::IntegratedGpu => "integrated GPU",
        wgpu::DeviceType::VirtualGpu => "virtual GPU",
        wgpu::DeviceType::Cpu => "software",
        wgpu::DeviceType::Other => "other",
    }
}

/// Smaller is better: a real GPU before software, and any API before GL, whose limits are narrower.
fn rank(info: &wgpu::AdapterInfo) -> u32 {
    let device = match info.device_type {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    };
    2 * device + u32::from(info.backend == wgpu::Backend::Gl)
}

pub(super) fn summarise(adapter: &wgpu::Adapter) -> AdapterSummary {
    let info = adapter.get_info();
    let limits = adapter.limits();
    AdapterSummary {
        usable: lack(adapter, &adapter.limits()).is_none(),
        kind: kind(info.device_type),
        backend: format!("{:?}", info.backend),
        driver: [info.driver, info.driver_info].join(" ").trim().to_owned(),
        name: info.name,
        max_texture_size: limits.max_texture_dimension_2d,
        max_shadow_maps: limits.max_texture_array_layers,
    }
}

/// What an adapter, or a device of it with these limits, lacks.
pub(super) fn lack(adapter: &wgpu::Adapter, limits: &wgpu::Limits) -> Option<String> {
    let flags = adapter.get_downlevel_capabilities().flags;
    if !flags.contains(wgpu::DownlevelFlags::COMPUTE_SHADERS) {
        return Some("compute shaders".to_owned());
    }
    let missed = REQUIRED_LIMITS.iter().find(|limit| (limit.of)(limits) < limit.least)?;
    Some(format!("{} {} (the limit is {})", missed.least, missed.name, (missed.of)(limits)))
}

pub(super) fn name(adapter: &wgpu::Adapter) -> String {
    let info = adapter.get_info();
    format!("{} ({:?})", info.name, info.backend)
}

/// All adapters of this machine.
pub(super) async fn adapters() -> Vec<wgpu::Adapter> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    instance.enumerate_adapters(wgpu::Backends::all()).await
}

/// All adapters of this machine, best first.
#[cfg(not(target_arch = "wasm32"))]
pub fn list_adapters() -> Vec<AdapterSummary> {
    let mut adapters = pollster::block_on(adapters());
    adapters.sort_by_key(|adapter| rank(&adapter.get_info()));
    adapters.iter().map(summarise).collect()
}

impl Gpu {
    /// The best of `adapters` that `options` allows and that can draw.
    ///
    /// # Errors
    /// [`RenderError::NoAdapter`], or [`RenderError::MissingFeature`] naming what the best one lacks.
    pub fn choose_adapter(
        mut adapters: Vec<wgpu::Adapter>,
        options: &GpuOptions,
    ) -> Result<wgpu::Adapter, RenderError> {
        adapters.sort_by_key(|adapter| rank(&adapter.get_info()));
        let found = match adapters.len() {
            0 => "none".to_owned(),
            _ => adapters.iter().map(name).collect::<Vec<_>>().join(", "),
        };
        let wanted = options.adapter.as_deref().map(str::to_lowercase);
        let mut first_lack = None;
        for adapter in adapters {
            if wanted.as_deref().is_some_and(|wanted| !name(&adapter).to_lowercase().contains(wanted)) {
                continue;
            }
            match lack(&adapter, &adapter.limits()) {
                None => return Ok(adapter),
                Some(feature) => {
                    let adapter = name(&adapter);
                    first_lack.get_or_insert(RenderError::MissingFeature { adapter, feature });
                }
            }
        }
        Err(first_lack.unwrap_or_else(|| RenderError::NoAdapter {
            wanted: options.adapter.as_ref().map_or("at all".to_owned(), |name| format!("named `{name}`")),
            found,
        }))
    }
}
