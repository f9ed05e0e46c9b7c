use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;
use glam::Vec3;
use gnomon::envmap::Equirect;
use gnomon::lights::{LightSet, fit, preview};
use gnomon::options::Given;
use gnomon::rigs::{self, Target, targets};
use gnomon::studio::{self, Look, Project, Stage};
use gnomon_terminal::{Terminal, print};

use crate::error::CliError;
use crate::options::{Fitted, GivenEnvironment, LookArgs, environment_help, load_environment};
use crate::output;

/// Take an environment apart into area lights and an ambient rest, for this program or another
///
/// Lights and the map that they leave go into a rig: as JSON, which gnomon render --rig takes back edited, or as other programs read it. Maps
/// are written beside it, named after it. Where lights leave nothing for mirrors to show, the whole map goes in for these alone, or fewer
/// lights are fitted that leave something; the file says which. The flux of all lights and of the residual map together is the
/// environment's.
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  gnomon decompose grace.hdr --preview lights.png
  gnomon decompose grace.hdr -o grace.usda
  gnomon decompose sky -o rig.py --light-count 16
  gnomon decompose sky -o lights.xml --format mujoco
  gnomon decompose room --method partition --light-count 60 -o lights.json --residual rest.exr")]
pub struct DecomposeArgs {
    /// Environment map, or a built-in one
    #[arg(value_name = "ENV", help = environment_help())]
    environment: String,

    #[command(flatten)]
    look: LookArgs<Fitted>,

    /// Scene that the lights are for: those that it is drawn with; in an interior they go to what comes in, and what arrives nowhere is left
    /// out
    #[arg(long, value_name = "SCENE", conflicts_with = "above_ground")]
    scene: Option<String>,

    /// For scenes that stand on a ground, which little light from below reaches: a partition of fewer than 48 lights, optimized or
    /// not, spends few of them there
    #[arg(long)]
    above_ground: bool,

    /// Write the rig here instead of, as JSON, on standard output
    #[arg(short, long, value_name = "RIG")]
    output: Option<PathBuf>,

    /// Program that the rig is for
    #[arg(long, value_name = "NAME", help = brief_formats(), long_help = formats(), value_parser = target_named)]
    format: Option<&'static Target>,

    /// Write what is left of the map: the ambient part
    #[arg(long, value_name = "OUT.exr")]
    residual: Option<PathBuf>,

    /// Write the tone-mapped map with the lights outlined
    #[arg(long, value_name = "OUT.png")]
    preview: Option<PathBuf>,
}

fn names() -> String {
    targets().iter().map(|target| target.name).collect::<Vec<_>>().join(", ")
}

fn target_named(name: &str) -> Result<&'static Target, String> {
    rigs::by_name(name).ok_or_else(|| format!("the formats of rigs are {}", names()))
}

fn brief_formats() -> String {
    format!("Program that the rig is for: {} [default: by the name's extension]", names())
}

fn formats() -> String {
    let line = |target: &Target| {
        let extensions: Vec<_> =
            target.extensions.iter().map(|extension| format!(" (.{extension})")).collect();
        let most =
            target.most_lights.map_or(String::new(), |most| format!("; {most} lights unless told otherwise"));
        format!("\n- {}{}: {}{most}", target.name, extensions.concat(), target.summary)
    };
    brief_formats() + &targets().iter().map(line).collect::<String>()
}

/// Width of the preview picture, unless the map is smaller.
const PREVIEW_WIDTH: u32 = 1024;

impl DecomposeArgs {
    /// The program that the rig is for.
    fn target(&self) -> Result<&'static Target, CliError> {
        match (self.format, &self.output) {
            (Some(target), _) => Ok(target),
            (None, None) => Ok(&targets()[0]),
            (None, Some(path)) => {
                let extension = path.extension().unwrap_or_default().to_string_lossy();
                rigs::by_extension(&extension).ok_or_else(|| {
                    let path = path.display();
                    CliError::usage(format!("the name {path} tells no rig format: give one with --format"))
                })
            }
        }
    }

    /// The look that was asked for, with the fit that the program can show where nobody says which.
    fn asked(&self, target: &Target) -> Look {
        let mut asked = Look::default();
        let (method, count) = target.fit();
        let is_given = |names: &[&str]| names.iter().any(|name| self.look.given.has(name));
        if !is_given(&["lights"]) {
            asked.fit.method = method.map_or(asked.fit.method, str::to_owned);
            if !is_given(&["light-count", "threshold"]) {
                asked.fit.light_count = count;
            }
        }
        self.look.given.apply(&mut asked);
        asked
    }
}

/// Runs the command.
///
/// # Errors
/// An environment that cannot be read or fitted, unwritable outputs.
pub fn run(args: &DecomposeArgs, terminal: Terminal) -> Result<(), CliError> {
    let target = args.target()?;
    match &args.output {
        Some(path) => output::check_folder(path)?,
        None if target.name == targets()[0].name => {}
        None => {
            return Err(CliError::usage(format!("{} is written to a file: give it with -o", target.name)));
        }
    }
    for (path, extension) in [(&args.residual, "exr"), (&args.preview, "png")] {
        path.as_ref().map_or(Ok(()), |path| output::check(path, &[extension]))?;
    }
    let asked = args.asked(target).fit;
    asked.fit(args.above_ground)?;
    let spinner = terminal.spinner("fitting");
    let GivenEnvironment { whole, fitted, taken_out, factor } =
        load_environment(&args.environment, &args.look.given, terminal)?;
    let options = match &args.scene {
        Some(scene) => {
            let project = Project::open(scene, Look::default(), &Given::default())?;
            Stage::under(project, Arc::clone(&fitted), Vec::new())?.fit_scene().options(&asked)?
        }
        None => asked.options(args.above_ground)?,
    };
    let mut lights = studio::fit_lights(&asked, &options, &fitted)?;
    lights.taken_out = taken_out.len();
    lights.lights.extend(taken_out);
    let (environment, lights) = match factor == Vec3::ONE {
        true => (whole, lights),
        false => (Arc::new(whole.times(factor)), lights.times(factor)),
    };
    if let Some(path) = &args.residual {
        gnomon::picture::write(path, lights.residual.radiance())?;
    }
    if let Some(path) = &args.preview {
        let width = PREVIEW_WIDTH.max(environment.width().min(2 * PREVIEW_WIDTH));
        gnomon::picture::write(path, &preview(&environment, &lights, width))?;
    }
    match &args.output {
        Some(path) => {
            let told = told(&lights, &environment);
            let about = [format!("Light of {}, by Gnomon: {told}.", args.environment)];
            let written = rigs::write(target, path, &environment, &lights, &about)?;
            drop(spinner);
            written.warnings.iter().for_each(|warning| terminal.warn(warning));
            terminal.note(&told);
            Ok(())
        }
        None => {
            drop(spinner);
            Ok(print(&lights.document().to_json())?)
        }
    }
}

/// What lights there are, and how far they are from their map.
fn told(lights: &LightSet, environment: &Equirect) -> String {
    let (count, method) = (lights.lights.len(), lights.method);
    let share = 100.0 * (1.0 - lights.flux_shares().residual);
    match lights.omits_hidden {
        true => format!("{count} {method} lights carry {share:.1} % of what arrives in the scene"),
        false => {
            let error = 100.0 * fit::error_behind_edges(environment, lights);
            format!(
                "{count} {method} lights carry {share:.1} % of the environment's flux; light behind edges is off by {error:.1} %"
            )
        }
    }
}
