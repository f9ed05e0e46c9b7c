//! A scene, its environment and its look: everything that a picture needs but a device.

use std::sync::{Arc, OnceLock};

use glam::{Affine3A, Mat4, Quat, Vec3};
use gnomon_envmap::{Equirect, Grade};
use gnomon_options::Options;
use gnomon_reference::Sky;
use gnomon_renderer::Reflections;
use gnomon_scene::{Bounds, Camera, Emission, Ground, Scene, camera_around};

use crate::environment::{FitScene, Surroundings, surroundings_of};
use crate::look::{AnimationLook, CameraLook};
use crate::pose::{Clip, clips, pose, reach};
use crate::{Look, Project, SceneSource, StudioError};

/// A scene in the pose and with the materials that its look asks for, under an environment.
#[derive(Clone)]
pub struct Stage {
    source: SceneSource,
    look: Look,
    /// As its file has it.
    loaded: Arc<Loaded>,
    /// As the look has it.
    scene: Arc<Scene>,
    /// Box around the models, over the look's clip where it has one: what ground and automatic camera are for. It does not depend on the
    /// time, so that they stay while a clip plays.
    reach: Option<Bounds>,
    /// At rest.
    stands_on_ground: bool,
    surroundings: Surroundings,
    warnings: Vec<String>,
}

/// A scene as its file has it. The scenes of looks are clones of it, which share its meshes.
struct Loaded {
    /// At rest.
    scene: Scene,
    /// The same for looks that set the reflectance, which then copies no mesh.
    separated: OnceLock<Scene>,
    stands_on_ground: bool,
    /// [`Scene::has_floor`], where a look asks for a ground.
    has_floor: OnceLock<bool>,
    /// Width over height of the pictures that it was loaded for.
    aspect: f32,
}

/// What a new look changed in the scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct LookChange {
    /// Ground or reflectance.
    pub dressed: bool,
    /// Pose, and with the clip the place of the ground.
    pub moved: bool,
    /// Clip.
    reaches_elsewhere: bool,
    /// What its files mean.
    meant: bool,
}

impl LookChange {
    fn between(was: &Look, new: &Look) -> Self {
        Self {
            dressed: (&was.reflectance, &was.surfaces, &was.scene)
                != (&new.reflectance, &new.surfaces, &new.scene),
            moved: was.animation != new.animation,
            reaches_elsewhere: was.animation.clip != new.animation.clip,
            meant: was.scene.axes() != new.scene.axes() || was.scene.variant != new.scene.variant,
        }
    }
}

impl Loaded {
    fn new(mut scene: Scene, aspect: f32) -> Self {
        scene.rest();
        let stands_on_ground = scene.stands_on_ground();
        let (separated, has_floor) = Default::default();
        Self { stands_on_ground, scene, separated, has_floor, aspect }
    }

    fn reach(&self, look: &AnimationLook) -> Result<Option<Bounds>, StudioError> {
        reach(&mut self.scene.clone(), look)
    }

    /// The scene at rest with a look's reflectance, and its ground under models that reach so far.
    fn dressed(&self, look: &Look, reach: Option<Bounds>) -> Result<Scene, StudioError> {
        let mut scene = match &look.reflectance {
            None => self.scene.clone(),
            Some(reflectance) => {
                let separated = self.separated.get_or_init(|| {
                    let mut scene = self.scene.clone();
                    scene.separate_materials();
                    scene
                });
                let mut scene = separated.clone();
                scene.set_reflectance(reflectance);
                scene
            }
        };
        for height in scene.materials.iter_mut().filter_map(|material| material.height.as_mut()) {
            height.scale *= look.scene.bump_scale;
        }
        for light in &mut scene.lights {
            light.radiance *= look.scene.lamp_strength;
        }
        // The ground's mesh is that of the file's pose in every clip: only its node moves.
        let has_floor =
            look.scene.ground != Ground::None && *self.has_floor.get_or_init(|| self.scene.has_floor());
        scene.add_ground_under(look.scene.ground, look.scene.ground_camera_height, reach, has_floor);
        let count = scene.materials.len();
        for (&index, settings) in &look.surfaces {
            let material = scene.materials.get_mut(index).ok_or_else(|| {
                StudioError::Request(format!("there is no material {index}: the scene has {count}, from 0"))
            })?;
            settings.apply(&mut material.surface);
        }
        // Last: it adds materials, and looks know those before by their numbers.
        if look.scene.emission == Emission::Lights {
            scene.light_emission();
        }
        Ok(scene)
    }

