//! A device that an embedding program brings along: shared, shown in a window, too weak, lost.

use std::sync::Arc;
use std::sync::atomic::AtomicU32;
use std::sync::atomic::Ordering::Relaxed;

use crate::common::{constant_map, gpu_or_skip, no_light, one_disk, scene_of, sphere};
use glam::Vec3;
use gnomon_renderer::shadow::{self, VisibilityPath};
use gnomon_renderer::wgpu::{self, TextureFormat, TextureUsages};
use gnomon_renderer::{Gpu, GpuOptions, Presenter, RenderError, RenderSettings, Renderer};
use gnomon_scene::{Camera, Material};

const SIZE: u32 = 32;

fn adapter() -> Option<wgpu::Adapter> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::all()));
    match Gpu::choose_adapter(adapters, &GpuOptions::default()) {
        Ok(adapter) => Some(adapter),
        Err(error) => {
            gnomon_testing::skip(&error.to_string());
            None
        }
    }
}

fn open(
    adapter: &wgpu::Adapter,
    descriptor: &wgpu::DeviceDescriptor<'_>,
) -> (wgpu::Device, Result<Gpu, RenderError>) {
    let (device, queue) = pollster::block_on(adapter.request_device(descriptor)).unwrap();
    (device.clone(), Gpu::from_wgpu(adapter, device, queue))
}

fn camera() -> Camera {
    Camera::look_at(Vec3::new(0.0, 1.0, 4.0), Vec3::ZERO, 0.8)
}

fn lit_renderer(gpu: &Gpu) -> Renderer {
    let mut renderer =
        Renderer::new(gpu, RenderSettings::default().with(|s| s.techniques.supersample = 1)).unwrap();
    renderer.set_scene(&scene_of(vec![sphere()], Material::default())).unwrap();
    renderer.set_lighting(&constant_map(Vec3::ONE), &one_disk(Vec3::Y, 0.4)).unwrap();
    renderer
}

fn target(device: &wgpu::Device, format: TextureFormat) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: SIZE, height: SIZE, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_SRC,
        view_formats: &[],
    })
}

/// Reads a target of 8-bit texels back with the embedding program's own means.
fn read_back(device: &wgpu::Device, queue: &wgpu::Queue, texture: &wgpu::Texture) -> Vec<u8> {
    let bytes_per_row = wgpu::COPY_BYTES_PER_ROW_ALIGNMENT;
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(bytes_per_row * SIZE),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&Default::default());
    let layout = wgpu::TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: Some(bytes_per_row),
        rows_per_image: Some(SIZE),
    };
    let to = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
    encoder.copy_texture_to_buffer(texture.as_image_copy(), to, texture.size());
    queue.submit([encoder.finish()]);
    buffer.map_async(wgpu::MapMode::Read, .., |result| result.unwrap());
    device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
    let padded = buffer.get_mapped_range(..).unwrap().to_vec();
    padded.chunks(bytes_per_row as usize).flat_map(|row| &row[..4 * SIZE as usize]).copied().collect()
}

#[test]
fn a_window_shows_the_displayed_picture_whatever_its_format_encodes() {
    let Some(adapter) = adapter() else { return };
    let (device, queue) =
        pollster::block_on(adapter.request_device(&Gpu::device_descriptor(&adapter))).unwrap();
    let gpu = Gpu::from_wgpu(&adapter, device.clone(), queue.clone()).unwrap();
    let mut renderer = lit_renderer(&gpu);
    assert!(renderer.display_view().is_none());
    let display = renderer.render(&camera(), SIZE, SIZE).unwrap().display;
    assert!(renderer.display_view().is_some());
    for format in [TextureFormat::Rgba8Unorm, TextureFormat::Rgba8UnormSrgb] {
        let window = target(&device, format);
        let presenter = Presenter::new(&gpu, format).unwrap();
        presenter.draw(&renderer, &window.create_view(&Default::default())).unwrap();
        let shown = read_back(&device, &queue, &window);
        let far = shown.iter().zip(display.as_flattened()).map(|(a, b)| a.abs_diff(*b)).max();
        assert!(far <= Some(1), "{format:?}: off by {far:?} of 255");
    }
}

