use std::ops::RangeInclusive;
use std::path::PathBuf;

use clap::Args;
use gnomon::renderer::GpuOptions;
use gnomon::studio::{Dataset, DatasetFiles, Manifest, Unit};
use gnomon_terminal::Terminal;

use crate::error::CliError;
use crate::options::Numbers;

/// Draw a data set: pictures by the thousand, with cameras, poses, boxes and lights of each
///
/// A manifest says what items are drawn from; an item's number alone decides what it shows. Several runs may draw parts of a data set at once,
/// and what is whole is kept, so that a run that was stopped goes on. An item that cannot be drawn is told and left out; the exit status is then 2.
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  gnomon dataset boxes.toml -o boxes
  gnomon dataset boxes.toml -o boxes --range 500..999
  gnomon dataset boxes.toml -o shards --shards 100")]
pub struct DatasetArgs {
    /// What items are drawn from (crates/studio/DATASET.md)
    #[arg(value_name = "MANIFEST.toml")]
    manifest: PathBuf,

    /// Folder of the items: for each its pictures and a .json of one line
    #[arg(short, long, value_name = "FOLDER")]
    output: PathBuf,

    /// First and last item, both included [default: all]
    #[arg(long, value_name = "A..B")]
    range: Option<Numbers<u64>>,

    /// Write tar archives of so many items each, as WebDataset reads them
    #[arg(long, value_name = "N")]
    shards: Option<u64>,

    /// Draw all items anew, whatever is there
    #[arg(long)]
    overwrite: bool,

    /// Part of the name of the adapter to use (see gnomon info) [default: the fastest]
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
}

/// Runs the command.
///
/// # Errors
/// A manifest that makes no sense, no adapter, unwritable files; items that could not be drawn.
pub fn run(args: &DatasetArgs, terminal: Terminal) -> Result<(), CliError> {
    let manifest = Manifest::read(&args.manifest)?;
    let range = range(args, manifest.items())?;
    let mut dataset = Dataset::new(manifest, GpuOptions { adapter: args.adapter.clone() })?;
    let digest = dataset.manifest().digest(&dataset.drawn_by())?;
    let files = DatasetFiles::new(&args.output, args.shards, digest)?;
    let missing = files.missing(range.clone(), dataset.manifest().items(), args.overwrite)?;
    let count = |units: &[Unit]| units.iter().map(|Unit(items)| items.end() - items.start() + 1).sum::<u64>();
    let (all, left) = (range.end() - range.start() + 1, count(&missing));
    if left < all {
        terminal.note(&format!("{} items are there already, {left} to draw", all - left));
    }
    let bar = terminal.bar("items");
    let mut failed = 0_u64;
    let mut done = 0_u64;
    for unit in dataset.manifest().in_order(missing) {
        bar.set(done as f32 / left as f32);
        bar.tell(&format!("item {}", unit.0.start()));
        dataset.write(&unit, &files, &mut |item, error| {
            failed += 1;
            bar.suspend(|| terminal.warn(&format!("item {item} is left out: {error}")));
        })?;
        done += unit.0.end() - unit.0.start() + 1;
    }
    drop(bar);
    match failed {
        0 => Ok(()),
        _ => Err(CliError::usage(format!(
            "{failed} of {left} items could not be drawn; the others are in {}",
            args.output.display()
        ))),
    }
}

fn range(args: &DatasetArgs, items: u64) -> Result<RangeInclusive<u64>, CliError> {
    match &args.range {
        None => Ok(0..=items - 1),
        Some(Numbers(range)) if *range.end() < items => Ok(range.clone()),
        Some(Numbers(range)) => Err(CliError::usage(format!(
            "--range ends with item {}, but the last one of the manifest is {}",
            range.end(),
            items - 1
        ))),
    }
}
