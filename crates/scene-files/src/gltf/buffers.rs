//! Bytes of a glTF file: the GLB container, buffers and their views.

use std::borrow::Cow;
use std::collections::HashMap;

use super::schema::{Int, Meshopt, Root};
use super::{Budget, Fault, Source, document, get, meshopt, uri};

/// JSON and binary chunk of a file; a `.gltf` is all JSON. GLB: specification, section 4.
pub fn split<'a>(bytes: &'a [u8], warnings: &mut Vec<String>) -> Result<(&'a [u8], Option<&'a [u8]>), Fault> {
    let Some(header) = bytes.strip_prefix(b"glTF") else { return Ok((bytes, None)) };
    let truncated = || Fault::invalid("the GLB ends too early");
    let (version, rest) = word(header).ok_or_else(truncated)?;
    if version == 1 {
        return Err(document::first_version("1.0"));
    }
    if version != 2 {
        return Err(Fault::Unsupported(format!("GLB version {version} (2 is known)")));
    }
    let (length, _) = word(rest).ok_or_else(truncated)?;
    let contents = bytes.get(12..length as usize).ok_or_else(|| {
        Fault::Invalid(format!("the GLB header promises {length} bytes, but there are {}", bytes.len()))
    })?;
    if bytes.len() > length as usize {
        warnings
            .push(format!("{} bytes after the end of the GLB are ignored", bytes.len() - length as usize));
    }
    let (json, mut rest) = chunk(contents)?;
    if json.kind != *b"JSON" {
        return Err(Fault::invalid("the GLB's first chunk is not JSON"));
    }
    // Unknown chunks are to be ignored; the binary one comes second.
    let mut binary = None;
    let mut number = 1;
    while !rest.is_empty() {
        let (chunk, after) = chunk(rest)?;
        if chunk.kind == *b"BIN\0" {
            if number != 1 {
                return Err(Fault::invalid("the GLB's binary chunk is not its second"));
            }
            binary = Some(chunk.data);
        }
        rest = after;
        number += 1;
    }
    Ok((json.data, binary))
}

/// A little-endian word and what follows it.
fn word(bytes: &[u8]) -> Option<(u32, &[u8])> {
    bytes.split_first_chunk().map(|(word, rest)| (u32::from_le_bytes(*word), rest))
}

struct Chunk<'a> {
    kind: [u8; 4],
    data: &'a [u8],
}

/// The first chunk, and what follows it.
fn chunk(bytes: &[u8]) -> Result<(Chunk<'_>, &[u8]), Fault> {
    let truncated = || Fault::invalid("a chunk of the GLB is cut off");
    let (length, rest) = word(bytes).ok_or_else(truncated)?;
    let (kind, rest) = rest.split_first_chunk().ok_or_else(truncated)?;
    let (data, rest) = rest.split_at_checked(length as usize).ok_or_else(truncated)?;
    Ok((Chunk { kind: *kind, data }, rest))
}

/// The file's buffers; `None` where one is declared without data (an extension's fallback).
pub struct Buffers<'a> {
    root: &'a Root,
    data: Vec<Option<Cow<'a, [u8]>>>,
    /// Of those views that are compressed.
    decompressed: HashMap<usize, Vec<u8>>,
}

impl<'a> Buffers<'a> {
    /// Reads every buffer and checks its length.
    pub fn read(
        root: &'a Root,
        binary: Option<&'a [u8]>,
        source: &Source,
        budget: &mut Budget,
    ) -> Result<Self, Fault> {
        let mut data = Vec::with_capacity(root.buffers.len());
        for (index, buffer) in root.buffers.iter().enumerate() {
            let bytes = match &buffer.uri {
                Some(uri) => Some(Cow::Owned(uri::resolve(uri, source, budget)?)),
                None => binary.filter(|_| index == 0).map(Cow::Borrowed),
            };
            let promised = buffer.byte_length.0;
            let bytes = match bytes {
                Some(bytes) if bytes.len() < promised => {
                    let held = bytes.len();
                    return Err(Fault::Invalid(format!(
                        "buffer {index} holds {held} bytes, fewer than the {promised} promised"
                    )));
                }
                // A GLB pads its chunk.
                Some(Cow::Borrowed(bytes)) => Some(Cow::Borrowed(&bytes[..promised])),
                Some(Cow::Owned(mut bytes)) => {
                    bytes.truncate(promised);
                    Some(Cow::Owned(bytes))
                }
                None => None,
            };
            data.push(bytes);
        }
        let mut buffers = Self { root, data, decompressed: HashMap::new() };
        for (index, view) in root.buffer_views.iter().enumerate() {
            if let Some(packed) = &view.extensions.meshopt {
                let bytes = buffers.decompress(packed, index, budget)?;
                buffers.decompressed.insert(index, bytes);
            }
        }
        Ok(buffers)
    }

    /// Bytes of a view that is compressed.
    fn decompress(&self, packed: &Meshopt, index: usize, budget: &mut Budget) -> Result<Vec<u8>, Fault> {
        let name = format!("buffer view {index}");
        let bytes = self.range(packed.buffer, packed.byte_offset, packed.byte_length, &name)?;
        let (count, stride) = (packed.count.0, packed.byte_stride.0);
        budget.take(count, stride)?;
        meshopt::decode(&packed.mode, packed.filter.as_deref(), (count, stride), bytes)
            .map_err(|message| Fault::Invalid(format!("{name}: {message}")))
    }

    /// Bytes of a buffer view.
    pub fn view(&self, index: usize, referrer: &str) -> Result<&[u8], Fault> {
        let view = get(&self.root.buffer_views, index, "buffer view", referrer)?;
        match self.decompressed.get(&index) {
            Some(bytes) => Ok(bytes),
            None => {
                let name = format!("buffer view {index}");
                self.range(view.buffer, view.byte_offset, view.byte_length, &name)
            }
        }
    }

    fn range(&self, buffer: Int, offset: Int, length: Int, name: &str) -> Result<&[u8], Fault> {
        let Int(index) = buffer;
        let buffer = get(&self.data, index, "buffer", name)?;
        let bytes = buffer.as_deref().ok_or_else(|| Fault::Invalid(format!("buffer {index} has no data")))?;
        let (start, length) = (offset.0, length.0);
        start.checked_add(length).and_then(|end| bytes.get(start..end)).ok_or_else(|| {
            let held = bytes.len();
            Fault::Invalid(format!("{name} takes {length} bytes from {start}, but its buffer has {held}"))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn glb_chunks_are_bounded() {
        let mut glb = b"glTF\x02\0\0\0\x18\0\0\0\x04\0\0\0JSON{}  ".to_vec();
        let mut warnings = Vec::new();
        assert_eq!(split(&glb, &mut warnings).unwrap(), (&b"{}  "[..], None));
        for length in 0..glb.len() {
            if length >= 4 {
                assert!(split(&glb[..length], &mut warnings).is_err(), "{length}");
            }
        }
        glb[12] = 5;
        assert!(split(&glb, &mut warnings).is_err());
    }
}
