use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

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

/// An open graphics device. A clone is another handle to the same device.
#[derive(Clone)]
pub struct Gpu {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    pub(crate) compiled: Arc<Compiled>,
    summary: Arc<AdapterSummary>,
    fault: Arc<Mutex<Option<Fault>>>,
}

/// What a device has reported.
enum Fault {
    Error(String),
    Lost(String),
}

/// What every frame needs beyond WebGPU's core: the average blocker depth is filtered in 32 bits.
const REQUIRED_FEATURES: wgpu::Features = wgpu::Features::FLOAT32_FILTERABLE;

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

fn summarise(adapter: &wgpu::Adapter) -> AdapterSummary {
    let info = adapter.get_info();
    let limits = adapter.limits();
    AdapterSummary {
        usable: lack(adapter, adapter.features(), &adapter.limits()).is_none(),
        kind: kind(info.device_type),
        backend: format!("{:?}", info.backend),
        driver: [info.driver, info.driver_info].join(" ").trim().to_owned(),
        name: info.name,
        max_texture_size: limits.max_texture_dimension_2d,
        max_shadow_maps: limits.max_texture_array_layers,
    }
}

/// What an adapter, or a device of it with these features and limits, lacks.
fn lack(adapter: &wgpu::Adapter, features: wgpu::Features, limits: &wgpu::Limits) -> Option<String> {
    let flags = adapter.get_downlevel_capabilities().flags;
    if !flags.contains(wgpu::DownlevelFlags::COMPUTE_SHADERS) {
        return Some("compute shaders".to_owned());
    }
    if !features.contains(REQUIRED_FEATURES) {
        return Some("filtering of 32-bit float textures (the feature FLOAT32_FILTERABLE)".to_owned());
    }
    let missed = REQUIRED_LIMITS.iter().find(|limit| (limit.of)(limits) < limit.least)?;
    Some(format!("{} {} (the limit is {})", missed.least, missed.name, (missed.of)(limits)))
}

fn name(adapter: &wgpu::Adapter) -> String {
    let info = adapter.get_info();
    format!("{} ({:?})", info.name, info.backend)
}

fn adapters() -> Vec<wgpu::Adapter> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    pollster::block_on(instance.enumerate_adapters(wgpu::Backends::all()))
}

/// All adapters of this machine, best first.
pub fn list_adapters() -> Vec<AdapterSummary> {
    let mut adapters = adapters();
    adapters.sort_by_key(|adapter| rank(&adapter.get_info()));
    adapters.iter().map(summarise).collect()
}

impl Gpu {
    /// Opens the best adapter that `options` allows.
    ///
    /// # Errors
    /// [`RenderError::NoAdapter`], [`RenderError::MissingFeature`], [`RenderError::NoDevice`].
    pub fn new(options: &GpuOptions) -> Result<Self, RenderError> {
        let adapter = Self::choose_adapter(adapters(), options)?;
        let request = adapter.request_device(&Self::device_descriptor(&adapter));
        let (device, queue) = pollster::block_on(request)
            .map_err(|error| RenderError::NoDevice { adapter: name(&adapter), reason: error.to_string() })?;
        Self::from_wgpu(&adapter, device, queue)
    }

    /// Draws with a device that an embedding program has opened already, best by [`Gpu::device_descriptor`].
    ///
    /// The device's handlers of uncaptured errors and of its loss are replaced: what they would be told, the next call of a renderer
    /// gives as an error.
    ///
    /// # Errors
    /// [`RenderError::MissingFeature`] naming the feature or limit that the device lacks.
    pub fn from_wgpu(
        adapter: &wgpu::Adapter,
        device: wgpu::Device,
        queue: wgpu::Queue,
    ) -> Result<Self, RenderError> {
        if let Some(feature) = lack(adapter, device.features(), &device.limits()) {
            return Err(RenderError::MissingFeature { adapter: name(adapter), feature });
        }
        let fault = Arc::new(Mutex::new(None));
        let note_error = Arc::clone(&fault);
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            let words = gnomon_messages::one_line(&error.to_string());
            locked(&note_error).get_or_insert(Fault::Error(words));
        }));
        let note_loss = Arc::clone(&fault);
        device.set_device_lost_callback(move |reason, message| {
            *locked(&note_loss) = Some(Fault::Lost(match reason {
                wgpu::DeviceLostReason::Destroyed => "it was destroyed".to_owned(),
                _ => gnomon_messages::one_line(&message),
            }));
        });
        Ok(Self { device, queue, compiled: Arc::default(), summary: Arc::new(summarise(adapter)), fault })
    }

    /// What a device needs so that everything the adapter can do is to be had: the features that frames need, and the
    /// adapter's own limits.
    pub fn device_descriptor(adapter: &wgpu::Adapter) -> wgpu::DeviceDescriptor<'static> {
        wgpu::DeviceDescriptor {
            label: Some("gnomon"),
            required_features: REQUIRED_FEATURES,
            // More lights than WebGPU's 256 layers, and larger meshes than its 128 MiB bindings.
            required_limits: adapter.limits(),
            ..Default::default()
        }
    }

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
            match lack(&adapter, adapter.features(), &adapter.limits()) {
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

    /// The device, for what an embedding program makes with it.
    pub fn device(&self) -> &wgpu::Device {
        &self.device
    }

    /// The queue of the device.
    pub fn queue(&self) -> &wgpu::Queue {
        &self.queue
    }

    /// The adapter in use.
    pub fn adapter(&self) -> &AdapterSummary {
        &self.summary
    }

    /// Largest number of texture array layers: the bound on shadow maps.
    pub(crate) fn max_layers(&self) -> u32 {
        self.device.limits().max_texture_array_layers
    }

    /// Bytes of the largest buffer that a shader can be given.
    pub(crate) fn largest_storage(&self) -> u64 {
        let limits = self.device.limits();
        limits.max_storage_buffer_binding_size.min(limits.max_buffer_size)
    }

    /// Waits until the GPU has done everything submitted so far.
    pub(crate) fn wait(&self) -> Result<(), RenderError> {
        let polled = self.device.poll(wgpu::PollType::wait_indefinitely());
        // A lost device explains a failed wait better than the wait's own words.
        self.check()?;
        polled.map(|_| ()).map_err(|error| RenderError::Device(error.to_string()))
    }

    /// The first fault that the device has reported, if any; it stays until the device is opened anew.
    ///
    /// # Errors
    /// [`RenderError::DeviceLost`] where nothing can be drawn with this device any more, [`RenderError::Device`] for any other fault.
    pub fn check(&self) -> Result<(), RenderError> {
        match &*locked(&self.fault) {
            Some(Fault::Error(words)) => Err(RenderError::Device(words.clone())),
            Some(Fault::Lost(reason)) => Err(RenderError::DeviceLost { reason: reason.clone() }),
            None => Ok(()),
        }
    }
}

fn locked(fault: &Mutex<Option<Fault>>) -> MutexGuard<'_, Option<Fault>> {
    fault.lock().unwrap_or_else(PoisonError::into_inner)
}
