//! The live session.

use std::sync::Arc;

use gnomon_envmap::Equirect;
use gnomon_lights::LightSet;
use gnomon_lights::fit::FitSettings;
use gnomon_metrics::SampledError;
use gnomon_renderer::{
    Change, Gpu, LightingChange, LightingSettings, MeasureSettings, PreparedLighting, RenderSettings,
    Renderer, SceneChange,
};
use gnomon_scene::{Camera, Scene};
use gnomon_scene_files::EnvironmentSource;

use crate::check::{Checking, Shown};
use crate::converging::Converging;
use crate::environment::{LightingRequest, LightingResult, work_out, work_out_stage};
use crate::frame_rate::{DrawnFrame, FrameRate, FramesInFlight};
use crate::job::Job;
use crate::look::EnvironmentLook;
use crate::stage::LookChange;
use crate::{EditedRig, Executor, Look, ReferencePicture, Stage, StudioError, default_executor};

mod drawing;
mod take_over;

use take_over::{LoadedStage, SceneRequest};

/// A scene that is drawn while its look changes. Every change costs the least that it can:
///
/// | change | work |
/// |---|---|
/// | camera | none |
/// | [`Look::display`]: exposure, tone mapping, background | settings of the next frame |
/// | the environment's rotation, strength and tint | directions and radiance of the lights |
/// | clip, time | a pose to the GPU |
/// | reflectance | materials to the GPU |
/// | [`Look::techniques`]: visibility, samples, sizes of shadow maps | pipelines and shadow maps; meshes and textures stay |
/// | [`Look::fit`], [`Look::lighting`], another environment | background work; then an upload |
/// | another scene | background work; then an upload |
///
/// Background work is done where an [`Executor`] says, by default on threads. [`Studio::poll`] takes its results over; frames go on
/// meanwhile with what there was.
pub struct Studio {
    stage: Stage,
    renderer: Renderer,
    lights: Arc<LightSet>,
    /// What the lights in force were made for.
    lit_for: LightingKey,
    lighting: Job<LightingRequest, Result<LightingResult, StudioError>>,
    scenes: Job<SceneRequest, Result<LoadedStage, StudioError>>,
    converging: Option<Converging>,
    checking: Option<Checking>,
    executor: Arc<dyn Executor>,
    profile: bool,
    in_flight: FramesInFlight,
    /// Frames whose times have come.
    timed: Vec<DrawnFrame>,
    frame_rate: Option<FrameRate>,
}

/// What the lights of an environment depend on.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LightingKey {
    map: Option<EnvironmentSource>,
    /// How it is read; turn and grade are another matter.
    environment: EnvironmentLook,
    rig: Option<EditedRig>,
    fit: FitSettings,
    /// Whether the scene stands on one, where that makes other lights.
    ground: bool,
    /// The environment's turn, where they were made for what arrives in an interior.
    interior_turn: Option<f32>,
    lighting: LightingSettings,
}

impl LightingKey {
    pub fn of(look: &Look, ground: bool, is_interior: bool) -> Self {
        Self {
            map: look.map.clone(),
            // Else turning needs no new lights.
            interior_turn: is_interior.then_some(look.environment.rotation),
            environment: look.environment.shown_as(&EnvironmentLook::default()),
            rig: look.edited_rig().cloned(),
            fit: look.fit.clone(),
            ground: ground && look.fit.heeds_ground(),
            lighting: look.lighting.clone(),
        }
    }

    fn same_map(&self, other: &Self) -> bool {
        (&self.map, &self.environment, &self.rig) == (&other.map, &other.environment, &other.rig)
    }

    /// Puts a look back to what these lights are for.
    fn restore(&self, look: &mut Look) {
        look.map = self.map.clone();
        look.environment = self.environment.shown_as(&look.environment);
        look.rig.clone_from(&self.rig);
        look.fit = self.fit.clone();
        look.lighting = self.lighting.clone();
    }
}

/// What [`Studio::poll`] took over.
#[derive(Debug)]
pub enum Update {
    /// Another scene is there, with the look that its file asks for.
    Scene,
    /// Environment and lights are those of the look.
    Lighting,
    /// The look asks for another level of detail, for the frame rate that is held.
    LevelOfDetail,
    /// Background work failed; scene, environment and look are what they were before it was asked for.
    Failed(StudioError),
}

