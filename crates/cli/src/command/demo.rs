use std::path::PathBuf;

use clap::Args;
use gnomon::lights::preview;
use gnomon::metrics::{Exposure, compare, flip_difference, signed_difference};
use gnomon::picture::tonemap::{ToneMapping, tone_mapped};
use gnomon::picture::{ContactSheet, Panel, RgbImage};
use gnomon::reference::{ReferenceOptions, render};
use gnomon::renderer::{Gpu, GpuOptions};
use gnomon::studio::{Look, Project, Studio, environment_named};
use gnomon_terminal::{Terminal, print};

use crate::error::CliError;
use crate::options::{GpuArgs, stage};
use crate::output;

/// Show what Gnomon does: a built-in scene, drawn, ray-traced and compared
///
/// Writes sheet.png (environment with its lights, GPU picture, reference, and their differences), the single pictures, and
/// comparison.json, and prints the error.
#[derive(Args, Debug)]
pub struct DemoArgs {
    /// Folder for the pictures; made if missing
    #[arg(short, long, value_name = "FOLDER", default_value = "out/demo")]
    output: PathBuf,

    /// Built-in scene
    #[arg(long, value_name = "NAME", default_value = "three-boxes")]
    scene: String,

    /// Built-in environment
    #[arg(long, value_name = "NAME", default_value = "room")]
    env: String,

    /// Samples a pixel of the ray-traced reference
    #[arg(long, value_name = "N", default_value_t = 256)]
    spp: u32,

    #[command(flatten)]
    gpu: GpuArgs,
}

/// Size of each picture on the sheet.
const WIDTH: u32 = 480;
const HEIGHT: u32 = 360;

/// Runs the command.
///
/// # Errors
/// No adapter, unwritable folder.
pub fn run(args: &DemoArgs, terminal: Terminal) -> Result<(), CliError> {
    std::fs::create_dir_all(&args.output)
        .map_err(|source| CliError::Write { path: args.output.clone(), source })?;
    let mut look = Look::default();
    look.picture.size = [WIDTH, HEIGHT];
    let mut project = Project::open(&args.scene, look, &args.gpu.look.given)?;
    project.look.set_environment(environment_named(&args.env));
    let spinner = terminal.spinner("rendering");
    let gpu = Gpu::new(&GpuOptions { adapter: args.gpu.adapter.clone() })?;
    let mut studio = Studio::new(&gpu, stage(project, terminal)?)?;
    let picture = studio.frame(WIDTH, HEIGHT)?.radiance;
    drop(spinner);

    let bar = terminal.bar("ray tracing");
    let progress = |share| bar.set(share);
    let options = ReferenceOptions {
        width: WIDTH,
        height: HEIGHT,
        samples_per_pixel: args.spp,
        reflections: studio.stage().reflects_scene(),
        progress: Some(&progress),
        ..ReferenceOptions::default()
    };
    let (scene, camera) = studio.stage().for_reference()?;
    let estimate = render(&scene, &camera, studio.stage().sky(), &options)?;
    drop(bar);

    let reference = &estimate.mean;
    let comparison = compare(&picture, reference, None)?;
    let mean = comparison.reference_mean.iter().sum::<f64>() / 3.0;
    let noise = (channel_mean(&estimate.variance).max(0.0)).sqrt() / mean.max(f64::from(f32::MIN_POSITIVE));
    let shown = |radiance: &RgbImage| tone_mapped(radiance, ToneMapping::default(), comparison.exposure);
    let lights = studio.lights();
    let mut sheet = ContactSheet::new("sheet", format!("Environment: {}", args.env), 2);
    sheet.banner = Some(preview(studio.environment(), lights, 2 * WIDTH + ContactSheet::GAP));
    sheet.panels = vec![
        Panel::new(format!("GPU, {} {}", lights.lights.len(), lights.method), shown(&picture)),
        Panel::new(format!("Ray traced, {} samples a pixel", args.spp), shown(reference)),
        Panel::new(
            format!("FLIP, weighted median {:.3}", comparison.flip.weighted_median),
            flip_difference(&picture, reference, Exposure::Stops(comparison.exposure))?,
        ),
        Panel::new(
            format!("GPU - reference, relative RMSE {:.3}", comparison.relative_rmse),
            signed_difference(&picture, reference, mean.max(f64::from(f32::MIN_POSITIVE)) as f32)?,
        ),
    ];
    let display = (0.0, ToneMapping::default());
    let file = |name: &str| args.output.join(name);
    gnomon::picture::write(file("sheet.png"), &sheet.to_image())?;
    output::write_radiance(&file("gpu.exr"), &picture, display)?;
    output::write_radiance(&file("reference.exr"), reference, display)?;
    output::write_text(&file("comparison.json"), &(output::json(&comparison) + "\n"))?;
    Ok(print(&format!(
        "relative RMSE {:.4} (the reference's own noise is {noise:.4} of it), bias {:+.4}, FLIP weighted median {:.4}, PSNR {:.1} dB\n{}",
        comparison.relative_rmse,
        comparison.relative_bias,
        comparison.flip.weighted_median,
        comparison.psnr,
        file("sheet.png").display()
    ))?)
}

fn channel_mean(picture: &RgbImage) -> f64 {
    let sum: f64 = picture.texels().iter().map(|texel| texel.as_dvec3().element_sum()).sum();
    sum / (3.0 * picture.texels().len() as f64)
}
