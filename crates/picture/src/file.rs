//! Files of any known format. A new format is one decoder and one line in [`FORMATS`].

use std::fs::File;
use std::io::Read;
use std::path::Path;

use glam::Vec3;

use crate::error::{DecodeError, ImageError};
use crate::{RgbImage, exr, hdr, ldr};

/// Longest file that is read [bytes]: the largest picture, uncompressed, with alpha and a header.
const MAX_FILE: u64 = (1 << 31) + (1 << 20);

/// A picture format: how it is recognised and read. Writers are [`crate::write`]'s.
#[derive(Clone, Copy, Debug)]
pub struct Format {
    /// Name for people.
    pub name: &'static str,
    /// File name extensions in lower case; the first is the usual one.
    pub extensions: &'static [&'static str],
    /// Whether [`crate::write`] stores it.
    pub writable: bool,
    sniff: fn(&[u8]) -> bool,
    has_layers: bool,
    decode: Decoder,
}

/// What takes the bytes of a picture apart, and which of its layers.
type Decoder = fn(&[u8], Option<&str>, &mut dyn TexelSink) -> Result<Description, DecodeError>;

/// Every format, in the order in which they are tried.
const FORMATS: &[Format] = &[
    Format {
        name: "OpenEXR",
        extensions: &["exr"],
        writable: true,
        sniff: exr::sniff,
        has_layers: true,
        decode: exr::decode,
    },
    Format {
        name: "Radiance",
        extensions: &["hdr", "pic", "rgbe"],
        writable: true,
        sniff: hdr::sniff,
        has_layers: false,
        decode: |bytes, _, sink| hdr::decode(bytes, sink),
    },
    Format {
        name: "PNG",
        extensions: &["png"],
        writable: true,
        sniff: ldr::sniff_png,
        has_layers: false,
        decode: |bytes, _, sink| ldr::decode_png(bytes, sink),
    },
    Format {
        name: "JPEG",
        extensions: &["jpg", "jpeg"],
        writable: false,
        sniff: ldr::sniff_jpeg,
        has_layers: false,
        decode: |bytes, _, sink| ldr::decode_jpeg(bytes, sink),
    },
];

/// Every picture format that can be read.
pub fn formats() -> &'static [Format] {
    FORMATS
}

/// The format that a file of these bytes, or of more, begins like.
pub fn format_of(bytes: &[u8]) -> Option<&'static Format> {
    FORMATS.iter().find(|format| (format.sniff)(bytes))
}

/// What an EXR file's `envmap` attribute says of its projection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EnvironmentAttribute {
    /// Latitude-longitude, samples from edge to edge.
    LatLong,
    /// Six faces in a stack, samples from edge to edge.
    Cube,
}

/// Takes a picture's texels as they are decoded, so that a large one need not be in memory whole.
pub trait TexelSink {
    /// Width and height of the picture and what it says of its projection, before any texel. Texels that do not come are black.
    fn begin(&mut self, width: u32, height: u32, environment: Option<EnvironmentAttribute>);

    /// Texels of row `y` from column `x` to the right, linear Rec. 709; they may be NaN, infinite or negative where the file's are. Rows
    /// come in any order and in parts, each texel once.
    fn texels(&mut self, x: u32, y: u32, texels: &[Vec3]);
}

/// What was decoded.
#[derive(Clone, Debug)]
pub struct Description {
    /// Name of the file's format, as in [`formats`].
    pub format: &'static str,
    /// How it was read where that is not plain, as its layer: one line each, for people.
    pub details: Vec<String>,
    /// What was ignored or assumed, one line each, without the file's name.
    pub warnings: Vec<String>,
}

/// A picture as its file has it.
#[derive(Clone, Debug)]
pub struct Decoded {
    /// Linear radiance; may hold NaN, infinite and negative values where the file does.
    pub image: RgbImage,
    /// Name of the file's format, as in [`formats`].
    pub format: &'static str,
    /// The file's own word on being an environment map.
    pub environment: Option<EnvironmentAttribute>,
    /// What was ignored or assumed, one line each, without the file's name.
    pub warnings: Vec<String>,
}

/// The whole picture.
struct Whole {
    image: RgbImage,
    environment: Option<EnvironmentAttribute>,
}

impl TexelSink for Whole {
    fn begin(&mut self, width: u32, height: u32, environment: Option<EnvironmentAttribute>) {
        *self = Self { image: RgbImage::filled(width, height, Vec3::ZERO), environment };
    }

    fn texels(&mut self, x: u32, y: u32, texels: &[Vec3]) {
        self.image.row_mut(y)[x as usize..][..texels.len()].copy_from_slice(texels);
    }
}

/// Which texels of a picture count.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mask {
    /// Width in texels.
    pub width: u32,
    /// Height in texels.
    pub height: u32,
    /// Row by row from the top: whether the texel counts.
    pub inside: Vec<bool>,
}

