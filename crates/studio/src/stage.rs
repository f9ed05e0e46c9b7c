//! A scene, its environment and its look: everything that a picture needs but a device.

use std::sync::Arc;

use glam::{Affine3A, Mat4, Quat, Vec3};
use gnomon_envmap::Equirect;
use gnomon_lights::FitOptions;
use gnomon_options::Options;
use gnomon_scene::{Bounds, Camera, Material, MaterialId, NodeId, Scene, camera_around};

use crate::environment::load_environment;
use crate::look::CameraLook;
use crate::pose::{pose, reach};
use crate::{Look, Project, SceneSource, StudioError};

/// A scene in the pose and with the materials that its look asks for, under an environment.
#[derive(Clone)]
pub struct Stage {
    source: SceneSource,
    look: Look,
    scene: Arc<Scene>,
    bare: Bare,
    /// Box around the models, over the look's clip where it has one: what ground and automatic camera are for. It does not depend on the
    /// time, so that they stay while a clip plays.
    reach: Option<Bounds>,
    /// At rest.
    stands_on_ground: bool,
    environment: Arc<Equirect>,
    /// Its suitable exposure [stops].
    automatic_exposure: f32,
    warnings: Vec<String>,
}

/// What the look changes in a scene, as the file has it.
#[derive(Clone)]
struct Bare {
    materials: Vec<Material>,
    material_of_mesh: Vec<Option<MaterialId>>,
    nodes: usize,
    ground: Option<NodeId>,
    stands_on_ground: bool,
    warnings: usize,
    /// Width over height of the pictures that it was loaded for.
    aspect: f32,
}

/// What a new look changed in the scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct SceneChange {
    /// Ground or reflectance.
    pub dressed: bool,
    /// Pose, and with the clip the place of the ground.
    pub moved: bool,
    /// Clip.
    reaches_elsewhere: bool,
}

impl SceneChange {
    fn between(was: &Look, new: &Look) -> Self {
        Self {
            dressed: (&was.reflectance, &was.surfaces, &was.scene)
                != (&new.reflectance, &new.surfaces, &new.scene),
            moved: was.animation != new.animation,
            reaches_elsewhere: was.animation.clip != new.animation.clip,
        }
    }
}

impl Bare {
    fn of(scene: &mut Scene, aspect: f32) -> Self {
        scene.rest();
        Self {
            materials: scene.materials.clone(),
            material_of_mesh: scene.meshes.iter().map(|mesh| mesh.material).collect(),
            nodes: scene.nodes.len(),
            ground: scene.ground,
            stands_on_ground: scene.stands_on_ground(),
            warnings: scene.warnings.len(),
            aspect,
        }
    }

    /// Whether it does once [`dress`] was there, too.
    fn dressed_stands_on_ground(&self, dressed: &Scene) -> bool {
        self.stands_on_ground || dressed.ground != self.ground
    }

    /// Takes off what [`dress`] put on.
    fn restore(&self, scene: &mut Scene) {
        scene.meshes.truncate(self.material_of_mesh.len());
        for (mesh, material) in scene.meshes.iter_mut().zip(&self.material_of_mesh) {
            if mesh.material != *material {
                Arc::make_mut(mesh).material = *material;
            }
        }
        scene.nodes.truncate(self.nodes);
        scene.materials.clone_from(&self.materials);
        scene.ground = self.ground;
        scene.warnings.truncate(self.warnings);
    }
}

/// Reflectance, and ground under models that reach so far.
fn dress(scene: &mut Scene, look: &Look, reach: Option<Bounds>) -> Result<(), StudioError> {
    // The ground's mesh is that of the file's pose in every clip: only its node moves.
    scene.rest();
    if let Some(reflectance) = &look.reflectance {
        scene.set_reflectance(reflectance);
    }
    scene.add_ground_under(look.scene.ground, reach);
    let count = scene.materials.len();
    for (&index, settings) in &look.surfaces {
        let material = scene.materials.get_mut(index).ok_or_else(|| {
            StudioError::Request(format!("there is no material {index}: the scene has {count}, from 0"))
        })?;
        settings.apply(&mut material.surface);
    }
    Ok(())
}

impl Stage {
    /// Reads the environment and takes the pose.
    ///
    /// # Errors
    /// A scene without environment, files that cannot be used, names of nothing.
    pub fn new(project: Project) -> Result<Self, StudioError> {
        let (map, warnings) = load_environment(&project.look)?;
        Self::under(project, Arc::new(map), warnings)
    }

