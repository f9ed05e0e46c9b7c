//! The numbers after the header of a PLY file.

use super::header::{Element, Encoding, Header, Property, Scalar};
use crate::error::Fault;
use crate::text;

/// The numbers after the header, in file order.
pub struct Values<'a> {
    encoding: Encoding,
    rest: &'a [u8],
    /// Whether each row has lines of its own, so that what its last line holds beyond it belongs to nothing.
    by_lines: bool,
    at_line_start: bool,
}

/// Words that begin a line which is no row.
const COMMENTS: [&[u8]; 2] = [b"comment", b"obj_info"];

impl<'a> Values<'a> {
    pub fn new(header: &Header, body: &'a [u8]) -> Self {
        let rows = header.elements.iter().filter(|element| !element.properties.is_empty());
        let rows = rows.fold(0_u64, |sum, element| sum.saturating_add(element.count));
        let is_row = |line: &&[u8]| {
            let line = line.trim_ascii();
            !line.is_empty() && !COMMENTS.iter().any(|word| line.starts_with(word))
        };
        let lines = || body.split(|byte| matches!(byte, b'\n' | b'\r')).filter(is_row).count() as u64;
        let by_lines = header.encoding == Encoding::Ascii && lines() >= rows;
        Self { encoding: header.encoding, rest: body, by_lines, at_line_start: true }
    }

    /// Refuses an element that promises more than the rest of the file can hold, before anything is allocated for it.
    pub fn check_room(&self, element: &Element) -> Result<(), Fault> {
        let smallest = |p: &Property| match self.encoding {
            // One digit and a separator.
            Encoding::Ascii => 2,
            Encoding::Little | Encoding::Big => p.count_type.unwrap_or(p.scalar).size() as u64,
        };
        let row: u64 = element.properties.iter().map(smallest).sum();
        // The last separator may be missing.
        let room = self.rest.len() as u64 + 1;
        if element.count.checked_mul(row).is_none_or(|bytes| bytes > room) {
            return Err(Fault::Invalid(format!(
                "the header promises {} {} elements, more than the file has room for",
                element.count, element.name
            )));
        }
        Ok(())
    }

    /// Passes over what is left of a row's line; whether there was anything.
    pub fn end_row(&mut self) -> bool {
        if !self.by_lines {
            return false;
        }
        let end = self.rest.iter().position(|byte| matches!(byte, b'\n' | b'\r')).unwrap_or(self.rest.len());
        let (surplus, rest) = self.rest.split_at(end);
        self.rest = rest;
        !surplus.trim_ascii().is_empty()
    }

    pub fn next(&mut self, scalar: Scalar) -> Result<f64, Fault> {
        let truncated = || Fault::invalid("the file ends too early");
        if self.encoding == Encoding::Ascii {
            let word = self.word().ok_or_else(truncated)?;
            return std::str::from_utf8(word).ok().and_then(text::number).ok_or_else(|| {
                let text = String::from_utf8_lossy(&word[..word.len().min(40)]).into_owned();
                Fault::Invalid(format!("'{text}' stands where a number should"))
            });
        }
        let (bytes, rest) = self.rest.split_at_checked(scalar.size()).ok_or_else(truncated)?;
        self.rest = rest;
        let mut word = [0; 8];
        let word = &mut word[..bytes.len()];
        word.copy_from_slice(bytes);
        if self.encoding == Encoding::Big {
            word.reverse();
        }
        Ok(scalar.decode(word))
    }

    /// The next word of text that is no comment.
    fn word(&mut self) -> Option<&'a [u8]> {
        loop {
            let start = self.rest.iter().position(|byte| !byte.is_ascii_whitespace())?;
            let (blanks, word) = self.rest.split_at(start);
            self.at_line_start |= blanks.iter().any(|byte| matches!(byte, b'\n' | b'\r'));
            let end = word.iter().position(u8::is_ascii_whitespace).unwrap_or(word.len());
            let (word, rest) = word.split_at(end);
            self.rest = rest;
            if !(std::mem::take(&mut self.at_line_start) && COMMENTS.contains(&word)) {
                return Some(word);
            }
            let end = rest.iter().position(|byte| matches!(byte, b'\n' | b'\r')).unwrap_or(rest.len());
            self.rest = &rest[end..];
        }
    }

    fn count(&mut self, count_type: Scalar, item: Scalar) -> Result<usize, Fault> {
        let count = self.next(count_type)?;
        let smallest = if self.encoding == Encoding::Ascii { 2 } else { item.size() };
        let room = (self.rest.len() + 1) / smallest;
        if !(count >= 0.0 && count.fract() == 0.0 && count <= room as f64) {
            return Err(Fault::Invalid(format!(
                "a list promises {count} items, but the file has room for {room}"
            )));
        }
        Ok(count as usize)
    }

    pub fn list(&mut self, property: &Property, items: &mut Vec<f64>) -> Result<(), Fault> {
        items.clear();
        let count = self.count(property.count_type.unwrap_or(Scalar::U8), property.scalar)?;
        for _ in 0..count {
            items.push(self.next(property.scalar)?);
        }
        Ok(())
    }

    pub fn skip(&mut self, property: &Property) -> Result<(), Fault> {
        let count =
            property.count_type.map_or(Ok(1), |count_type| self.count(count_type, property.scalar))?;
        for _ in 0..count {
            self.next(property.scalar)?;
        }
        Ok(())
    }

    /// Passes over an element.
    pub fn skip_element(&mut self, element: &Element) -> Result<(), Fault> {
        if element.properties.is_empty() {
            return Ok(());
        }
        for _ in 0..element.count {
            for property in &element.properties {
                self.skip(property)?;
            }
            self.end_row();
        }
        Ok(())
    }
}
