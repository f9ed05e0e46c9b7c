use std::path::PathBuf;

use clap::Args;
use gnomon::reference::{ReferenceOptions, render};

use crate::error::CliError;
use crate::options::{InputArgs, Inputs};
use crate::output;
use crate::terminal::Terminal;

/// Ray-trace the truth on the CPU
///
/// Direct light of the whole environment, by importance sampling, on all cores. EXR holds linear radiance, PNG the exposed and
/// tone-mapped picture.
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  gnomon reference three-boxes --env room -o truth.exr
  gnomon reference bunny.ply --env grace.hdr --size 512x384 --spp 1024 -o truth.exr --variance var.exr")]
pub struct ReferenceArgs {
    #[command(flatten)]
    inputs: InputArgs,

    /// Where the picture goes
    #[arg(short, long, value_name = "OUT.exr")]
    output: PathBuf,

    /// Samples a pixel
    #[arg(long, value_name = "N", default_value_t = 256)]
    spp: u32,

    /// Write the variance of every pixel's mean
    #[arg(long, value_name = "VAR.exr")]
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
    output::check(&args.output, &["exr", "png"])?;
    if let Some(path) = &args.variance {
        output::check(path, &["exr"])?;
    }
    let inputs = Inputs::load(&args.inputs, terminal)?;
    let bar = terminal.bar("ray tracing");
    let progress = |share| bar.set(share);
    let estimate = render(
        &inputs.scene,
        &inputs.camera,
        &inputs.environment,
        &ReferenceOptions {
            width: inputs.width,
            height: inputs.height,
            samples_per_pixel: args.spp,
            seed: args.seed,
            progress: Some(&progress),
            cancel: None,
        },
    )?;
    drop(bar);
    output::write_radiance(&args.output, &estimate.mean, inputs.exposure)?;
    if let Some(path) = &args.variance {
        gnomon::image::write(path, &estimate.variance)?;
    }
    Ok(())
}