    /// The same under an environment that has been read; `warnings` are what its reader said.
    ///
    /// # Errors
    /// As [`Stage::new`], but for the environment.
    pub fn under(
        project: Project,
        environment: Arc<Equirect>,
        mut warnings: Vec<String>,
    ) -> Result<Self, StudioError> {
        let Project { source, mut scene, look } = project;
        warnings.splice(0..0, scene.warnings.iter().map(|warning| format!("{source}: {warning}")));
        let bare = Bare::of(&mut scene, look.picture.aspect());
        let reach = reach(&mut scene, &look.animation)?;
        dress(&mut scene, &look, reach)?;
        let stands_on_ground = bare.dressed_stands_on_ground(&scene);
        pose(&mut scene, &look.animation)?;
        let automatic_exposure = environment.suitable_exposure();
        let scene = Arc::new(scene);
        let mut stage = Self {
            source,
            look,
            scene,
            bare,
            reach,
            stands_on_ground,
            environment,
            automatic_exposure,
            warnings,
        };
        stage.warn_of_dress();
        stage.look.check()?;
        stage.camera()?;
        Ok(stage)
    }

    /// The scene as it is drawn.
    pub fn scene(&self) -> &Arc<Scene> {
        &self.scene
    }

    /// Whether the scene at rest stands on a ground ([`Scene::stands_on_ground`]): fits then spend few lights on what is below it.
    pub fn stands_on_ground(&self) -> bool {
        self.stands_on_ground
    }

    /// What the look's fit takes for this scene.
    ///
    /// # Errors
    /// As [`gnomon_lights::fit::FitSettings::options`].
    pub fn fit_options(&self) -> Result<FitOptions, StudioError> {
        Ok(self.look.fit.options(self.stands_on_ground)?)
    }

    /// The environment as it is drawn, but for its turn.
    pub fn environment(&self) -> &Arc<Equirect> {
        &self.environment
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
            CameraLook::Free(camera) => Ok(camera.clone()),
            CameraLook::Named(name) => Ok(self.scene.camera(Some(name))?.clone()),
            CameraLook::Automatic => {
                Ok(self.scene.cameras.first().cloned().unwrap_or_else(|| self.framing()))
            }
        }
    }

    /// Whether the automatic camera of a scene that is loaded anew, for pictures of this size, is the present one: a lens that a file gives by
    /// its vertical angle is that of the aspect at loading.
    pub(crate) fn reloads_its_camera(&self) -> bool {
        self.scene.cameras.is_empty() || self.look.picture.aspect() == self.bare.aspect
    }

    /// A view that frames the scene's models: as they are at rest, or wherever the look's clip takes them.
    pub fn framing(&self) -> Camera {
        camera_around(self.reach, self.look.picture.aspect())
    }

    /// The middle of what [`Stage::framing`] frames [m].
    pub fn center(&self) -> Vec3 {
        self.reach.map_or(Vec3::ZERO, |bounds| bounds.center())
    }

    /// Stops of exposure of the displayed picture.
    pub fn exposure(&self) -> f32 {
        self.look.display.exposure.unwrap_or(self.automatic_exposure)
    }

    /// How the environment is turned.
    pub fn world_from_environment(&self) -> Quat {
        Quat::from_rotation_y(self.look.environment.rotation.to_radians())
    }

    /// Scene and view for the reference, under the environment as it is: instead of it they turn, the other way, so that no texel of it is
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
            false => Some(load_environment(&look)?),
        };
        self.change_look(look)?;
        if let Some((map, warnings)) = map {
            self.set_environment(Arc::new(map), warnings);
        }
        Ok(())
    }

    /// The same but for the environment, which is the caller's to load.
    pub(crate) fn change_look(&mut self, look: Look) -> Result<SceneChange, StudioError> {
        look.check()?;
        let was = std::mem::replace(&mut self.look, look);
        let change = SceneChange::between(&was, &self.look);
        let applied = self.apply(change).and_then(|()| self.camera().map(drop));
        if let Err(error) = applied {
            self.look = was;
            // What was applied before can be applied again.
            self.apply(change)?;
            return Err(error);
        }
        if change.dressed {
            self.warn_of_dress();
        }
        Ok(change)
    }

    fn apply(&mut self, change: SceneChange) -> Result<(), StudioError> {
        if change.dressed || change.reaches_elsewhere {
            let scene = Arc::make_mut(&mut self.scene);
            self.bare.restore(scene);
            if change.reaches_elsewhere {
                self.reach = reach(scene, &self.look.animation)?;
            }
            dress(scene, &self.look, self.reach)?;
            self.stands_on_ground = self.bare.dressed_stands_on_ground(scene);
        }
        if change.dressed || change.moved {
            pose(Arc::make_mut(&mut self.scene), &self.look.animation)?;
        }
        Ok(())
    }

    fn warn_of_dress(&mut self) {
        let new = self.scene.warnings.iter().skip(self.bare.warnings);
        self.warnings.extend(new.map(|warning| format!("{}: {warning}", self.source)));
    }

    pub(crate) fn set_environment(&mut self, map: Arc<Equirect>, warnings: Vec<String>) {
        self.automatic_exposure = map.suitable_exposure();
        self.environment = map;
        self.warnings.extend(warnings);
    }
}
