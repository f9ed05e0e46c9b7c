//! The container of the RGL's files: named arrays of numbers.

use crate::error::{MeasuredError, invalid};

/// Most arrays of a file, and most numbers of one.
const MOST_TENSORS: u32 = 64;
const MOST_NUMBERS: usize = 1 << 27;
/// Longest name of an array [bytes].
const LONGEST_NAME: usize = 64;
/// Numbers of the types.
const UINT8: u8 = 1;
const FLOAT32: u8 = 10;
const FLOAT64: u8 = 11;

/// A named array.
pub struct Tensor<'a> {
    pub name: String,
    pub shape: Vec<usize>,
    kind: u8,
    bytes: &'a [u8],
}

struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Reader<'a> {
    fn take(&mut self, count: usize) -> Result<&'a [u8], MeasuredError> {
        let end = self.at.checked_add(count).filter(|end| *end <= self.bytes.len());
        let end = end.ok_or_else(|| invalid("the file ends within its list of arrays"))?;
        let taken = &self.bytes[self.at..end];
        self.at = end;
        Ok(taken)
    }

    fn number(&mut self, bytes: usize) -> Result<u64, MeasuredError> {
        Ok(self.take(bytes)?.iter().rev().fold(0, |number, byte| number << 8 | u64::from(*byte)))
    }
}

/// The arrays of a file.
pub fn read(bytes: &[u8]) -> Result<Vec<Tensor<'_>>, MeasuredError> {
    let mut reader = Reader { bytes, at: 0 };
    if !bytes.starts_with(b"tensor_file\0") {
        return Err(invalid("the file does not begin with 'tensor_file'"));
    }
    reader.take(12)?;
    let version = [reader.number(1)?, reader.number(1)?];
    if version != [1, 0] {
        return Err(invalid(format!(
            "tensor files of version 1.0 are read, this is {}.{}",
            version[0], version[1]
        )));
    }
    let count = reader.number(4)? as u32;
    if count > MOST_TENSORS {
        return Err(invalid(format!("the file lists {count} arrays, more than {MOST_TENSORS}")));
    }
    (0..count).map(|_| tensor(&mut reader)).collect()
}

fn tensor<'a>(reader: &mut Reader<'a>) -> Result<Tensor<'a>, MeasuredError> {
    let length = reader.number(2)? as usize;
    if length > LONGEST_NAME {
        return Err(invalid(format!(
            "the file names an array with {length} characters, more than {LONGEST_NAME}"
        )));
    }
    let name = gnomon_messages::quoted(&String::from_utf8_lossy(reader.take(length)?));
    let dimensions = reader.number(2)? as usize;
    let kind = reader.number(1)? as u8;
    let offset = reader.number(8)?;
    if dimensions > 8 {
        return Err(invalid(format!("'{name}' has {dimensions} dimensions, more than 8")));
    }
    let shape = (0..dimensions).map(|_| reader.number(8)).collect::<Result<Vec<_>, _>>()?;
    let shape: Vec<usize> =
        shape.into_iter().map(|side| usize::try_from(side).unwrap_or(usize::MAX)).collect();
    let size = match kind {
        1 | 2 => 1,
        3 | 4 | 9 => 2,
        5 | 6 | FLOAT32 => 4,
        7 | 8 | FLOAT64 => 8,
        _ => return Err(invalid(format!("'{name}' is of the unknown type {kind}"))),
    };
    let count =
        shape.iter().try_fold(1usize, |count, side| count.checked_mul(*side)).filter(|c| *c <= MOST_NUMBERS);
    let count = count.ok_or_else(|| invalid(format!("'{name}' has more than {MOST_NUMBERS} values")))?;
    let start = usize::try_from(offset).unwrap_or(usize::MAX);
    let end = start.checked_add(size * count).filter(|end| *end <= reader.bytes.len());
    let end = end.ok_or_else(|| invalid(format!("'{name}' reaches past the end of the file")))?;
    Ok(Tensor { name, shape, kind, bytes: &reader.bytes[start..end] })
}

impl Tensor<'_> {
    /// Its numbers.
    pub fn floats(&self) -> Result<Vec<f32>, MeasuredError> {
        let numbers: Vec<f32> = match self.kind {
            FLOAT32 => {
                self.bytes.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect()
            }
            _ => return Err(invalid(format!("'{}' must be of 32-bit floating-point numbers", self.name))),
        };
        match numbers.iter().all(|number| number.is_finite()) {
            true => Ok(numbers),
            false => Err(invalid(format!("'{}' has values that are no numbers", self.name))),
        }
    }

    /// Its characters.
    pub fn text(&self) -> String {
        match self.kind {
            UINT8 => gnomon_messages::quoted(&String::from_utf8_lossy(self.bytes)),
            _ => String::new(),
        }
    }
}
