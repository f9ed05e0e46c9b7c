use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, OnceLock};
#[cfg(not(target_arch = "wasm32"))]
use std::task::{Context, Poll, Waker};

use crate::RenderError;
use crate::bindings::Compiled;
use crate::models::Models;

mod adapter;
mod errors;
mod read_back;

#[cfg(not(target_arch = "wasm32"))]
pub use adapter::list_adapters;
pub use adapter::{AdapterSummary, GpuOptions};
pub(crate) use read_back::{ReadBack, TextureReadBack};

use adapter::{lack, name, summarise};
use errors::Faults;

/// An open graphics device. A clone is another handle to the same device.
#[derive(Clone)]
pub struct Gpu {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    pub(crate) compiled: Arc<Compiled>,
    /// What shaders are compiled for.
    pub(crate) models: Models,
    summary: Arc<AdapterSummary>,
    faults: Arc<Mutex<Faults>>,
    uploaded: Arc<AtomicU64>,
    /// Once it was found out, see [`crate::MeasureSettings::profile`].
    pub(crate) stamps_are_true: Arc<OnceLock<bool>>,
}

/// Features that are asked for where the adapter has them. A frame of the default techniques needs none.
const WELCOME_FEATURES: wgpu::Features = wgpu::Features::FLOAT32_FILTERABLE
    .union(wgpu::Features::TIMESTAMP_QUERY)
    .union(wgpu::Features::DEPTH32FLOAT_STENCIL8);

impl Gpu {
    /// The same device, for shaders that know these reflectance models.
    pub(crate) fn with_models(&self, models: Models) -> Self {
        Self { models, ..self.clone() }
    }

    /// Opens the best adapter that `options` allows.
    ///
    /// # Errors
    /// [`RenderError::NoAdapter`], [`RenderError::MissingFeature`], [`RenderError::NoDevice`].
    pub async fn open(options: &GpuOptions) -> Result<Self, RenderError> {
        Self::on(&Self::choose_adapter(adapter::adapters().await, options)?).await
    }

    /// Opens this adapter, for a program that has surfaces of the adapter's instance to show frames on.
    ///
    /// # Errors
    /// [`RenderError::MissingFeature`], [`RenderError::NoDevice`].
    pub async fn on(adapter: &wgpu::Adapter) -> Result<Self, RenderError> {
        let request = adapter.request_device(&Self::device_descriptor(adapter));
        let (device, queue) = request
            .await
            .map_err(|error| RenderError::NoDevice { adapter: name(adapter), reason: error.to_string() })?;
        let gpu = Self::from_wgpu(adapter, device, queue)?;
        gpu.handle_faults();
        Ok(gpu)
    }

    /// [`Gpu::open`], waited for.
    ///
    /// # Errors
    /// As [`Gpu::open`].
    #[cfg(not(target_arch = "wasm32"))]
    pub fn new(options: &GpuOptions) -> Result<Self, RenderError> {
        pollster::block_on(Self::open(options))
    }

    /// Draws with a device that an embedding program has opened already, best by [`Gpu::device_descriptor`]; one with WebGPU's
    /// default limits and no features serves the default techniques.
    ///
    /// The device's handlers stay the program's: they are told its own errors and the device's loss. Errors of this library's calls
    /// come out of these calls.
    ///
    /// # Errors
    /// [`RenderError::MissingFeature`] naming the limit that the device lacks.
    pub fn from_wgpu(
        adapter: &wgpu::Adapter,
        device: wgpu::Device,
        queue: wgpu::Queue,
    ) -> Result<Self, RenderError> {
        if let Some(feature) = lack(adapter, &device.limits()) {
            return Err(RenderError::MissingFeature { adapter: name(adapter), feature });
        }
        Ok(Self {
            device,
            queue,
            compiled: Arc::default(),
            models: Models::default(),
            summary: Arc::new(summarise(adapter)),
            faults: Arc::default(),
            uploaded: Arc::default(),
            stamps_are_true: Arc::default(),
        })
    }

    /// What a device needs so that everything the adapter can do is to be had: features for techniques that need some, and the
    /// adapter's own limits.
    pub fn device_descriptor(adapter: &wgpu::Adapter) -> wgpu::DeviceDescriptor<'static> {
        wgpu::DeviceDescriptor {
            label: Some("gnomon"),
            required_features: adapter.features() & WELCOME_FEATURES,
            // More lights than WebGPU's 256 layers, and larger meshes than its 128 MiB bindings.
            required_limits: adapter.limits(),
            ..Default::default()
        }
    }

    /// Whether a technique can be had.
    ///
    /// # Errors
    /// [`RenderError::NeedsFeature`] where it needs features that the device was opened without.
    pub(crate) fn require(
        &self,
        technique: &'static str,
        features: wgpu::Features,
    ) -> Result<(), RenderError> {
        let missing = features - self.device.features();
        if missing.is_empty() {
            return Ok(());
        }
        let features = missing.iter_names().map(|(name, _)| name).collect::<Vec<_>>().join(", ");
        Err(RenderError::NeedsFeature { technique, features, adapter: self.summary.name.clone() })
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

    /// Bytes that this library has uploaded to buffers and textures of the device: a difference tells what a change or a frame costs.
    pub fn uploaded_bytes(&self) -> u64 {
        self.uploaded.load(Ordering::Relaxed)
    }

    pub(crate) fn count_upload(&self, bytes: &[u8]) {
        self.uploaded.fetch_add(bytes.len() as u64, Ordering::Relaxed);
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
    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) fn wait(&self) -> Result<(), RenderError> {
        let polled = self.device.poll(wgpu::PollType::wait_indefinitely());
        // A lost device explains a failed wait better than the wait's own words.
        self.check()?;
        polled.map(drop).map_err(|error| RenderError::Device(error.to_string()))
    }

    /// Waits for what becomes ready as the GPU goes on.
    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) fn wait_for<T>(
        &self,
        future: impl Future<Output = Result<T, RenderError>>,
    ) -> Result<T, RenderError> {
        let mut future = std::pin::pin!(future);
        let mut context = Context::from_waker(Waker::noop());
        loop {
            if let Poll::Ready(result) = future.as_mut().poll(&mut context) {
                return result;
            }
            self.wait()?;
        }
    }
}
