//! What a picture is of: a scene, a camera, an environment, and options of a look.

use gnomon::lights::fit::FitSettings;
use gnomon::options::OptionSpec;
use gnomon::renderer::{DisplaySettings, LightPaths, LightingSettings, TechniqueSettings};
use gnomon::studio::{
    AnimationLook, CameraLook, Look, PictureSettings, Project, Stage, StudioError, Surroundings,
};
use gnomon_messages::quoted;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};

use crate::camera::Camera;
use crate::environment::Environment;
use crate::error::{raised, refused};
use crate::keywords;
use crate::scene::Scene;

/// Options that a picture may have of its own.
pub type PictureOptions = (
    FitSettings,
    (
        LightPaths,
        (LightingSettings, (TechniqueSettings, (PictureSettings, (DisplaySettings, AnimationLook)))),
    ),
);

/// Pixels across and down, as Python gives them.
#[derive(Clone, Copy)]
pub struct Size(pub [u32; 2]);

impl FromPyObject<'_, '_> for Size {
    type Error = PyErr;

    fn extract(size: Borrowed<'_, '_, PyAny>) -> PyResult<Self> {
        let sides = size.extract().ok().filter(|sides: &[u32; 2]| !sides.contains(&0));
        sides.map(Self).ok_or_else(|| {
            let size = size.repr().map_or_else(|_| String::new(), |text| text.to_string());
            refused(format!("a size is (width, height) in whole pixels from 1, not {}", quoted(&size)))
        })
    }
}

/// Everything that a stage is made of. It can go to another thread, and what becomes of the scene meanwhile is nothing to it.
pub struct View {
    project: Project,
    surroundings: Surroundings,
}

impl View {
    /// The view of a scene as the arguments of `render` say.
    pub fn of(
        scene: &Bound<'_, Scene>,
        camera: Option<&Bound<'_, PyAny>>,
        environment: Option<&Environment>,
        size: Option<Size>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let given = keywords::given::<PictureOptions>(options, keywords::flag as fn(&OptionSpec) -> String)?;
        let environment = match environment {
            Some(environment) => environment.clone(),
            None => Scene::own_environment(scene)?,
        };
        let mut project = scene.borrow().project.clone();
        let fixed = camera.map(|camera| camera_look(camera, &project)).transpose()?;
        let look = &mut project.look;
        look.map = environment.look.map;
        look.environment = environment.look.environment;
        given.apply(look);
        look.picture.size = size.map_or(look.picture.size, |Size(size)| size);
        look.camera = fixed.unwrap_or_else(|| look.camera.clone());
        Ok(Self { project, surroundings: environment.surroundings })
    }

    /// Pixels across and down.
    pub fn size(&self) -> [u32; 2] {
        self.look().picture.size
    }

    fn look(&self) -> &Look {
        &self.project.look
    }

    /// The stage that the renderer and the reference take.
    pub fn stage(self) -> Result<Stage, StudioError> {
        Stage::under(self.project, self.surroundings, Vec::new())
    }
}

/// A camera, the name of one of the scene's, or a text as the command's `--camera`.
fn camera_look(camera: &Bound<'_, PyAny>, project: &Project) -> PyResult<CameraLook> {
    if let Ok(name) = camera.cast::<PyString>() {
        let name = name.to_str()?;
        let is_named = project.scene.cameras.iter().any(|camera| camera.name == name);
        return match is_named || !name.contains('=') {
            true => Ok(CameraLook::Named(name.to_owned())),
            false => {
                Ok(CameraLook::Free(name.parse().map_err(|error: gnomon::scene::SceneError| raised(error))?))
            }
        };
    }
    Ok(CameraLook::Free(camera.extract::<Camera>()?.0))
}
