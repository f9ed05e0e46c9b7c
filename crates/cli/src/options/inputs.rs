use std::path::Path;

use clap::{Args, ValueEnum};
use gnomon::envmap::{Equirect, Projection};
use gnomon::scene::{
    Camera, EnvironmentSettings, EnvironmentSource, Ground, LoadOptions, LoadedScene, ReflectanceSettings,
    Scene, builtin, default_camera, load,
};

use crate::error::CliError;
use crate::options::environment::builtin_names;
use crate::options::{EnvironmentSpec, Size, finite, load_environment, projection, stops};
use crate::terminal::Terminal;

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
    /// the scene's cameras [default: the scene's first, or one that frames it]
    #[arg(long, value_name = "CAMERA")]
    camera: Option<String>,

    /// Picture size in pixels
    #[arg(long, value_name = "WxH", default_value = "1024x768")]
    size: Size,

    /// Ground under the scene [default: plane for OBJ and PLY, none for others]
    #[arg(long, value_name = "GROUND")]
    ground: Option<GroundName>,

    /// Reflectance of every material of the scene but the ground's, as MODEL:KEY=VALUE,...: phong or blinn-phong (shininess, specular,
    /// diffuse), torrance-sparrow-beckmann or -gaussian (slope, specular, ior, metallic, diffuse), metallic-roughness
    /// (roughness, ...), lambert; a color is one number or R/G/B [default: the scene's own]
    #[arg(long, value_name = "MODEL")]
    reflectance: Option<ReflectanceSettings>,

    /// Exposure of PNG output in stops [default: the scene file's, or what brings the environment's mean to 0.5]
    #[arg(long, value_name = "EV", allow_negative_numbers = true, value_parser = stops)]
    exposure: Option<f32>,
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

/// Everything that a picture depends on, read and checked.
pub struct Inputs {
    /// The scene with its ground.
    pub scene: Scene,
    /// The view.
    pub camera: Camera,
    /// The environment, turned.
    pub environment: Equirect,
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Stops of exposure of displayed pictures.
    pub exposure: f32,
}

impl Inputs {
    /// Reads what the options name. What had to be repaired is told as warnings.
    ///
    /// # Errors
    /// Files that cannot be used, names of nothing, no environment.
    pub fn load(args: &InputArgs, terminal: Terminal) -> Result<Self, CliError> {
        let Size { width, height } = args.size;
        let aspect = width as f32 / height as f32;
        let LoadedScene { mut scene, environment, ground } = load_scene(&args.scene, aspect)?;
        if let Some(reflectance) = &args.reflectance {
            scene.set_reflectance(reflectance);
        }
        for warning in &scene.warnings {
            terminal.warn(&format!("{}: {warning}", args.scene));
        }
        let own = environment.as_ref();
        let spec = environment_spec(args, own)?;
        let camera = match &args.camera {
            Some(text) => match scene.cameras.iter().find(|camera| camera.name == *text) {
                Some(camera) => camera.clone(),
                None => Camera::from_argument(text)?,
            },
            None => scene.cameras.first().cloned().unwrap_or_else(|| default_camera(&scene, aspect)),
        };
        scene.add_ground(args.ground.map_or(ground, Ground::from));
        let environment = load_environment(&spec, terminal)?;
        let exposure = args.exposure.or(own.map(|own| own.exposure_ev));
        Ok(Self {
            scene,
            camera,
            // Of the environment alone: pictures of a moving scene keep one exposure.
            exposure: exposure.unwrap_or_else(|| environment.suitable_exposure()),
            environment,
            width,
            height,
        })
    }

    /// A built-in scene under an environment.
    ///
    /// # Errors
    /// Names of nothing.
    pub fn builtin(
        scene: &str,
        environment: &str,
        (width, height): (u32, u32),
        terminal: Terminal,
    ) -> Result<Self, CliError> {
        let scene = builtin::by_name(scene)?;
        let camera = scene.cameras.first().cloned();
        let aspect = width as f32 / height as f32;
        Ok(Self {
            camera: camera.unwrap_or_else(|| default_camera(&scene, aspect)),
            scene,
            environment: load_environment(&EnvironmentSpec::named(environment), terminal)?,
            width,
            height,
            exposure: 0.0,
        })
    }
}

fn load_scene(name: &str, aspect: f32) -> Result<LoadedScene, CliError> {
    if builtin::NAMES.contains(&name) {
        let scene = builtin::by_name(name)?;
        return Ok(LoadedScene { scene, environment: None, ground: Ground::None });
    }
    if !Path::new(name).exists() {
        let names = builtin::NAMES.join(", ");
        return Err(CliError::usage(format!(
            "there is no scene '{name}': no such file, and the built-in ones are {names}"
        )));
    }
    Ok(load(Path::new(name), &LoadOptions { aspect, ..LoadOptions::default() })?)
}

/// The command line's environment, or else the scene file's with what the command line changes.
fn environment_spec(
    args: &InputArgs,
    own: Option<&EnvironmentSettings>,
) -> Result<EnvironmentSpec, CliError> {
    let name = match (&args.env, own.map(|own| &own.source)) {
        (Some(name), _) => name.clone(),
        (None, Some(EnvironmentSource::Builtin(name))) => name.clone(),
        (None, Some(EnvironmentSource::File(path))) => path.to_string_lossy().into_owned(),
        (None, None) => {
            return Err(CliError::usage(format!(
                "{} brings no environment: give one with --env (a file, or {})",
                args.scene,
                builtin_names()
            )));
        }
    };
    // A turn that the scene file gives belongs to its own environment.
    let own_rotation = own.filter(|_| args.env.is_none()).map_or(0.0, |own| own.rotation_degrees);
    Ok(EnvironmentSpec {
        name,
        projection: args.projection,
        rotation_degrees: args.env_rotation.unwrap_or(own_rotation),
    })
}
