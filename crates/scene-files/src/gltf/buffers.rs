//! Bytes of a glTF file: the GLB container, data URIs and files beside it.

use std::borrow::Cow;

use base64::Engine;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use gnomon_messages::quoted;

use super::schema::Root;
use super::{Budget, Fault, Source, get};

/// JSON and binary chunk of a file; a `.gltf` is all JSON. GLB: specification, section 4.
pub fn split<'a>(bytes: &'a [u8], warnings: &mut Vec<String>) -> Result<(&'a [u8], Option<&'a [u8]>), Fault> {
    let Some(header) = bytes.strip_prefix(b"glTF") else { return Ok((bytes, None)) };
    let truncated = || Fault::invalid("the GLB ends too early");
    let (version, rest) = word(header).ok_or_else(truncated)?;
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
                Some(uri) => Some(Cow::Owned(resolve(uri, source, budget)?)),
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
        Ok(Self { root, data })
    }

    /// Bytes of a buffer view.
    pub fn view(&self, index: usize, referrer: &str) -> Result<&[u8], Fault> {
        let view = get(&self.root.buffer_views, index, "buffer view", referrer)?;
        let name = format!("buffer view {index}");
        let buffer = get(&self.data, view.buffer.0, "buffer", &name)?;
        let bytes = buffer
            .as_deref()
            .ok_or_else(|| Fault::Invalid(format!("buffer {} has no data", view.buffer.0)))?;
        let (start, length) = (view.byte_offset.0, view.byte_length.0);
        start.checked_add(length).and_then(|end| bytes.get(start..end)).ok_or_else(|| {
            let held = bytes.len();
            Fault::Invalid(format!("{name} takes {length} bytes from {start}, but its buffer has {held}"))
        })
    }
}

/// Bytes behind a URI: embedded data, or a file relative to this one.
pub fn resolve(uri: &str, source: &Source, budget: &mut Budget) -> Result<Vec<u8>, Fault> {
    if let Some(data) = uri.strip_prefix("data:") {
        let (kind, text) = data.split_once(',').ok_or_else(|| Fault::invalid("a data URI has no data"))?;
        budget.take(text.len(), 1)?;
        if !kind.ends_with(";base64") {
            return percent_decoded(text).ok_or_else(|| Fault::invalid("a data URI has a broken % sequence"));
        }
        return LENIENT
            .decode(text)
            .map_err(|error| Fault::Invalid(format!("a data URI is no base64: {error}")));
    }
    let scheme = uri.split_once(':').is_some_and(|(scheme, _)| {
        !scheme.is_empty() && scheme.bytes().all(|b| b.is_ascii_alphanumeric() || b"+-.".contains(&b))
    });
    let path = percent_decoded(uri).and_then(|path| String::from_utf8(path).ok());
    let path = path.filter(|path| !path.is_empty() && !path.contains('\0'));
    let path = path.ok_or_else(|| Fault::Invalid(format!("'{}' is no URI", quoted(uri))))?;
    if scheme || path.starts_with(['/', '\\']) {
        let uri = quoted(uri);
        return Err(Fault::Unsupported(format!("'{uri}' is not a path relative to the file")));
    }
    let path = source.sibling(&path);
    source.read(&path, budget).map_err(|fault| Fault::Elsewhere(fault.at(&path)))
}

/// Padding is often left out.
const LENIENT: GeneralPurpose = GeneralPurpose::new(
    &base64::alphabet::STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// `%20` to a blank and so on (RFC 3986, section 2.1); `None` where a sequence is broken.
fn percent_decoded(uri: &str) -> Option<Vec<u8>> {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let [first, after @ ..] = rest {
        if *first == b'%' {
            let (digits, after) = after.split_first_chunk::<2>()?;
            let digit = |d: u8| char::from(d).to_digit(16);
            bytes.push((digit(digits[0])? * 16 + digit(digits[1])?) as u8);
            rest = after;
        } else {
            bytes.push(*first);
            rest = after;
        }
    }
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percent_sequences_decode() {
        assert_eq!(percent_decoded("a%20b%C3%A9.bin").as_deref(), Some("a bé.bin".as_bytes()));
        assert_eq!(percent_decoded("a%2"), None);
        assert_eq!(percent_decoded("a%zz"), None);
        assert_eq!(percent_decoded("%ff").as_deref(), Some(&[255][..]));
    }

    #[test]
    fn base64_needs_no_padding_but_real_letters() {
        assert_eq!(LENIENT.decode("AAEC").unwrap(), [0, 1, 2]);
        assert_eq!(LENIENT.decode("AAE").unwrap(), LENIENT.decode("AAE=").unwrap());
        assert!(LENIENT.decode("AA*C").is_err());
    }

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