    /// Whether a scene that was made of it does at rest.
    fn stands_on_ground(&self, dressed: &Scene) -> bool {
        self.stands_on_ground || dressed.ground != self.scene.ground
    }

    /// What was said of such a scene beyond what was said of the file.
    fn new_warnings(&self, source: &SceneSource, dressed: &Scene) -> Vec<String> {
        let new = dressed.warnings.iter().skip(self.scene.warnings.len());
        new.map(|warning| format!("{source}: {warning}")).collect()
    }
}

impl Stage {
    /// Reads the environment and takes the pose.
    ///
    /// # Errors
    /// A scene without environment, files that cannot be used, names of nothing.
    pub fn new(project: Project) -> Result<Self, StudioError> {
        let (surroundings, warnings) = surroundings_of(Some(&project.source), &project.look)?;
        Self::under(project, surroundings, warnings)
    }

    /// The same under an environment that has been read; `warnings` are what its reader said.
    ///
    /// # Errors
    /// As [`Stage::new`], but for the environment.
    pub fn under(
        project: Project,
        surroundings: impl Into<Surroundings>,
        mut warnings: Vec<String>,
    ) -> Result<Self, StudioError> {
        let Project { source, scene, look, .. } = project;
        look.check()?;
        warnings.splice(0..0, scene.warnings.iter().map(|warning| format!("{source}: {warning}")));
        let loaded = Loaded::new(scene, look.picture.aspect());
        let reach = loaded.reach(&look.animation)?;
        let mut scene = loaded.dressed(&look, reach)?;
        let stands_on_ground = loaded.stands_on_ground(&scene);
        pose(&mut scene, &look.animation)?;
        warnings.extend(loaded.new_warnings(&source, &scene));
        let stage = Self {
            source,
            look,
            scene: Arc::new(scene),
            loaded: Arc::new(loaded),
            reach,
            stands_on_ground,
            surroundings: surroundings.into(),
            warnings,
        };
        stage.look.check()?;
        stage.camera()?;
        Ok(stage)
    }

    /// The scene as it is drawn.
    pub fn scene(&self) -> &Arc<Scene> {
        &self.scene
    }

    /// The clips that the scene can play.
    pub fn clips(&self) -> Vec<Clip> {
        clips(&self.scene, &self.look.animation)
    }

    /// Whether the scene at rest stands on a ground ([`Scene::stands_on_ground`]): fits then spend few lights on what is below it.
    pub fn stands_on_ground(&self) -> bool {
        self.stands_on_ground
    }

    /// What a fit may know of the scene: as it is posed, seen and lit now.
    pub fn fit_scene(&self) -> FitScene {
        FitScene {
            scene: Arc::clone(&self.scene),
            camera: self.camera().ok(),
            aspect: self.look.picture.aspect(),
            world_from_environment: self.world_from_environment(),
            ground: self.stands_on_ground,
        }
    }

    /// The map that lights, as it is drawn but for its turn and its grade.
    pub fn environment(&self) -> &Arc<Equirect> {
        self.surroundings.map()
    }

    /// Everything around the scene, as it is drawn but for its turn and its grade.
    pub fn surroundings(&self) -> &Surroundings {
        &self.surroundings
    }

    /// Where the scene is from.
    pub fn source(&self) -> &SceneSource {
        &self.source
    }

    /// The look.
    pub fn look(&self) -> &Look {
        &self.look
    }

    /// What loaders repaired or ignored since this was asked last, a line each.
    pub fn take_warnings(&mut self) -> Vec<String> {
        std::mem::take(&mut self.warnings)
    }

    /// The view.
    ///
    /// # Errors
    /// [`StudioError::Scene`] for a camera that the scene does not have.
    pub fn camera(&self) -> Result<Camera, StudioError> {
        match &self.look.camera {
            CameraLook::Free(camera) => Ok(camera.relative_to(self.scene.origin)),
            CameraLook::Named(name) => Ok(self.scene.camera(Some(name))?.clone()),
            CameraLook::Automatic => {
                Ok(self.scene.cameras.first().cloned().unwrap_or_else(|| self.framing()))
            }
        }
    }

    /// Whether the automatic camera of a scene that is loaded anew, for pictures of this size, is the present one: a lens that a file gives by
    /// its vertical angle is that of the aspect at loading.
    pub(crate) fn reloads_its_camera(&self) -> bool {
        self.scene.cameras.is_empty() || self.look.picture.aspect() == self.loaded.aspect
    }

    /// A view that frames the scene's models: as they are at rest, or wherever the look's clip takes them.
    pub fn framing(&self) -> Camera {
        Camera { origin: self.scene.origin, ..camera_around(self.reach, self.look.picture.aspect()) }
    }

