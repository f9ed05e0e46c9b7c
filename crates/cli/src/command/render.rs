use std::path::PathBuf;
use std::time::Instant;

use clap::{Args, ValueEnum};
use gnomon::envmap::Equirect;
use gnomon::image::RgbImage;
use gnomon::lights::{LightSet, fit};
use gnomon::renderer::shadow::{ConvolutionSettings, Prefilter, ShadowSettings};
use gnomon::renderer::{Gpu, GpuOptions, PassTiming, RenderSettings, Renderer, ShadowSizing};
use gnomon::scene::Camera;
use serde_json::{Value, json};

use super::level_of_detail::{self, LevelOfDetailArgs};
use crate::error::CliError;
use crate::options::{FitArgs, InputArgs, Inputs};
use crate::output;
use crate::terminal::Terminal;

/// Draw a scene under an environment on the GPU, soft shadows included
///
/// The environment becomes area lights, each with soft shadows, and an ambient rest. PNG holds the exposed and tone-mapped
/// picture, EXR linear radiance.
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  gnomon render three-boxes --env room -o boxes.png
  gnomon render bunny.ply --env grace.hdr --lights disks -o bunny.png --stats stats.json
  gnomon render bunny.ply --env grace.hdr --target-fps 30 -o bunny.png
  gnomon render robot.glb --env sky --camera 'eye=3,2,4; target=0,0.5,0; fov=40' -o robot.exr")]
pub struct RenderArgs {
    #[command(flatten)]
    inputs: InputArgs,

    /// Where the picture goes
    #[arg(short, long, value_name = "OUT.{png,exr}")]
    output: PathBuf,

    #[command(flatten)]
    gpu: GpuArgs,

    #[command(flatten)]
    level_of_detail: LevelOfDetailArgs,

    /// Write lights, flux shares, adapter, memory and the time of every pass as JSON
    #[arg(long, value_name = "STATS.json")]
    stats: Option<PathBuf>,
}

/// How the GPU draws.
#[derive(Args, Clone, Debug)]
pub struct GpuArgs {
    /// How to fit lights to the environment: disks, squares, rectangles, partition, samples (see gnomon info), or none for
    /// ambient light only
    #[arg(long, value_name = "METHOD", default_value = DEFAULT_FIT)]
    pub lights: String,

    #[command(flatten)]
    pub fit: FitArgs,

    /// Shadow technique: convolution, pcss, moments, pcf, hard, hard-linear or none
    #[arg(long, value_name = "NAME", default_value = "convolution")]
    pub shadows: String,

    /// How shadows and unshadowed light become one picture: ratio, subtractive or additive
    #[arg(long, value_name = "NAME", default_value = "ratio")]
    pub compositing: String,

    /// Where unshadowed light comes from: auto (irradiance map, prefiltered environment, radiance cache, by material), sh (nine
    /// spherical harmonics for matte surfaces) or cache (a radiance cache for every glossy material)
    #[arg(long, value_name = "NAME", default_value = "auto")]
    pub unshadowed: String,

    /// Texels along each side of a light's shadow map, a power of two
    #[arg(long, value_name = "N", default_value_t = 256)]
    pub shadow_resolution: u32,

    /// Terms of the series that convolution shadows are made of, 1 to 16: more tell blockers apart that are closer to the receiver,
    /// and cost time and memory for every four
    #[arg(long, value_name = "M", default_value_t = 4)]
    pub order: u32,

    /// How convolution shadows are filtered: mip chains (half floats), or summed-area tables (32-bit floats; a rectangle's kernel has
    /// its own width and height)
    #[arg(long, value_enum, default_value_t = PrefilterName::Mip)]
    pub prefilter: PrefilterName,

    /// Places of the depth map that convolution shadows look at for blockers too near for the series, 0 to 64; 0 leaves contacts to the
    /// series and its sharpening, as the paper does
    #[arg(long, value_name = "N", default_value_t = 8)]
    pub contact_samples: u32,

    /// How large the lights' shadow maps are: by the light's footprint, wide lights having coarser maps, or all alike
    #[arg(long, value_enum, default_value_t = SizingName::Footprint)]
    pub shadow_sizing: SizingName,

    /// Memory for shadow maps and their images in MiB; lights that do not fit take turns
    #[arg(long, value_name = "MIB", default_value_t = 1024)]
    pub shadow_memory: u32,

    /// What the ambient rest of a fit does about shadows: cells (lights of its own), occlusion or unshadowed
    #[arg(long, value_name = "NAME", default_value = "cells")]
    pub ambient: String,

    /// Most lights or probes that the ambient rest may become, 6 to 4096
    #[arg(long, value_name = "N", default_value_t = 32)]
    pub ambient_cells: usize,

