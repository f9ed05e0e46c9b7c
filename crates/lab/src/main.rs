//! The gnomon-lab command: the evaluations of the papers that this project implements, made again on this machine.
//!
//! A [`Suite`] is the evaluation of one paper or of one property such as motion; an [`Experiment`] is one figure or table of it, a file in
//! the suite's folder and a line in its list. An experiment is given a [`Lab`] (adapter, data, truth pictures, how much time there is) and
//! returns a [`report::Section`]. [`timing::interleaved`] times rivals in turns, so that none has the machine for itself while another
//! shares it, and every time stands beside an error against ray-traced truth.

mod budget;
mod bumps;
mod columns;
mod convolution;
mod data;
mod drawn;
mod error;
mod experiment;
mod fit_timing;
mod fits;
mod lab;
mod motion;
mod pictures;
mod report;
mod setup;
mod subtractive;
mod suite;
mod timing;
mod truth;

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use gnomon_terminal::Terminal;

use crate::data::{DataFolder, Environment, View};
use crate::error::LabError;
use crate::experiment::{Experiment, Suite};
use crate::lab::{Effort, Lab, LabOptions};
use crate::setup::{Setup, TimedRenderer};
use crate::truth::Truth;

/// The command's name.
const NAME: &str = "gnomon-lab";

/// Measure how long things take on this machine, and how far from the truth they are
///
/// Exit status: 0 for success, 2 for any error, which is told in one line on standard error.
#[derive(Parser, Debug)]
#[command(name = NAME, version, propagate_version = true, max_term_width = 110)]
struct Cli {
    #[command(subcommand)]
    command: Command,

    /// Show errors and results only: no progress, no warnings
    #[arg(short, long, global = true)]
    quiet: bool,
}

#[derive(Subcommand, Debug)]
enum Command {
    Fits(fits::FitsArgs),
    /// Make the evaluation of convolution soft shadows (Annen et al. 2008) again
    Convolution(suite::SuiteArgs),
    /// Make the evaluation of subtractive shadows (DeCoro and Rusinkiewicz 2008) again, and look for the best setting of all
    Subtractive(suite::SuiteArgs),
    /// Measure what a frame's time buys, on scenes of which another renderer made pictures
    Budget(suite::SuiteArgs),
    /// Make pictures of bumps that shadow and light themselves (Heidrich 2001, section 3)
    Bumps(suite::SuiteArgs),
    /// Measure what motion costs, and how long another environment takes
    Motion(suite::SuiteArgs),
}

fn main() -> ExitCode {
    gnomon_terminal::run(NAME, run)
}

fn run(cli: &Cli) -> Result<(), LabError> {
    let terminal = Terminal::new(NAME, cli.quiet);
    match &cli.command {
        Command::Fits(args) => fits::run(args, terminal),
        Command::Convolution(args) => suite::run(&convolution::SUITE, args, terminal),
        Command::Subtractive(args) => suite::run(&subtractive::SUITE, args, terminal),
        Command::Budget(args) => suite::run(&budget::SUITE, args, terminal),
        Command::Bumps(args) => suite::run(&bumps::SUITE, args, terminal),
        Command::Motion(args) => suite::run(&motion::SUITE, args, terminal),
    }
}