#[test]
fn webgpus_default_limits_without_features_draw_the_default_techniques() {
    let Some(adapter) = adapter() else { return };
    let (_, gpu) = open(&adapter, &wgpu::DeviceDescriptor::default());
    let gpu = gpu.unwrap();
    assert!(gpu.device().features().is_empty());
    let mut renderer = Renderer::new(&gpu, RenderSettings::default()).unwrap();
    renderer.set_scene(&scene_of(vec![sphere()], Material::default())).unwrap();
    renderer.set_lighting(&constant_map(Vec3::ONE), &one_disk(Vec3::Y, 0.4)).unwrap();
    let Some(full) = gpu_or_skip() else { return };
    let mut expected = Renderer::new(&full, RenderSettings::default()).unwrap();
    expected.set_scene(&scene_of(vec![sphere()], Material::default())).unwrap();
    expected.set_lighting(&constant_map(Vec3::ONE), &one_disk(Vec3::Y, 0.4)).unwrap();
    let picture = |renderer: &mut Renderer| renderer.render(&camera(), SIZE, SIZE).unwrap().display;
    assert_eq!(picture(&mut renderer), picture(&mut expected));

    // Through a buffer the same techniques can be had, and give the pictures that a device with all features gives.
    for (shadows, visibility) in shadow::names().flat_map(|(shadows, _)| {
        [VisibilityPath::Inline, VisibilityPath::Buffered].map(|visibility| (shadows, visibility))
    }) {
        let settings = RenderSettings::default().with(|s| {
            s.techniques.shadows = shadows.to_owned();
            s.techniques.visibility = visibility;
            s.techniques.shadow_resolution = 64;
        });
        let needed = match shadows {
            "convolution" | "moments" => Some("FLOAT32_FILTERABLE"),
            "stencil" => Some("DEPTH32FLOAT_STENCIL8"),
            _ => None,
        };
        if let Some(needed) = needed {
            let Err(error) = Renderer::new(&gpu, settings) else { panic!("{shadows} needs {needed}") };
            assert!(matches!(error, RenderError::NeedsFeature { .. }), "{error}");
            assert!(error.to_string().contains(shadows) && error.to_string().contains(needed));
            continue;
        }
        for renderer in [&mut renderer, &mut expected] {
            renderer.set_settings(settings.clone(), &one_disk(Vec3::Y, 0.4)).unwrap();
        }
        assert_eq!(picture(&mut renderer), picture(&mut expected), "{shadows} {visibility:?}");
    }
}

#[test]
fn a_device_that_is_too_weak_is_refused_by_name() {
    let Some(adapter) = adapter() else { return };
    let mut narrow = Gpu::device_descriptor(&adapter);
    narrow.required_limits.max_storage_textures_per_shader_stage = 2;
    let (_, gpu) = open(&adapter, &narrow);
    let Err(error @ RenderError::MissingFeature { .. }) = gpu else { panic!("no limit was missed") };
    assert!(error.to_string().contains("4 storage textures"), "{error}");

    let mut narrow = Gpu::device_descriptor(&adapter);
    narrow.required_limits.max_storage_buffers_per_shader_stage = 7;
    let (_, gpu) = open(&adapter, &narrow);
    let Err(error @ RenderError::MissingFeature { .. }) = gpu else { panic!("no limit was missed") };
    assert!(error.to_string().contains("8 storage buffers"), "{error}");
}

