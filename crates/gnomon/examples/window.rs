//! Gnomon in a program's own winit loop: the program opens the device and submits its own encoder, and no picture is read back.
use gnomon::renderer::{Gpu, Presenter, RenderSettings, Renderer, wgpu};
use gnomon::{envmap, lights::fit, scene};
use std::{error::Error, sync::Arc};
use winit::event_loop::{ActiveEventLoop, EventLoop};
use winit::window::{Window, WindowId};
use winit::{application::ApplicationHandler, event::WindowEvent};

struct View {
    window: Arc<Window>,
    surface: wgpu::Surface<'static>,
    config: wgpu::SurfaceConfiguration,
    renderer: Renderer,
    presenter: Presenter,
    angle: f32,
}

impl View {
    fn open(event_loop: &ActiveEventLoop) -> Result<Self, Box<dyn Error>> {
        let window = Arc::new(event_loop.create_window(Window::default_attributes().with_title("Gnomon"))?);
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        let surface = instance.create_surface(Arc::clone(&window))?;
        let on = wgpu::RequestAdapterOptions { compatible_surface: Some(&surface), ..Default::default() };
        let adapter = pollster::block_on(instance.request_adapter(&on))?;
        let (device, queue) = pollster::block_on(adapter.request_device(&Gpu::device_descriptor(&adapter)))?;
        let gpu = Gpu::from_wgpu(&adapter, device, queue)?;
        let config = surface.get_default_config(&adapter, 0, 0).ok_or("the surface has no format")?;
        let presenter = Presenter::new(&gpu, config.format)?;
        let map = envmap::builtin::by_name("room").ok_or("no such environment")?;
        let mut renderer =
            Renderer::new(&gpu, RenderSettings::default().with(|s| s.techniques.supersample = 1))?;
        renderer.set_scene(&scene::builtin::by_name("three-boxes")?)?;
        renderer.set_lighting(&map, &fit::by_name("optimized", &fit::FitOptions::default())?.fit(&map)?)?;
        Ok(Self { window, surface, config, renderer, presenter, angle: 0.0 })
    }

    fn draw(&mut self) -> Result<(), Box<dyn Error>> {
        let (size, gpu) = (self.window.inner_size(), self.renderer.gpu().clone());
        if size.width == 0 || size.height == 0 {
            return Ok(()); // minimised
        } else if (self.config.width, self.config.height) != (size.width, size.height) {
            (self.config.width, self.config.height) = (size.width, size.height);
            self.surface.configure(gpu.device(), &self.config);
        }
        self.angle += 0.01;
        let eye = glam::Vec3::new(5.0 * self.angle.sin(), 3.0, 5.0 * self.angle.cos());
        let camera = scene::Camera::look_at(eye, glam::Vec3::ZERO, 0.8);
        if let wgpu::CurrentSurfaceTexture::Success(frame) = self.surface.get_current_texture() {
            let mut encoder = gpu.device().create_command_encoder(&Default::default());
            self.renderer.record(&mut encoder, &camera, size.width, size.height)?;
            let target = frame.texture.create_view(&Default::default());
            self.presenter.record(&mut encoder, &self.renderer, &target)?;
            gpu.queue().submit([encoder.finish()]);
            gpu.queue().present(frame);
        } else {
            self.config.width = 0; // configured anew, as after having been minimised
        }
        self.window.request_redraw();
        Ok(())
    }
}

struct App(Result<Option<View>, Box<dyn Error>>);
impl ApplicationHandler for App {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        self.0 = View::open(event_loop).map(Some);
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        if let (Ok(Some(view)), WindowEvent::RedrawRequested) = (&mut self.0, &event)
            && let Err(error) = view.draw()
        {
            self.0 = Err(error);
        }
        if self.0.is_err() || event == WindowEvent::CloseRequested {
            event_loop.exit();
        }
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut app = App(Ok(None));
    EventLoop::new()?.run_app(&mut app)?;
    app.0.map(|_| ())
}