    /// Samples along each side of a pixel, 1 to 8
    #[arg(long, value_name = "N", default_value_t = 2)]
    pub supersample: u32,

    /// Samples along each side of a tile over which lights are summed once: 1, 2, 4, 8, 16 or 32. Samples unlike the tiles around
    /// them are lit by themselves, so that edges stay sharp
    #[arg(long, value_name = "N", default_value_t = 2)]
    pub shadow_sampling: u32,

    /// Part of the name of the adapter to use (see gnomon info) [default: the fastest]
    #[arg(long, value_name = "NAME")]
    pub adapter: Option<String>,
}

/// Names of [`Prefilter`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum PrefilterName {
    /// Mip chains
    Mip,
    /// Summed-area tables
    Sat,
}

/// Names of [`ShadowSizing`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SizingName {
    /// The wider the light, the coarser its map
    Footprint,
    /// All alike
    Uniform,
}

/// The fit that leaves no light unshadowed, so that the picture's error stays small under every environment measured.
pub const DEFAULT_FIT: &str = "partition";

/// Frames timed for the statistics, after one that compiles the pipelines, and the time after which fewer will do.
const TIMED_FRAMES: usize = 5;
const TIMED_SECONDS: f64 = 2.0;

/// Runs the command.
///
/// # Errors
/// Inputs that cannot be used, no adapter, unwritable outputs.
pub fn run(args: &RenderArgs, terminal: Terminal) -> Result<(), CliError> {
    output::check(&args.output, &["png", "exr"])?;
    if let Some(path) = &args.stats {
        output::check(path, &["json"])?;
    }
    let inputs = Inputs::load(&args.inputs, terminal)?;
    let mut gpu = args.gpu.clone();
    let settled = match args.level_of_detail.budget_ms() {
        Some(budget_ms) => {
            let _spinner = terminal.spinner("settling");
            let (fit, adapter) = ((gpu.lights.as_str(), gpu.fit.options()), gpu.adapter.clone());
            let settings = settings(&gpu, inputs.exposure);
            Some(level_of_detail::settle(budget_ms, adapter, fit, settings, &inputs)?)
        }
        None => None,
    };
    let lights = match &settled {
        Some(settled) => {
            gpu.shadow_resolution = settled.level.shadow_resolution;
            gpu.shadow_sampling = settled.level.shadow_sampling;
            settled.lights.clone()
        }
        None => {
            let _spinner = terminal.spinner("fitting");
            fit_lights(&gpu, &inputs.environment)?
        }
    };
    let spinner = terminal.spinner("rendering");
    let drawn = draw(&gpu, &inputs, &lights, args.stats.is_some())?;
    drop(spinner);
    output::write_radiance(&args.output, &drawn.radiance, inputs.exposure)?;
    if let Some(path) = &args.stats {
        let mut stats = stats(&inputs, &lights, &drawn);
        if let Some(settled) = &settled {
            stats["level_of_detail"] = settled.document();
        }
        output::write_text(path, &(output::json(&stats) + "\n"))?;
    }
    if let Some(settled) = &settled {
        terminal.note(&settled.summary());
    }
    Ok(())
}

/// Lights and ambient rest of an environment, as the options ask.
///
/// # Errors
/// Unknown fit, option out of range.
pub fn fit_lights(args: &GpuArgs, environment: &Equirect) -> Result<LightSet, CliError> {
    if args.lights == "none" {
        return Ok(LightSet::new("none", Vec::new(), environment.clone()));
    }
    Ok(fit::by_name(&args.lights, &args.fit.options())?.fit(environment)?)
}

/// Settings of the renderer, as the options ask.
fn settings(args: &GpuArgs, exposure: f32) -> RenderSettings {
    let mut shadow_settings = ShadowSettings::default();
    if args.contact_samples == 0 {
        shadow_settings.convolution = ConvolutionSettings::paper();
    }
    shadow_settings.convolution.contact_samples = args.contact_samples;
    shadow_settings.convolution.order = args.order;
    shadow_settings.convolution.prefilter = match args.prefilter {
        PrefilterName::Mip => Prefilter::MipChain,
        PrefilterName::Sat => Prefilter::SummedAreaTable,
    };
    RenderSettings {
        shadows: args.shadows.clone(),
        shadow_settings,
        shadow_sizing: match args.shadow_sizing {
            SizingName::Footprint => ShadowSizing::Footprint,
            SizingName::Uniform => ShadowSizing::Uniform,
        },
        shadow_memory_bytes: u64::from(args.shadow_memory) << 20,
        ambient: args.ambient.clone(),
        ambient_cells: args.ambient_cells,
        compositing: args.compositing.clone(),
        unshadowed: args.unshadowed.clone(),
        shadow_resolution: args.shadow_resolution,
        samples: args.supersample,
        shadow_sampling: args.shadow_sampling,
        exposure_ev: exposure,
        profile: false,
        ..RenderSettings::default()
    }
}

