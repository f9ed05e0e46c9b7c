use std::sync::{Arc, Mutex, PoisonError};

use serde::Serialize;

use crate::RenderError;
use crate::bindings::Compiled;

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

/// An open graphics device.
pub struct Gpu {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    pub(crate) compiled: Compiled,
    summary: AdapterSummary,
    fault: Arc<Mutex<Option<String>>>,
}

/// What every frame needs beyond WebGPU's core: the average blocker depth is filtered in 32 bits.
const REQUIRED_FEATURES: wgpu::Features = wgpu::Features::FLOAT32_FILTERABLE;

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

fn summarise(adapter: &wgpu::Adapter) -> AdapterSummary {
    let info = adapter.get_info();
    let limits = adapter.limits();
    AdapterSummary {
        usable: missing_feature(adapter).is_none(),
        kind: kind(info.device_type),
        backend: format!("{:?}", info.backend),
        driver: [info.driver, info.driver_info].join(" ").trim().to_owned(),
        name: info.name,
        max_texture_size: limits.max_texture_dimension_2d,
        max_shadow_maps: limits.max_texture_array_layers,
    }
}

fn missing_feature(adapter: &wgpu::Adapter) -> Option<&'static str> {
    let flags = adapter.get_downlevel_capabilities().flags;
    if !flags.contains(wgpu::DownlevelFlags::COMPUTE_SHADERS) {
        Some("compute shaders")
    } else if !adapter.features().contains(REQUIRED_FEATURES) {
        Some("filtering of 32-bit float textures")
    } else if adapter.limits().max_storage_textures_per_shader_stage < 4 {
        Some("four storage textures a shader")
    } else {
        None
    }
}

fn adapters() -> Vec<wgpu::Adapter> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let mut adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::all()));
    adapters.sort_by_key(|adapter| rank(&adapter.get_info()));
    adapters
}

/// All adapters of this machine, best first.
pub fn list_adapters() -> Vec<AdapterSummary> {
    adapters().iter().map(summarise).collect()
}

impl Gpu {
    /// Opens the best adapter that `options` allows.
    ///
    /// # Errors
    /// [`RenderError::NoAdapter`], [`RenderError::MissingFeature`], [`RenderError::NoDevice`].
    pub fn new(options: &GpuOptions) -> Result<Self, RenderError> {
        let adapters = adapters();
        let name = |adapter: &wgpu::Adapter| {
            let info = adapter.get_info();
            format!("{} ({:?})", info.name, info.backend)
        };
        let wanted = options.adapter.as_deref().map(str::to_lowercase);
        let matching = adapters.iter().filter(|adapter| {
            wanted.as_deref().is_none_or(|wanted| name(adapter).to_lowercase().contains(wanted))
        });
        // Among those that match, one that can draw; else report what the first one lacks.
        let mut first_lack = None;
        let mut chosen = None;
        for adapter in matching {
            match missing_feature(adapter) {
                None => {
                    chosen = Some(adapter);
                    break;
                }
                Some(feature) => {
                    first_lack.get_or_insert(RenderError::MissingFeature { adapter: name(adapter), feature });
                }
            }
        }
        let Some(adapter) = chosen else {
            return Err(first_lack.unwrap_or_else(|| RenderError::NoAdapter {
                wanted: options
                    .adapter
                    .as_ref()
                    .map_or("at all".to_owned(), |name| format!("named `{name}`")),
                found: match adapters.len() {
                    0 => "none".to_owned(),
                    _ => adapters.iter().map(name).collect::<Vec<_>>().join(", "),
                },
            }));
        };
        let request = adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("gnomon"),
            required_features: REQUIRED_FEATURES,
            // More lights than WebGPU's 256 layers, and larger meshes than its 128 MiB bindings.
            required_limits: adapter.limits(),
            ..Default::default()
        });
        let (device, queue) = pollster::block_on(request)
            .map_err(|error| RenderError::NoDevice { adapter: name(adapter), reason: error.to_string() })?;
        let fault = Arc::new(Mutex::new(None));
        let note = {
            let fault = Arc::clone(&fault);
            move |words: String| {
                fault.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(words);
            }
        };
        let note_error = note.clone();
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            note_error(one_line(&error.to_string()))
        }));
        device.set_device_lost_callback(move |reason, message| {
            if reason != wgpu::DeviceLostReason::Destroyed {
                note(format!("device lost: {}", one_line(&message)));
            }
        });
        Ok(Self { device, queue, compiled: Compiled::default(), summary: summarise(adapter), fault })
    }

    /// The adapter in use.
    pub fn adapter(&self) -> &AdapterSummary {
        &self.summary
    }

    /// Largest number of texture array layers: the bound on shadow maps.
    pub(crate) fn max_layers(&self) -> u32 {
        self.device.limits().max_texture_array_layers
    }

    /// Waits until the GPU has done everything submitted so far.
    pub(crate) fn wait(&self) -> Result<(), RenderError> {
        self.device
            .poll(wgpu::PollType::wait_indefinitely())
            .map_err(|e| RenderError::Device(e.to_string()))?;
        self.check()
    }

    /// The first fault that the device has reported, if any; it stays until the device is opened anew.
    pub(crate) fn check(&self) -> Result<(), RenderError> {
        match &*self.fault.lock().unwrap_or_else(PoisonError::into_inner) {
            Some(words) => Err(RenderError::Device(words.clone())),
            None => Ok(()),
        }
    }
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
