//! What render and reference do for a sequence.

use std::path::Path;

use gnomon::metrics::SampledError;
use gnomon::picture::tonemap::{ToneMapping, tone_mapped};
use gnomon::reference::{self, ReferenceOptions};
use gnomon::renderer::layers::{Layer, LayerRequest};
use gnomon::renderer::{Background, Gpu, GpuOptions};
use gnomon::studio::{Film, FrameFiles, Sequence, SequenceRun, Stage, Studio};
use gnomon_terminal::Terminal;
use serde_json::{Value, json};

use super::check::CheckArgs;
use crate::error::CliError;
use crate::options::SequenceArgs;
use crate::output::{self, Drawn};

/// Draws a sequence on the GPU, and saves its scene where that is asked for, as soon as all is known to be fit for it.
///
/// # Errors
/// No adapter, pictures of other settings under the same names, unwritable files, no ffmpeg for a film.
pub fn render(
    args: &SequenceArgs,
    (check, request): (&CheckArgs, &LayerRequest),
    (output, save_scene): (&Path, Option<&Path>),
    options: &GpuOptions,
    stage: Stage,
    terminal: Terminal,
) -> Result<(), CliError> {
    let gpu = Gpu::new(options)?;
    let (layers, light_layers) = (&request.layers, request.light_layers);
    let how = json!({ "gpu": gpu.adapter().name, "layers": layers, "light_layers": light_layers });
    let job = Job::new(args, output, &stage, how)?;
    let [width, height] = stage.look().picture.size;
    let mut studio = Studio::new(&gpu, stage)?;
    studio.take_warnings().iter().for_each(|warning| terminal.warn(warning));
    if let Some(path) = save_scene {
        studio.save_scene(path)?;
    }
    job.run(terminal, |sequence, frame| {
        if layers.contains(&Layer::Motion) {
            studio.set_look(sequence.look_before(frame))?;
            studio.remember_for_motion()?;
        }
        studio.set_look(sequence.look(frame))?;
        let (frame, layers) = studio.frame_layers(width, height, request)?;
        let error = check.frame(studio.stage(), &frame.radiance)?;
        let is_transparent = studio.look().display.background == Background::Transparent;
        let alpha = is_transparent.then_some(frame.alpha);
        Ok((Drawn { radiance: frame.radiance, alpha, layers }, error))
    })
}

/// Ray-traces a sequence.
///
/// # Errors
/// As [`render`], but for the adapter.
pub fn reference(
    args: &SequenceArgs,
    output: &Path,
    options: &ReferenceOptions<'_>,
    mut stage: Stage,
    terminal: Terminal,
) -> Result<(), CliError> {
    let how = json!({ "samples_per_pixel": options.samples_per_pixel, "seed": options.seed });
    let job = Job::new(args, output, &stage, how)?;
    job.run(terminal, |sequence, frame| {
        stage.set_look(sequence.look(frame))?;
        let (scene, camera) = stage.for_reference()?;
        let sky = stage.sky();
        if stage.look().display.background == Background::Transparent {
            let (estimate, alpha) = reference::render_with_alpha(&scene, &camera, sky, options)?;
            return Ok((Drawn { alpha: Some(alpha), ..Drawn::new(estimate.mean) }, None));
        }
        Ok((Drawn::new(reference::render(&scene, &camera, sky, options)?.mean), None))
    })
}

/// Frames to be drawn and where they go.
struct Job {
    sequence: Sequence,
    sink: Sink,
    /// Frames that are still to be drawn.
    frames: Vec<u32>,
    kept: usize,
    display: (f32, ToneMapping),
}

enum Sink {
    Pictures(SequenceRun),
    Film(Film),
}

impl Job {
    fn new(args: &SequenceArgs, output: &Path, stage: &Stage, how: Value) -> Result<Self, CliError> {
        let (sequence, frames) = args.sequence(stage)?;
        let display = (stage.exposure(), stage.look().display.tone_mapping);
        let count = frames.clone().count();
        let (sink, frames) = if output::is_film(output) {
            let film = Film::start(output, stage.look().picture.size, args.frames_per_second())?;
            (Sink::Film(film), frames.collect())
        } else {
            let description = sequence.description(stage, how);
            let run = SequenceRun::open(FrameFiles::new(output)?, frames, description, args.overwrite())?;
            let missing = run.missing().to_vec();
            (Sink::Pictures(run), missing)
        };
        Ok(Self { sequence, sink, kept: count - frames.len(), frames, display })
    }

    fn run(
        mut self,
        terminal: Terminal,
        mut draw: impl FnMut(&Sequence, u32) -> Result<(Drawn, Option<SampledError>), CliError>,
    ) -> Result<(), CliError> {
        if self.kept > 0 {
            terminal.note(&format!("{} frames are there already, {} to draw", self.kept, self.frames.len()));
        }
        let bar = terminal.bar("frames");
        for (done, &frame) in self.frames.iter().enumerate() {
            bar.set(done as f32 / self.frames.len() as f32);
            bar.tell(&format!("frame {frame}"));
            let (drawn, error) = draw(&self.sequence, frame)?;
            if let Some(error) = error {
                bar.suspend(|| terminal.note(&format!("check of frame {frame}: {error}")));
            }
            match &mut self.sink {
                Sink::Pictures(run) => {
                    drawn.write(&run.path(frame), self.display)?;
                    run.finish(frame)?;
                }
                Sink::Film(film) => {
                    film.add(&tone_mapped(&drawn.radiance, self.display.1, self.display.0))?
                }
            }
        }
        drop(bar);
        match self.sink {
            Sink::Film(film) => Ok(film.finish()?),
            Sink::Pictures(_) => Ok(()),
        }
    }
}
