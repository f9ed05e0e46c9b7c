//! Radiance pictures (.hdr, .pic): Greg Ward, *Real Pixels*, Graphics Gems II (1991), and the Radiance file formats page.

use std::path::Path;

use glam::Vec3;

use crate::error::{DecodeError, ImageError};
use crate::file::Decoded;
use crate::picture::rec709_from_xyz;
use crate::{MAX_TEXELS, RgbImage, atomic};

const FORMAT: &str = "Radiance";
/// Longest header that is read; real ones hold a few hundred bytes.
const MAX_HEADER: usize = 1 << 20;
/// Lengths of scanline that the newer run-length code may hold.
const NEW_RLE_LENGTHS: std::ops::RangeInclusive<usize> = 8..=0x7fff;
/// Texels that one byte of file can stand for at most. A run of the newer code holds 127 texels in 8 bytes; the older one
/// has no bound, but no sensible picture exceeds this.
const MAX_TEXELS_PER_BYTE: u64 = 1024;

fn malformed(reason: impl Into<String>) -> DecodeError {
    DecodeError::malformed(FORMAT, reason)
}

/// Whether the bytes begin like a Radiance picture.
pub fn sniff(bytes: &[u8]) -> bool {
    bytes.starts_with(b"#?RADIANCE") || bytes.starts_with(b"#?RGBE")
}

/// Decodes a Radiance picture: run-length codes old and new, uncompressed, RGBE and XYZE, all eight orientations.
///
/// Texels are `mantissa * 2^(exponent - 136)`, exactly 0 for exponent 0, divided by the product of the `EXPOSURE` lines;
/// an `EXPOSURE` that is not a positive finite number is ignored with a warning.
///
/// # Errors
/// [`DecodeError`] for a damaged or oversized file. Memory stays in proportion to the file's length.
pub fn decode(bytes: &[u8]) -> Result<Decoded, DecodeError> {
    let mut cursor = Cursor { bytes, at: 0 };
    let header = Header::read(&mut cursor)?;
    let layout = Layout::read(&mut cursor)?;
    let texel_count = layout.texel_count();
    if texel_count > MAX_TEXELS || texel_count > bytes.len() as u64 * MAX_TEXELS_PER_BYTE {
        return Err(DecodeError::too_large(
            FORMAT,
            format!(
                "{} scanlines of {} texels in a file of {} bytes (limit {MAX_TEXELS} texels)",
                layout.scanlines,
                layout.scanline_length,
                bytes.len()
            ),
        ));
    }

    let mut texels = vec![Vec3::ZERO; texel_count as usize];
    let mut scanline = vec![[0u8; 4]; layout.scanline_length as usize];
    let scale = scales(header.exposure);
    for index in 0..layout.scanlines {
        read_scanline(&mut cursor, &mut scanline)
            .map_err(|reason| malformed(format!("scanline {index}: {reason}")))?;
        for (along, &rgbe) in (0..).zip(&scanline) {
            texels[layout.position(index, along)] = header.color(rgbe, &scale);
        }
    }
    let (width, height) = layout.size();
    let image = RgbImage::from_texels(width, height, texels).ok_or_else(|| malformed("size"))?;
    Ok(Decoded { image, format: FORMAT, environment: None, warnings: header.warnings })
}

/// Radiance of mantissa 1 for every exponent.
fn scales(exposure: f64) -> [f64; 256] {
    std::array::from_fn(|exponent| match exponent {
        0 => 0.0,
        _ => (exponent as f64 - 136.0).exp2() / exposure,
    })
}

struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Cursor<'a> {
    /// The next line without its end (`\n` or `\r\n`).
    fn line(&mut self) -> Result<&'a [u8], DecodeError> {
        let rest = self.bytes.get(self.at..MAX_HEADER.min(self.bytes.len())).unwrap_or_default();
        let Some(length) = rest.iter().position(|&byte| byte == b'\n') else {
            return Err(malformed(if self.bytes.len() > MAX_HEADER {
                "the header does not end within 1 MiB"
            } else {
                "the file ends inside the header"
            }));
        };
        self.at += length + 1;
        let line = &rest[..length];
        Ok(line.strip_suffix(b"\r").unwrap_or(line))
    }

    fn byte(&mut self) -> Result<u8, &'static str> {
        let byte = *self.bytes.get(self.at).ok_or(ENDS)?;
        self.at += 1;
        Ok(byte)
    }

    fn take(&mut self, count: usize) -> Result<&'a [u8], &'static str> {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let taken = rest.get(..count).ok_or(ENDS)?;
        self.at += count;
        Ok(taken)
    }

    fn texel(&mut self) -> Result<[u8; 4], &'static str> {
        let taken = self.take(4)?;
        Ok([taken[0], taken[1], taken[2], taken[3]])
    }
}