#[test]
fn a_programs_handlers_are_told_its_own_errors_and_its_loss_and_nothing_else() {
    let Some(adapter) = adapter() else { return };
    let (device, gpu) = open(&adapter, &Gpu::device_descriptor(&adapter));
    let gpu = gpu.unwrap();
    let told: Arc<[AtomicU32; 2]> = Arc::default();
    let (errors, losses) = (Arc::clone(&told), Arc::clone(&told));
    device.on_uncaptured_error(Arc::new(move |_| {
        errors[0].fetch_add(1, Relaxed);
    }));
    device.set_device_lost_callback(move |_, _| {
        losses[1].fetch_add(1, Relaxed);
    });
    let told = || [told[0].load(Relaxed), told[1].load(Relaxed)];
    let mut renderer = lit_renderer(&gpu);

    // A format that cannot be drawn into: this library's error, and only of this call.
    let Err(error) = Presenter::new(&gpu, TextureFormat::Rgb9e5Ufloat) else { panic!("no such target") };
    assert!(matches!(error, RenderError::Device(_)), "{error}");
    renderer.draw(&camera(), SIZE, SIZE).unwrap();
    assert_eq!(told(), [0, 0]);

    // The program's own error, which is none of this library's.
    let _ = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: 16,
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::MAP_WRITE,
        mapped_at_creation: false,
    });
    assert_eq!(told(), [1, 0]);
    renderer.draw(&camera(), SIZE, SIZE).unwrap();

    device.destroy();
    assert!(matches!(renderer.draw(&camera(), SIZE, SIZE), Err(RenderError::DeviceLost { .. })));
    // Its loss is told when the device is looked after next.
    let _ = device.poll(wgpu::PollType::Poll);
    assert_eq!(told(), [1, 1]);
}

#[test]
fn a_frame_in_the_programs_own_encoder_is_the_frame_that_is_rendered() {
    let Some(gpu) = gpu_or_skip() else { return };
    let (device, queue) = (gpu.device(), gpu.queue());
    let mut renderer = lit_renderer(&gpu);
    let expected = renderer.render(&camera(), SIZE, SIZE).unwrap().display;
    let window = target(device, TextureFormat::Rgba8Unorm);
    let presenter = Presenter::new(&gpu, TextureFormat::Rgba8Unorm).unwrap();
    let mut elsewhere = lit_renderer(&gpu);
    let mut encoder = device.create_command_encoder(&Default::default());
    elsewhere.record(&mut encoder, &camera(), SIZE, SIZE).unwrap();
    presenter.record(&mut encoder, &elsewhere, &window.create_view(&Default::default())).unwrap();
    let before = read_back(device, queue, &window);
    assert!(before.iter().all(|byte| *byte == 0), "recording has submitted something");
    queue.submit([encoder.finish()]);
    let shown = read_back(device, queue, &window);
    let far = shown.iter().zip(expected.as_flattened()).map(|(a, b)| a.abs_diff(*b)).max();
    assert!(far <= Some(1), "off by {far:?} of 255");
}

#[test]
fn a_lost_device_is_an_error_in_every_call_and_a_new_one_draws_again() {
    let Some(adapter) = adapter() else { return };
    let scene = scene_of(vec![sphere()], Material::default());
    let (device, gpu) = open(&adapter, &Gpu::device_descriptor(&adapter));
    let gpu = gpu.unwrap();
    let mut renderer = lit_renderer(&gpu);
    let before = renderer.render(&camera(), SIZE, SIZE).unwrap().display;

    device.destroy();
    #[track_caller]
    fn lost<T>(result: Result<T, RenderError>) {
        let Err(error) = result else { panic!("the loss went unseen") };
        assert!(matches!(error, RenderError::DeviceLost { .. }), "{error}");
    }
    lost(renderer.render(&camera(), SIZE, SIZE));
    lost(renderer.draw(&camera(), SIZE, SIZE));
    lost(renderer.submit(&camera(), 2 * SIZE, SIZE));
    lost(renderer.set_scene(&scene));
    lost(renderer.set_materials(&scene));
    lost(renderer.set_lighting(&no_light(), &one_disk(Vec3::Y, 0.2)));
    lost(Renderer::new(&gpu, RenderSettings::default()));
    lost(Presenter::new(&gpu, TextureFormat::Rgba8Unorm));
    lost(gpu.check());

    let Some(gpu) = gpu_or_skip() else { return };
    assert_eq!(lit_renderer(&gpu).render(&camera(), SIZE, SIZE).unwrap().display, before);
}

#[test]
fn a_renderer_outlives_the_handle_it_was_made_with_and_shares_the_device() {
    let Some(gpu) = gpu_or_skip() else { return };
    let clone = gpu.clone();
    let mut renderer = lit_renderer(&gpu);
    drop(gpu);
    renderer.draw(&camera(), SIZE, SIZE).unwrap();
    assert_eq!(clone.adapter().name, renderer.gpu().adapter().name);
}
