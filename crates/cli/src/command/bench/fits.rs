use clap::Args;
use gnomon::lights::bench::time_fits;
use serde_json::json;

use crate::error::CliError;
use crate::options::{EnvironmentSpec, load_environment};
use crate::output;
use crate::terminal::{Terminal, print};

/// Time every light fit on one environment map
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  gnomon bench fits
  gnomon bench fits grace.hdr --repeats 9 --json")]
pub struct FitsArgs {
    /// Environment map (HDR or EXR), or a built-in one: room, sky (both are 1024 x 512)
    #[arg(value_name = "ENV", default_value = "room")]
    environment: String,

    /// Runs of each fit; the median counts
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1000))]
    repeats: u32,

    /// Print JSON instead of a table
    #[arg(long)]
    json: bool,
}

/// Runs the command.
///
/// # Errors
/// An environment that cannot be read or fitted.
pub fn run(args: &FitsArgs, terminal: Terminal) -> Result<(), CliError> {
    let map = load_environment(&EnvironmentSpec::named(&args.environment), terminal)?;
    let spinner = terminal.spinner("fitting");
    let timings = time_fits(&map, args.repeats as usize)?;
    drop(spinner);
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    if args.json {
        let fits: Vec<_> = timings
            .iter()
            .map(|fit| json!({ "method": fit.method, "lights": fit.lights, "median_milliseconds": fit.median_ms }))
            .collect();
        return print(&output::json(&json!({
            "environment": args.environment, "width": map.width(), "height": map.height(),
            "threads": threads, "repeats": args.repeats, "fits": fits,
        })));
    }
    let mut table = format!(
        "{} ({} x {}), {threads} threads, median of {}\n{:<12} {:>6} {:>10}\n",
        args.environment,
        map.width(),
        map.height(),
        args.repeats,
        "fit",
        "lights",
        "ms"
    );
    for fit in &timings {
        table += &format!("{:<12} {:>6} {:>10.1}\n", fit.method, fit.lights, fit.median_ms);
    }
    print(&table)
}