/// A picture and what it took.
pub struct Drawn {
    /// Linear radiance.
    pub radiance: RgbImage,
    adapter: Value,
    shadow_bytes: u64,
    shadow_batches: usize,
    frame_milliseconds: f64,
    passes: Vec<PassTiming>,
}

/// Draws one frame on the adapter that the options name; `timed` draws more of them and keeps the medians.
///
/// # Errors
/// No adapter, unknown technique, a scene beyond the adapter's limits.
pub fn draw(args: &GpuArgs, inputs: &Inputs, lights: &LightSet, timed: bool) -> Result<Drawn, CliError> {
    let gpu = Gpu::new(&GpuOptions { adapter: args.adapter.clone() })?;
    let settings = settings(args, inputs.exposure);
    let renderer = |profile| -> Result<Renderer, CliError> {
        let mut renderer = Renderer::new(&gpu, RenderSettings { profile, ..settings.clone() })?;
        renderer.set_scene(&inputs.scene)?;
        renderer.set_lighting(&inputs.environment, lights)?;
        Ok(renderer)
    };
    let mut plain = renderer(false)?;
    let frame = plain.render(&inputs.camera, inputs.width, inputs.height)?;
    let mut drawn = Drawn {
        radiance: frame.radiance,
        adapter: json!(gpu.adapter()),
        shadow_bytes: plain.shadow_bytes(),
        shadow_batches: plain.shadow_batches(),
        frame_milliseconds: 0.0,
        passes: Vec::new(),
    };
    if timed {
        drawn.frame_milliseconds = frame_milliseconds(&mut plain, &inputs.camera, inputs)?;
        drop(plain);
        drawn.passes = pass_timings(&mut renderer(true)?, &inputs.camera, inputs)?;
    }
    Ok(drawn)
}

/// What `draw` gives for each of a few frames: [`TIMED_FRAMES`] of them, or as many as fit into [`TIMED_SECONDS`].
fn timed_frames<T>(mut draw: impl FnMut() -> Result<T, CliError>) -> Result<Vec<T>, CliError> {
    let start = Instant::now();
    let mut frames = Vec::with_capacity(TIMED_FRAMES);
    while frames.is_empty() || frames.len() < TIMED_FRAMES && start.elapsed().as_secs_f64() < TIMED_SECONDS {
        frames.push(draw()?);
    }
    Ok(frames)
}

/// Median time of a whole frame, from its first command until the device is idle.
fn frame_milliseconds(renderer: &mut Renderer, camera: &Camera, inputs: &Inputs) -> Result<f64, CliError> {
    let times = timed_frames(|| {
        let start = Instant::now();
        renderer.draw(camera, inputs.width, inputs.height)?;
        Ok(start.elapsed().as_secs_f64() * 1e3)
    })?;
    Ok(median(times))
}

/// Median time of every pass of a profiling renderer, after one frame that compiles its pipelines.
fn pass_timings(
    renderer: &mut Renderer,
    camera: &Camera,
    inputs: &Inputs,
) -> Result<Vec<PassTiming>, CliError> {
    let mut passes = renderer.draw(camera, inputs.width, inputs.height)?;
    let frames = timed_frames(|| Ok(renderer.draw(camera, inputs.width, inputs.height)?))?;
    for (index, pass) in passes.iter_mut().enumerate() {
        let times = frames.iter().filter_map(|frame| frame.get(index)).map(|pass| pass.milliseconds);
        pass.milliseconds = median(times.collect());
    }
    Ok(passes)
}

/// The middle one of some values; 0 of none.
pub(super) fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

fn stats(inputs: &Inputs, lights: &LightSet, drawn: &Drawn) -> Value {
    let shares = lights.flux_shares();
    json!({
        "width": inputs.width,
        "height": inputs.height,
        "triangles": inputs.scene.triangle_count(),
        "adapter": drawn.adapter,
        "exposure": inputs.exposure,
        "light_count": lights.lights.len(),
        "flux_shares": { "lights": shares.lights, "residual": shares.residual },
        "shadow_bytes": drawn.shadow_bytes,
        "shadow_batches": drawn.shadow_batches,
        "frame_milliseconds": drawn.frame_milliseconds,
        "passes": drawn.passes,
        "fit": lights.document(),
    })
}
