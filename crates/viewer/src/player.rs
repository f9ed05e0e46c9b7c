//! Plays a script through egui's own input events.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use eframe::egui::{
    self, ColorImage, Context, DroppedFile, Event, Key, Modifiers, MouseWheelUnit, PointerButton, Pos2,
    RawInput, TouchPhase, Vec2, ViewportCommand,
};
use glam::Vec3;
use gnomon_picture::RgbImage;
use gnomon_picture::tonemap::srgb_decode;

use crate::notices::{Level, Notices};
use crate::script::{ScriptError, Step};
use crate::targets::Targets;

/// Longest wait for a condition.
const PATIENCE: Duration = Duration::from_secs(240);
/// Longest wait for the window system, which may refuse what it is asked for.
const COURTESY: Duration = Duration::from_secs(5);
/// Frames that a control has to come up.
const FRAMES_TO_APPEAR: u32 = 120;
/// Steps of a drag.
const DRAG_STEPS: u32 = 6;

/// What a script waits for and looks at.
pub struct Status<'a> {
    /// Something is being loaded, fitted or drawn.
    pub busy: bool,
    /// Samples a pixel of the reference.
    pub samples: u32,
    /// Messages on display.
    pub notices: &'a Notices,
}

/// What only the window can do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Request {
    /// Destroy the device.
    LoseDevice,
}

/// A script at work.
pub struct Player {
    steps: VecDeque<(usize, Step)>,
    /// Input of the frames to come, one entry a frame.
    input: VecDeque<Vec<Event>>,
    dropped: Option<PathBuf>,
    step_began: Instant,
    frames: u32,
    screenshot: Option<Arc<Mutex<Option<Arc<ColorImage>>>>>,
    failed: Option<ScriptError>,
}

/// A file that a script drops.
#[derive(Debug)]
struct ScriptedFile(PathBuf);

impl DroppedFile for ScriptedFile {
    fn path(&self) -> &Path {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        std::fs::read(&self.0).map_err(|error| error.to_string())
    }
}

impl Player {
    /// Plays these steps.
    pub fn new(steps: Vec<(usize, Step)>) -> Self {
        Self {
            steps: steps.into(),
            input: VecDeque::new(),
            dropped: None,
            step_began: Instant::now(),
            frames: 0,
            screenshot: None,
            failed: None,
        }
    }

    /// What went wrong, once the window is closed.
    pub fn failure(&self) -> Option<ScriptError> {
        let left = self.steps.front().map(|(line, _)| ScriptError {
            line: *line,
            message: "the window was closed before this was done".to_owned(),
        });
        self.failed.clone().or(left)
    }

    /// Adds one frame's input.
    pub fn play(
        &mut self,
        ctx: &Context,
        raw: &mut RawInput,
        targets: &mut Targets,
        status: &Status<'_>,
    ) -> Option<Request> {
        ctx.request_repaint();
        if let Some(path) = self.dropped.take() {
            raw.dropped_files.push(Arc::new(ScriptedFile(path)));
        }
        if let Some(events) = self.input.pop_front() {
            raw.events.extend(events);
            return None;
        }
        let (line, step) = self.steps.front().cloned()?;
        self.frames += 1;
        if self.frames == 1 {
            self.step_began = Instant::now();
        }
        match self.go(ctx, raw, targets, status, &step) {
            Ok(Progress::Waits) if self.step_began.elapsed() > PATIENCE => {
                self.fail(ctx, line, format!("waited for {} s in vain", PATIENCE.as_secs()));
            }
            Ok(Progress::Waits) => {}
            Ok(Progress::Done(request)) => {
                self.steps.pop_front();
                self.frames = 0;
                return request;
            }
            Err(message) => self.fail(ctx, line, message),
        }
        None
    }

    fn fail(&mut self, ctx: &Context, line: usize, message: String) {
        self.failed = Some(ScriptError { line, message });
        self.steps.clear();
        ctx.send_viewport_cmd(ViewportCommand::Close);
    }