const ENDS: &str = "the file ends here";

struct Header {
    exposure: f64,
    xyz: bool,
    warnings: Vec<String>,
}

impl Header {
    fn read(cursor: &mut Cursor) -> Result<Self, DecodeError> {
        if !sniff(cursor.bytes) {
            return Err(malformed("it does not begin with #?RADIANCE or #?RGBE"));
        }
        cursor.line()?;
        let mut header = Self { exposure: 1.0, xyz: false, warnings: Vec::new() };
        loop {
            let line = cursor.line()?;
            if line.is_empty() {
                break;
            }
            if is_resolution(line) {
                return Err(malformed("no blank line before the resolution"));
            }
            let line = String::from_utf8_lossy(line);
            match line.split_once('=').map(|(name, value)| (name.trim(), value.trim())) {
                Some(("FORMAT", "32-bit_rle_rgbe")) => header.xyz = false,
                Some(("FORMAT", "32-bit_rle_xyze")) => header.xyz = true,
                Some(("FORMAT", other)) => {
                    let other: String = other.chars().take(40).collect();
                    return Err(DecodeError::unsupported(FORMAT, format!("FORMAT={other}")));
                }
                Some(("EXPOSURE", value)) => header.multiply_exposure(value),
                _ => {}
            }
        }
        Ok(header)
    }

    fn multiply_exposure(&mut self, value: &str) {
        let product = value.parse::<f64>().map_or(f64::NAN, |factor| self.exposure * factor);
        // Also refuses a product whose reciprocal leaves the range of a texel.
        if product > 1e-30 && product < 1e30 {
            self.exposure = product;
        } else {
            let value: String = value.chars().take(40).collect();
            self.warnings.push(format!("EXPOSURE={value} is not a usable factor and was ignored"));
        }
    }

    fn color(&self, rgbe: [u8; 4], scale: &[f64; 256]) -> Vec3 {
        let scale = scale[usize::from(rgbe[3])];
        let mantissa = |index: usize| ((f64::from(rgbe[index]) * scale).min(f64::from(f32::MAX))) as f32;
        let color = Vec3::new(mantissa(0), mantissa(1), mantissa(2));
        if self.xyz {
            let limit = Vec3::splat(f32::MAX);
            rec709_from_xyz(color).clamp(-limit, limit)
        } else {
            color
        }
    }
}

fn is_resolution(line: &[u8]) -> bool {
    matches!(line, [b'+' | b'-', b'X' | b'Y', b' ', ..])
}

/// How scanlines lie in the picture.
struct Layout {
    scanlines: u32,
    scanline_length: u32,
    /// Scanlines are columns rather than rows.
    columns: bool,
    /// Rows count from the bottom (`+Y`), columns from the right (`-X`).
    rows_up: bool,
    columns_left: bool,
}

impl Layout {
    fn read(cursor: &mut Cursor) -> Result<Self, DecodeError> {
        let line = String::from_utf8_lossy(cursor.line()?);
        let wrong = || {
            let shown: String = line.chars().take(60).collect();
            malformed(format!("resolution '{shown}' is not like '-Y 512 +X 1024'"))
        };
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        let [major, scanlines, minor, length] = words[..] else { return Err(wrong()) };
        let number = |word: &str| word.parse::<u32>().ok().filter(|&n| n > 0 && !word.starts_with('+'));
        let (Some(scanlines), Some(scanline_length)) = (number(scanlines), number(length)) else {
            return Err(wrong());
        };
        let (columns, vertical, horizontal) = match (major, minor) {
            ("-Y" | "+Y", "-X" | "+X") => (false, major, minor),
            ("-X" | "+X", "-Y" | "+Y") => (true, minor, major),
            _ => return Err(wrong()),
        };
        let (rows_up, columns_left) = (vertical == "+Y", horizontal == "-X");
        Ok(Self { scanlines, scanline_length, columns, rows_up, columns_left })
    }

    fn texel_count(&self) -> u64 {
        u64::from(self.scanlines) * u64::from(self.scanline_length)
    }

    fn size(&self) -> (u32, u32) {
        if self.columns {
            (self.scanlines, self.scanline_length)
        } else {
            (self.scanline_length, self.scanlines)
        }
    }

