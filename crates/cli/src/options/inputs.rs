use std::path::Path;

use clap::{Args, ValueEnum};
use gnomon::envmap::Projection;
use gnomon::options::Given;
use gnomon::scene::{Camera, Ground, ReflectanceSettings};
use gnomon::scene_files::read_camera;
use gnomon::studio::{CameraLook, Look, Project, Stage, environment_named};
use gnomon_terminal::Terminal;

use crate::error::CliError;
use crate::options::environment::builtin_names;
use crate::options::look::{LookArgs, Shown};
use crate::options::{finite, projection};

/// What is seen, under which light, from where.
#[derive(Args, Debug)]
pub struct InputArgs {
    /// Scene file (glTF, OBJ, PLY or TOML), or a built-in one: three-boxes, column, terrain
    #[arg(value_name = "SCENE")]
    scene: String,

    /// Environment map (HDR or EXR), or a built-in one: room, sky [default: the scene file's]
    #[arg(long, value_name = "ENV")]
    env: Option<String>,

    /// Layout of the map, where its shape does not tell: equirect, vertical-cross, ...
    #[arg(long, value_name = "NAME", value_parser = projection)]
    projection: Option<Projection>,

    /// Turn the environment about +y by the right-hand rule
    #[arg(long, value_name = "DEG", allow_negative_numbers = true, value_parser = finite)]
    env_rotation: Option<f32>,

    /// View: 'eye=X,Y,Z; target=X,Y,Z; fov=DEGREES' (horizontal), a TOML or JSON file with these three, or the name of one of
    /// the scene's cameras [default: the scene's first, or one that frames it over the whole of its clip]
    #[arg(long, value_name = "CAMERA")]
    camera: Option<String>,

    /// Clip of an animated scene, by name or by number from 0 [default: the scene file's, or the model as it stands]
    #[arg(long, value_name = "NAME")]
    clip: Option<String>,

    /// Time in the clip in seconds; beyond its end it starts again [default: the scene file's, or 0]
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = finite)]
    time: Option<f32>,

    /// Ground under the scene, at its lowest point over the whole of its clip [default: plane for OBJ and PLY, none for others]
    #[arg(long, value_name = "GROUND")]
    ground: Option<GroundName>,

    /// Reflectance of every material of the scene but the ground's, as MODEL:KEY=VALUE,...: phong or blinn-phong (shininess, specular,
    /// diffuse), torrance-sparrow-beckmann or -gaussian (slope, specular, ior, metallic, diffuse), metallic-roughness
    /// (roughness, ...), lambert; a color is one number or R/G/B [default: the scene's own]
    #[arg(long, value_name = "MODEL")]
    reflectance: Option<ReflectanceSettings>,

    #[command(flatten)]
    look: LookArgs<Shown>,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum GroundName {
    Plane,
    None,
}

impl From<GroundName> for Ground {
    fn from(name: GroundName) -> Self {
        match name {
            GroundName::Plane => Self::Plane,
            GroundName::None => Self::None,
        }
    }
}

impl InputArgs {
    /// Loads the scene, with a look of what its file says and what the command line says in its place, here and in `given`.
    ///
    /// # Errors
    /// Files that cannot be used, names of nothing, no environment.
    pub fn project(&self, given: &Given) -> Result<Project, CliError> {
        let mut project = Project::open(&self.scene, Look::default(), &self.look.given.with(given))?;
        if let Some(name) = &self.env {
            project.set_environment(environment_named(name));
        }
        let look = &mut project.look;
        if look.environment.source.is_none() {
            return Err(CliError::usage(format!(
                "{} brings no environment: give one with --env (a file, or {})",
                self.scene,
                builtin_names()
            )));
        }
        let environment = &mut look.environment;
        environment.rotation = self.env_rotation.unwrap_or(environment.rotation);
        if let Some(projection) = self.projection {
            environment.projection = Some(projection.name().to_owned());
        }
        if let Some(reflectance) = &self.reflectance {
            look.reflectance = Some(reflectance.clone());
            look.surfaces.clear();
        }
        look.ground = self.ground.map_or(look.ground, Ground::from);
        look.animation.clip = self.clip.clone().or(look.animation.clip.take());
        look.animation.time = self.time.unwrap_or(look.animation.time);
        if let Some(text) = &self.camera {
            let is_named = project.scene.cameras.iter().any(|camera| camera.name == *text);
            look.camera = match is_named {
                true => CameraLook::Named(text.clone()),
                false => CameraLook::Free(camera_named(text)?),
            };
        }
        Ok(project)
    }
}

/// Reads the environment, takes the pose, and tells what had to be repaired as warnings.
///
/// # Errors
/// An environment that cannot be used, a clip or camera that the scene does not have.
pub fn stage(project: Project, terminal: Terminal) -> Result<Stage, CliError> {
    let mut stage = Stage::new(project)?;
    stage.take_warnings().iter().for_each(|warning| terminal.warn(warning));
    Ok(stage)
}

/// The camera that a user describes, `eye=x,y,z;target=x,y,z;fov=degrees` (horizontal), or else a camera file by its path.
fn camera_named(text: &str) -> Result<Camera, CliError> {
    let path = Path::new(text);
    Ok(if text.contains('=') && !path.exists() { text.parse()? } else { read_camera(path)? })
}
