use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;
use gnomon::lights::preview;
use gnomon::options::Given;
use gnomon::studio::{self, Look, Project, Stage};
use gnomon_terminal::{Terminal, print};

use crate::error::CliError;
use crate::options::{Fitted, LookArgs, Selection, environment_help, load_environment};
use crate::output;

/// Take an environment apart into area lights and an ambient rest
///
/// Every light has a centre direction, an outline, a solid angle [sr], and radiance and flux as linear RGB; the flux of all
/// lights and of the residual map together is the environment's.
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  gnomon decompose grace.hdr --preview lights.png
  gnomon decompose room --method partition --light-count 60 -o lights.json --residual rest.exr")]
pub struct DecomposeArgs {
    /// Environment map, or a built-in one
    #[arg(value_name = "ENV", help = environment_help())]
    environment: String,

    #[command(flatten)]
    look: LookArgs<Fitted>,

    /// Scene that the lights are for: those that it is drawn with, by default `optimized` ones; in an interior they go to what comes in, and
    /// what arrives nowhere is left out
    #[arg(long, value_name = "SCENE", conflicts_with = "above_ground")]
    scene: Option<String>,

    /// For scenes that stand on a ground, which little light from below reaches: a partition of fewer than 48 lights, optimized or
    /// not, spends few of them there
    #[arg(long)]
    above_ground: bool,

    /// Write the lights as JSON here instead of on standard output
    #[arg(short, long, value_name = "LIGHTS.json")]
    output: Option<PathBuf>,

    /// Write what is left of the map: the ambient part
    #[arg(long, value_name = "OUT.exr")]
    residual: Option<PathBuf>,

    /// Write the tone-mapped map with the lights outlined
    #[arg(long, value_name = "OUT.png")]
    preview: Option<PathBuf>,
}

/// Width of the preview picture, unless the map is smaller.
const PREVIEW_WIDTH: u32 = 1024;

/// Runs the command.
///
/// # Errors
/// An environment that cannot be read or fitted, unwritable outputs.
pub fn run(args: &DecomposeArgs, terminal: Terminal) -> Result<(), CliError> {
    if let Some(path) = &args.output {
        output::check(path, &["json"])?;
    }
    if let Some(path) = &args.residual {
        output::check(path, &["exr"])?;
    }
    if let Some(path) = &args.preview {
        output::check(path, &["png"])?;
    }
    // A scene gets the lights that it is drawn with.
    let mut asked = match args.scene {
        Some(_) => Look::default().fit,
        None => Fitted::defaults().fit,
    };
    args.look.given.apply(&mut asked);
    asked.fit(args.above_ground)?;
    let spinner = terminal.spinner("fitting");
    let environment = Arc::new(load_environment(&args.environment, &args.look.given, terminal)?);
    let options = match &args.scene {
        Some(scene) => {
            let project = Project::open(scene, Look::default(), &Given::default())?;
            Stage::under(project, Arc::clone(&environment), Vec::new())?.fit_scene().options(&asked)?
        }
        None => asked.options(args.above_ground)?,
    };
    let lights = studio::fit_lights(&asked, &options, &environment)?;
    drop(spinner);
    if let Some(path) = &args.residual {
        gnomon::picture::write(path, lights.residual.radiance())?;
    }
    if let Some(path) = &args.preview {
        let width = PREVIEW_WIDTH.max(environment.width().min(2 * PREVIEW_WIDTH));
        gnomon::picture::write(path, &preview(&environment, &lights, width))?;
    }
    match &args.output {
        Some(path) => {
            output::write_text(path, &lights.to_json())?;
            let share = 100.0 * (1.0 - lights.flux_shares().residual);
            let of = match lights.omits_hidden {
                true => "what arrives in the scene",
                false => "the environment's flux",
            };
            let count = lights.lights.len();
            terminal.note(&format!("{count} {} carry {share:.1} % of {of}", lights.method));
            Ok(())
        }
        None => Ok(print(&lights.to_json())?),
    }
}
