//! OpenEXR pictures, through the `exr` crate: its block interface, so that sizes are checked before anything is allocated
//! and only the wanted layer and level are decompressed.

mod blocks;
mod channels;
mod chroma;
mod layers;
mod sampling;

use std::borrow::Cow;
use std::io::Cursor;
use std::path::Path;

use ::exr::block::reader::Reader;
use ::exr::meta::BlockDescription;
use ::exr::meta::attribute::{ChannelDescription, EnvironmentMap};
use ::exr::meta::header::Header;
use ::exr::prelude::{
    Blocks, Compression, Encoding, Image, LineOrder, SpecificChannels, Vec2, WritableImage,
};
use glam::{Mat3, Vec3};

use crate::error::{DecodeError, ImageError};
use crate::file::{Description, EnvironmentAttribute, TexelSink};
use crate::primaries::{Primaries, converted};
use crate::{MAX_TEXELS, RgbImage, atomic};
use blocks::read_rows;
pub use channels::{Channel, Samples, encode_channels, write_channels};
use layers::{Channels, Choice};

const FORMAT: &str = "OpenEXR";
/// Largest block (tile or run of scanlines) that is decompressed in one piece [bytes].
const MAX_BLOCK_BYTES: u64 = 1 << 28;

fn malformed(reason: impl Into<String>) -> DecodeError {
    DecodeError::malformed(FORMAT, reason)
}

fn too_large(reason: impl Into<String>) -> DecodeError {
    DecodeError::too_large(FORMAT, reason)
}

/// Whether the bytes begin like an OpenEXR picture.
pub fn sniff(bytes: &[u8]) -> bool {
    bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01])
}

/// Decodes an OpenEXR picture: scanlines or tiles, half, float or integer samples, every compression of the `exr` crate
/// (all but HTJ2K); of several resolutions the largest.
///
/// A layer is what the channels of a part have before the last dot of their names; red, green and blue are called so or R, G and B, in
/// any case. Read is the layer that is named, or else the one that is plainly the picture: the only one, the one without a name, or one with
/// a name like Blender's `Combined`; of several parts otherwise the first, with a warning. Where nothing is red, green and blue, luminance
/// is read, with its chroma; where there is none either, the file's only channel, as grey.
///
/// The picture covers the display window, black where the file has no data, except that an environment map covers its
/// data window. Colours of other `chromaticities` become Rec. 709.
///
/// # Errors
/// [`DecodeError`] for a damaged or oversized file, deep data, other subsampling than of chroma, and where no layer is plainly the picture.
pub fn decode(
    bytes: &[u8],
    layer: Option<&str>,
    sink: &mut dyn TexelSink,
) -> Result<Description, DecodeError> {
    let (bytes, sampling) = match sampling::unsampled(bytes) {
        Some(unsampled) => (Cow::Owned(unsampled.bytes), unsampled.sampling),
        None => (Cow::Borrowed(bytes), Vec::new()),
    };
    let reader = Reader::read_from_buffered(Cursor::new(&*bytes), false).map_err(from_exr)?;
    check_tables(reader.headers(), bytes.len())?;
    let Choice { part, channels, mut details, mut warnings } = layers::choose(reader.headers(), layer)?;
    let mut header = reader.headers()[part].clone();
    set_sampling(&mut header, sampling.get(part))?;
    check_sizes(&header, bytes.len())?;
    let fills_chroma = check_sampling(&header, channels)?;
    let window = Window::of(&header)?;

    let chromaticities = header.shared_attributes.chromaticities.map(|from| Primaries {
        red: [from.red.0, from.red.1],
        green: [from.green.0, from.green.1],
        blue: [from.blue.0, from.blue.1],
        white: [from.white.0, from.white.1],
    });
    let others = chromaticities.filter(|own| !own.is_rec709() && !matches!(channels, Channels::Grey(_)));
    let matrix = others.and_then(|primaries| primaries.rec709());
    match (others, matrix) {
        (Some(primaries), Some(_)) => details.push(primaries.told()),
        (Some(_), None) => {
            warnings.push("its primaries span no colours; colours were taken as Rec. 709".to_owned());
        }
        (None, _) => {}
    }
    let environment = header.own_attributes.environment_map.map(|kind| match kind {
        EnvironmentMap::LatitudeLongitude => EnvironmentAttribute::LatLong,
        EnvironmentMap::Cube => EnvironmentAttribute::Cube,
    });
    sink.begin(window.width, window.height, environment);
    let mut output = Output { sink, window: &window, matrix };
    match channels {
        Channels::Rgb(channels) => {
            read_rows(reader, part, &header, channels, |x, y, row| output.take(x, y, row))?;
        }
        Channels::Grey(channel) => {
            read_rows(reader, part, &header, [channel; 3], |x, y, row| output.take(x, y, row))?;
        }
        Channels::LuminanceChroma([y, ry, by]) => {
            let Vec2(width, height) = header.layer_size;
            let mut picture = RgbImage::filled(width as u32, height as u32, Vec3::ZERO);
            read_rows(reader, part, &header, [ry, y, by], |x, y, row| {
                picture.row_mut(y as u32)[x..][..row.len()].copy_from_slice(row);
            })?;
            let weights = chromaticities.map_or(crate::LUMINANCE, |primaries| primaries.luminance());
            output.take_chroma(picture, weights, fills_chroma);
        }
    }
    Ok(Description { format: FORMAT, details, warnings })
}

