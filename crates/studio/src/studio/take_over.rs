//! What background work brings, and taking it over.

use std::sync::Arc;

use gnomon_envmap::Equirect;
use gnomon_options::Given;
use gnomon_renderer::{Change, Gpu, LightingChange, PreparedLighting, SceneChange};

use super::{LightingKey, Studio, Update, checked, renderer_of};
use crate::environment::{
    LightingRequest, LightingResult, MapSource, Surroundings, work_out, work_out_stage, work_out_unless,
};
use crate::frame_rate::FramesInFlight;
use crate::{Look, Project, SceneSource, Stage, StudioError};

/// A scene to be loaded, and what there is already.
pub(super) struct SceneRequest {
    source: SceneSource,
    look: Look,
    surroundings: Surroundings,
    lit_for: LightingKey,
    /// Whether a program gave the files of the scene before.
    was_given: bool,
}

/// A scene ready for the device.
pub(super) struct LoadedStage {
    stage: Stage,
    lighting: LightingResult,
    /// The look when it was asked for.
    asked: Look,
}

impl SceneRequest {
    pub fn work_out(self) -> Result<LoadedStage, StudioError> {
        let asked_for = self.look.clone();
        let project = Project::open_source(self.source, self.look, &Given::default())?;
        // The files that two programs give may be others of one name.
        let is_given = self.was_given || matches!(project.source, SceneSource::Files(_));
        let is_same = self.lit_for.same_map(&LightingKey::of(&project.look, false, false));
        let stage = match is_same && !(is_given && project.brings_environment) {
            true => Stage::under(project, self.surroundings, Vec::new())?,
            false => Stage::new(project)?,
        };
        let lighting = work_out_stage(&stage)?;
        Ok(LoadedStage { stage, lighting, asked: asked_for })
    }
}

impl Studio {
    /// Loads another scene on a thread, with its environment where it brings one. Fit, techniques and display stay as they are unless it is
    /// a scene file that says otherwise; changes of them made meanwhile are kept.
    pub fn load_scene(&mut self, source: SceneSource) {
        self.scenes.request(SceneRequest {
            source,
            look: self.look().clone(),
            surroundings: self.stage.surroundings().clone(),
            lit_for: self.lit_for.clone(),
            was_given: matches!(self.stage.source(), SceneSource::Files(_)),
        });
    }

    /// Takes another map as the environment, and works out its lights on a thread: for an environment that is itself a sequence. It may be
    /// called every frame. One map is worked on at a time and those that come meanwhile replace each other, so that lights lag behind by
    /// as long as a fit takes and none is shown that was not asked for. The look keeps the name of the file before it.
    pub fn stream_environment(&mut self, map: Arc<Equirect>) {
        self.request_lighting_by(MapSource::Loaded(map.into()));
    }

    /// Reads the look's environment anew on a thread: after its file has changed, or to end a stream.
    pub fn reload_environment(&mut self) {
        self.request_lighting_by(MapSource::Unread(self.stage.source().clone()));
    }

    /// Whether lights or a scene are worked on.
    pub fn is_busy(&self) -> bool {
        self.lighting.is_busy() || self.scenes.is_busy()
    }

    /// Takes over what background work has finished and what is known of the times of frames; never waits. Call it once a frame: where
    /// there are no threads, this gives background work its slice.
    pub fn poll(&mut self) -> Vec<Update> {
        self.executor.run_slices();
        let mut updates = Vec::new();
        if let Some(loaded) = self.scenes.poll() {
            updates.push(self.take_scene(loaded.flatten()));
        }
        if let Some(worked_out) = self.lighting.poll() {
            updates.push(self.take_lighting(worked_out.flatten()));
        }
        updates.extend(self.follow_times());
        updates
    }

    /// Waits until nothing is worked on in the background, and takes everything over. Not for a browser, unless by [`crate::Slices`].
    pub fn wait(&mut self) -> Vec<Update> {
        let mut updates = Vec::new();
        while let Some(loaded) = self.scenes.wait() {
            updates.push(self.take_scene(loaded.flatten()));
        }
        while let Some(worked_out) = self.lighting.wait() {
            updates.push(self.take_lighting(worked_out.flatten()));
        }
        updates
    }

