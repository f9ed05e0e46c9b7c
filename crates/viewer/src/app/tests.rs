//! The window's contents without a window: egui is given input, and the device draws pictures that nobody sees.

#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests fail the test")]

use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use eframe::egui::mutex::RwLock;
use eframe::egui::{Event, Id, Key, Modifiers, Pos2, ViewportId, vec2};
use eframe::egui_wgpu::{Renderer, RendererOptions};
use gnomon_renderer::{Gpu, GpuOptions, RenderError, wgpu};
use gnomon_studio::{CameraLook, StudioError};

use super::*;
use crate::Options;
use crate::notices::Level;
use crate::picture::{DebugChoice, Shown};

/// A scene that a software adapter draws quickly.
const SCENE: &str = "[[model]]\nbuiltin = \"three-boxes\"\nground = true\n\n[environment]\nbuiltin = \"room\"\n\n\
    [fit]\nlight_count = 6\n\n[render]\nsupersample = 1\nshadows = \"convolution\"\nshadow_resolution = 64\nambient = \"unshadowed\"\n";

/// Longest wait for what a thread works out.
const PATIENCE: Duration = Duration::from_secs(120);

/// A device such as a window has.
fn render_state() -> Option<RenderState> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::all()));
    let adapter = match Gpu::choose_adapter(adapters, &GpuOptions::default()) {
        Ok(adapter) => adapter,
        Err(RenderError::NoAdapter { .. } | RenderError::MissingFeature { .. }) => {
            gnomon_testing::skip("no usable graphics adapter");
            return None;
        }
        Err(error) => panic!("{error}"),
    };
    let request = adapter.request_device(&Gpu::device_descriptor(&adapter));
    let (device, queue) = pollster::block_on(request).unwrap();
    let target_format = wgpu::TextureFormat::Rgba8Unorm;
    let renderer = Renderer::new(&device, target_format, RendererOptions::default());
    Some(RenderState {
        adapter,
        available_adapters: Vec::new(),
        instance,
        device,
        queue,
        target_format,
        renderer: Arc::new(RwLock::new(renderer)),
    })
}

/// A viewer of [`SCENE`].
fn viewer_in(folder: &Path) -> Viewer {
    let scene = folder.join("scene.toml");
    std::fs::write(&scene, SCENE).unwrap();
    let mut viewer =
        Viewer::new(Options { scene: Some(scene.to_str().unwrap().to_owned()), ..Options::default() });
    viewer.picture_path = folder.join("picture.png").to_str().unwrap().to_owned();
    viewer
}

/// What egui has of a window.
struct Headless {
    ctx: Context,
    size: Vec2,
    frames: u32,
}

impl Headless {
    fn new(width: f32, height: f32) -> Self {
        Self { ctx: Context::default(), size: vec2(width, height), frames: 0 }
    }

    /// One frame; how long until the next one is wanted.
    fn frame(&mut self, events: Vec<Event>, mut contents: impl FnMut(&mut Ui)) -> Duration {
        self.frames += 1;
        let input = RawInput {
            screen_rect: Some(Rect::from_min_size(Pos2::ZERO, self.size)),
            time: Some(f64::from(self.frames) / 60.0),
            events,
            ..RawInput::default()
        };
        let output = self.ctx.run_ui(input, |ui| contents(ui));
        let wanted_after = output.viewport_output[&ViewportId::ROOT].repaint_delay;
        output.drop_without_applying_deltas();
        wanted_after
    }

