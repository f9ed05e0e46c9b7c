//! Frames by the asynchronous interface alone: nothing here waits for the GPU.

use std::pin::pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::task::{Context, Poll, Wake, Waker};
use std::time::{Duration, Instant};

use crate::common::{constant_map, one_disk, scene_of, sphere};
use glam::Vec3;
use gnomon_renderer::wgpu::PollType;
use gnomon_renderer::{Gpu, GpuOptions, RenderError, RenderSettings, Renderer};
use gnomon_scene::{Camera, Material};

const SIZE: u32 = 48;

#[derive(Default)]
struct Woken(AtomicBool);

impl Wake for Woken {
    fn wake(self: Arc<Self>) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// Runs a future as a program's loop would: it looks after the device, and polls what was woken and nothing else.
fn run<T>(gpu: Option<&Gpu>, future: impl Future<Output = T>) -> T {
    let woken = Arc::new(Woken(AtomicBool::new(true)));
    let waker = Waker::from(Arc::clone(&woken));
    let mut future = pin!(future);
    let deadline = Instant::now() + Duration::from_secs(60);
    loop {
        if woken.0.swap(false, Ordering::Relaxed)
            && let Poll::Ready(result) = future.as_mut().poll(&mut Context::from_waker(&waker))
        {
            return result;
        }
        assert!(Instant::now() < deadline, "nothing has woken the future");
        if let Some(gpu) = gpu {
            gpu.device().poll(PollType::Poll).unwrap();
        }
    }
}

#[test]
fn frames_come_without_waiting_and_are_those_that_were_asked_for() {
    let gpu = match run(None, Gpu::open(&GpuOptions::default())) {
        Ok(gpu) => gpu,
        Err(error) => return gnomon_testing::skip(&error.to_string()),
    };
    let settings = RenderSettings::default().with(|s| s.techniques.supersample = 1);
    let mut renderer = Renderer::new(&gpu, settings).unwrap();
    renderer.set_scene(&scene_of(vec![sphere()], Material::default())).unwrap();
    renderer.set_lighting(&constant_map(Vec3::ONE), &one_disk(Vec3::Y, 0.4)).unwrap();
    let cameras = [4.0, 3.0].map(|z| Camera::look_at(Vec3::new(0.0, 1.0, z), Vec3::ZERO, 0.8));
    // Both are under way at once, and the second one is asked for first.
    let [first, second] = cameras.each_ref().map(|camera| renderer.render_async(camera, SIZE, SIZE));
    let (second, first) = (run(Some(&gpu), second).unwrap(), run(Some(&gpu), first).unwrap());
    for (camera, found) in cameras.iter().zip([&first, &second]) {
        let expected = renderer.render(camera, SIZE, SIZE).unwrap();
        assert_eq!((&found.radiance, &found.display), (&expected.radiance, &expected.display));
    }
    assert_ne!(first.display, second.display);
    let refused = run(Some(&gpu), renderer.render_async(&cameras[0], 0, SIZE));
    assert!(matches!(refused.map(drop), Err(RenderError::OutOfRange { .. })));
}
