//! The gnomon command: parses, dispatches, and says in one line what went wrong.

mod command;
mod error;
mod options;
mod output;

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use gnomon_terminal::Terminal;

use crate::error::CliError;

/// The command's name.
const NAME: &str = "gnomon";

/// Light a scene in which everything moves with an HDR environment map, soft shadows included
///
/// Exit status: 0 for success, 2 for any error, which is told in one line on standard error.
#[derive(Parser, Debug)]
#[command(name = NAME, version, propagate_version = true, max_term_width = 110)]
#[command(after_help = "Examples:
  gnomon render bunny.ply --env grace.hdr -o bunny.png
  gnomon reference bunny.ply --env grace.hdr -o truth.exr
  gnomon compare bunny.exr truth.exr --difference difference.png
  gnomon view bunny.ply --env grace.hdr
  gnomon demo")]
struct Cli {
    #[command(subcommand)]
    command: Command,

    /// Show errors and results only: no progress, no warnings
    #[arg(short, long, global = true)]
    quiet: bool,
}

#[derive(Subcommand, Debug)]
enum Command {
    Render(Box<command::render::RenderArgs>),
    Reference(Box<command::reference::ReferenceArgs>),
    Dataset(command::dataset::DatasetArgs),
    Reflectance(command::reflectance::ReflectanceArgs),
    Decompose(command::decompose::DecomposeArgs),
    Compare(command::compare::CompareArgs),
    Inspect(command::inspect::InspectArgs),
    Info(command::info::InfoArgs),
    Demo(command::demo::DemoArgs),
    #[cfg(feature = "view")]
    View(command::view::ViewArgs),
}

fn main() -> ExitCode {
    gnomon_terminal::run(NAME, run)
}

fn run(cli: &Cli) -> Result<(), CliError> {
    let terminal = Terminal::new(NAME, cli.quiet);
    match &cli.command {
        Command::Render(args) => command::render::run(args, terminal),
        Command::Reference(args) => command::reference::run(args, terminal),
        Command::Dataset(args) => command::dataset::run(args, terminal),
        Command::Reflectance(args) => command::reflectance::run(args, terminal),
        Command::Decompose(args) => command::decompose::run(args, terminal),
        Command::Compare(args) => command::compare::run(args, terminal),
        Command::Inspect(args) => command::inspect::run(args, terminal),
        Command::Info(args) => command::info::run(args),
        Command::Demo(args) => command::demo::run(args, terminal),
        #[cfg(feature = "view")]
        Command::View(args) => command::view::run(args),
    }
}
