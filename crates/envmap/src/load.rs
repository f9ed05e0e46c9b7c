use std::path::{Path, PathBuf};

use glam::Vec3;
use gnomon_picture::{Description, ImageError, RgbImage, read_bytes};

use crate::intake::{self, Intake, Taken};
use crate::{Equirect, Projection};

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
    /// The picture's format, and what the decoder told.
    description: Description,
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
        self.description.warnings.iter().cloned().chain(cleaned).collect()
    }

    /// The picture's format, how it was read, and what was ignored or assumed of it.
    pub fn description(&self) -> &Description {
        &self.description
    }
}

/// How an environment's file is read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LoadOptions<'a> {
    /// Its projection; else that which the file's `envmap` attribute or its shape announces.
    pub projection: Option<Projection>,
    /// Layer of an OpenEXR file; else the one that is plainly the picture.
    pub layer: Option<&'a str>,
}

/// Reads an environment map. A file that is equirect keeps its size, up to 4096 x 2048 texels: a larger one becomes a map of at most that,
/// by exact area, with the picture as its [`crate::Backdrop`]. Faces of `n` texels become `4 n` x `2 n`, a probe of `n` texels `2 n` x `n`.
///
/// # Errors
/// [`EnvMapError`]: unreadable, of no known shape, not of the shape or without the layer that was named.
pub fn load(path: impl AsRef<Path>, options: LoadOptions) -> Result<Environment, EnvMapError> {
    let bytes = read_bytes(&path)?;
    from_bytes(path, &bytes, options)
}

/// [`load`] of the bytes of a picture; `name` stands for their file in messages.
///
/// # Errors
/// As [`load`].
pub fn from_bytes(
    name: impl AsRef<Path>,
    bytes: &[u8],
    options: LoadOptions,
) -> Result<Environment, EnvMapError> {
    let path = || name.as_ref().to_owned();
    let known = Projection::list;
    let (intake, description) = intake::take(bytes, options.projection, options.layer)
        .map_err(|source| ImageError::Decode { path: path(), source })?;
    let Intake { taken, size: (width, height), environment, projection, .. } = intake;
    let projection = projection.ok_or_else(|| EnvMapError::UnknownShape {
        path: path(),
        width,
        height,
        known: known(),
    })?;
    let (map, report) = match taken {
        Taken::Averaged(averaged) => averaged.finish(),
        Taken::Nothing => return Err(EnvMapError::TooLarge { path: path(), width, height }),
        Taken::Whole(image) => {
            let mut unfolded = projection.unfold(image, environment).ok_or_else(|| {
                EnvMapError::WrongShape { path: path(), width, height, projection, known: known() }
            })?;
            let report = clean(unfolded.texels_mut());
            (unfolded.into_equirect(), report)
        }
    };
    Ok(Environment { map, projection, report, source_size: (width, height), description })
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
        *texel = report.clean(*texel, largest);
    }
    report
}

impl CleanReport {
    /// The texel as radiance, counted where it is none; infinite channels become `infinity`.
    pub(crate) fn clean(&mut self, texel: Vec3, infinity: f32) -> Vec3 {
        // Nearly all are radiance.
        if texel.is_finite() && texel.min_element() >= 0.0 {
            return texel;
        }
        let channels = texel.to_array();
        let any = |is: fn(f32) -> bool| usize::from(channels.into_iter().any(is));
        self.nan += any(f32::is_nan);
        self.negative += any(|value| value < 0.0);
        self.infinite += any(|value| value == f32::INFINITY);
        // `max` turns NaN into 0.
        Vec3::from_array(channels.map(|value| if value == f32::INFINITY { infinity } else { value.max(0.0) }))
    }
}