impl Studio {
    /// Fits lights, and puts everything on the device. Waits for all of it.
    ///
    /// # Errors
    /// Names of nothing, settings out of range, a scene beyond the adapter's limits.
    pub fn new(gpu: &Gpu, stage: Stage) -> Result<Self, StudioError> {
        Self::with_executor(gpu, stage, default_executor())
    }

    /// The same with background work where the host wants it.
    ///
    /// # Errors
    /// As [`Studio::new`].
    pub fn with_executor(gpu: &Gpu, stage: Stage, executor: Arc<dyn Executor>) -> Result<Self, StudioError> {
        let LightingResult { lights, prepared, lit_for, .. } = work_out_stage(&stage)?;
        Ok(Self {
            renderer: renderer_of(gpu, &stage, prepared)?,
            lit_for,
            stage,
            lights: Arc::new(lights),
            lighting: Job::new("light fitting", work_out, Arc::clone(&executor)),
            scenes: Job::new("scene loading", SceneRequest::work_out, Arc::clone(&executor)),
            converging: None,
            checking: None,
            executor,
            profile: false,
            in_flight: FramesInFlight::default(),
            timed: Vec::new(),
            frame_rate: None,
        })
    }

    /// Scene, environment and look.
    pub fn stage(&self) -> &Stage {
        &self.stage
    }

    /// The look that was set last. Where threads are busy, frames may not show all of it yet.
    pub fn look(&self) -> &Look {
        self.stage.look()
    }

    /// The same with what the program has come to where exposure and number of lights are left to it.
    pub fn look_in_force(&self) -> Look {
        let mut look = self.look().clone();
        look.display.exposure = Some(self.stage.exposure());
        look.fit.light_count = Some(self.lights.lights.len().max(1));
        look
    }

    /// The scene as it is drawn.
    pub fn scene(&self) -> &Scene {
        self.stage.scene()
    }

    /// The environment as it is drawn, but for its turn and its grade.
    pub fn environment(&self) -> &Equirect {
        self.stage.environment()
    }

    /// The lights that stand for it, neither turned nor graded.
    pub fn lights(&self) -> &LightSet {
        &self.lights
    }

    /// The renderer, for what a look does not say: memory, debug views.
    pub fn renderer(&mut self) -> &mut Renderer {
        &mut self.renderer
    }

    /// What loaders repaired or ignored since this was asked last, and what the renderer cannot draw as it is, a line each.
    pub fn take_warnings(&mut self) -> Vec<String> {
        let mut warnings = self.stage.take_warnings();
        warnings.extend(self.renderer.take_warnings());
        warnings
    }

    /// Changes the look: [`Studio::set_look`] of what `change` makes of the present one.
    ///
    /// # Errors
    /// As [`Studio::set_look`].
    pub fn edit(&mut self, change: impl FnOnce(&mut Look)) -> Result<(), StudioError> {
        let mut look = self.look().clone();
        change(&mut look);
        self.set_look(look)
    }

    /// Takes another look over, by the least work. Another environment, fit or ambient rest is worked out on a thread.
    ///
    /// # Errors
    /// What can be told at once: names of nothing, settings out of range, shadow maps beyond the memory. Everything is then as it was.
    pub fn set_look(&mut self, look: Look) -> Result<(), StudioError> {
        if &look == self.look() {
            return Ok(());
        }
        let wanted = self.wanted_lighting();
        let (stage, change) = checked(&self.stage, look)?;
        let scene = match (change.dressed, change.moved) {
            (true, true) => Some(SceneChange::Whole(stage.scene())),
            (true, false) => Some(SceneChange::Materials(stage.scene())),
            (false, true) => Some(SceneChange::Pose(stage.scene())),
            (false, false) => None,
        };
        self.renderer.change(Change { scene, ..self.change_to(&stage) })?;
        self.stage = stage;
        if self.wanted_lighting() != wanted {
            self.request_lighting();
        }
        Ok(())
    }

