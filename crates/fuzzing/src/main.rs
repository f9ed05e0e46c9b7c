//! Damages files for a time and reports what readers do not survive: a panic, more than ten seconds, or more than 2 GiB of memory. The
//! files go to a folder. Each target runs in a process of its own, so that its end can be told.

mod watch;

use std::io::{Seek, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Duration, Instant};

use clap::Parser;
use gnomon_fuzzing::mutation::{Random, mutated};
use gnomon_fuzzing::seeds::seeds;
use gnomon_fuzzing::{Target, target, targets};
use gnomon_terminal::{Terminal, TerminalError, print};

use watch::Outcome;

const NAME: &str = "gnomon-fuzz";

/// Damage files and report what readers do not survive
#[derive(Parser, Debug)]
#[command(name = NAME, version)]
struct Arguments {
    /// Time for all targets together [s]
    #[arg(long, default_value_t = 60)]
    seconds: u64,

    /// The same seed makes the same damage
    #[arg(long, default_value_t = 1)]
    seed: u64,

    /// Only this target; `--list` names all
    #[arg(long)]
    target: Option<String>,

    /// Name the targets
    #[arg(long, conflicts_with_all = ["write_seeds", "worker"])]
    list: bool,

    /// Where files go that a reader did not survive
    #[arg(long, value_name = "FOLDER", default_value = "out/fuzz")]
    found: PathBuf,

    /// Write the files to start from into a folder for each target, for another fuzzer
    #[arg(long, value_name = "FOLDER")]
    write_seeds: Option<PathBuf>,

    /// Be the process that reads, and write here how far it is
    #[arg(long, value_name = "FILE", hide = true, requires = "target")]
    worker: Option<PathBuf>,
}

/// Why it ends early.
#[derive(Debug, thiserror::Error)]
enum FuzzError {
    /// No such target.
    #[error("there is no target '{0}' (see --list)")]
    NoTarget(String),
    /// Files or processes are refused.
    #[error("{0}: {1}")]
    Io(&'static str, std::io::Error),
    /// Readers did not survive.
    #[error("{0} files were not survived; they are in {1}")]
    Found(usize, PathBuf),
    /// Nobody reads the output, or the arguments do not parse.
    #[error(transparent)]
    Terminal(#[from] TerminalError),
}

fn main() -> ExitCode {
    gnomon_terminal::run(NAME, run)
}

fn run(arguments: &Arguments) -> Result<(), FuzzError> {
    let chosen: Vec<Target> = match &arguments.target {
        Some(name) => vec![target(name).ok_or_else(|| FuzzError::NoTarget(name.clone()))?],
        None => targets(),
    };
    if arguments.list {
        return Ok(print(&chosen.iter().map(|target| target.name).collect::<Vec<_>>().join("\n"))?);
    }
    if let Some(folder) = &arguments.write_seeds {
        return write_seeds(&chosen, folder).map_err(|error| FuzzError::Io("seeds cannot be written", error));
    }
    if let (Some(file), [target]) = (&arguments.worker, chosen.as_slice()) {
        return work(target, arguments, file).map_err(|error| FuzzError::Io("no work", error));
    }
    let terminal = Terminal::new(NAME, false);
    let share = Duration::from_secs(arguments.seconds) / chosen.len().max(1) as u32;
    let mut found = 0;
    for target in &chosen {
        let start = Instant::now();
        let (mut runs, mut seed) = (0, arguments.seed);
        // After a reader's end the next process goes on with other damage.
        while let Some(left) = share.checked_sub(start.elapsed()).filter(|left| !left.is_zero()) {
            let (outcome, done) = watch::watched(target, left, seed, &arguments.found)
                .map_err(|error| FuzzError::Io("a reader cannot be started", error))?;
            runs += done;
            if let Outcome::Ended { how, file } = outcome {
                terminal.warn(&format!("{}: {how}: {}", target.name, file.display()));
                found += 1;
            }
            seed = seed.wrapping_add(1_000_003);
        }
        terminal.note(&format!("{}: {runs} files in {:.0} s", target.name, start.elapsed().as_secs_f64()));
    }
    if found > 0 { Err(FuzzError::Found(found, arguments.found.clone())) } else { Ok(()) }
}

/// Reads damaged files until the time is over. The number of the one that is being read stands in `progress`.
fn work(target: &Target, arguments: &Arguments, progress: &Path) -> std::io::Result<()> {
    let start = Instant::now();
    let seeds = seeds(target);
    let mut random = Random::new(arguments.seed);
    let mut progress = std::fs::File::create(progress)?;
    let mut number = 0_u64;
    while start.elapsed() < Duration::from_secs(arguments.seconds.max(1)) {
        let bytes = mutated(&seeds, &mut random);
        progress.rewind()?;
        progress.write_all(&number.to_le_bytes())?;
        target.run(&bytes);
        number += 1;
    }
    Ok(())
}

fn write_seeds(targets: &[Target], folder: &Path) -> std::io::Result<()> {
    for target in targets {
        let folder = folder.join(target.name);
        std::fs::create_dir_all(&folder)?;
        for (index, seed) in seeds(target).iter().enumerate() {
            std::fs::write(folder.join(format!("{index:04}")), seed)?;
        }
    }
    Ok(())
}
