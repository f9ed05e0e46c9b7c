use std::path::Path;

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser};
use gnomon::brdf::{FINISH, Model, Parameter};
use gnomon::lights::fit::FitSettings;
use gnomon::options::{Given, OptionSpec, specs};
use gnomon::renderer::Reflections;
use gnomon::scene::{Camera, ReflectanceSettings, Scene, builtin};
use gnomon::scene_files::{self, EnvironmentSource, read_camera};
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
    /// Loads the scene, with a look of what its file says and what the command line says in its place, here and in `given`. Options that come to
    /// nothing beside others are told as warnings.
    ///
    /// # Errors
    /// Files that cannot be used, names of nothing, no environment.
    pub fn project(&self, given: &Given, terminal: Terminal) -> Result<Project, CliError> {
        for warning in self.idle(&self.look.given.with(given)) {
            terminal.warn(&warning);
        }
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
                "{} brings no environment: give one with --env (a file, or {}), with --env-strength 0 for darkness",
                self.scene,
                builtin_names()
            )));
        }
        if let Some(name) = &look.environment.background_map
            && matches!(environment_named(name), EnvironmentSource::Builtin(_))
            && !Path::new(name).exists()
        {
            return Err(CliError::usage(format!(
                "--background-map takes the file of a map, and {name} is built in: only --env takes its name"
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
                false => CameraLook::Free(camera_named(text, &project.scene)?),
            };
        }
        Ok(project)
    }

    /// What is given and has no effect, a line each.
    fn idle(&self, given: &Given) -> Vec<String> {
        let is_builtin = |name: &str| matches!(environment_named(name), EnvironmentSource::Builtin(_));
        let names = |specs: Vec<&OptionSpec>| specs.iter().map(|spec| spec.name()).collect::<Vec<_>>();
        let mut cases = Vec::new();
        if given.has("rig") {
            cases.push((names(specs::<FitSettings>()), "--rig brings the lights"));
        }
        if self.env.as_deref().is_some_and(is_builtin) {
            let read = vec!["env-layer".to_owned(), "projection".to_owned()];
            cases.push((read, "the environment is built in and no file"));
        }
        if builtin::NAMES.contains(&self.scene.as_str()) {
            let meant = vec!["up".to_owned(), "unit".to_owned()];
            cases.push((meant, "the scene is built in and no file"));
        }
        let mut told = Vec::new();
        for (options, why) in cases {
            let idle = options.iter().filter(|name| given.has(name));
            told.extend(idle.map(|name| format!("--{name} has no effect: {why}")));
        }
        let mut look = Look::default();
        given.apply(&mut look);
        if given.has("rig") && given.has("reflections") && look.paths.reflections == Reflections::Scene {
            told.push("--reflections scene has no effect: of a rig only the lights are reflected".to_owned());
        }
        told
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
fn camera_named(text: &str, scene: &Scene) -> Result<Camera, CliError> {
    let path = Path::new(text);
    if path.exists() {
        return Ok(read_camera(path)?);
    }
    if text.contains('=') {
        return Ok(text.parse()?);
    }
    let names: Vec<_> = scene.cameras.iter().map(|camera| camera.name.as_str()).collect();
    let known = match names.is_empty() {
        true => "the scene has no camera".to_owned(),
        false => format!("the scene's cameras are {}", names.join(", ")),
    };
    Err(CliError::usage(format!("there is no camera '{text}': no such file, and {known}")))
}
