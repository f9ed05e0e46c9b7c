//! Blocks of a file, decompressed side by side and handed on as rows of colours.

use std::borrow::Cow;
use std::io::Cursor;
use std::panic::{AssertUnwindSafe, catch_unwind};

use ::exr::block::chunk::{Chunk, CompressedBlock};
use ::exr::block::reader::{ChunksReader, Reader};
use ::exr::meta::attribute::{ChannelDescription, ChannelList, IntegerBounds, SampleType};
use ::exr::meta::header::Header;
use ::exr::prelude::{Compression, Vec2};
use glam::Vec3;
use half::f16;
use rayon::prelude::*;

use super::{from_exr, malformed};
use crate::error::DecodeError;

/// Most blocks that wait in memory to be decompressed side by side, and most bytes that come of them.
const BATCH: u64 = 16;
const MAX_BATCH_BYTES: u64 = 1 << 28;

/// A decompressed block: texels from a place of the data window on, row by row.
struct Rows {
    x: usize,
    y: usize,
    width: usize,
    texels: Vec<Vec3>,
}

/// Reads three channels of one part, in any order of rows and in parts of rows.
pub(super) fn read_rows(
    reader: Reader<Cursor<&[u8]>>,
    part: usize,
    header: &Header,
    channels: [usize; 3],
    mut take: impl FnMut(usize, usize, &mut [Vec3]),
) -> Result<(), DecodeError> {
    let mut chunks = reader
        .filter_chunks(false, |_, tile, block| block.layer == part && tile.level_index == Vec2(0, 0))
        .map_err(from_exr)?;
    let mut seen = std::collections::HashSet::new();
    let expected = chunks.expected_chunk_count();
    let batch = (MAX_BATCH_BYTES / block_bytes(header).max(1)).clamp(1, BATCH) as usize;
    loop {
        let batch = chunks.by_ref().take(batch).collect::<Result<Vec<Chunk>, _>>().map_err(from_exr)?;
        if batch.is_empty() {
            break;
        }
        // Not the crate's own thread pool: a job that panics there ends the process.
        let blocks: Vec<_> = batch
            .into_par_iter()
            .filter(|chunk| chunk.layer_index == part)
            .map(|chunk| decompress(chunk, header, channels))
            .collect();
        for block in blocks {
            let Some(Rows { x, y, width, mut texels }) = block? else { continue };
            if seen.insert((x, y)) {
                (y..).zip(texels.chunks_mut(width)).for_each(|(y, row)| take(x, y, row));
            }
        }
    }
    if seen.len() != expected {
        return Err(malformed(format!("{} of {expected} blocks are missing", expected - seen.len())));
    }
    Ok(())
}

/// Bytes of a whole block, as stored and as colours.
fn block_bytes(header: &Header) -> u64 {
    let Vec2(width, height) = header.max_block_pixel_size();
    let texels = width.min(header.layer_size.0) as u64 * height.min(header.layer_size.1) as u64;
    texels.saturating_mul((header.channels.bytes_per_pixel + size_of::<Vec3>()) as u64)
}

/// Three channels of a block; none of a block of another resolution.
fn decompress(chunk: Chunk, header: &Header, channels: [usize; 3]) -> Result<Option<Rows>, DecodeError> {
    let place = header.get_block_data_indices(&chunk.compressed_block).map_err(from_exr)?;
    if place.level_index != Vec2(0, 0) {
        return Ok(None);
    }
    let section = header.get_absolute_block_pixel_coordinates(place).map_err(from_exr)?;
    section.validate(Some(header.layer_size)).map_err(from_exr)?;
    let bytes = match chunk.compressed_block {
        CompressedBlock::Tile(block) => block.compressed_pixels_le,
        CompressedBlock::ScanLine(block) => block.compressed_pixels_le,
        _ => return Err(malformed("a deep block in a flat part")),
    };
    let Vec2(width, height) = section.size;
    let (x, y) = (section.position.0 as usize, section.position.1 as usize);
    let lines = Lines { list: &header.channels.list, y, width, height };
    let size = lines.bytes();
    let is_sampled = header.channels.list.iter().any(|channel| channel.sampling != Vec2(1, 1));
    let data = match header.compression {
        Compression::B44 | Compression::B44A if is_sampled && bytes.len() != size => {
            lines.interleaved(&decompressed_apart(&bytes, header, section)?)
        }
        _ => {
            // The crate knows by the bytes of a pixel how long a block is, which is right for subsampled ones too if it is told their mean.
            let mean = size / (width * height).max(1);
            decompressed(bytes, &with_bytes_per_pixel(header, mean), section)?
        }
    };
    if data.len() != size {
        return Err(malformed("a block is shorter than its channels"));
    }
    Ok(Some(Rows { x, y, width, texels: lines.texels(&data, channels) }))
}

fn with_bytes_per_pixel(header: &Header, bytes: usize) -> Cow<'_, Header> {
    if header.channels.bytes_per_pixel == bytes {
        return Cow::Borrowed(header);
    }
    let mut header = header.clone();
    header.channels.bytes_per_pixel = bytes;
    Cow::Owned(header)
}

