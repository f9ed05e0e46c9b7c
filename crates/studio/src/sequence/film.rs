//! Films, through an installed ffmpeg.

use std::ffi::OsString;
use std::fs;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::thread::{self, JoinHandle};

use gnomon_picture::RgbImage;
use gnomon_picture::ldr::srgb8;

use crate::StudioError;

/// A film that is being written: H.264, through ffmpeg, into a file beside, which is renamed when all is there.
pub struct Film {
    ffmpeg: Child,
    frames: Option<ChildStdin>,
    words: Option<JoinHandle<String>>,
    path: PathBuf,
    beside: PathBuf,
    finished: bool,
}

impl Film {
    /// Starts a film of `[width, height]` pixels; both must be even, as its halved colour planes need.
    ///
    /// # Errors
    /// [`StudioError::Request`] where ffmpeg is not installed or the size is odd.
    pub fn start(
        path: &Path,
        [width, height]: [u32; 2],
        frames_per_second: f64,
    ) -> Result<Self, StudioError> {
        if width % 2 != 0 || height % 2 != 0 {
            return Err(StudioError::Request(format!(
                "a film of {width} x {height} pixels cannot be encoded: both sides must be even (see --size)"
            )));
        }
        let name = path.file_name().unwrap_or_default();
        // ffmpeg tells the format by the extension.
        let mut hidden = OsString::from(format!(".{}.part.", std::process::id()));
        hidden.push(name);
        let beside = path.with_file_name(hidden);
        let size = format!("{width}x{height}");
        let mut command = Command::new("ffmpeg");
        command.args(["-nostdin", "-hide_banner", "-loglevel", "error", "-y"]);
        command.args(["-f", "rawvideo", "-pixel_format", "rgb24", "-video_size", &size]);
        command.args(["-framerate", &frames_per_second.to_string(), "-i", "pipe:0"]);
        // Players expect BT.709 of what does not say otherwise.
        command.args(["-vf", "scale=out_color_matrix=bt709", "-colorspace", "bt709"]);
        command.args(["-c:v", "libx264", "-crf", "16", "-pix_fmt", "yuv420p", "-movflags", "+faststart"]);
        command.arg(&beside).stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped());
        let mut ffmpeg = command.spawn().map_err(|error| match error.kind() {
            io::ErrorKind::NotFound => StudioError::Request(
                "a film needs ffmpeg, which is not installed: install it (Debian: apt install ffmpeg), or write numbered \
                 pictures with -o NAME_####.png"
                    .to_owned(),
            ),
            _ => StudioError::Request(format!("ffmpeg cannot be run: {error}")),
        })?;
        let frames = ffmpeg.stdin.take();
        // Read all the while: a full pipe would stop it.
        let words = ffmpeg.stderr.take().map(|mut stderr| {
            thread::spawn(move || {
                let mut words = Vec::new();
                let _ = stderr.read_to_end(&mut words);
                String::from_utf8_lossy(&words).into_owned()
            })
        });
        Ok(Self { ffmpeg, frames, words, path: path.to_owned(), beside, finished: false })
    }

    /// Adds a picture of display light, tone-mapped, in 0..1.
    ///
    /// # Errors
    /// [`StudioError::Request`] with ffmpeg's words.
    pub fn add(&mut self, displayed: &RgbImage) -> Result<(), StudioError> {
        let written = match &mut self.frames {
            Some(frames) => frames.write_all(&srgb8(displayed)),
            None => Err(io::ErrorKind::BrokenPipe.into()),
        };
        written.map_err(|error| self.failed(&error.to_string()))
    }

    /// Ends the film and puts it in its place.
    ///
    /// # Errors
    /// [`StudioError::Request`] with ffmpeg's words, [`StudioError::Write`].
    pub fn finish(mut self) -> Result<(), StudioError> {
        self.frames = None;
        let ended = self.ffmpeg.wait();
        if !ended.as_ref().is_ok_and(|status| status.success()) {
            let how = ended.map_or_else(|error| error.to_string(), |status| status.to_string());
            return Err(self.failed(&how));
        }
        fs::rename(&self.beside, &self.path)
            .map_err(|source| StudioError::Write { path: self.path.clone(), source })?;
        self.finished = true;
        Ok(())
    }

    fn failed(&mut self, how: &str) -> StudioError {
        self.frames = None;
        let _ = self.ffmpeg.wait();
        let words = self.words.take().and_then(|words| words.join().ok()).unwrap_or_default();
        let words = gnomon_messages::one_line(words.lines().last().unwrap_or(how));
        StudioError::Request(format!("ffmpeg could not write {}: {words}", self.path.display()))
    }
}

impl Drop for Film {
    fn drop(&mut self) {
        if !self.finished {
            self.frames = None;
            let _ = self.ffmpeg.kill();
            let _ = self.ffmpeg.wait();
            let _ = fs::remove_file(&self.beside);
        }
    }
}
