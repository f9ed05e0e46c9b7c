mod fits;
mod suite;

use clap::{Args, Subcommand};

use crate::error::CliError;
use crate::terminal::Terminal;

/// Measure how long things take on this machine, and how far from the truth they are
#[derive(Args, Debug)]
pub struct BenchArgs {
    #[command(subcommand)]
    bench: Bench,
}

#[derive(Subcommand, Debug)]
enum Bench {
    Fits(fits::FitsArgs),
    /// Make the evaluation of convolution soft shadows (Annen et al. 2008) again
    Convolution(suite::SuiteArgs),
    /// Make the evaluation of subtractive shadows (DeCoro and Rusinkiewicz 2008) again, and look for the best setting of all
    Subtractive(suite::SuiteArgs),
    /// Measure what motion costs, and how long another environment takes
    Motion(suite::SuiteArgs),
}

/// Runs the command.
///
/// # Errors
/// Inputs that cannot be used, no adapter, an unwritable folder.
pub fn run(args: &BenchArgs, terminal: Terminal) -> Result<(), CliError> {
    match &args.bench {
        Bench::Fits(args) => fits::run(args, terminal),
        Bench::Convolution(args) => suite::run("convolution", args, terminal),
        Bench::Subtractive(args) => suite::run("subtractive", args, terminal),
        Bench::Motion(args) => suite::run("motion", args, terminal),
    }
}
