//! OpenEXR pictures, through the `exr` crate: its block interface, so that sizes are checked before anything is allocated
//! and only the wanted layer and level are decompressed.

use std::io::Cursor;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use ::exr::block::UncompressedBlock;
use ::exr::block::chunk::{Chunk, CompressedBlock};
use ::exr::block::reader::{ChunksReader, Reader};
use ::exr::meta::attribute::{EnvironmentMap, SampleType};
use ::exr::meta::header::Header;
use ::exr::meta::{BlockDescription, MetaData};
use ::exr::prelude::{
    Blocks, Compression, Encoding, Image, LineOrder, SpecificChannels, Vec2, WritableImage,
};
use glam::Vec3;
use half::f16;
use rayon::prelude::*;

use crate::error::{DecodeError, ImageError};
use crate::file::{Decoded, EnvironmentAttribute};
use crate::{MAX_TEXELS, RgbImage, atomic};

const FORMAT: &str = "OpenEXR";
/// Largest block (tile or run of scanlines) that is decompressed in one piece [bytes].
const MAX_BLOCK_BYTES: u64 = 1 << 28;
/// Blocks that wait in memory to be decompressed side by side.
const BATCH: usize = 16;

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
/// (all but HTJ2K). Read is the first layer with `R`, `G` and `B`, else the first with `Y`, else the first channel of
/// the first layer, as grey; of several resolutions the largest.
///
/// The picture covers the display window, black where the file has no data, except that an environment map covers its
/// data window. Values are taken as linear Rec. 709, whatever `chromaticities` says; other primaries add a warning.
///
/// # Errors
/// [`DecodeError`] for a damaged or oversized file, deep data or subsampled channels.
pub fn decode(bytes: &[u8]) -> Result<Decoded, DecodeError> {
    let reader = Reader::read_from_buffered(Cursor::new(bytes), false).map_err(from_exr)?;
    check_tables(reader.headers(), bytes.len())?;
    let (layer, channels) = choose_layer(reader.headers())
        .ok_or_else(|| DecodeError::unsupported(FORMAT, "it holds no flat layer with a channel"))?;
    let header = reader.headers()[layer].clone();
    check_sizes(&header, bytes.len())?;
    for &channel in &channels {
        if header.channels.list[channel].sampling != Vec2(1, 1) {
            return Err(DecodeError::unsupported(FORMAT, "subsampled colour channels"));
        }
    }
    let window = Window::of(&header)?;
    let image = read_texels(reader, layer, &header, &channels, &window)?;

    let mut warnings = Vec::new();
    if let Some(primaries) = header.shared_attributes.chromaticities {
        let rec709 = [(0.64, 0.33), (0.30, 0.60), (0.15, 0.06)];
        let file = [primaries.red, primaries.green, primaries.blue];
        if file.iter().zip(rec709).any(|(f, (x, y))| (f.0 - x).abs().max((f.1 - y).abs()) > 0.005) {
            warnings.push("its primaries are not Rec. 709; colours were taken as if they were".to_owned());
        }
    }
    let environment = header.own_attributes.environment_map.map(|kind| match kind {
        EnvironmentMap::LatitudeLongitude => EnvironmentAttribute::LatLong,
        EnvironmentMap::Cube => EnvironmentAttribute::Cube,
    });
    Ok(Decoded { image, format: FORMAT, environment, warnings })
}

