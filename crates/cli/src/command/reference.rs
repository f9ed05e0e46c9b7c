use std::path::PathBuf;

use clap::Args;
use gnomon::options::Given;
use gnomon::reference::{ReferenceOptions, render, render_with_alpha};
use gnomon::renderer::Background;
use gnomon_terminal::Terminal;

use super::sequence;
use crate::error::CliError;
use crate::options::{InputArgs, SequenceArgs, stage};
use crate::output::{self, Drawn};

/// Ray-trace the truth on the CPU
///
/// Direct light of the whole environment, by importance sampling, on all cores, and what glossy surfaces reflect of the scene. EXR holds linear radiance, PNG the exposed and
/// tone-mapped picture.
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  gnomon reference three-boxes --env room -o truth.exr
  gnomon reference bunny.ply --env grace.hdr --size 512x384 --spp 1024 -o truth.exr --variance var.exr
  gnomon reference robot.glb --env sky --frames 0..24 --fps 25 -o truth_####.exr")]
pub struct ReferenceArgs {
    #[command(flatten)]
    inputs: InputArgs,

    /// Where the picture goes; of a sequence a name with #### in the place of the frame's number (else _#### is put before the extension), or a film
    #[arg(short, long, value_name = "OUT.{exr,png,mp4}")]
    output: PathBuf,

    #[command(flatten)]
    sequence: SequenceArgs,

    /// Samples a pixel
    #[arg(long, value_name = "N", default_value_t = 256)]
    spp: u32,

    /// Write the variance of every pixel's mean
    #[arg(long, value_name = "VAR.exr", conflicts_with_all = ["frames", "duration"])]
    variance: Option<PathBuf>,

    /// Another seed gives another, equally good estimate
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
}

/// Runs the command.
///
/// # Errors
/// Inputs that cannot be used, unwritable outputs.
pub fn run(args: &ReferenceArgs, terminal: Terminal) -> Result<(), CliError> {
    args.sequence.check()?;
    let is_sequence = args.sequence.is_given();
    output::check_pictures(&args.output, is_sequence)?;
    if let Some(path) = &args.variance {
        output::check(path, &["exr"])?;
    }
    let stage = stage(args.inputs.project(&Given::default(), terminal)?, terminal)?;
    let options = ReferenceOptions {
        width: stage.look().picture.size[0],
        height: stage.look().picture.size[1],
        samples_per_pixel: args.spp,
        background: stage.look().shows_environment(),
        reflections: stage.reflects_scene(),
        seed: args.seed,
        ..ReferenceOptions::default()
    };
    if is_sequence {
        return sequence::reference(&args.sequence, &args.output, &options, stage, terminal);
    }
    let bar = terminal.bar("ray tracing");
    let progress = |share| bar.set(share);
    let (scene, camera) = stage.for_reference()?;
    let options = ReferenceOptions { progress: Some(&progress), ..options };
    let sky = stage.sky();
    let (estimate, alpha) = match stage.look().display.background {
        Background::Transparent => {
            let (estimate, alpha) = render_with_alpha(&scene, &camera, sky, &options)?;
            (estimate, Some(alpha))
        }
        _ => (render(&scene, &camera, sky, &options)?, None),
    };
    drop(bar);
    let display = (stage.exposure(), stage.look().display.tone_mapping);
    Drawn { alpha, ..Drawn::new(estimate.mean) }.write(&args.output, display)?;
    if let Some(path) = &args.variance {
        gnomon::picture::write(path, &estimate.variance)?;
    }
    Ok(())
}