    /// Place in the row-major picture of a scanline's texel.
    fn position(&self, scanline: u32, along: u32) -> usize {
        let (width, height) = self.size();
        let (x, y) = if self.columns { (scanline, along) } else { (along, scanline) };
        let x = if self.columns_left { width - 1 - x } else { x };
        let y = if self.rows_up { height - 1 - y } else { y };
        y as usize * width as usize + x as usize
    }
}

fn read_scanline(cursor: &mut Cursor, scanline: &mut [[u8; 4]]) -> Result<(), &'static str> {
    let start = cursor.at;
    if NEW_RLE_LENGTHS.contains(&scanline.len()) {
        let [a, b, high, low] = cursor.texel()?;
        if a == 2 && b == 2 && high < 128 {
            if usize::from(high) << 8 | usize::from(low) != scanline.len() {
                return Err("its length disagrees with the resolution");
            }
            return read_new_rle(cursor, scanline);
        }
        cursor.at = start;
    }
    read_old_rle(cursor, scanline)
}

/// Four runs of planes: red, green, blue, exponent.
fn read_new_rle(cursor: &mut Cursor, scanline: &mut [[u8; 4]]) -> Result<(), &'static str> {
    for channel in 0..4 {
        let mut at = 0;
        while at < scanline.len() {
            let code = usize::from(cursor.byte()?);
            let count = if code > 128 { code - 128 } else { code };
            if count == 0 {
                return Err("a run has no length");
            }
            let run = scanline.get_mut(at..at + count).ok_or("a run passes the end of the scanline")?;
            if code > 128 {
                let value = cursor.byte()?;
                run.iter_mut().for_each(|texel| texel[channel] = value);
            } else {
                let values = cursor.take(count)?;
                run.iter_mut().zip(values).for_each(|(texel, &value)| texel[channel] = value);
            }
            at += count;
        }
    }
    Ok(())
}

/// Whole texels, where (1, 1, 1, n) repeats the last one; directly following repeats hold higher digits of the count.
fn read_old_rle(cursor: &mut Cursor, scanline: &mut [[u8; 4]]) -> Result<(), &'static str> {
    let (mut at, mut digit) = (0, 0);
    while at < scanline.len() {
        let texel = cursor.texel()?;
        if texel[..3] == [1, 1, 1] {
            let previous = at.checked_sub(1).ok_or("a repeat has nothing to repeat")?;
            let count = if digit < 4 { u64::from(texel[3]) << (8 * digit) } else { u64::MAX };
            let end = usize::try_from(count).ok().and_then(|count| at.checked_add(count));
            let value = scanline[previous];
            end.and_then(|end| scanline.get_mut(at..end))
                .ok_or("a run passes the end of the scanline")?
                .fill(value);
            at += count as usize;
            digit += 1;
        } else {
            scanline[at] = texel;
            at += 1;
            digit = 0;
        }
    }
    Ok(())
}

/// Encodes a picture as uncompressed RGBE, to the nearest mantissa of 8 bits that the largest channel's exponent leaves. What is negative
/// or no number becomes 0.
///
/// # Errors
/// Says what is wrong with an empty picture.
pub fn encode(image: &RgbImage) -> Result<Vec<u8>, String> {
    let (width, height) = (image.width(), image.height());
    if width == 0 || height == 0 {
        return Err("the picture is empty".to_owned());
    }
    let mut bytes = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n").into_bytes();
    bytes.extend(image.texels().iter().flat_map(|texel| rgbe(*texel)));
    Ok(bytes)
}

/// `mantissa * 2^(exponent - 136)`.
fn rgbe(color: Vec3) -> [u8; 4] {
    let color = color.max(Vec3::ZERO).as_dvec3();
    let mantissas = |exponent: i32| (color * f64::from(136 - exponent).exp2()).round();
    // The least exponent with which no mantissa exceeds a byte; 0 stands for black, below what the format holds.
    let least = color.max_element().max(1e-300).log2().floor() as i32 + 129;
    let fits = |exponent: &i32| mantissas(*exponent).max_element() <= 255.0;
    match (least..=least + 1).find(fits) {
        Some(exponent @ 1..=255) => {
            let [r, g, b] = mantissas(exponent).to_array().map(|mantissa| mantissa as u8);
            [r, g, b, exponent as u8]
        }
        Some(..=0) => [0; 4],
        _ => [255; 4],
    }
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