    /// Frames until everything is loaded and drawn; how long until the next one is wanted.
    #[track_caller]
    fn rest(&mut self, app: &mut App<'_>) -> Duration {
        let began = Instant::now();
        loop {
            let wanted_after = self.frame(Vec::new(), |ui| app.show(ui));
            // Egui itself wants a few frames after input.
            if !app.viewer.is_busy() && app.viewer.studio().is_some() && !wanted_after.is_zero()
                || began.elapsed() > PATIENCE
            {
                return wanted_after;
            }
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    fn press(&mut self, app: &mut App<'_>, key: Key) {
        for pressed in [true, false] {
            let event =
                Event::Key { key, physical_key: None, pressed, repeat: false, modifiers: Modifiers::NONE };
            self.frame(vec![event], |ui| app.show(ui));
        }
    }
}

fn assert_no_notices(viewer: &Viewer) {
    assert!(viewer.notices.lines().is_empty(), "{:?}", viewer.notices);
}

#[test]
fn a_window_without_room_draws_nothing_and_goes_on_later() {
    let folder = tempfile::tempdir().unwrap();
    let Some(state) = render_state() else { return };
    let mut viewer = viewer_in(folder.path());
    let mut app = App::over(state.clone(), &mut viewer, None);
    let mut window = Headless::new(320.0, 240.0);
    window.rest(&mut app);
    let drawn = app.viewer.picture.size();
    assert_eq!(drawn, [320, 240]);

    // A minimised window of some systems, and a panel as wide as the window.
    for size in [[0, 0], [0, 240], [320, 0]] {
        app.viewer.picture.touch();
        app.viewer.draw(&window.ctx, &state, size);
        assert_eq!((app.viewer.picture.size(), app.viewer.picture.is_stale()), (drawn, true), "{size:?}");
        assert_eq!(app.viewer.studio().unwrap().look().picture.size, drawn, "{size:?}");
        assert!(app.viewer.picture.texture().is_some());
    }
    for (size, panel) in [(vec2(0.0, 0.0), None), (vec2(90.0, 60.0), Some(true)), (vec2(200.0, 0.0), None)] {
        (window.size, app.panel) = (size, panel);
        for _ in 0..3 {
            window.frame(Vec::new(), |ui| app.show(ui));
        }
        assert_eq!(app.viewer.picture.size(), drawn, "{size:?}");
    }
    (window.size, app.panel) = (vec2(160.0, 120.0), None);
    window.rest(&mut app);
    assert_eq!((app.viewer.picture.size(), app.viewer.picture.is_stale()), ([160, 120], false));
    assert_no_notices(app.viewer);

    // What the window keeps away from the library is an error there.
    let studio = app.viewer.studio().unwrap();
    let refused = |result: Result<_, StudioError>| {
        matches!(result, Err(StudioError::Render(RenderError::OutOfRange { .. })))
    };
    for [width, height] in [[0, 0], [0, 64], [64, 0]] {
        assert!(refused(studio.submit(width, height).map(drop)));
        assert!(refused(studio.draw(width, height).map(drop)));
        assert!(refused(studio.frame(width, height).map(drop)));
        studio.converge(width, height).unwrap();
        let began = Instant::now();
        while matches!(studio.reference(), Ok(None)) && began.elapsed() < PATIENCE {
            std::thread::sleep(Duration::from_millis(2));
        }
        assert!(matches!(studio.reference(), Err(StudioError::Reference(_))));
    }
    assert!(studio.frame(64, 48).is_ok());
}

#[test]
fn drawing_the_panel_changes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let Some(state) = render_state() else { return };
    let mut viewer = viewer_in(folder.path());
    viewer.attach(&state);
    let began = Instant::now();
    while viewer.studio().is_none() && began.elapsed() < PATIENCE {
        viewer.poll();
    }
    // Finer than controls show, and out of their ranges.
    viewer.edit(|look| {
        look.environment.rotation = 1_234.568;
        look.display.exposure = Some(25.123_456);
        look.techniques.shadow_settings.convolution.order = 3;
        look.techniques.supersample = 6;
        let reflectance = "phong: diffuse=0.123456/0.3/0.7 ,shininess=812.345678,specular=0.12345";
        look.reflectance = Some(reflectance.parse().unwrap());
    });
    assert_no_notices(&viewer);
    let look = viewer.studio().unwrap().look().clone();
    assert_eq!(look.techniques.supersample, 6);
    let mut targets = Targets::default();
    let mut window = Headless::new(340.0, 4000.0);
    let mut panel = |viewer: &mut Viewer, targets: &mut Targets, events| {
        window.frame(events, |ui| {
            targets.clear();
            panel::show(ui, viewer, targets);
        });
    };
    panel(&mut viewer, &mut targets, Vec::new());
    for section in ["section Material", "section Convolution soft shadows (convolution)"] {
        let pos = targets.place(section).unwrap().center();
        let button = |pressed| Event::PointerButton {
            pos,
            button: PointerButton::Primary,
            pressed,
            modifiers: Modifiers::NONE,
        };
        for event in [Event::PointerMoved(pos), button(true), button(false)] {
            panel(&mut viewer, &mut targets, vec![event]);
        }
        // It unfolds, and moves what is below.
        for _ in 0..30 {
            panel(&mut viewer, &mut targets, Vec::new());
        }
    }
    for name in [
        "shininess",
        "own base_color",
        "env-rotation",
        "ambient-cells",
        "exposure",
        "convolution-order",
        "convolution-contact-samples",
        "supersample",
    ] {
        assert!(targets.place(name).is_some(), "'{name}' is not on display");
    }
    assert_eq!(*viewer.studio().unwrap().look(), look);
}

/// By the panel's own controls: lights of the environment become a rig, of which one is moved, tinted, switched off, looked at alone and left out.
#[test]
fn a_rig_is_edited_in_the_panel() {
    let folder = tempfile::tempdir().unwrap();
    let Some(state) = render_state() else { return };
    let mut viewer = viewer_in(folder.path());
    viewer.rig_path = folder.path().join("rig.json").to_str().unwrap().to_owned();
    let mut app = App::over(state, &mut viewer, None);
    // So high that nothing has to be scrolled, and little of it a picture.
    let mut window = Headless::new(400.0, 1500.0);
    app.panel = Some(true);
    window.rest(&mut app);
    let mut click = |app: &mut App<'_>, name: &str| {
        let pos = app.targets.place(name).unwrap_or_else(|| panic!("there is no '{name}'")).center();
        let button = |pressed| Event::PointerButton {
            pos,
            button: PointerButton::Primary,
            pressed,
            modifiers: Modifiers::NONE,
        };
        for event in [Event::PointerMoved(pos), button(true), button(false)] {
            window.frame(vec![event], |ui| app.show(ui));
        }
        window.rest(app);
        for _ in 0..30 {
            window.frame(Vec::new(), |ui| app.show(ui));
        }
    };
    let lights = |app: &mut App<'_>| {
        let studio = app.viewer.studio().unwrap();
        (studio.stage().rig().unwrap(), studio.lights().lights.clone())
    };
    click(&mut app, "section Light rig");
    let fitted = app.viewer.studio().unwrap().lights().lights.clone();
    click(&mut app, "save rig");
    let (rig, before) = lights(&mut app);
    assert_eq!((rig.lights.len(), before.len(), before[0].radiance), (6, 6, fitted[0].radiance));
    // The middle of a slider's row.
    click(&mut app, "rig azimuth");
    let (moved, shown) = lights(&mut app);
    assert_ne!(moved.lights[0].direction, rig.lights[0].direction);
    assert!(shown[0].direction.abs_diff_eq(glam::Vec3::from(moved.lights[0].direction), 1e-5));
    click(&mut app, "rig solo");
    assert_eq!((lights(&mut app).0.solo, lights(&mut app).1.len()), (Some(0), 1));
    assert_eq!(app.viewer.studio().unwrap().environment().flux().length(), 0.0);
    click(&mut app, "rig solo");
    click(&mut app, "rig on");
    assert_eq!((lights(&mut app).0.lights[0].enabled, lights(&mut app).1.len()), (false, 5));
    click(&mut app, "add light");
    assert_eq!((app.viewer.rig_light, lights(&mut app).0.lights.len(), lights(&mut app).1.len()), (6, 7, 6));
    click(&mut app, "save rig");
    let saved = lights(&mut app);
    assert!(app.viewer.studio().unwrap().look().rig.is_none() && saved.1.len() == 6);
    click(&mut app, "remove light");
    assert_eq!(lights(&mut app).1.len(), 5);
    click(&mut app, "reload rig");
    assert_eq!(lights(&mut app), saved);
}