    fn go(
        &mut self,
        ctx: &Context,
        raw: &RawInput,
        targets: &mut Targets,
        status: &Status<'_>,
        step: &Step,
    ) -> Result<Progress, String> {
        let window = raw.screen_rect.map_or(Vec2::splat(1.0), |rect| rect.size());
        let at = |place: Pos2| (place.to_vec2() * window).to_pos2();
        let waits_unless = |done| if done { Progress::Done(None) } else { Progress::Waits };
        match step {
            Step::Size { width, height } => {
                let wanted = Vec2::new(*width, *height);
                let is_so = (window - wanted).abs().max_elem() < 1.0;
                Ok(self.ask(ctx, ViewportCommand::InnerSize(wanted), is_so))
            }
            Step::Key { key, modifiers } => {
                self.press(*key, *modifiers);
                Ok(Progress::Done(None))
            }
            Step::Drag { button, from, to } => {
                self.drag(*button, at(*from), at(*to));
                Ok(Progress::Done(None))
            }
            Step::Scroll { at: place, lines } => {
                self.input.push_back(vec![Event::PointerMoved(at(*place))]);
                self.input.push_back(vec![Event::MouseWheel {
                    unit: MouseWheelUnit::Line,
                    delta: Vec2::new(0.0, *lines),
                    phase: TouchPhase::Move,
                    modifiers: Modifiers::NONE,
                    source: egui::MouseWheelSource::Wheel,
                }]);
                Ok(Progress::Done(None))
            }
            Step::Click { name } => self.click(targets, name),
            Step::Choose { name, value } => {
                let entry = format!("{name}={value}");
                if let Some(rect) = targets.place(&entry) {
                    targets.want(None);
                    self.click_at(rect.center());
                    return Ok(Progress::Done(None));
                }
                targets.want(Some(if targets.place(name).is_some() { &entry } else { name }));
                // The list is opened once, and has some frames to come up.
                if let (Some(rect), 0) = (targets.place(name), self.frames % 12) {
                    self.click_at(rect.center());
                }
                self.appears(&entry)
            }
            Step::Type { text } => {
                self.press(Key::A, Modifiers { ctrl: true, command: true, ..Modifiers::NONE });
                self.input.push_back(vec![Event::Text(text.clone())]);
                self.press(Key::Enter, Modifiers::NONE);
                Ok(Progress::Done(None))
            }
            Step::Drop { path } => {
                self.dropped = Some(std::path::absolute(path).map_err(|error| error.to_string())?);
                Ok(Progress::Done(None))
            }
            Step::Wait { seconds } => {
                Ok(waits_unless(self.step_began.elapsed() >= Duration::from_secs_f64(*seconds)))
            }
            // What was asked for in the frame before needs one to begin.
            Step::WaitIdle => Ok(waits_unless(self.frames > 4 && !status.busy)),
            Step::WaitSamples { count } => Ok(waits_unless(status.samples >= *count)),
            Step::Screenshot { path } => self.screenshot(ctx, path).map(waits_unless),
            Step::Expect { text } => {
                if status.notices.lines().iter().any(|notice| notice.text.contains(text.as_str())) {
                    return Ok(Progress::Done(None));
                }
                Err(format!("no message holds '{text}': {}", messages(status.notices)))
            }
            Step::ExpectNoError => {
                if status.notices.lines().iter().all(|notice| notice.level != Level::Error) {
                    return Ok(Progress::Done(None));
                }
                Err(format!("there are errors: {}", messages(status.notices)))
            }
            Step::Minimize | Step::Restore => {
                let wanted = *step == Step::Minimize;
                let is_so = raw.viewport().minimized.unwrap_or(false) == wanted;
                Ok(self.ask(ctx, ViewportCommand::Minimized(wanted), is_so))
            }
            Step::LoseDevice => Ok(Progress::Done(Some(Request::LoseDevice))),
            Step::Quit => {
                ctx.send_viewport_cmd(ViewportCommand::Close);
                Ok(Progress::Done(None))
            }
        }
    }

