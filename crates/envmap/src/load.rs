use std::path::{Path, PathBuf};

use glam::Vec3;
use gnomon_picture::{Decoded, ImageError, RgbImage};

use crate::{Equirect, Projection};

/// Largest picture of a projection other than equirect, in texels: resampling takes some 100 bytes for each.
const MAX_RESAMPLED_TEXELS: u64 = 1 << 24;

/// Why a picture cannot serve as an environment.
#[derive(Debug, thiserror::Error)]
pub enum EnvMapError {
    /// The file could not be read.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// The shape fits no projection, and none was named.
    #[error("{path}: {width} x {height} texels fit no projection; known are {known}", path = path.display())]
    UnknownShape {
        /// The file.
        path: PathBuf,
        /// Its width in texels.
        width: u32,
        /// Its height in texels.
        height: u32,
        /// Names and shapes that were tried.
        known: String,
    },
    /// The picture cannot be taken apart as the projection that was named.
    #[error(
        "{path}: {width} x {height} texels cannot be read as {name} (its shape is {shape}); known are {known}",
        path = path.display(), name = projection.name(), shape = projection.shape()
    )]
    WrongShape {
        /// The file.
        path: PathBuf,
        /// Its width in texels.
        width: u32,
        /// Its height in texels.
        height: u32,
        /// The projection that was named.
        projection: Projection,
        /// Names and shapes of all projections.
        known: String,
    },
    /// The picture would have to be resampled and is too large for that.
    #[error("{path}: {width} x {height} texels are too many to be resampled (limit 2^24); make it smaller", path = path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// Its width in texels.
        width: u32,
        /// Its height in texels.
        height: u32,
    },
}

/// How many texels of a map had a channel that is no radiance, and were changed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CleanReport {
    /// Not a number; set to 0.
    pub nan: usize,
    /// Negative, also negative infinity; set to 0.
    pub negative: usize,
    /// Infinite; set to the largest finite channel of the map.
    pub infinite: usize,
}

/// An environment map as its file has it.
#[derive(Clone, Debug)]
pub struct Environment {
    /// Incoming radiance, finite and not negative. Its flux is the cleaned picture's, channel by channel.
    pub map: Equirect,
    /// How the picture was read.
    pub projection: Projection,
    /// Texels that had to be cleaned.
    pub report: CleanReport,
    /// Width and height of the picture in texels.
    pub source_size: (u32, u32),
    /// What the decoder ignored or assumed.
    notes: Vec<String>,
}

impl Environment {
    /// One line for each thing that a user should know about the file.
    pub fn warnings(&self) -> Vec<String> {
        let CleanReport { nan, negative, infinite } = self.report;
        let lines = [
            (nan, "NaN texels were set to 0"),
            (negative, "negative texels were set to 0"),
            (infinite, "infinite texels were set to the largest finite value of the map"),
        ];
        let cleaned =
            lines.iter().filter(|(count, _)| *count > 0).map(|(count, what)| format!("{count} {what}"));
        self.notes.iter().cloned().chain(cleaned).collect()
    }
}

/// Reads an environment map. The projection is `forced`, or else announced by the file's `envmap` attribute or by its shape.
/// A file that is equirect keeps its size; faces of `n` texels become `4 n` x `2 n`, a probe of `n` texels `2 n` x `n`.
///
/// # Errors
/// [`EnvMapError`]: unreadable, of no known shape, or not of the shape that was named.
pub fn load(path: impl AsRef<Path>, forced: Option<Projection>) -> Result<Environment, EnvMapError> {
    let path = path.as_ref();
    unfold(path, gnomon_picture::read(path)?, forced)
}

/// [`load`] of the bytes of a picture; `name` stands for their file in messages.
///
/// # Errors
/// As [`load`].
pub fn from_bytes(
    name: impl AsRef<Path>,
    bytes: &[u8],
    forced: Option<Projection>,
) -> Result<Environment, EnvMapError> {
    let path = name.as_ref();
    let decoded = gnomon_picture::decode(bytes)
        .map_err(|source| ImageError::Decode { path: path.to_owned(), source })?;
    unfold(path, decoded, forced)
}

fn unfold(path: &Path, decoded: Decoded, forced: Option<Projection>) -> Result<Environment, EnvMapError> {
    let Decoded { image, environment, warnings, .. } = decoded;
    let (width, height) = (image.width(), image.height());
    let known = Projection::list;
    let path = || path.to_owned();
    let projection = forced
        .or_else(|| Projection::detect(width, height, environment))
        .ok_or_else(|| EnvMapError::UnknownShape { path: path(), width, height, known: known() })?;
    let texels = u64::from(width) * u64::from(height);
    let kept = projection == Projection::Equirect && environment.is_none();
    if !kept && texels > MAX_RESAMPLED_TEXELS {
        return Err(EnvMapError::TooLarge { path: path(), width, height });
    }
    let mut unfolded = projection.unfold(&image, environment).ok_or_else(|| EnvMapError::WrongShape {
        path: path(),
        width,
        height,
        projection,
        known: known(),
    })?;
    drop(image);
    let report = clean(unfolded.texels_mut());
    let map = unfolded.into_equirect();
    Ok(Environment { map, projection, report, source_size: (width, height), notes: warnings })
}

/// Makes an equirect map of a picture that a program computed, cleaning it as [`load`] does.
pub fn from_picture(mut image: RgbImage) -> (Equirect, CleanReport) {
    let report = clean(image.texels_mut());
    (Equirect::new(image), report)
}

fn clean(texels: &mut [Vec3]) -> CleanReport {
    let channels = || texels.iter().flat_map(|texel| texel.to_array());
    let largest = channels().filter(|value| value.is_finite()).fold(0.0, f32::max);
    let mut report = CleanReport::default();
    for texel in texels {
        let [r, g, b] = texel.to_array();
        let any = |is: fn(f32) -> bool| usize::from(is(r) || is(g) || is(b));
        report.nan += any(f32::is_nan);
        report.negative += any(|value| value < 0.0);
        report.infinite += any(|value| value == f32::INFINITY);
        // `max` turns NaN into 0.
        *texel = Vec3::from_array(texel.to_array().map(|value| value.max(0.0).min(largest)));
    }
    report
}
