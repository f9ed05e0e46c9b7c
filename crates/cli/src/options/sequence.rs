use std::ops::RangeInclusive;

use clap::Args;
use gnomon::studio::{Sequence, Stage, Timeline};

use crate::error::CliError;
use crate::options::{Numbers, finite, positive};

/// Which pictures of a moving scene.
#[derive(Args, Clone, Debug)]
pub struct SequenceArgs {
    /// Draw a sequence: its first and last frame, both included. Frame N shows the scene N / FPS seconds after --time; frames that are
    /// there already are kept. Several runs may draw one sequence at once, each its own frames
    #[arg(long, value_name = "A..B")]
    frames: Option<Numbers<u32>>,

    /// Draw a sequence of so many seconds, from frame 0 on; with --frames those of it
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = positive)]
    duration: Option<f32>,

    /// Frames a second of a sequence [default: 25]
    #[arg(long, value_name = "F", allow_negative_numbers = true, value_parser = positive)]
    fps: Option<f32>,

    /// Turn the camera about the vertical through the scene's middle by so many degrees a second
    #[arg(long, value_name = "DEG", allow_negative_numbers = true, value_parser = finite)]
    turntable: Option<f32>,

    /// Turn the environment about +y by so many degrees a second
    #[arg(long, value_name = "DEG", allow_negative_numbers = true, value_parser = finite)]
    env_turn: Option<f32>,

    /// Draw all frames anew, whatever pictures there are
    #[arg(long)]
    overwrite: bool,
}

/// Frames a second where nobody says.
pub(super) const FRAMES_PER_SECOND: f32 = 25.0;

/// Most frames of a sequence: eleven hours of a film.
const MOST_FRAMES: u32 = 1_000_000;

impl SequenceArgs {
    /// Whether a sequence is asked for, rather than one picture.
    pub fn is_given(&self) -> bool {
        self.frames.is_some() || self.duration.is_some()
    }

    /// Refuses options of a sequence where none is asked for.
    ///
    /// # Errors
    /// [`CliError::Usage`] naming the option.
    pub fn check(&self) -> Result<(), CliError> {
        let given = [
            ("--fps", self.fps.is_some()),
            ("--turntable", self.turntable.is_some()),
            ("--env-turn", self.env_turn.is_some()),
            ("--overwrite", self.overwrite),
        ];
        match given.iter().find(|(_, given)| *given && !self.is_given()) {
            Some((option, _)) => Err(CliError::usage(format!(
                "{option} is for a sequence: say how long with --frames or --duration"
            ))),
            None => Ok(()),
        }
    }

    /// Whether pictures that are there are drawn anew.
    pub fn overwrite(&self) -> bool {
        self.overwrite
    }

    /// Frames a second.
    pub fn frames_per_second(&self) -> f64 {
        f64::from(self.fps.unwrap_or(FRAMES_PER_SECOND))
    }

    /// The sequence of a stage, and its frames.
    ///
    /// # Errors
    /// Frames that lie beyond the duration.
    pub fn sequence(&self, stage: &Stage) -> Result<(Sequence, RangeInclusive<u32>), CliError> {
        let timeline = Timeline {
            frames_per_second: self.frames_per_second(),
            turntable: f64::from(self.turntable.unwrap_or(0.0)),
            environment_turn: f64::from(self.env_turn.unwrap_or(0.0)),
        };
        let last = self.duration.map(|seconds| timeline.frames_in(f64::from(seconds)) - 1);
        let frames = match (&self.frames, last) {
            (Some(Numbers(frames)), Some(last)) if *frames.end() > last => {
                return Err(CliError::usage(format!(
                    "--duration ends with frame {last}, before --frames does"
                )));
            }
            (Some(Numbers(frames)), _) => frames.clone(),
            (None, last) => 0..=last.unwrap_or(0),
        };
        if frames.end() - frames.start() >= MOST_FRAMES {
            return Err(CliError::usage(format!("a sequence has at most {MOST_FRAMES} frames")));
        }
        Ok((Sequence::new(stage, timeline)?, frames))
    }
}
