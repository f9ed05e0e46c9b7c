use std::path::Path;

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser};
use gnomon::brdf::{FINISH, Model, Parameter};
use gnomon::options::Given;
use gnomon::scene::{Camera, ReflectanceSettings, builtin};
use gnomon::scene_files::{self, read_camera};
use gnomon::studio::{CameraLook, Look, Paper, Project, Stage, environment_named};
use gnomon_terminal::Terminal;

use crate::error::CliError;
use crate::options::environment::{builtin_names, environment_help};
use crate::options::look::{LookArgs, Shown};

/// What is seen, under which light, from where.
#[derive(Args, Debug)]
pub struct InputArgs {
    /// Scene file, or a built-in one
    #[arg(value_name = "SCENE", help = scene_help())]
    scene: String,

    /// Environment map, or a built-in one
    #[arg(long, value_name = "ENV", help = format!("{} [default: the scene file's]", environment_help()))]
    env: Option<String>,

    /// View: 'eye=X,Y,Z; target=X,Y,Z; fov=DEGREES' (horizontal), or of a calibrated camera 'fx=PX; fy=PX; cx=PX; cy=PX; size=WxH' (OpenCV)
    /// in place of fov, with fov 'shift=X,Y' in picture widths; a TOML or JSON file with these; or the name of one of the scene's cameras [default: the scene's first, or one that frames it over the whole of its clip]
    #[arg(long, value_name = "CAMERA")]
    camera: Option<String>,

    /// Reflectance of every material of the scene but the ground's, as MODEL:KEY=VALUE,...; a color is one number or R/G/B
    /// [default: the scene's own]
    #[arg(long, value_name = "MODEL", long_help = reflectance_help())]
    reflectance: Option<ReflectanceSettings>,

    /// Method of a paper, of which other options change parts
    #[arg(long, value_name = "PAPER", value_parser = papers())]
    paper: Option<String>,

    #[command(flatten)]
    look: LookArgs<Shown>,
}

impl InputArgs {
    /// Loads the scene, with a look of what its file says and what the command line says in its place, here and in `given`.
    ///
    /// # Errors
    /// Files that cannot be used, names of nothing, no environment.
    pub fn project(&self, given: &Given) -> Result<Project, CliError> {
        let paper = self.paper.as_deref().and_then(Paper::from_name).unwrap_or_default();
        let given = paper.given().with(&self.look.given).with(given);
        let mut project = Project::open(&self.scene, Look::default(), &given)?;
        let look = &mut project.look;
        if let Some(name) = &self.env {
            look.set_environment(environment_named(name));
            given.apply(look);
        }
        if !look.has_environment() {
            return Err(CliError::usage(format!(
                "{} brings no environment: give one with --env (a file, or {})",
                self.scene,
                builtin_names()
            )));
        }
        if let Some(reflectance) = &self.reflectance {
            look.reflectance = Some(reflectance.clone());
            look.surfaces.clear();
        }
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

fn papers() -> PossibleValuesParser {
    let choice = |paper: &Paper| PossibleValue::new(paper.name());
    Paper::ALL.iter().map(choice).collect::<Vec<_>>().into()
}

fn scene_help() -> String {
    let formats: Vec<_> = scene_files::formats().iter().map(|format| format.name).collect();
    format!("Scene file ({}), or a built-in one: {}", formats.join(", "), builtin::NAMES.join(", "))
}

/// What `--reflectance` takes: every model with its parameters.
fn reflectance_help() -> String {
    let mut text = "Reflectance of every material of the scene but the ground's, as MODEL:KEY=VALUE,...; a color is one number or R/G/B \
        [default: the scene's own]"
        .to_owned();
    for model in Model::ALL {
        let names = |parameters: &[&Parameter]| {
            parameters.iter().map(|parameter| parameter.names()).collect::<Vec<_>>().join(", ")
        };
        let (required, optional) = (names(model.required()), names(model.optional()));
        let needs = if required.is_empty() { String::new() } else { format!("; needs {required}") };
        text += &format!("\n- {}: {}{needs}; takes {optional}", model.name(), model.summary());
    }
    let finish = FINISH.iter().map(|parameter| parameter.names()).collect::<Vec<_>>().join(", ");
    text + &format!("\nEach takes {finish}, too")
}

/// Reads the environment, takes the pose, and tells what had to be repaired as warnings.
///
/// # Errors
/// An environment that cannot be used, a clip or camera that the scene does not have.
pub fn stage(project: Project, terminal: Terminal) -> Result<Stage, CliError> {
    let spinner = terminal.spinner("reading");
    let mut stage = Stage::new(project)?;
    drop(spinner);
    stage.take_warnings().iter().for_each(|warning| terminal.warn(warning));
    Ok(stage)
}

/// The camera that a user describes, `eye=x,y,z;target=x,y,z;fov=degrees` (horizontal), or else a camera file by its path.
fn camera_named(text: &str) -> Result<Camera, CliError> {
    let path = Path::new(text);
    Ok(if text.contains('=') && !path.exists() { text.parse()? } else { read_camera(path)? })
}
