//! The header of a PLY file: what follows, in which order and encoding.

use std::borrow::Cow;

use gnomon_messages::quoted;

use crate::error::Fault;
use crate::text;

/// How the numbers after the header are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    Ascii,
    Little,
    Big,
}

/// Type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Scalar {
    fn parse(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "int64" => Self::I64,
            "uint64" => Self::U64,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    /// Bytes in a binary file.
    pub fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    /// The value that full intensity has in an integer colour; `None` for floating point.
    pub fn largest_integer(self) -> Option<f64> {
        match self {
            Self::I8 => Some(f64::from(i8::MAX)),
            Self::U8 => Some(f64::from(u8::MAX)),
            Self::I16 => Some(f64::from(i16::MAX)),
            Self::U16 => Some(f64::from(u16::MAX)),
            Self::I32 => Some(f64::from(i32::MAX)),
            Self::U32 => Some(f64::from(u32::MAX)),
            Self::I64 => Some(i64::MAX as f64),
            Self::U64 => Some(u64::MAX as f64),
            Self::F32 | Self::F64 => None,
        }
    }

    /// The number in `size()` bytes, least significant first.
    pub fn decode(self, bytes: &[u8]) -> f64 {
        let mut word = [0; 8];
        for (to, from) in word.iter_mut().zip(bytes) {
            *to = *from;
        }
        let bits = u64::from_le_bytes(word);
        match self {
            Self::I8 => f64::from(bits as i8),
            Self::U8 => f64::from(bits as u8),
            Self::I16 => f64::from(bits as i16),
            Self::U16 => f64::from(bits as u16),
            Self::I32 => f64::from(bits as i32),
            Self::U32 => f64::from(bits as u32),
            Self::I64 => bits as i64 as f64,
            Self::U64 => bits as f64,
            Self::F32 => f64::from(f32::from_bits(bits as u32)),
            Self::F64 => f64::from_bits(bits),
        }
    }
}

/// A column: a number, or a list where `count_type` is set.
#[derive(Debug)]
pub struct Property {
    pub name: String,
    pub scalar: Scalar,
    pub count_type: Option<Scalar>,
}

/// A table of `count` rows.
#[derive(Debug)]
pub struct Element {
    pub name: String,
    pub count: u64,
    pub properties: Vec<Property>,
}

#[derive(Debug)]
pub struct Header {
    pub encoding: Encoding,
    pub elements: Vec<Element>,
    /// Names of pictures: of `comment TextureFile`.
    pub textures: Vec<String>,
    pub warnings: Vec<String>,
}

/// Reads the header and returns it with the bytes after it.
pub fn parse(bytes: &[u8]) -> Result<(Header, &[u8]), Fault> {
    let mut lines = Lines { rest: crate::without_bom(bytes), number: 0, ended_by_cr: false };
    if lines.next()?.trim_end() != "ply" {
        return Err(Fault::invalid("it does not start with 'ply'"));
    }
    let mut encoding = None;
    let mut elements: Vec<Element> = Vec::new();
    let (mut textures, mut warnings) = (Vec::new(), Vec::new());
    loop {
        let line = lines.next()?;
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        let bad = || Fault::Invalid(format!("header line {}: cannot understand '{line}'", lines.number));
        match words.as_slice() {
            ["comment", word, ..] if word.eq_ignore_ascii_case("TextureFile") => {
                let name = line.trim_start().trim_start_matches("comment").trim_start();
                textures.extend(name.get(word.len()..).map(|name| name.trim().to_owned()));
            }
            [] | ["comment" | "obj_info", ..] => {}
            ["format", name, version] => {
                if *version != "1.0" {
                    return Err(Fault::Unsupported(format!("PLY version {version} (1.0 is known)")));
                }
                encoding = Some(match *name {
                    "ascii" => Encoding::Ascii,
                    "binary_little_endian" => Encoding::Little,
                    "binary_big_endian" => Encoding::Big,
                    _ => return Err(bad()),
                });
            }
            ["element", name, count] => {
                let count = count.parse().map_err(|_| bad())?;
                elements.push(Element { name: (*name).to_owned(), count, properties: Vec::new() });
            }
            ["property", "list", count_type, item, name] => {
                let count_type = Some(Scalar::parse(count_type).ok_or_else(bad)?);
                let scalar = Scalar::parse(item).ok_or_else(bad)?;
                let element = elements.last_mut().ok_or_else(bad)?;
                element.properties.push(Property { name: (*name).to_owned(), scalar, count_type });
            }
            ["property", scalar, name] => {
                let scalar = Scalar::parse(scalar).ok_or_else(bad)?;
                let element = elements.last_mut().ok_or_else(bad)?;
                element.properties.push(Property { name: (*name).to_owned(), scalar, count_type: None });
            }
            ["end_header"] => break,
            ["format" | "element" | "property" | "end_header", ..] => return Err(bad()),
            // Programs forget the word 'comment'.
            _ => warnings.push(format!("header line {} is left out: '{}'", lines.number, quoted(&line))),
        }
    }
    let encoding = encoding.ok_or_else(|| Fault::invalid("the header has no format line"))?;
    Ok((Header { encoding, elements, textures, warnings }, lines.rest))
}

/// Header lines, ended by LF, CR LF or CR.
struct Lines<'a> {
    rest: &'a [u8],
    number: usize,
    /// Lines end with CR alone, as the first one did: an LF behind it belongs to what follows.
    ended_by_cr: bool,
}

impl<'a> Lines<'a> {
    fn next(&mut self) -> Result<Cow<'a, str>, Fault> {
        self.number += 1;
        let end = self.rest.iter().position(|&b| b == b'\n' || b == b'\r');
        let end = end.ok_or_else(|| Fault::invalid("the header does not end"))?;
        let (line, rest) = self.rest.split_at(end);
        let is_pair = rest.starts_with(b"\r\n");
        if self.number == 1 {
            self.ended_by_cr = rest.starts_with(b"\r") && !is_pair;
        }
        self.rest = if is_pair && !self.ended_by_cr { &rest[2..] } else { &rest[1..] };
        Ok(text::decode(line))
    }
}