fn decompressed(bytes: Vec<u8>, header: &Header, section: IntegerBounds) -> Result<Vec<u8>, DecodeError> {
    let size = section.size.area() * header.channels.bytes_per_pixel;
    if matches!(header.compression, Compression::DWAA(_) | Compression::DWAB(_)) && bytes.len() != size {
        check_counters(&bytes, section.size, header)?;
    }
    // The crate's B44 decoder overflows on damaged blocks, which panics in builds that check arithmetic; a block is a
    // closed unit of work, so nothing half-changed is seen afterwards.
    let outcome = catch_unwind(AssertUnwindSafe(|| {
        header.compression.decompress_image_section_from_le(header, bytes, section, false)
    }));
    outcome.unwrap_or_else(|_| Err(::exr::error::Error::Invalid("compressed block".into()))).map_err(from_exr)
}

/// The channels of a B44 block one by one: they follow one another there, and the crate miscounts subsampled ones beside others.
fn decompressed_apart(
    bytes: &[u8],
    header: &Header,
    section: IntegerBounds,
) -> Result<Vec<Vec<u8>>, DecodeError> {
    let mut rest = bytes;
    let channels = header.channels.list.iter().map(|channel| {
        let Vec2(across, down) = channel.sampling;
        let size = Vec2(section.size.0 / across, section.size.1 / down);
        let bytes_per_sample = channel.sample_type.bytes_per_sample();
        let length = match channel.sample_type {
            SampleType::F16 => squares_length(rest, size.0.div_ceil(4) * size.1.div_ceil(4)),
            _ => Some(size.area() * bytes_per_sample),
        };
        let (own, others) = length
            .and_then(|length| rest.split_at_checked(length))
            .ok_or_else(|| malformed("a B44 block is too short"))?;
        rest = others;
        let mut header = header.clone();
        header.channels =
            ChannelList::new(vec![ChannelDescription { sampling: Vec2(1, 1), ..channel.clone() }].into());
        decompressed(own.to_vec(), &header, IntegerBounds::new(section.position, size))
    });
    channels.collect()
}

/// Bytes of so many squares of 4 x 4 samples: three for one of a single value, which its third byte tells, else fourteen.
fn squares_length(bytes: &[u8], count: usize) -> Option<usize> {
    let length = |at: usize| bytes.get(at + 2).map(|&shift| at + if shift >= 13 << 2 { 3 } else { 14 });
    (0..count).try_fold(0, |at, _| length(at))
}

/// How a block's samples follow one another: line by line, and in a line channel by channel.
struct Lines<'a> {
    list: &'a [ChannelDescription],
    y: usize,
    width: usize,
    height: usize,
}

impl Lines<'_> {
    /// Number, channel and samples of every line of a channel.
    fn each(&self) -> impl Iterator<Item = (usize, usize, usize)> {
        (0..self.height).flat_map(move |row| {
            let there = move |channel: &ChannelDescription| (self.y + row).is_multiple_of(channel.sampling.1);
            let channels = self.list.iter().enumerate().filter(move |(_, channel)| there(channel));
            channels.map(move |(index, channel)| (row, index, self.width / channel.sampling.0))
        })
    }

    fn bytes(&self) -> usize {
        self.each().map(|(_, channel, count)| count * self.list[channel].sample_type.bytes_per_sample()).sum()
    }

    /// Channels that lie one after another, line by line.
    fn interleaved(&self, channels: &[Vec<u8>]) -> Vec<u8> {
        let mut data = Vec::new();
        for (row, index, count) in self.each() {
            let channel = &self.list[index];
            let bytes = count * channel.sample_type.bytes_per_sample();
            let line = row / channel.sampling.1;
            data.extend(channels[index].chunks(bytes.max(1)).nth(line).unwrap_or_default());
        }
        data
    }

    /// Three channels of as many bytes. Where a channel is subsampled the first texel of each has the sample.
    fn texels(&self, mut data: &[u8], channels: [usize; 3]) -> Vec<Vec3> {
        let mut texels = vec![Vec3::ZERO; self.width * self.height];
        for (row, index, count) in self.each() {
            let channel = &self.list[index];
            let (line, rest) = data.split_at(count * channel.sample_type.bytes_per_sample());
            data = rest;
            for target in (0..3).filter(|&target| channels[target] == index) {
                let row = &mut texels[row * self.width..][..self.width];
                let mut put = |values: &mut dyn Iterator<Item = f32>| {
                    for (texel, value) in row.iter_mut().step_by(channel.sampling.0).zip(values) {
                        texel[target] = value;
                    }
                };
                // The crate has already turned the samples into the machine's byte order.
                let (twos, fours) = (line.as_chunks::<2>().0, line.as_chunks::<4>().0);
                match channel.sample_type {
                    SampleType::F16 => put(&mut twos.iter().map(|&bytes| f16::from_ne_bytes(bytes).to_f32())),
                    SampleType::F32 => put(&mut fours.iter().map(|&bytes| f32::from_ne_bytes(bytes))),
                    SampleType::U32 => put(&mut fours.iter().map(|&bytes| u32::from_ne_bytes(bytes) as f32)),
                }
            }
        }
        texels
    }
}

/// A DWA block begins with eleven counts, by which the crate allocates without a look at the block's size.
fn check_counters(
    bytes: &[u8],
    Vec2(width, height): Vec2<usize>,
    header: &Header,
) -> Result<(), DecodeError> {
    let texel_bytes = header.channels.bytes_per_pixel as u64;
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
