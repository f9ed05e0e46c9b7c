use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use gnomon::picture::tonemap::ToneMapping;
use gnomon::renderer::debug_view::DEBUG_VIEWS;
use gnomon::renderer::layers::RenderedLayers;
use gnomon::renderer::{Background, Gpu, GpuOptions, PassTiming};
use gnomon::studio::Studio;
use gnomon_terminal::Terminal;
use serde_json::{Value, json};

use super::check::{self, CheckArgs};
use super::level_of_detail::{self, LevelOfDetailArgs};
use super::sequence;
use crate::error::CliError;
use crate::options::{GpuArgs, InputArgs, LayerArgs, SequenceArgs, stage};
use crate::output::{self, Drawn};

/// Draw a scene under an environment on the GPU, soft shadows included
///
/// The environment becomes area lights, each with soft shadows, and an ambient rest. PNG holds the exposed and tone-mapped
/// picture, EXR linear radiance.
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  gnomon render three-boxes --env room -o boxes.png
  gnomon render bunny.ply --env grace.hdr --lights disks -o bunny.png --stats stats.json
  gnomon render bunny.ply --env grace.hdr --target-fps 30 -o bunny.png
  gnomon render bunny.ply --env grace.hdr --max-error 2% -o bunny.png
  gnomon render robot.glb --env sky --camera 'eye=3,2,4; target=0,0.5,0; fov=40' -o robot.exr
  gnomon render robot.glb --env sky --layers depth,normal,object -o robot.exr
  gnomon render robot.glb --env sky --duration 8 --fps 25 --turntable 45 -o frames/robot_####.png
  gnomon render robot.glb --env sky --clip Dance --frames 0..99 -o dance.mp4")]
pub struct RenderArgs {
    #[command(flatten)]
    inputs: InputArgs,

    /// Where the picture goes; of a sequence a name with #### in the place of the frame's number (else _#### is put before the extension), or a film
    #[arg(short, long, value_name = "OUT.{png,exr,mp4}")]
    output: PathBuf,

    #[command(flatten)]
    gpu: GpuArgs,

    #[command(flatten)]
    level_of_detail: LevelOfDetailArgs,

    #[command(flatten)]
    check: CheckArgs,

    #[command(flatten)]
    sequence: SequenceArgs,

    #[command(flatten)]
    layers: LayerArgs,

    /// Write lights, flux shares, adapter, memory, the time of every pass and the checked error as JSON
    #[arg(long, value_name = "STATS.json", conflicts_with_all = ["frames", "duration"])]
    stats: Option<PathBuf>,

    /// Show in place of the picture what it is made of
    #[arg(long, value_name = "VIEW", help = views(), conflicts_with_all = ["frames", "duration", "stats"])]
    debug: Option<String>,

    /// The light that a view of one is about, from 0 in the order of the fit, the scene's own last
    #[arg(long, value_name = "N", default_value_t = 0, requires = "debug")]
    debug_light: usize,

    /// Write a scene file that brings the same picture without these options
    #[arg(long, value_name = "SCENE.toml")]
    save_scene: Option<PathBuf>,
}

fn views() -> String {
    let views = DEBUG_VIEWS
        .iter()
        .map(|view| format!("{}{}", view.name, if view.of_light { " (of one light)" } else { "" }));
    format!("Show in place of the picture what it is made of: {}", views.collect::<Vec<_>>().join(", "))
}

/// Frames timed for the statistics, after one that compiles the pipelines, and the time after which fewer will do.
const TIMED_FRAMES: usize = 5;
const TIMED_SECONDS: f64 = 2.0;