    /// Goes on with another stage, and waits for what that takes: frames are then those that a new session would draw of it. What it shares with the
    /// stage before stays on the device: meshes and textures by their `Arc`, the environment with its lights. Only in an interior lights are worked
    /// out anew, as they are for its pose and its camera.
    ///
    /// # Errors
    /// As [`Studio::new`]; the session then stays as it was.
    pub fn set_stage(&mut self, stage: Stage) -> Result<(), StudioError> {
        let is_same = stage.surroundings().is(self.stage.surroundings());
        let (prepared, lit) = match work_out_unless(&stage, is_same.then_some(&self.lit_for))? {
            Some(LightingResult { lights, prepared, lit_for, .. }) => {
                (Some(LightingChange::Prepared(Box::new(prepared))), Some((lights, lit_for)))
            }
            None => (None, None),
        };
        let is_same_scene = Arc::ptr_eq(stage.scene(), self.stage.scene());
        self.renderer.change(Change {
            scene: (!is_same_scene).then_some(SceneChange::Whole(stage.scene())),
            lighting: prepared,
            ..self.change_to(&stage)
        })?;
        self.stage = stage;
        if let Some((lights, lit_for)) = lit {
            (self.lights, self.lit_for) = (Arc::new(lights), lit_for);
        }
        // What is worked on is for the stage before.
        self.lighting.forget();
        self.scenes.forget();
        Ok(())
    }

    /// Goes on with another device, as after the loss of the one before.
    ///
    /// # Errors
    /// As [`Studio::new`]; the session then stays as it was.
    pub fn reopen(&mut self, gpu: &Gpu) -> Result<(), StudioError> {
        let mut renderer = renderer_of(gpu, &self.stage, self.prepare_lighting()?)?;
        renderer.set_profile(self.times_passes());
        self.renderer = renderer;
        self.in_flight = FramesInFlight::default();
        Ok(())
    }

    /// What is in force, worked out once more.
    fn prepare_lighting(&self) -> Result<PreparedLighting, StudioError> {
        let mut look = self.look().clone();
        self.lit_for.restore(&mut look);
        let map = MapSource::Loaded(self.stage.surroundings().clone());
        Ok(work_out(LightingRequest { map, look, scene: self.stage.fit_scene() })?.prepared)
    }

    pub(super) fn request_lighting(&mut self) {
        self.request_lighting_by(match self.lit_for.same_map(&self.wanted_lighting()) {
            true => MapSource::Loaded(self.stage.surroundings().clone()),
            false => MapSource::Unread(self.stage.source().clone()),
        });
    }

    fn request_lighting_by(&mut self, map: MapSource) {
        let (look, scene) = (self.look().clone(), self.stage.fit_scene());
        self.lighting.request(LightingRequest { map, look, scene });
    }

    fn take_lighting(&mut self, worked_out: Result<LightingResult, StudioError>) -> Update {
        match worked_out.and_then(|result| self.light_up(result)) {
            Ok(()) => Update::Lighting,
            Err(error) => {
                self.forget_lighting();
                Update::Failed(error)
            }
        }
    }

    fn light_up(&mut self, result: LightingResult) -> Result<(), StudioError> {
        let LightingResult { surroundings, lights, prepared, warnings, lit_for } = result;
        let mut stage = self.stage.clone();
        // The suitable exposure is that of the environment that is seen now.
        stage.set_surroundings(surroundings, warnings);
        let lighting = Some(LightingChange::Prepared(Box::new(prepared)));
        self.renderer.change(Change { lighting, ..self.change_to(&stage) })?;
        self.lit_for = lit_for;
        self.lights = Arc::new(lights);
        self.stage = stage;
        Ok(())
    }

    /// Asks for the lights that are in force, unless others are still to come.
    fn forget_lighting(&mut self) {
        if !self.lighting.is_busy() {
            self.lit_for.restore(self.stage.look_for_lights());
        }
    }

    fn take_scene(&mut self, loaded: Result<LoadedStage, StudioError>) -> Update {
        match loaded.and_then(|loaded| self.show(loaded)) {
            Ok(()) => Update::Scene,
            Err(error) => Update::Failed(error),
        }
    }

    fn show(&mut self, loaded: LoadedStage) -> Result<(), StudioError> {
        let LoadedStage { stage, lighting: LightingResult { lights, prepared, lit_for, .. }, asked } = loaded;
        let mut look = stage.look().clone();
        look.keep_changes(&asked, self.look());
        let (stage, _) = checked(&stage, look)?;
        self.renderer.change(Change {
            scene: Some(SceneChange::Whole(stage.scene())),
            lighting: Some(LightingChange::Prepared(Box::new(prepared))),
            ..self.change_to(&stage)
        })?;
        self.stage = stage;
        self.lit_for = lit_for;
        self.lights = Arc::new(lights);
        // Lights that are being fitted are those of the scene before.
        self.lighting.forget();
        if self.wanted_lighting() != self.lit_for {
            self.request_lighting();
        }
        Ok(())
    }
}
