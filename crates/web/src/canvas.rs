//! A canvas of the page, and finished pictures on it.

use gnomon_renderer::{Gpu, Presenter, Renderer, wgpu};
use web_sys::OffscreenCanvas;

use crate::error::PageError;

/// Every browser takes it, and it leaves the encoding to the picture.
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Bgra8Unorm;

/// An adapter, its device, and what surfaces are made of.
pub struct Device {
    instance: wgpu::Instance,
    pub gpu: Gpu,
}

impl Device {
    pub async fn open() -> Result<Self, PageError> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        let adapters = instance.enumerate_adapters(wgpu::Backends::all()).await;
        let adapter = Gpu::choose_adapter(adapters, &Default::default())?;
        Ok(Self { gpu: Gpu::on(&adapter).await?, instance })
    }
}

/// A canvas that shows what a renderer has drawn.
pub struct Canvas {
    element: OffscreenCanvas,
    surface: wgpu::Surface<'static>,
    presenter: Presenter,
    size: [u32; 2],
}

impl Canvas {
    pub fn new(device: &Device, element: OffscreenCanvas) -> Result<Self, PageError> {
        let surface = device
            .instance
            .create_surface(wgpu::SurfaceTarget::OffscreenCanvas(element.clone()))
            .map_err(|error| PageError::Canvas(error.to_string()))?;
        Ok(Self { surface, presenter: Presenter::new(&device.gpu, FORMAT)?, element, size: [0, 0] })
    }

    /// The same canvas with another device.
    pub fn reopened(&self, device: &Device) -> Result<Self, PageError> {
        Self::new(device, self.element.clone())
    }

    /// Shows the picture that was drawn last over so many pixels.
    pub fn show(&mut self, gpu: &Gpu, renderer: &Renderer, size: [u32; 2]) -> Result<(), PageError> {
        if self.size != size {
            let [width, height] = size;
            self.element.set_width(width);
            self.element.set_height(height);
            self.surface.configure(
                gpu.device(),
                &wgpu::SurfaceConfiguration {
                    usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
                    format: FORMAT,
                    color_space: Default::default(),
                    width,
                    height,
                    present_mode: wgpu::PresentMode::Fifo,
                    desired_maximum_frame_latency: 2,
                    alpha_mode: wgpu::CompositeAlphaMode::Opaque,
                    view_formats: Vec::new(),
                },
            );
            self.size = size;
        }
        match self.surface.get_current_texture() {
            wgpu::CurrentSurfaceTexture::Success(frame) | wgpu::CurrentSurfaceTexture::Suboptimal(frame) => {
                self.presenter.draw(renderer, &frame.texture.create_view(&Default::default()))?;
                gpu.queue().present(frame);
            }
            // Configured anew for the next frame.
            _ => self.size = [0, 0],
        }
        Ok(())
    }
}