/// Takes over how channels are subsampled, which [`sampling::unsampled`] hid from the crate.
fn set_sampling(header: &mut Header, sampling: Option<&Vec<Vec2<usize>>>) -> Result<(), DecodeError> {
    let Some(sampling) = sampling else { return Ok(()) };
    let Vec2(width, height) = header.layer_size;
    let Vec2(left, top) = header.own_attributes.layer_position;
    for (channel, &Vec2(across, down)) in header.channels.list.iter_mut().zip(sampling) {
        let divides = |step: usize, size: usize, start: i32| {
            step > 0 && size.is_multiple_of(step) && i64::from(start).rem_euclid(step as i64) == 0
        };
        if !(divides(across, width, left) && divides(down, height, top)) {
            return Err(malformed("the sampling of a channel does not divide the data window"));
        }
        channel.sampling = Vec2(across, down);
    }
    let is_sampled = header.channels.list.iter().any(|channel| channel.sampling != Vec2(1, 1));
    match header.blocks {
        BlockDescription::Tiles(_) if is_sampled => Err(malformed("channels of tiles are subsampled")),
        _ => Ok(()),
    }
}

/// Whether chroma is to be filled in; other subsampling is refused.
fn check_sampling(header: &Header, channels: Channels) -> Result<bool, DecodeError> {
    let step = |channel: usize| header.channels.list[channel].sampling;
    let (whole, chroma) = match channels {
        Channels::Rgb(channels) => (channels.map(step).to_vec(), Vec2(1, 1)),
        Channels::Grey(channel) => (vec![step(channel)], Vec2(1, 1)),
        Channels::LuminanceChroma([y, ry, by]) if step(ry) == step(by) => (vec![step(y)], step(ry)),
        Channels::LuminanceChroma(channels) => (channels.map(step).to_vec(), Vec2(1, 1)),
    };
    match (whole.iter().all(|&step| step == Vec2(1, 1)), chroma) {
        (true, Vec2(1, 1)) => Ok(false),
        (true, Vec2(2, 2)) => Ok(true),
        _ => Err(DecodeError::unsupported(FORMAT, "subsampling other than of chroma by 2 x 2")),
    }
}

/// Where colours go.
struct Output<'a> {
    sink: &'a mut dyn TexelSink,
    window: &'a Window,
    /// Makes Rec. 709 of them.
    matrix: Option<Mat3>,
}

