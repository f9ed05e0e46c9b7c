//! The session behind the window: everything but widgets.

use std::sync::mpsc::{self, Receiver, TryRecvError};
use std::time::{Duration, Instant};

use eframe::egui::Context;
use eframe::egui_wgpu::RenderState;
use gnomon_options::Given;
use gnomon_renderer::debug_view::DEBUG_VIEWS;
use gnomon_renderer::lod::LodRange;
use gnomon_renderer::{Gpu, RenderError};
use gnomon_scene::Orbit;
use gnomon_studio::{
    AnimationLook, CameraLook, FrameRate, Look, Pace, Project, Stage, Studio, StudioError, Update,
    environment_named,
};

use crate::Options;
use crate::notices::{Level, Notices};
use crate::picture::{DebugChoice, Picture, Shown};

mod files;

/// Shown where nothing else was asked for or could be opened.
const DEFAULT_SCENE: &str = "three-boxes";
const DEFAULT_ENVIRONMENT: &str = "room";
/// Coarsest picture where the adapter cannot hold a finer one: one pixel for so many of the window along a side.
const COARSEST_FOR_LACK: u32 = 8;
/// After the last movement the picture is still taken to be moving for so long.
const SETTLES_AFTER: Duration = Duration::from_millis(250);

/// The state of the window's contents.
pub struct Viewer {
    gpu: Option<Gpu>,
    opening: Option<Receiver<Result<Box<Studio>, StudioError>>>,
    studio: Option<Box<Studio>>,
    options: Options,
    /// Whether the scene that was asked for could not be opened, and the default one is tried.
    fell_back: bool,
    orbit: Option<Orbit>,
    moved: Option<Instant>,
    played: Option<Instant>,
    pace: Pace,
    /// Divisor below which the adapter cannot hold the picture, and the size and samples that this is true of.
    least_divisor: u32,
    least_divisor_of: ([u32; 2], u32, u32),
    /// To be held by the session, once it is open.
    frame_rate: Option<FrameRate>,
    /// Messages to the user.
    pub notices: Notices,
    /// What is shown.
    pub picture: Picture,
    /// Whether the animation runs.
    pub playing: bool,
    /// Whether passes are timed.
    pub times: bool,
    /// Where pictures and scenes are saved.
    pub picture_path: String,
    /// See [`Viewer::picture_path`].
    pub scene_path: String,
    /// See [`Viewer::picture_path`].
    pub rig_path: String,
    /// Which light of a rig is edited.
    pub rig_light: usize,
}

impl Viewer {
    /// Nothing is open yet.
    pub fn new(options: Options) -> Self {
        let budget = options.target_fps.map(|fps| 1000.0 / fps);
        let mut notices = Notices::default();
        let frame_rate = budget.and_then(|budget| match FrameRate::new(budget, LodRange::default()) {
            Ok(frame_rate) => Some(frame_rate),
            Err(error) => {
                notices.error(&error);
                None
            }
        });
        Self {
            gpu: None,
            opening: None,
            studio: None,
            fell_back: false,
            orbit: None,
            moved: None,
            played: None,
            pace: Pace::default(),
            least_divisor: 1,
            least_divisor_of: ([0, 0], 0, 0),
            times: frame_rate.is_some(),
            frame_rate,
            notices,
            picture: Picture::default(),
            playing: false,
            picture_path: "picture.png".to_owned(),
            scene_path: "scene.toml".to_owned(),
            rig_path: "rig.json".to_owned(),
            rig_light: 0,
            options,
        }
    }

    /// Takes over the window's device: opens the first scene, or goes on with what was open before the device was lost.
    pub fn attach(&mut self, state: &RenderState) {
        let gpu = match Gpu::from_wgpu(&state.adapter, state.device.clone(), state.queue.clone()) {
            Ok(gpu) => gpu,
            Err(error) => return self.notices.error(&error),
        };
        self.gpu = Some(gpu.clone());
        self.picture.reset();
        match &mut self.studio {
            Some(studio) => match studio.reopen(&gpu) {
                Ok(()) => self.notices.add(Level::Warning, "the graphics device was lost and opened anew"),
                Err(error) => {
                    self.notices.error(&error);
                    self.studio = None;
                }
            },
            None => {
                let (scene, environment) = (self.options.scene.clone(), self.options.environment.clone());
                self.open(scene, environment);
            }
        }
    }