/// Runs the command.
///
/// # Errors
/// Inputs that cannot be used, no adapter, unwritable outputs.
pub fn run(args: &RenderArgs, terminal: Terminal) -> Result<(), CliError> {
    args.sequence.check()?;
    args.check.validate()?;
    let is_sequence = args.sequence.is_given();
    output::check_pictures(&args.output, is_sequence)?;
    let layers = args.layers.request(&args.output, is_sequence)?;
    for (path, extension) in [(&args.stats, "json"), (&args.save_scene, "toml")] {
        path.as_ref().map_or(Ok(()), |path| output::check(path, &[extension]))?;
    }
    let project = args.inputs.project(&args.gpu.look.given, terminal)?;
    let gpu_options = GpuOptions { adapter: args.gpu.adapter.clone() };
    let mut stage = stage(project, terminal)?;
    let settled = match args.level_of_detail.budget_ms() {
        Some(budget_ms) => {
            let _spinner = terminal.spinner("settling");
            let settled = level_of_detail::settle(budget_ms, &gpu_options, &stage)?;
            stage.set_look(settled.look(stage.look()))?;
            Some(settled)
        }
        None => None,
    };
    if is_sequence {
        let files = (args.output.as_path(), args.save_scene.as_deref());
        let made = (&args.check, &layers);
        return sequence::render(&args.sequence, made, files, &gpu_options, stage, terminal);
    }
    let spinner = terminal.spinner("rendering");
    let [width, height] = stage.look().picture.size;
    let bound = args.check.bound(&args.gpu.look.given);
    if let Some(first) = bound.as_ref().and_then(|bound| bound.looks(stage.look()).into_iter().next()) {
        // Lights are fitted once for the first try.
        stage.set_look(first)?;
    }
    let mut studio = Studio::new(&Gpu::new(&gpu_options)?, stage)?;
    studio.take_warnings().iter().for_each(|warning| terminal.warn(warning));
    if let Some(view) = &args.debug {
        let count = studio.renderer().light_count();
        if DEBUG_VIEWS.iter().any(|known| known.of_light && known.name == *view) && args.debug_light >= count
        {
            return Err(CliError::usage(format!(
                "there is no light {}: --debug-light takes the number of one of {count}, from 0",
                args.debug_light
            )));
        }
        studio.renderer().set_debug_view(view, args.debug_light)?;
    }
    let mut checked = None;
    let mut frame = None;
    if let Some(bound) = &bound {
        let (within, error) = studio.frame_within(bound)?;
        (frame, checked) = (Some(within), Some(error));
    }
    let (frame, layers) = match frame {
        Some(frame) if layers.layers.is_empty() => (frame, RenderedLayers::default()),
        _ => studio.frame_layers(width, height, &layers)?,
    };
    let times = args.stats.as_ref().map(|_| Times::measure(&mut studio)).transpose()?;
    let is_told = args.debug.is_none() && (args.stats.is_some() || !terminal.is_quiet());
    let checked = match checked {
        None if is_told => args.check.single(studio.stage(), &frame.radiance)?,
        checked => checked,
    };
    drop(spinner);
    let stage = studio.stage();
    // Debug views are no radiance: they are shown as they are.
    let shown = match args.debug {
        Some(_) => (0.0, ToneMapping::Linear),
        None => (stage.exposure(), stage.look().display.tone_mapping),
    };
    let alpha = (stage.look().display.background == Background::Transparent).then_some(frame.alpha);
    Drawn { radiance: frame.radiance, alpha, layers }.write(&args.output, shown)?;
    if let Some(path) = &args.save_scene {
        stage.save_scene(path)?;
    }
    if let (Some(path), Some(times)) = (&args.stats, times) {
        let mut stats = stats(&mut studio, &times);
        if let Some(settled) = &settled {
            stats["level_of_detail"] = settled.document();
        }
        if let Some(error) = &checked {
            stats["check"] = json!(error);
        }
        if let (Some(bound), Some(error)) = (&bound, &checked) {
            stats["max_error"] = check::bound_document(bound, studio.look(), error);
        }
        output::write_text(path, &(output::json(&stats) + "\n"))?;
    }
    if let Some(settled) = &settled {
        terminal.note(&settled.summary());
    }
    if let (Some(bound), Some(error)) = (&bound, &checked) {
        check::tell_bound(bound, studio.look(), studio.lights().lights.len(), error, terminal);
    }
    if let Some(error) = &checked {
        terminal.note(&format!("check: {error}"));
    }
    Ok(())
}

/// How long frames take.
struct Times {
    /// Median of whole frames, from the first command until the device is idle [ms].
    frame: f64,
    /// Median of every pass.
    passes: Vec<PassTiming>,
}

impl Times {
    /// Draws a few frames more, of a studio that has drawn one, and a few whose passes are timed.
    fn measure(studio: &mut Studio) -> Result<Self, CliError> {
        let [width, height] = studio.look().picture.size;
        let frames = timed_frames(|| {
            let start = Instant::now();
            studio.draw(width, height)?;
            Ok(start.elapsed().as_secs_f64() * 1e3)
        })?;
        studio.set_profile(true);
        let mut passes = studio.draw(width, height)?;
        let profiled = timed_frames(|| Ok(studio.draw(width, height)?))?;
        for (index, pass) in passes.iter_mut().enumerate() {
            let times = profiled.iter().filter_map(|frame| frame.get(index)).map(|pass| pass.milliseconds);
            pass.milliseconds = median(times.collect());
        }
        Ok(Self { frame: median(frames), passes })
    }
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

/// The middle one of some values; 0 of none.
pub(super) fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

fn stats(studio: &mut Studio, times: &Times) -> Value {
    let renderer = studio.renderer();
    let (adapter, bytes) = (json!(renderer.gpu().adapter()), renderer.shadow_bytes());
    let batches = renderer.shadow_batches();
    let stage = studio.stage();
    let lights = studio.lights().times(stage.grade().light);
    let [width, height] = stage.look().picture.size;
    let shares = lights.flux_shares();
    json!({
        "width": width,
        "height": height,
        "triangles": stage.scene().triangle_count(),
        "adapter": adapter,
        "exposure": stage.exposure(),
        "light_count": lights.lights.len(),
        "flux_shares": { "lights": shares.lights, "residual": shares.residual },
        "shadow_bytes": bytes,
        "shadow_batches": batches,
        "frame_milliseconds": times.frame,
        "passes": times.passes,
        "fit": lights.document(),
    })
}