impl Output<'_> {
    /// Takes texels from place `x`, `y` of the data window on.
    fn take(&mut self, x: usize, y: usize, texels: &mut [Vec3]) {
        if let Some(matrix) = &self.matrix {
            texels.iter_mut().for_each(|texel| *texel = converted(matrix, *texel));
        }
        if let Some((x, y, visible)) = self.window.visible(x, y, texels.len()) {
            self.sink.texels(x, y, &texels[visible]);
        }
    }

    /// Takes the data window as red less luminance, luminance, and blue less luminance.
    fn take_chroma(&mut self, mut picture: RgbImage, weights: Vec3, fills: bool) {
        if fills {
            chroma::fill(&mut picture);
        }
        let height = picture.height();
        for y in 0..height {
            chroma::colors(picture.row_mut(y), weights);
        }
        for y in 0..height {
            let below = if y + 1 < height { y + 1 } else { height.saturating_sub(2) };
            let rows = [y.saturating_sub(1), y, below].map(|y| picture.row(y));
            let mut row = match fills {
                true => chroma::saturation_fixed(rows, weights),
                false => rows[1].to_vec(),
            };
            self.take(0, y as usize, &mut row);
        }
    }
}

fn from_exr(error: ::exr::error::Error) -> DecodeError {
    use ::exr::error::Error;
    match error {
        Error::NotSupported(what) if what.contains("deep") => DecodeError::unsupported(
            FORMAT,
            "deep data, several samples a texel (flatten it, for instance: oiiotool IN.exr --flatten -o OUT.exr)",
        ),
        Error::NotSupported(what) => DecodeError::unsupported(FORMAT, what),
        Error::Invalid(what) => malformed(what),
        Error::Io(error) => malformed(error.to_string()),
        Error::Aborted => malformed("reading stopped"),
    }
}

/// Every chunk has an offset of eight bytes in the file, so the tables cannot be longer than it is.
fn check_tables(headers: &[Header], file_length: usize) -> Result<(), DecodeError> {
    let chunks = headers.iter().fold(0u64, |sum, header| sum.saturating_add(header.chunk_count as u64));
    if chunks.saturating_mul(8) > file_length as u64 {
        return Err(too_large(format!("it claims {chunks} blocks in a file of {file_length} bytes")));
    }
    Ok(())
}

/// Bytes of texels that one byte of file can stand for at most, by the method of compression.
fn largest_ratio(compression: Compression) -> u64 {
    match compression {
        Compression::Uncompressed => 1,
        // A run of 128 in two bytes.
        Compression::RLE => 64,
        // Deflate reaches 1032; PXR24 drops a quarter of the bytes first.
        Compression::ZIP1 | Compression::ZIP16 | Compression::PXR24 => 1400,
        // Fourteen bytes for 32, or three.
        Compression::B44 | Compression::B44A => 11,
        Compression::PIZ => 1 << 12,
        _ => 1 << 16,
    }
}

fn check_sizes(header: &Header, file_length: usize) -> Result<(), DecodeError> {
    let area = |size: Vec2<usize>| (size.0 as u64).saturating_mul(size.1 as u64);
    let texels = area(header.layer_size);
    let size = format!("{} x {} texels", header.layer_size.0, header.layer_size.1);
    if texels == 0 {
        return Err(malformed("the picture is empty"));
    }
    if texels > MAX_TEXELS {
        return Err(too_large(format!("{size} (limit {MAX_TEXELS})")));
    }
    if matches!(header.compression, Compression::HTJ2K32 | Compression::HTJ2K256) {
        return Err(DecodeError::unsupported(
            FORMAT,
            "HTJ2K compression (convert it, for instance: oiiotool IN.exr --compression zip -o OUT.exr)",
        ));
    }
    let texel_bytes = header.channels.bytes_per_pixel as u64;
    let stored = |channel: &ChannelDescription| {
        texels / area(channel.sampling).max(1) * channel.sample_type.bytes_per_sample() as u64
    };
    // Headers and tables only add to the file, so the bound is safe.
    let most = (file_length as u64).saturating_mul(largest_ratio(header.compression));
    if header.channels.list.iter().map(stored).fold(0, u64::saturating_add) > most {
        return Err(too_large(format!("{size} in a file of {file_length} bytes")));
    }
    let block = match header.blocks {
        BlockDescription::ScanLines => area(Vec2(
            header.layer_size.0,
            header.compression.scan_lines_per_block().min(header.layer_size.1),
        )),
        BlockDescription::Tiles(tiles) => {
            area(Vec2(tiles.tile_size.0.min(header.layer_size.0), tiles.tile_size.1.min(header.layer_size.1)))
        }
    };
    if block.saturating_mul(texel_bytes) > MAX_BLOCK_BYTES {
        return Err(too_large(format!("a block holds {block} texels of {texel_bytes} bytes")));
    }
    Ok(())
}