    /// Asks the window system for something, once, and waits until it is so.
    fn ask(&self, ctx: &Context, command: ViewportCommand, is_so: bool) -> Progress {
        if self.frames == 1 {
            ctx.send_viewport_cmd(command);
            return Progress::Waits;
        }
        if is_so || self.step_began.elapsed() > COURTESY { Progress::Done(None) } else { Progress::Waits }
    }

    fn appears(&self, name: &str) -> Result<Progress, String> {
        if self.frames > FRAMES_TO_APPEAR {
            return Err(format!("there is no control '{name}' on display"));
        }
        Ok(Progress::Waits)
    }

    fn click(&mut self, targets: &mut Targets, name: &str) -> Result<Progress, String> {
        match targets.place(name) {
            Some(rect) => {
                targets.want(None);
                self.click_at(rect.center());
                Ok(Progress::Done(None))
            }
            None => {
                targets.want(Some(name));
                self.appears(name)
            }
        }
    }

    fn press(&mut self, key: Key, modifiers: Modifiers) {
        for pressed in [true, false] {
            let event = Event::Key { key, physical_key: None, pressed, repeat: false, modifiers };
            self.input.push_back(vec![Event::ModifiersChanged(modifiers), event]);
        }
        self.input.push_back(vec![Event::ModifiersChanged(Modifiers::NONE)]);
    }

    fn click_at(&mut self, pos: Pos2) {
        self.input.push_back(vec![Event::PointerMoved(pos)]);
        for pressed in [true, false] {
            self.input.push_back(vec![button_event(pos, PointerButton::Primary, pressed)]);
        }
        // Lists and windows take a frame to come up.
        self.input.push_back(Vec::new());
    }

    fn drag(&mut self, button: PointerButton, from: Pos2, to: Pos2) {
        self.input.push_back(vec![Event::PointerMoved(from)]);
        self.input.push_back(vec![button_event(from, button, true)]);
        for i in 1..=DRAG_STEPS {
            let pos = from.lerp(to, i as f32 / DRAG_STEPS as f32);
            self.input.push_back(vec![Event::PointerMoved(pos)]);
        }
        self.input.push_back(vec![button_event(to, button, false)]);
    }

    /// Asks for the window's contents, and writes them once they are there; whether they are written.
    fn screenshot(&mut self, ctx: &Context, path: &Path) -> Result<bool, String> {
        let Some(taken) = &self.screenshot else {
            let taken = Arc::new(Mutex::new(None));
            let put = Arc::clone(&taken);
            ctx.request_screenshot(move |image| {
                *put.lock().unwrap_or_else(PoisonError::into_inner) = Some(image);
            });
            self.screenshot = Some(taken);
            return Ok(false);
        };
        let Some(image) = taken.lock().unwrap_or_else(PoisonError::into_inner).take() else {
            return Ok(false);
        };
        self.screenshot = None;
        let [width, height] = image.size.map(|side| side as u32);
        let linear = |x, y| {
            let pixel = image.pixels[(y * width + x) as usize];
            Vec3::new(f32::from(pixel.r()), f32::from(pixel.g()), f32::from(pixel.b()))
                .map(|c| srgb_decode(c / 255.0))
        };
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder).map_err(|error| error.to_string())?;
        }
        gnomon_picture::write(path, &RgbImage::from_fn(width, height, linear))
            .map_err(|error| error.to_string())?;
        Ok(true)
    }
}

/// What has become of a step.
enum Progress {
    Waits,
    Done(Option<Request>),
}

fn button_event(pos: Pos2, button: PointerButton, pressed: bool) -> Event {
    Event::PointerButton { pos, button, pressed, modifiers: Modifiers::NONE }
}

fn messages(notices: &Notices) -> String {
    match notices.lines() {
        [] => "there are none".to_owned(),
        lines => lines.iter().map(|notice| notice.text.as_str()).collect::<Vec<_>>().join("; "),
    }
}
