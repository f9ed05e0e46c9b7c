use clap::Args;
use gnomon_envmap::builtin;
use gnomon_terminal::{Terminal, print};
use serde_json::json;

use crate::LabError;
use crate::fit_timing::{sampler_errors, time_fits};

/// Time every light fit on one environment map, and compare the samplers
///
/// A sampler's error is the relative RMSE of irradiance over 256 receivers, each before a plane that hides half of the sphere.
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  gnomon-lab fits
  gnomon-lab fits grace.hdr --repeats 9 --json")]
pub struct FitsArgs {
    /// Environment map, or a built-in one: room, sky, evening, studio (1024 x 512 each)
    #[arg(value_name = "ENV", default_value = "room")]
    environment: String,

    /// Runs of each fit; the median and the least count
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1000))]
    repeats: u32,

    /// Print JSON instead of a table
    #[arg(long)]
    json: bool,
}

/// Numbers of samples at which samplers are compared.
const COUNTS: [usize; 4] = [16, 64, 256, 1024];

/// Runs the command.
///
/// # Errors
/// An environment that cannot be read or fitted.
pub fn run(args: &FitsArgs, terminal: Terminal) -> Result<(), LabError> {
    let map = match builtin::by_name(&args.environment) {
        Some(map) => map,
        None => {
            let environment = gnomon_envmap::load(&args.environment, Default::default())?;
            environment.warnings().iter().for_each(|warning| terminal.warn(warning));
            environment.map
        }
    };
    let spinner = terminal.spinner("fitting");
    let timings = time_fits(&map, args.repeats as usize)?;
    let errors = sampler_errors(&map, &COUNTS)?;
    drop(spinner);
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    if args.json {
        let fits: Vec<_> = timings
            .iter()
            .map(|fit| {
                json!({
                    "method": fit.method, "sampler": fit.sampler, "lights": fit.lights,
                    "median_milliseconds": fit.median_ms, "least_milliseconds": fit.least_ms,
                })
            })
            .collect();
        let samplers: Vec<_> = errors
            .iter()
            .map(|error| json!({ "sampler": error.sampler, "relative_rmse": error.relative_rmse }))
            .collect();
        let document = json!({
            "environment": args.environment, "width": map.width(), "height": map.height(),
            "threads": threads, "repeats": args.repeats, "fits": fits,
            "sample_counts": COUNTS, "samplers": samplers,
        });
        return Ok(print(&format!("{document:#}"))?);
    }
    let mut table = format!(
        "{} ({} x {}), {threads} threads, {} runs\n{:<22} {:>6} {:>10} {:>10}\n",
        args.environment,
        map.width(),
        map.height(),
        args.repeats,
        "fit",
        "lights",
        "median ms",
        "least ms"
    );
    for fit in &timings {
        let name = fit.sampler.map_or(fit.method.to_owned(), |sampler| format!("{}, {sampler}", fit.method));
        table += &format!("{name:<22} {:>6} {:>10.1} {:>10.1}\n", fit.lights, fit.median_ms, fit.least_ms);
    }
    table += &format!("\n{:<22}", "error with N samples");
    table.extend(COUNTS.map(|count| format!(" {count:>8}")));
    for error in &errors {
        table += &format!("\n{:<22}", error.sampler);
        table.extend(error.relative_rmse.iter().map(|error| format!(" {error:>8.4}")));
    }
    Ok(print(&(table + "\n"))?)
}
