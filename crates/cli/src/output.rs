//! Results to files. Each is complete or not there.

use std::io;
use std::path::Path;

use gnomon::picture::exr::{Channel, Samples};
use gnomon::picture::tonemap::{ToneMapping, straight, tone_mapped};
use gnomon::picture::{RgbImage, atomic};
use gnomon::renderer::layers::{Layer, RenderedLayers};
use serde::Serialize;

use crate::error::CliError;

/// Whether a file name asks for linear radiance (EXR) rather than for a displayed picture.
pub fn is_linear(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("exr"))
}

/// Refuses a name that no writer takes before hours of work go into it.
///
/// # Errors
/// [`CliError::Usage`]: the extension is not one of `extensions`, or the folder is not there.
pub fn check(path: &Path, extensions: &[&str]) -> Result<(), CliError> {
    let extension = path.extension().map(|extension| extension.to_string_lossy().to_lowercase());
    if !extension.is_some_and(|extension| extensions.contains(&extension.as_str())) {
        let known =
            extensions.iter().map(|extension| format!(".{extension}")).collect::<Vec<_>>().join(" or ");
        return Err(CliError::usage(format!(
            "cannot write {}: the name must end in {known}",
            path.display()
        )));
    }
    check_folder(path)
}

/// [`check`] of what a picture goes to, or with `is_sequence` a sequence: its folder is made, a film's is not.
///
/// # Errors
/// As [`check`].
pub fn check_pictures(path: &Path, is_sequence: bool) -> Result<(), CliError> {
    if !is_sequence && path.to_string_lossy().contains("####") {
        return Err(CliError::usage(format!(
            "{} names the pictures of a sequence: say which frames with --frames or --duration, or leave out the ####",
            path.display()
        )));
    }
    if !is_sequence || is_film(path) {
        return check(path, if is_sequence { &["png", "exr", "mp4"] } else { &["png", "exr"] });
    }
    check(Path::new(path.file_name().unwrap_or_default()), &["png", "exr", "mp4"])
}

/// Whether a file name asks for a film.
pub fn is_film(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("mp4"))
}

/// Refuses a name in a folder that is not there.
///
/// # Errors
/// [`CliError::Usage`].
pub fn check_folder(path: &Path) -> Result<(), CliError> {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() && !folder.is_dir() => Err(CliError::usage(format!(
            "cannot write {}: there is no folder {}",
            path.display(),
            folder.display()
        ))),
        _ => Ok(()),
    }
}

/// Writes radiance: EXR as it is, PNG exposed by `exposure` stops and tone-mapped.
///
/// # Errors
/// As [`gnomon::picture::write`].
pub fn write_radiance(
    path: &Path,
    radiance: &RgbImage,
    (exposure, tone_mapping): (f32, ToneMapping),
) -> Result<(), CliError> {
    if is_linear(path) {
        gnomon::picture::write(path, radiance)?;
    } else {
        gnomon::picture::write(path, &tone_mapped(radiance, tone_mapping, exposure))?;
    }
    Ok(())
}

/// What becomes of a frame.
pub struct Drawn {
    pub radiance: RgbImage,
    /// Where nothing is behind the scene.
    pub alpha: Option<Vec<f32>>,
    pub layers: RenderedLayers,
}

impl Drawn {
    /// A picture alone.
    pub fn new(radiance: RgbImage) -> Self {
        Self { radiance, alpha: None, layers: RenderedLayers::default() }
    }

    /// Writes it as [`write_radiance`] does; with alpha, straight in PNG and premultiplied in EXR; layers go into the EXR file.
    ///
    /// # Errors
    /// As there, and as [`gnomon::picture::exr::write_channels`].
    pub fn write(&self, path: &Path, (exposure, tone_mapping): (f32, ToneMapping)) -> Result<(), CliError> {
        let Self { radiance, alpha, layers } = self;
        if is_linear(path) && (alpha.is_some() || !layers.layers.is_empty()) {
            let (mut channels, attributes) = layers.with_picture(radiance);
            if let Some(alpha) = alpha.as_ref().filter(|_| layers.get(Layer::Alpha).is_none()) {
                let samples = Samples::Floats(alpha.clone());
                channels.push(Channel { name: "A".to_owned(), samples });
            }
            let size = [radiance.width(), radiance.height()];
            gnomon::picture::exr::write_channels(path, size, channels, &attributes)?;
            return Ok(());
        }
        let Some(alpha) = alpha else { return write_radiance(path, radiance, (exposure, tone_mapping)) };
        let shown = tone_mapped(&straight(radiance, alpha), tone_mapping, exposure);
        gnomon::picture::ldr::write_png_with_alpha(path, &shown, alpha)?;
        Ok(())
    }
}

/// Writes text.
///
/// # Errors
/// [`CliError::Write`].
pub fn write_text(path: &Path, text: &str) -> Result<(), CliError> {
    atomic::write::<io::Error>(path, |file| file.write_all(text.as_bytes()))
        .map_err(|source| CliError::Write { path: path.to_owned(), source })
}

/// Indented JSON. Numbers that JSON lacks (infinity) become `null`.
pub fn json(value: &impl Serialize) -> String {
    // Only maps with keys that are no strings can fail, and the commands have none.
    serde_json::to_string_pretty(value).unwrap_or_default()
}