#[test]
fn nothing_runs_without_a_clip() {
    let folder = tempfile::tempdir().unwrap();
    let Some(state) = render_state() else { return };
    let mut viewer = viewer_in(folder.path());
    let mut app = App::over(state, &mut viewer, None);
    let mut window = Headless::new(160.0, 120.0);
    assert!(!window.rest(&mut app).is_zero());
    window.press(&mut app, Key::Space);
    assert!(!app.viewer.playing);
    assert!(!window.rest(&mut app).is_zero(), "the window is drawn for ever");
}

#[test]
fn a_debug_view_that_is_not_shown_is_not_saved() {
    let folder = tempfile::tempdir().unwrap();
    let Some(state) = render_state() else { return };
    let mut viewer = viewer_in(folder.path());
    let mut app = App::over(state, &mut viewer, None);
    let mut window = Headless::new(160.0, 120.0);
    window.rest(&mut app);
    let mut saved = |app: &mut App<'_>, shown, debug| {
        (app.viewer.picture.shown, app.viewer.picture.debug) = (shown, debug);
        window.rest(app);
        app.viewer.save_picture();
        std::fs::read(&app.viewer.picture_path).unwrap()
    };
    let normals = Some(DebugChoice { view: 1, light: 0 });
    let picture = saved(&mut app, Shown::Gpu, None);
    assert!(saved(&mut app, Shown::Gpu, normals) != picture, "the view that is shown is what is saved");
    assert!(saved(&mut app, Shown::Reference, normals) == picture);
}