    /// The middle of what [`Stage::framing`] frames [m].
    pub fn center(&self) -> Vec3 {
        self.reach.map_or(Vec3::ZERO, |bounds| bounds.center())
    }

    /// Stops of exposure of the displayed picture.
    pub fn exposure(&self) -> f32 {
        self.look.display.exposure.unwrap_or(self.surroundings.exposure())
    }

    /// How the environment is turned.
    pub fn world_from_environment(&self) -> Quat {
        Quat::from_rotation_y(self.look.environment.rotation.to_radians())
    }

    /// What the environment's radiance is multiplied by.
    pub fn grade(&self) -> Grade {
        self.look.environment.grade()
    }

    /// What is around the scene of [`Stage::for_reference`].
    pub fn sky(&self) -> Sky<'_> {
        self.surroundings.sky(self.grade())
    }

    /// Whether glossy surfaces reflect the scene in its pictures: a rig's lights are reflected alone.
    pub fn reflects_scene(&self) -> bool {
        self.look.paths.reflections == Reflections::Scene && self.look.environment.rig.is_none()
    }

    /// Scene and view for the reference, under [`Stage::sky`]: instead of it they turn, the other way, so that no texel of it is
    /// resampled.
    ///
    /// # Errors
    /// As [`Stage::camera`].
    pub fn for_reference(&self) -> Result<(Arc<Scene>, Camera), StudioError> {
        let mut camera = self.camera()?;
        if self.look.environment.rotation == 0.0 {
            return Ok((Arc::clone(&self.scene), camera));
        }
        let environment_from_world = self.world_from_environment().inverse();
        camera.world_from_camera = Mat4::from_quat(environment_from_world) * camera.world_from_camera;
        let mut scene = Scene::clone(&self.scene);
        let turn = Affine3A::from_quat(environment_from_world);
        for root in scene.nodes.iter_mut().filter(|node| node.parent.is_none()) {
            root.parent_from_node = turn * root.parent_from_node;
        }
        Ok((Arc::new(scene), camera))
    }

    /// Takes another look over, with its environment where that is another.
    ///
    /// # Errors
    /// As [`Stage::new`]; everything is then as it was.
    pub fn set_look(&mut self, look: Look) -> Result<(), StudioError> {
        let map = match self.look.has_map_of(&look) {
            true => None,
            false => Some(surroundings_of(Some(&self.source), &look)?),
        };
        (*self, _) = self.with_look(look)?;
        if let Some((surroundings, warnings)) = map {
            self.set_surroundings(surroundings, warnings);
        }
        Ok(())
    }

    /// This stage with another look, but for the environment, which is the caller's to load.
    pub(crate) fn with_look(&self, look: Look) -> Result<(Self, LookChange), StudioError> {
        look.check()?;
        let change = LookChange::between(&self.look, &look);
        let loaded = match change.meant {
            true => {
                let scene = self.source.load(&look, look.scene.axes())?.scene;
                Arc::new(Loaded::new(scene, look.picture.aspect()))
            }
            false => Arc::clone(&self.loaded),
        };
        let reach = match change.reaches_elsewhere || change.meant {
            true => loaded.reach(&look.animation)?,
            false => self.reach,
        };
        let is_same = !(change.dressed || change.moved);
        let (scene, stands_on_ground) = if is_same {
            (Arc::clone(&self.scene), self.stands_on_ground)
        } else {
            let (mut scene, stands_on_ground) = match change.dressed || change.reaches_elsewhere {
                true => {
                    let scene = loaded.dressed(&look, reach)?;
                    let stands_on_ground = loaded.stands_on_ground(&scene);
                    (scene, stands_on_ground)
                }
                false => (Scene::clone(&self.scene), self.stands_on_ground),
            };
            pose(&mut scene, &look.animation)?;
            (Arc::new(scene), stands_on_ground)
        };
        let mut stage = Self { look, scene, loaded, reach, stands_on_ground, ..self.clone() };
        stage.camera()?;
        if change.dressed {
            let warnings = stage.loaded.new_warnings(&stage.source, &stage.scene);
            stage.warnings.extend(warnings);
        }
        Ok((stage, change))
    }

    /// The look, to ask for other lights and for nothing else: these are the caller's to work out.
    pub(crate) fn look_for_lights(&mut self) -> &mut Look {
        &mut self.look
    }

    pub(crate) fn set_surroundings(&mut self, surroundings: Surroundings, warnings: Vec<String>) {
        self.surroundings = surroundings;
        self.warnings.extend(warnings);
    }
}