    /// Opens a first scene on a thread: the window is there at once.
    fn open(&mut self, scene: Option<String>, environment: Option<String>) {
        let Some(gpu) = self.gpu.clone() else { return };
        let (send, receive) = mpsc::channel();
        let open = move || -> Result<Box<Studio>, StudioError> {
            let scene = scene.unwrap_or_else(|| DEFAULT_SCENE.to_owned());
            let mut project = Project::open(&scene, Look::default(), &Given::default())?;
            let default = || project.look.map.is_none().then(|| DEFAULT_ENVIRONMENT.to_owned());
            if let Some(name) = environment.or_else(default) {
                project.look.set_environment(environment_named(&name));
            }
            Ok(Box::new(Studio::new(&gpu, Stage::new(project)?)?))
        };
        let thread = std::thread::Builder::new().name("opening".to_owned()).spawn(move || {
            // The window may be closed by now.
            let _ = send.send(open());
        });
        match thread {
            Ok(_) => self.opening = Some(receive),
            Err(error) => self.notices.error(&error),
        }
    }

    /// The session, once it is open.
    pub fn studio(&mut self) -> Option<&mut Studio> {
        self.studio.as_deref_mut()
    }

    /// Whether the device is gone, so that nothing may be drawn with it any more.
    pub fn device_is_lost(&self) -> bool {
        matches!(self.gpu.as_ref().map(Gpu::check), Some(Err(RenderError::DeviceLost { .. })))
    }

    /// Destroys the device, as a driver's reset does.
    pub fn lose_device(&self, state: &RenderState) {
        state.device.destroy();
        // Its loss is told when the device is looked after next.
        let _ = state.device.poll(gnomon_renderer::wgpu::PollType::Poll);
    }

    /// Whether anything is being loaded, fitted or still to be drawn.
    pub fn is_busy(&self) -> bool {
        let background = self.studio.as_ref().is_some_and(|studio| studio.is_busy());
        self.opening.is_some() || background || self.picture.is_stale() || self.is_moving()
    }

    /// Whether something is being loaded or fitted.
    pub fn is_loading(&self) -> bool {
        self.opening.is_some() || self.studio.as_ref().is_some_and(|studio| studio.is_busy())
    }

    /// Whether the user moves the view, or has done so a moment ago.
    pub fn is_moving(&self) -> bool {
        self.moved.is_some_and(|moved| moved.elapsed() < SETTLES_AFTER)
    }

    /// Takes over what threads have finished.
    pub fn poll(&mut self) {
        if let Some(opening) = &self.opening {
            match opening.try_recv() {
                Err(TryRecvError::Empty) => {}
                Ok(Ok(studio)) => {
                    self.opening = None;
                    let studio = self.studio.insert(studio);
                    if let Err(error) = studio.hold_frame_rate(self.frame_rate.take()) {
                        self.notices.error(&error);
                    }
                    self.scene_changed();
                }
                Ok(Err(error)) => self.opening_failed(&error),
                Err(TryRecvError::Disconnected) => {
                    self.opening_failed(&StudioError::Background("opening a scene"))
                }
            }
        }
        let Some(studio) = &mut self.studio else { return };
        let updates = studio.poll();
        self.picture.take_times(studio, &mut self.pace);
        for warning in studio.take_warnings() {
            self.notices.add(Level::Warning, &warning);
        }
        for update in updates {
            match update {
                Update::Scene => self.scene_changed(),
                Update::Lighting | Update::LevelOfDetail => self.picture.touch(),
                Update::Failed(error) => self.notices.error(&error),
            }
        }
    }

    fn opening_failed(&mut self, error: &StudioError) {
        self.opening = None;
        self.notices.error(error);
        if !std::mem::replace(&mut self.fell_back, true) {
            self.open(None, None);
        }
    }

    fn scene_changed(&mut self) {
        self.picture.touch();
        self.playing = false;
        self.take_view();
    }

    /// Turns around what the session's camera sees.
    fn take_view(&mut self) {
        let Some(studio) = &self.studio else { return };
        match studio.camera() {
            Ok(camera) => self.orbit = Some(Orbit::from_camera(&camera, studio.scene().bounds())),
            Err(error) => self.notices.error(&error),
        }
    }

    /// Frames the scene.
    pub fn frame_scene(&mut self) {
        let Some(studio) = &self.studio else { return };
        let camera = studio.stage().framing();
        self.orbit = Some(Orbit::from_camera(&camera, studio.scene().bounds()));
        self.move_view(|_| {});
    }

    /// Moves the view.
    pub fn move_view(&mut self, change: impl FnOnce(&mut Orbit)) {
        let Some(orbit) = &mut self.orbit else { return };
        change(orbit);
        let camera = orbit.camera();
        self.moved = Some(Instant::now());
        self.edit(|look| look.camera = CameraLook::Free(camera));
    }