#[test]
fn a_reference_that_nobody_looks_at_is_given_up() {
    let folder = tempfile::tempdir().unwrap();
    let Some(state) = render_state() else { return };
    let mut viewer = viewer_in(folder.path());
    let mut app = App::over(state, &mut viewer, None);
    let mut window = Headless::new(160.0, 120.0);
    window.rest(&mut app);
    // Not even its first pass is awaited.
    window.press(&mut app, Key::R);
    app.viewer.picture.shown = Shown::Gpu;
    window.rest(&mut app);
    let began = Instant::now();
    while began.elapsed() < Duration::from_millis(500) {
        assert!(matches!(app.viewer.studio().unwrap().reference(), Ok(None)), "it goes on");
        std::thread::sleep(Duration::from_millis(10));
    }

    app.viewer.picture.shown = Shown::Reference;
    let began = Instant::now();
    while app.viewer.picture.truth.is_none() && began.elapsed() < PATIENCE {
        window.frame(Vec::new(), |ui| app.show(ui));
    }
    let traced = app.viewer.picture.texture();
    // Another view has no reference yet, and no error.
    app.viewer.move_view(|orbit| orbit.turn(glam::Vec2::new(0.3, 0.0)));
    window.frame(Vec::new(), |ui| app.show(ui));
    assert!(matches!(app.viewer.studio().unwrap().look().camera, CameraLook::Free(_)));
    assert!(app.viewer.picture.truth.is_none() && app.viewer.picture.texture() != traced);
}

#[test]
fn a_picture_that_stands_still_gets_its_number() {
    let folder = tempfile::tempdir().unwrap();
    let Some(state) = render_state() else { return };
    let mut viewer = viewer_in(folder.path());
    let mut app = App::over(state, &mut viewer, None);
    let mut window = Headless::new(160.0, 120.0);
    let began = Instant::now();
    while app.viewer.picture.checked.is_none() && began.elapsed() < PATIENCE {
        window.frame(Vec::new(), |ui| app.show(ui));
        std::thread::sleep(Duration::from_millis(5));
    }
    let error = app.viewer.picture.checked.unwrap();
    assert!(error.relative_rmse > 0.0 && error.uncertainty < 0.2, "{error:?}");
    let wanted_after = window.rest(&mut app);
    assert!(wanted_after > Duration::from_secs(1), "nothing is left to find out: {wanted_after:?}");
    app.viewer.move_view(|orbit| orbit.turn(glam::Vec2::new(0.3, 0.0)));
    window.frame(Vec::new(), |ui| app.show(ui));
    assert_eq!(app.viewer.picture.checked, None, "that was another picture");
    assert_no_notices(app.viewer);
}

#[test]
fn messages_leave_the_help_readable() {
    let ctx = Context::default();
    let mut notices = crate::notices::Notices::default();
    for i in 0..3 {
        notices.add(Level::Error, &format!("cannot read file {i}: it is no picture"));
    }
    for size in [vec2(640.0, 480.0), vec2(1280.0, 800.0)] {
        let window = Rect::from_min_size(Pos2::ZERO, size);
        let (mut messages, mut help) = (None, None);
        for _ in 0..4 {
            let input = RawInput { screen_rect: Some(window), ..RawInput::default() };
            let output = ctx.run_ui(input, |ui| {
                messages = overlay::notices(ui.ctx(), window, &mut Targets::default(), &mut notices);
                overlay::help(ui.ctx(), &mut true, messages);
                help = ui.ctx().memory(|memory| memory.area_rect(Id::unique("keys and mouse")));
            });
            output.drop_without_applying_deltas();
        }
        let (messages, help) = (messages.unwrap(), help.unwrap());
        assert!(window.contains_rect(messages) && window.contains_rect(help), "{messages} {help}");
        assert!(help.bottom() <= messages.top() && help.height() > 150.0, "{messages} {help}");
    }
}

#[test]
fn a_clip_is_framed_and_a_drag_goes_on_from_there() {
    let Some(model) = gnomon_testing::data_file("models/RobotExpressive.glb") else { return };
    let folder = tempfile::tempdir().unwrap();
    let Some(state) = render_state() else { return };
    let mut viewer = viewer_in(folder.path());
    let boxes = "builtin = \"three-boxes\"\nground = true";
    let scene = SCENE.replace(boxes, &format!("file = {:?}", model.to_str().unwrap()));
    std::fs::write(folder.path().join("scene.toml"), scene).unwrap();
    let mut app = App::over(state, &mut viewer, None);
    let mut window = Headless::new(160.0, 120.0);
    window.rest(&mut app);
    let eye = |viewer: &mut Viewer| viewer.studio().unwrap().camera().unwrap().eye();
    let at_rest = eye(app.viewer);
    app.viewer.edit(|look| look.animation.clip = Some("Jump".to_owned()));
    let framed = eye(app.viewer);
    assert!(framed.distance(at_rest) > 0.1, "{framed} {at_rest}");
    app.viewer.move_view(|_| {});
    assert!(eye(app.viewer).distance(framed) < 1e-3, "{} {framed}", eye(app.viewer));
}