/// Where the data lies in the picture that is returned.
struct Window {
    width: u32,
    height: u32,
    /// Picture position of the data window's first texel.
    left: i64,
    top: i64,
}

impl Window {
    fn of(header: &Header) -> Result<Self, DecodeError> {
        let data = (header.own_attributes.layer_position, header.layer_size);
        let display = header.shared_attributes.display_window;
        let (position, size) = match header.own_attributes.environment_map {
            Some(_) => data,
            None => (display.position, display.size),
        };
        let texels = (size.0 as u64).saturating_mul(size.1 as u64);
        // A display window far beyond the data would turn a small file into a large picture.
        if texels > MAX_TEXELS || texels > 64 * (data.1.0 as u64 * data.1.1 as u64).max(1 << 20) {
            return Err(too_large(format!("its display window has {} x {} texels", size.0, size.1)));
        }
        if texels == 0 {
            return Err(malformed("the display window is empty"));
        }
        Ok(Self {
            width: size.0 as u32,
            height: size.1 as u32,
            left: i64::from(data.0.0) - i64::from(position.0),
            top: i64::from(data.0.1) - i64::from(position.1),
        })
    }

    /// Where `count` texels from a place of the data window on lie in the picture, and which of them; `None` where all lie outside.
    fn visible(&self, x: usize, y: usize, count: usize) -> Option<(u32, u32, std::ops::Range<usize>)> {
        let (x, y) = (x as i64 + self.left, y as i64 + self.top);
        let end = (x + count as i64).min(i64::from(self.width));
        let start = x.max(0);
        let is_inside = start < end && (0..i64::from(self.height)).contains(&y);
        is_inside.then(|| (start as u32, y as u32, (start - x) as usize..(end - x) as usize))
    }
}

/// Encodes a picture as OpenEXR: scanlines, 32-bit float `R`, `G`, `B`, ZIP. Lossless, also for NaN and infinity.
///
/// # Errors
/// The reason, for a picture without texels.
pub fn encode(image: &RgbImage) -> Result<Vec<u8>, String> {
    if image.texels().is_empty() {
        return Err("the picture is empty".to_owned());
    }
    let (width, height) = (image.width() as usize, image.height() as usize);
    let texel = |Vec2(x, y): Vec2<usize>| {
        let texel = image.texels()[y * width + x];
        (texel.x, texel.y, texel.z)
    };
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let layer = ::exr::prelude::Layer::new(
        (width, height),
        ::exr::prelude::LayerAttributes::default(),
        encoding,
        SpecificChannels::rgb(texel),
    );
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(layer).write().to_buffered(&mut bytes).map_err(|error| error.to_string())?;
    Ok(bytes.into_inner())
}

/// Writes a picture as [`encode`] stores it, whole or not at all.
///
/// # Errors
/// [`ImageError::Write`] from the file system, [`ImageError::Encode`] for an empty picture.
pub fn write(path: &Path, image: &RgbImage) -> Result<(), ImageError> {
    let bytes = encode(image).map_err(|reason| ImageError::Encode { path: path.to_owned(), reason })?;
    atomic::write(path, |writer| writer.write_all(&bytes))
        .map_err(|source| ImageError::Write { path: path.to_owned(), source })
}
