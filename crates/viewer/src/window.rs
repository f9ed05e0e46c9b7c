//! The window, opened again where its graphics device is lost.

use std::sync::Arc;
use std::time::{Duration, Instant};

use eframe::egui::{self, ViewportBuilder};
use eframe::egui_wgpu::{WgpuConfiguration, WgpuSetup, WgpuSetupCreateNew};
use gnomon_renderer::{Gpu, GpuOptions, wgpu};

use crate::app::App;
use crate::player::Player;
use crate::viewer::Viewer;
use crate::{Options, ViewerError, script};

/// A device that lives shorter than this will not live longer next time.
const SHORT_LIFE: Duration = Duration::from_secs(10);
/// So many short-lived devices in a row are enough.
const MOST_SHORT_LIVES: u32 = 3;

/// Opens the window and stays until it is closed.
///
/// # Errors
/// [`ViewerError::Window`] without a display or a usable adapter, [`ViewerError::Script`] where a scripted session fails. All else is told in
/// the window.
pub fn run(options: Options) -> Result<(), ViewerError> {
    let mut player = match &options.script {
        None => None,
        Some(path) => {
            let text = std::fs::read_to_string(path)
                .map_err(|source| ViewerError::ReadScript { path: path.clone(), source })?;
            Some(Player::new(script::parse(&text)?))
        }
    };
    let mut viewer = Viewer::new(options.clone());
    let mut short_lives = 0;
    loop {
        let began = Instant::now();
        let (shown, playing) = (&mut viewer, player.as_mut());
        let app: eframe::AppCreator<'_> =
            Box::new(|creation| Ok(Box::new(App::new(creation, shown, playing)?)));
        let closed = eframe::run_native("Gnomon", native_options(&options), app);
        if let Some(failure) = player.as_ref().and_then(Player::failure).filter(|_| !viewer.device_is_lost())
        {
            return Err(failure.into());
        }
        if !viewer.device_is_lost() {
            return closed.map_err(|error| ViewerError::Window(error.to_string()));
        }
        short_lives = if began.elapsed() < SHORT_LIFE { short_lives + 1 } else { 0 };
        if short_lives >= MOST_SHORT_LIVES {
            return Err(ViewerError::DeviceLost(short_lives));
        }
    }
}

fn native_options(options: &Options) -> eframe::NativeOptions {
    let choice = GpuOptions { adapter: options.adapter.clone() };
    let setup = WgpuSetupCreateNew {
        native_adapter_selector: Some(Arc::new(move |adapters, surface| {
            let can_show = |adapter: &&wgpu::Adapter| {
                surface.is_none_or(|surface| adapter.is_surface_supported(surface))
            };
            let adapters = adapters.iter().filter(can_show).cloned().collect();
            Gpu::choose_adapter(adapters, &choice).map_err(|error| error.to_string())
        })),
        device_descriptor: Arc::new(Gpu::device_descriptor),
        ..WgpuSetupCreateNew::without_display_handle()
    };
    eframe::NativeOptions {
        viewport: ViewportBuilder::default()
            .with_title("Gnomon")
            .with_inner_size(options.size.unwrap_or([1280.0, 800.0]))
            .with_min_inner_size(egui::vec2(160.0, 120.0))
            .with_drag_and_drop(true),
        wgpu_options: WgpuConfiguration { wgpu_setup: WgpuSetup::CreateNew(setup), ..Default::default() },
        ..Default::default()
    }
}