    /// Changes the look; says so where that cannot be done.
    pub fn edit(&mut self, change: impl FnOnce(&mut Look)) {
        let Some(studio) = &mut self.studio else { return };
        let clip = studio.look().animation.clip.clone();
        if let Err(error) = studio.edit(change) {
            self.notices.error(&error);
        }
        self.picture.touch();
        let look = studio.look();
        // A camera of its own accord frames what the clip reaches.
        if look.camera == CameraLook::Automatic && look.animation.clip != clip {
            self.take_view();
        }
    }

    /// Goes to another debug view.
    pub fn step_debug_view(&mut self, by: i32) {
        let choice = self.picture.debug.unwrap_or(DebugChoice { view: 0, light: 0 });
        let count = DEBUG_VIEWS.len() as i32;
        let view = (choice.view as i32 + by).rem_euclid(count.max(1)) as usize;
        self.picture.shown = Shown::Gpu;
        self.picture.debug = (view > 0).then_some(DebugChoice { view, ..choice });
    }

    /// Goes to another light in debug views of one.
    pub fn step_light(&mut self, by: i32) {
        let Some(studio) = &mut self.studio else { return };
        let count = studio.renderer().light_count() as i64;
        if let Some(choice) = &mut self.picture.debug {
            choice.light = (choice.light as i64 + i64::from(by)).rem_euclid(count.max(1)) as usize;
        }
    }

    /// Runs or stops the clip, where one is chosen.
    pub fn toggle_playing(&mut self) {
        let has_clip = self.studio.as_ref().is_some_and(|studio| studio.look().animation.clip.is_some());
        self.playing = has_clip && !self.playing;
    }

    /// Lets the clip go on, where it runs.
    fn play(&mut self) {
        let now = self.playing.then(Instant::now);
        // What passed while nothing ran does not count.
        let (Some(before), Some(now)) = (std::mem::replace(&mut self.played, now), now) else { return };
        let step = now.duration_since(before).as_secs_f32();
        self.edit(|look| {
            look.animation = AnimationLook { time: look.animation.time + step, ..look.animation.clone() }
        });
    }

    /// Draws what is out of date into a picture for so many pixels of the window.
    pub fn draw(&mut self, ctx: &Context, state: &RenderState, window: [u32; 2]) {
        self.play();
        let moving = self.is_moving() || self.playing;
        let Some(studio) = &mut self.studio else { return };
        if window.contains(&0) || self.gpu.as_ref().is_none_or(|gpu| gpu.check().is_err()) {
            return;
        }
        studio.set_profile(self.times);
        let techniques = &studio.look().techniques;
        let wanted = (window, techniques.supersample, techniques.shadow_sampling);
        if wanted != self.least_divisor_of {
            (self.least_divisor, self.least_divisor_of) = (1, wanted);
        }
        let whole = window.map(|side| (side / self.least_divisor).max(1));
        if studio.look().picture.size != whole {
            let frames_itself = studio.look().camera == CameraLook::Automatic;
            self.edit(|look| look.picture.size = whole);
            if frames_itself {
                self.take_view();
            }
        }
        let Some(studio) = &mut self.studio else { return };
        let divisor = self.pace.divisor(moving).max(self.least_divisor);
        let size = window.map(|side| (side / divisor).max(1));
        match self.picture.draw(studio, state, (size, divisor), &mut self.pace) {
            Ok(()) => {}
            Err(StudioError::Render(error @ RenderError::OverLimit { .. }))
                if divisor < COARSEST_FOR_LACK =>
            {
                self.notices
                    .add(Level::Warning, &format!("the picture is drawn smaller than the window: {error}"));
                self.least_divisor = divisor + 1;
                self.picture.touch();
            }
            Err(error) => self.notices.error(&error),
        }
        let Some(studio) = &mut self.studio else { return };
        if self.picture.shown == Shown::Gpu {
            self.picture.forget_reference(studio);
            if !moving && let Err(error) = self.picture.check(studio, ctx) {
                self.notices.error(&error);
            }
        } else if !moving {
            match self.picture.trace(studio, ctx) {
                Ok(()) => ctx.request_repaint_after(Duration::from_millis(150)),
                Err(error) => {
                    self.notices.error(&error);
                    self.picture.shown = Shown::Gpu;
                }
            }
        }
        if moving || self.picture.is_stale() {
            ctx.request_repaint();
        } else if self.is_loading() {
            ctx.request_repaint_after(Duration::from_millis(50));
        }
    }
}