    fn wanted_lighting(&self) -> LightingKey {
        let is_interior = self.lit_for.interior_turn.is_some();
        LightingKey::of(self.look(), self.stage.stands_on_ground(), is_interior)
    }

    /// What the renderer takes over of a stage but for its scene and its lights.
    fn change_to(&self, stage: &Stage) -> Change<'static> {
        let measure = MeasureSettings { profile: self.times_passes() };
        Change {
            settings: Some(RenderSettings { measure, ..stage.look().settings(stage.exposure()) }),
            world_from_environment: Some(stage.world_from_environment()),
            grade: Some(stage.grade()),
            ..Change::default()
        }
    }

    /// The view that frames are drawn from.
    ///
    /// # Errors
    /// As [`Stage::camera`].
    pub fn camera(&self) -> Result<Camera, StudioError> {
        self.stage.camera()
    }

    /// Starts a reference picture of so many pixels in the background, or goes on with it. It starts anew whenever anything changes that
    /// it depends on, once what was traced before has ended: to find that out this has to be called once a frame.
    ///
    /// # Errors
    /// As [`Stage::camera`]. What the tracer refuses [`Studio::reference`] tells.
    pub fn converge(&mut self, width: u32, height: u32) -> Result<(), StudioError> {
        let (stage, before) = (&self.stage, self.converging.take());
        self.converging = Some(Converging::follow(before, stage, [width, height], &*self.executor)?);
        Ok(())
    }

    /// Stops tracing.
    pub fn stop_converging(&mut self) {
        self.converging = None;
    }

    /// How far a picture of so many pixels as it would be drawn now is from the truth, [`Stage::check`], found in the background; `None` until it is
    /// known and where a debug view is drawn. To be called once a frame while nothing moves: it draws one frame when anything has changed, and what was
    /// found out about pictures before is dropped.
    ///
    /// # Errors
    /// As [`Studio::frame_async`] and [`Stage::check`]; each is told once.
    pub fn check(&mut self, width: u32, height: u32) -> Result<Option<SampledError>, StudioError> {
        if self.renderer.shows_debug_view() || self.is_busy() {
            self.checking = None;
            return Ok(None);
        }
        let shown = Shown {
            look: self.look().clone(),
            scene: Arc::clone(self.stage.scene()),
            surroundings: self.stage.surroundings().clone(),
            lights: Arc::clone(&self.lights),
            size: [width, height],
        };
        if let Some(checking) = self.checking.as_ref().filter(|checking| checking.is_of(&shown)) {
            return checking.found();
        }
        self.checking = None;
        let frame = self.renderer.render_async(&self.stage.camera()?, width, height);
        self.checking = Some(Checking::start(shown, &self.stage, frame, &*self.executor)?);
        Ok(None)
    }

    /// Stops checking.
    pub fn stop_checking(&mut self) {
        self.checking = None;
    }

    /// The reference as far as it has come; `None` before its first pass and while nothing is traced.
    ///
    /// # Errors
    /// [`StudioError::Reference`] for what the tracer refuses: an empty picture, a camera without a lens.
    pub fn reference(&self) -> Result<Option<ReferencePicture>, StudioError> {
        self.converging.as_ref().map_or(Ok(None), Converging::picture)
    }
}

/// A stage with another look, of which nothing is out of range: names that only a thread would look up are told at once.
fn checked(stage: &Stage, look: Look) -> Result<(Stage, LookChange), StudioError> {
    look.fit.fit(false)?;
    stage.with_look(look)
}

/// A renderer of a stage under lights that were worked out for it.
fn renderer_of(gpu: &Gpu, stage: &Stage, prepared: PreparedLighting) -> Result<Renderer, StudioError> {
    let mut renderer = Renderer::new(gpu, stage.look().settings(stage.exposure()))?;
    renderer.change(Change {
        scene: Some(SceneChange::Whole(stage.scene())),
        world_from_environment: Some(stage.world_from_environment()),
        grade: Some(stage.grade()),
        lighting: Some(LightingChange::Prepared(Box::new(prepared))),
        ..Change::default()
    })?;
    Ok(renderer)
}