fn from_exr(error: ::exr::error::Error) -> DecodeError {
    use ::exr::error::Error;
    match error {
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
    let texel_bytes = header.channels.bytes_per_pixel as u64;
    // Headers and tables only add to the file, so the bound is safe.
    let most = (file_length as u64).saturating_mul(largest_ratio(header.compression));
    // Subsampled channels store less than `bytes_per_pixel` says.
    let subsampled = header.channels.list.iter().any(|channel| channel.sampling != Vec2(1, 1));
    if !subsampled && texels.saturating_mul(texel_bytes) > most {
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

/// Layer and the channels that become red, green and blue.
fn choose_layer(headers: &[Header]) -> Option<(usize, [usize; 3])> {
    let flat = || headers.iter().enumerate().filter(|(_, header)| !header.deep);
    let find = |header: &Header, name: &str| {
        let is = |channel: &::exr::meta::attribute::ChannelDescription| channel.name.to_string() == name;
        header.channels.list.iter().position(is)
    };
    let rgb = |header: &Header| Some([find(header, "R")?, find(header, "G")?, find(header, "B")?]);
    let grey = |channel: usize| [channel; 3];
    flat()
        .find_map(|(layer, header)| Some((layer, rgb(header)?)))
        .or_else(|| flat().find_map(|(layer, header)| Some((layer, grey(find(header, "Y")?)))))
        .or_else(|| {
            flat().find(|(_, header)| !header.channels.list.is_empty()).map(|(layer, _)| (layer, grey(0)))
        })
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

    /// Index of a texel of the data window, unless it lies outside the picture.
    fn index(&self, x: usize, y: usize) -> Option<usize> {
        let (x, y) = (x as i64 + self.left, y as i64 + self.top);
        let inside = (0..i64::from(self.width)).contains(&x) && (0..i64::from(self.height)).contains(&y);
        inside.then(|| y as usize * self.width as usize + x as usize)
    }
}

fn read_texels(
    reader: Reader<Cursor<&[u8]>>,
    layer: usize,
    header: &Header,
    channels: &[usize; 3],
    window: &Window,
) -> Result<RgbImage, DecodeError> {
    let mut chunks = reader
        .filter_chunks(false, |_, tile, block| block.layer == layer && tile.level_index == Vec2(0, 0))
        .map_err(from_exr)?;
    let meta = chunks.meta_data().clone();
    let mut image = RgbImage::filled(window.width, window.height, Vec3::ZERO);
    let mut seen = std::collections::HashSet::new();
    let expected = chunks.expected_chunk_count();
    loop {
        let batch = chunks.by_ref().take(BATCH).collect::<Result<Vec<Chunk>, _>>().map_err(from_exr)?;
        if batch.is_empty() {
            break;
        }
        // Not the crate's own thread pool: a job that panics there ends the process.
        let blocks: Vec<_> = batch.into_par_iter().map(|chunk| decompress(chunk, &meta)).collect();
        for block in blocks {
            let block = block?;
            let wanted = block.index.layer == layer && block.index.level == Vec2(0, 0);
            if wanted && seen.insert((block.index.pixel_position.0, block.index.pixel_position.1)) {
                insert(&block, header, channels, window, &mut image);
            }
        }
    }
    if seen.len() != expected {
        return Err(malformed(format!("{} of {expected} blocks are missing", expected - seen.len())));
    }
    Ok(image)
}

fn decompress(chunk: Chunk, meta: &MetaData) -> Result<UncompressedBlock, DecodeError> {
    check_counters(&chunk, meta)?;
    // The crate's B44 decoder overflows on damaged blocks, which panics in builds that check arithmetic; a block is a
    // closed unit of work, so nothing half-changed is seen afterwards.
    let outcome = catch_unwind(AssertUnwindSafe(|| UncompressedBlock::decompress_chunk(chunk, meta, false)));
    outcome.unwrap_or_else(|_| Err(::exr::error::Error::Invalid("compressed block".into()))).map_err(from_exr)
}

/// A DWA block begins with eleven counts, by which the crate allocates without a look at the block's size.
fn check_counters(chunk: &Chunk, meta: &MetaData) -> Result<(), DecodeError> {
    let header = meta.headers.get(chunk.layer_index).ok_or_else(|| malformed("a block's layer"))?;
    if !matches!(header.compression, Compression::DWAA(_) | Compression::DWAB(_)) {
        return Ok(());
    }
    let bytes = match &chunk.compressed_block {
        CompressedBlock::Tile(block) => &block.compressed_pixels_le,
        CompressedBlock::ScanLine(block) => &block.compressed_pixels_le,
        _ => return Ok(()),
    };
    let place = header.get_block_data_indices(&chunk.compressed_block).map_err(from_exr)?;
    let Vec2(width, height) = header.get_absolute_block_pixel_coordinates(place).map_err(from_exr)?.size;
    let texel_bytes = header.channels.bytes_per_pixel as u64;
    if bytes.len() as u64 == width as u64 * height as u64 * texel_bytes {
        return Ok(());
    }
    // Cosine transforms pad each side to a multiple of eight; run lengths may add a little.
    let most = 2 * (width as u64 + 7) * (height as u64 + 7) * texel_bytes + 1024;
    let counter = |index: usize| {
        let bytes = bytes.get(8 * index..8 * index + 8)?;
        Some(u64::from_le_bytes(bytes.try_into().ok()?))
    };
    // Uncompressed sizes of the sections in bytes, then counts of two-byte coefficients.
    let sound = [1, 6, 7, 8, 9].iter().all(|&index| counter(index).is_some_and(|count| count <= most));
    sound.then_some(()).ok_or_else(|| malformed("the counters of a DWA block exceed the block"))
}

fn insert(
    block: &UncompressedBlock,
    header: &Header,
    channels: &[usize; 3],
    window: &Window,
    image: &mut RgbImage,
) {
    for line in block.lines(&header.channels) {
        let targets = [0, 1, 2].map(|target| channels[target] == line.location.channel);
        if targets == [false; 3] {
            continue;
        }
        let kind = header.channels.list[line.location.channel].sample_type;
        for (along, sample) in line.value.chunks_exact(kind.bytes_per_sample()).enumerate() {
            let Vec2(x, y) = line.location.position;
            let Some(index) = window.index(x + along, y) else { continue };
            // The crate has already turned the samples into the machine's byte order.
            let value = match (kind, sample) {
                (SampleType::F16, &[a, b]) => f16::from_ne_bytes([a, b]).to_f32(),
                (SampleType::F32, &[a, b, c, d]) => f32::from_ne_bytes([a, b, c, d]),
                (SampleType::U32, &[a, b, c, d]) => u32::from_ne_bytes([a, b, c, d]) as f32,
                _ => 0.0,
            };
            let texel = &mut image.texels_mut()[index];
            for (target, _) in targets.iter().enumerate().filter(|&(_, &is)| is) {
                texel[target] = value;
            }
        }
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