/// Decodes the bytes of a picture in whichever format they begin like.
///
/// # Errors
/// [`DecodeError`]: unknown format, damaged, unsupported, over a limit, or of several layers of which none is plainly the picture.
pub fn decode(bytes: &[u8]) -> Result<Decoded, DecodeError> {
    let mut whole = Whole { image: RgbImage::filled(0, 0, Vec3::ZERO), environment: None };
    let Description { format, warnings, .. } = decode_into(bytes, None, &mut whole)?;
    Ok(Decoded { image: whole.image, format, environment: whole.environment, warnings })
}

/// Decodes the bytes of a picture part by part: of an OpenEXR file the named layer, where one is named.
///
/// # Errors
/// As [`decode`], and [`DecodeError::NoLayer`]. What `sink` has got by then is of no use.
pub fn decode_into(
    bytes: &[u8],
    layer: Option<&str>,
    sink: &mut dyn TexelSink,
) -> Result<Description, DecodeError> {
    let format = format_of(bytes).ok_or_else(|| {
        let known = FORMATS.iter().map(|format| format.name).collect::<Vec<_>>().join(", ");
        DecodeError::UnknownFormat { known }
    })?;
    match layer {
        Some(name) if !format.has_layers => Err(DecodeError::NoLayer {
            name: name.to_owned(),
            known: format!("none, as it is a {} file", format.name),
        }),
        _ => (format.decode)(bytes, layer, sink),
    }
}

/// Reads a picture; the content decides the format, not the name.
///
/// # Errors
/// [`ImageError::Read`] from the file system, [`ImageError::Decode`] for what is in the file.
pub fn read(path: impl AsRef<Path>) -> Result<Decoded, ImageError> {
    let path = path.as_ref();
    let bytes = read_bytes(path)?;
    decode(&bytes).map_err(|source| ImageError::Decode { path: path.to_owned(), source })
}

/// Reads a mask: texels whose stored brightness (mean of the channels, before any decoding) is at least one half count.
///
/// # Errors
/// As [`read`].
pub fn read_mask(path: impl AsRef<Path>) -> Result<Mask, ImageError> {
    let image = read(path)?.image;
    // Low-range pictures come decoded from sRGB, where one half is stored for 0.214.
    let inside = image.texels().iter().map(|texel| {
        let stored = texel.to_array().map(crate::tonemap::srgb_encode);
        stored.iter().sum::<f32>() / 3.0 >= 0.5
    });
    Ok(Mask { width: image.width(), height: image.height(), inside: inside.collect() })
}

/// Reads the bytes of a picture's file, for [`decode_into`].
///
/// # Errors
/// [`ImageError::Read`] from the file system, [`ImageError::Decode`] for a file that is too long.
pub fn read_bytes(path: impl AsRef<Path>) -> Result<Vec<u8>, ImageError> {
    let path = path.as_ref();
    let error = |source| ImageError::Read { path: path.to_owned(), source };
    let file = File::open(path).map_err(error)?;
    // Growing would take twice the memory for a while.
    let length = file.metadata().map_or(0, |metadata| metadata.len()).min(MAX_FILE);
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(length as usize).map_err(|_| error(std::io::ErrorKind::OutOfMemory.into()))?;
    file.take(MAX_FILE + 1).read_to_end(&mut bytes).map_err(error)?;
    if bytes.len() as u64 > MAX_FILE {
        let source = DecodeError::TooLarge { format: "picture", reason: format!("over {MAX_FILE} bytes") };
        return Err(ImageError::Decode { path: path.to_owned(), source });
    }
    Ok(bytes)
}

/// Writes a picture in the format of its name: `.exr` as linear 32-bit float, `.hdr` as mantissas of 8 bits with a shared
/// exponent, `.png` as 8-bit sRGB of display-linear values in 0..1 ([`crate::tonemap::tone_mapped`] makes them from radiance).
///
/// # Errors
/// [`ImageError::UnknownExtension`], or as [`exr::write`], [`hdr::write`] and [`ldr::write_png`].
pub fn write(path: impl AsRef<Path>, image: &RgbImage) -> Result<(), ImageError> {
    let path = path.as_ref();
    let extension = path.extension().map(|extension| extension.to_string_lossy().to_ascii_lowercase());
    match extension.as_deref() {
        Some("exr") => exr::write(path, image),
        Some("hdr") => hdr::write(path, image),
        Some("png") => ldr::write_png(path, image),
        _ => {
            let known = FORMATS.iter().filter(|format| format.writable);
            let known =
                known.map(|format| format!(".{}", format.extensions[0])).collect::<Vec<_>>().join(", ");
            Err(ImageError::UnknownExtension { path: path.to_owned(), known })
        }
    }
}
