//! The gnomon command: parses, dispatches, and says in one line what went wrong.

mod command;
mod error;
mod options;
mod output;
mod terminal;

use std::ffi::OsString;
use std::process::ExitCode;

use clap::error::ErrorKind;
use clap::{Parser, Subcommand};

use crate::error::{CliError, single_line};
use crate::terminal::{Terminal, print, say};

/// Light a scene in which everything moves with an HDR environment map, soft shadows included
///
/// Exit status: 0 for success, 2 for any error, which is told in one line on standard error.
#[derive(Parser, Debug)]
#[command(name = "gnomon", version, propagate_version = true, max_term_width = 110)]
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
    Decompose(command::decompose::DecomposeArgs),
    Compare(command::compare::CompareArgs),
    Info(command::info::InfoArgs),
    Bench(command::bench::BenchArgs),
    Demo(command::demo::DemoArgs),
    #[cfg(feature = "view")]
    View(command::view::ViewArgs),
}

fn main() -> ExitCode {
    match run(std::env::args_os()) {
        Ok(()) | Err(CliError::ClosedOutput) => ExitCode::SUCCESS,
        Err(error) => {
            say(&format!("gnomon: error: {}", error.one_line()));
            ExitCode::from(2)
        }
    }
}

fn run(arguments: impl Iterator<Item = OsString>) -> Result<(), CliError> {
    let cli = match Cli::try_parse_from(arguments) {
        Ok(cli) => cli,
        Err(error) => return explain(&error),
    };
    let terminal = Terminal::new(cli.quiet);
    match &cli.command {
        Command::Render(args) => command::render::run(args, terminal),
        Command::Reference(args) => command::reference::run(args, terminal),
        Command::Decompose(args) => command::decompose::run(args, terminal),
        Command::Compare(args) => command::compare::run(args, terminal),
        Command::Info(args) => command::info::run(args),
        Command::Bench(args) => command::bench::run(args, terminal),
        Command::Demo(args) => command::demo::run(args, terminal),
        #[cfg(feature = "view")]
        Command::View(args) => command::view::run(args),
    }
}

/// Help and version are results; everything else that clap refuses becomes one line.
fn explain(error: &clap::Error) -> Result<(), CliError> {
    let text = error.render().to_string();
    match error.kind() {
        ErrorKind::DisplayHelp | ErrorKind::DisplayVersion => print(&text),
        ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand | ErrorKind::MissingSubcommand => {
            Err(CliError::usage("no command given (see gnomon --help)"))
        }
        _ => {
            let message = text.split("\nUsage:").next().unwrap_or_default();
            let message = message.trim_start_matches("error: ").split("\nFor more information").next();
            Err(CliError::usage(format!("{} (see --help)", single_line(message.unwrap_or_default()))))
        }
    }
}
