use std::path::{Path, PathBuf};

use clap::Args;
use gnomon_renderer::{AdapterSummary, Gpu, GpuOptions};
use gnomon_terminal::{Terminal, print};

use crate::report::Document;
use crate::{DataFolder, Effort, Lab, LabError, LabOptions, Suite};

/// Experiments, error beside every time
///
/// Writes report.md, results.json, and every table (CSV), plot (SVG) and sheet of pictures (PNG) by itself. What is done so far
/// is there after every experiment. Traced pictures are kept in the folder's 'truth', so that another run need not trace them
/// again.
#[derive(Args, Debug)]
pub struct SuiteArgs {
    /// Small pictures and few rows: minutes without a GPU
    #[arg(long)]
    quick: bool,

    /// Only these experiments: names with commas between
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    only: Vec<String>,

    /// Folder for the report; made if missing [default: out/lab/NAME]
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,

    /// Folder with the scenes and environment maps of the papers [default: $GNOMON_DATA, else ../shared/data; built-in ones stand in
    /// for what is not there]
    #[arg(long, value_name = "FOLDER")]
    data: Option<PathBuf>,

    /// Folder with truth pictures by another renderer, SCENE_ENVIRONMENT.exr, to be used instead of the own tracer
    #[arg(long, value_name = "FOLDER")]
    truth: Option<PathBuf>,

    /// Part of the name of the adapter to use (see gnomon info) [default: the fastest]
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,

    /// Seconds: shows that everything works
    #[arg(long, hide = true, conflicts_with = "quick")]
    smoke: bool,
}

/// Runs a suite.
///
/// # Errors
/// Unknown experiments, data that cannot be used, no adapter, an unwritable folder.
pub fn run(suite: &Suite, args: &SuiteArgs, terminal: Terminal) -> Result<(), LabError> {
    let experiments = suite.choose(&args.only)?;
    let output = args.output.clone().unwrap_or_else(|| Path::new("out/lab").join(suite.name));
    let effort = match (args.smoke, args.quick) {
        (true, _) => Effort::Smoke,
        (_, true) => Effort::Quick,
        _ => Effort::Full,
    };
    let options = LabOptions {
        effort,
        data: DataFolder(data_folder(args)),
        truth: args.truth.clone(),
        kept_truth: Some(output.join("truth")),
    };
    let gpu = Gpu::new(&GpuOptions { adapter: args.adapter.clone() })?;
    let mut document = Document {
        title: suite.title.to_owned(),
        conditions: conditions(gpu.adapter(), &options),
        ..Document::default()
    };
    let bar = terminal.bar("experiments");
    let count = experiments.len().max(1) as f32;
    let place = std::sync::atomic::AtomicUsize::new(0);
    let progress = |what: &str, share: f32| {
        let finished = place.load(std::sync::atomic::Ordering::Relaxed) as f32;
        bar.tell(what);
        bar.set((finished + share) / count);
    };
    let lab = Lab::new(&gpu, options, &progress)?;
    // A folder that cannot be written is told before the work.
    document.write(&output)?;
    for experiment in experiments {
        let section = Suite::run(experiment, &lab)?;
        let tables: Vec<String> =
            section.tables.iter().map(|table| format!("{}\n{}", table.caption, table.to_text())).collect();
        let text = format!("{}\n\n{}", section.title, tables.join("\n"));
        document.sections.push(section);
        document.write(&output)?;
        bar.suspend(|| print(&(text + "\n")))?;
        place.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
    }
    drop(lab);
    drop(bar);
    Ok(print(&output.join("report.md").display().to_string())?)
}

/// Where the data lies: what the command line or the environment names, or the usual place if it is there.
fn data_folder(args: &SuiteArgs) -> Option<PathBuf> {
    let named = args.data.clone().or_else(|| std::env::var_os("GNOMON_DATA").map(PathBuf::from));
    named.or_else(|| Some(PathBuf::from("../shared/data")).filter(|folder| folder.is_dir()))
}

fn conditions(adapter: &AdapterSummary, options: &LabOptions) -> Vec<(String, String)> {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let data = match &options.data.0 {
        Some(folder) => folder.display().to_string(),
        None => "none: built-in scenes and environments stand in".to_owned(),
    };
    let truth = match &options.truth {
        Some(folder) => format!("pictures of {} where there are any, else the own tracer", folder.display()),
        None => "pictures of the data folder where there are any, else the own tracer".to_owned(),
    };
    [
        ("adapter", format!("{} ({}, {})", adapter.name, adapter.backend, adapter.kind)),
        ("driver", adapter.driver.clone()),
        ("version", format!("gnomon {}", env!("CARGO_PKG_VERSION"))),
        ("machine", format!("{} {}, {threads} threads", std::env::consts::OS, std::env::consts::ARCH)),
        ("effort", options.effort.name().to_owned()),
        ("data", data),
        ("truth", truth),
        (
            "times",
            "wall clock from a frame's first command until the device is idle; rivals in turns".to_owned(),
        ),
        ("errors", "relative RMSE: over the mean of the truth, background included".to_owned()),
    ]
    .map(|(name, value)| (name.to_owned(), value))
    .to_vec()
}
