//! Radiance pictures (.hdr, .pic): Greg Ward, *Real Pixels*, Graphics Gems II (1991), and the Radiance file formats page.

use std::path::Path;

use glam::{Mat3, Vec3};
use gnomon_messages::quoted;

use crate::error::{DecodeError, ImageError};
use crate::file::{Description, TexelSink};
use crate::primaries::{Primaries, converted, from_xyz};
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

/// Whether the bytes begin like a Radiance picture: with `#?` and any word, or without that line with the format.
pub fn sniff(bytes: &[u8]) -> bool {
    bytes.starts_with(b"#?") || bytes.starts_with(b"FORMAT=32-bit_rle_")
}

/// Decodes a Radiance picture: run-length codes old and new, uncompressed, RGBE and XYZE, all eight orientations.
///
/// Texels are `mantissa * 2^(exponent - 136)`, exactly 0 for exponent 0, divided by the products of the `EXPOSURE` and `COLORCORR`
/// lines; colours of other `PRIMARIES` become Rec. 709. A line whose value makes no sense is ignored with a warning.
///
/// # Errors
/// [`DecodeError`] for a damaged or oversized file. Memory stays in proportion to a scanline.
pub fn decode(bytes: &[u8], sink: &mut dyn TexelSink) -> Result<Description, DecodeError> {
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

    let (width, height) = layout.size();
    sink.begin(width, height, None);
    let matrix = header.matrix();
    let scales = scales(header.exposure, header.correction);
    let mut scanline = vec![[0u8; 4]; layout.scanline_length as usize];
    let mut colors = vec![Vec3::ZERO; scanline.len()];
    for index in 0..layout.scanlines {
        read_scanline(&mut cursor, &mut scanline)
            .map_err(|reason| malformed(format!("scanline {index}: {reason}")))?;
        for (color, &rgbe) in colors.iter_mut().zip(&scanline) {
            *color = color_of(rgbe, &scales, matrix.as_ref());
        }
        layout.hand_over(index, &mut colors, sink);
    }
    let converted = header.primaries.filter(|_| matrix.is_some() && !header.xyz);
    let details = converted.map(|primaries| primaries.told()).into_iter().collect();
    Ok(Description { format: FORMAT, details, warnings: header.warnings })
}

/// Radiance of mantissa 1 for every exponent, by channel.
type Scales = [[f64; 3]; 256];

fn scales(exposure: f64, correction: Vec3) -> Scales {
    let factors = correction.to_array().map(|factor| exposure * f64::from(factor));
    std::array::from_fn(|exponent| match exponent {
        0 => [0.0; 3],
        _ => factors.map(|factor| (exponent as f64 - 136.0).exp2() / factor),
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
    /// Product of the `COLORCORR` lines.
    correction: Vec3,
    xyz: bool,
    primaries: Option<Primaries>,
    warnings: Vec<String>,
}

impl Header {
    fn read(cursor: &mut Cursor) -> Result<Self, DecodeError> {
        if !sniff(cursor.bytes) {
            return Err(malformed("it begins neither with #? nor with its FORMAT"));
        }
        if cursor.bytes.starts_with(b"#?") {
            cursor.line()?;
        }
        let mut header =
            Self { exposure: 1.0, correction: Vec3::ONE, xyz: false, primaries: None, warnings: Vec::new() };
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
                    return Err(DecodeError::unsupported(FORMAT, format!("FORMAT={}", quoted(other))));
                }
                Some((name @ "EXPOSURE", value)) => header.multiply_exposure(name, value),
                Some((name @ "COLORCORR", value)) => header.multiply_correction(name, value),
                Some((name @ "PRIMARIES", value)) => header.set_primaries(name, value),
                _ => {}
            }
        }
        Ok(header)
    }

    fn ignore(&mut self, name: &str, value: &str, what: &str) {
        self.warnings.push(format!("{name}={} is no usable {what} and was ignored", quoted(value)));
    }

    fn multiply_exposure(&mut self, name: &str, value: &str) {
        let product = value.parse::<f64>().map_or(f64::NAN, |factor| self.exposure * factor);
        // Also refuses a product whose reciprocal leaves the range of a texel.
        if product > 1e-30 && product < 1e30 {
            self.exposure = product;
        } else {
            self.ignore(name, value, "factor");
        }
    }

    fn multiply_correction(&mut self, name: &str, value: &str) {
        match numbers::<3>(value).map(|factors| self.correction * Vec3::from_array(factors)) {
            Some(product) if product.min_element() > 1e-30 && product.max_element() < 1e30 => {
                self.correction = product;
            }
            _ => self.ignore(name, value, "triple of factors"),
        }
    }

    fn set_primaries(&mut self, name: &str, value: &str) {
        let read = numbers(value).map(|[rx, ry, gx, gy, bx, by, wx, wy]: [f32; 8]| Primaries {
            red: [rx, ry],
            green: [gx, gy],
            blue: [bx, by],
            white: [wx, wy],
        });
        match read.filter(|primaries| primaries.rec709().is_some()) {
            Some(primaries) => self.primaries = Some(primaries),
            None => self.ignore(name, value, "set of chromaticities"),
        }
    }

    /// What makes Rec. 709 of the file's colours, unless they are that already.
    fn matrix(&self) -> Option<Mat3> {
        if self.xyz {
            return Some(from_xyz());
        }
        self.primaries.filter(|primaries| !primaries.is_rec709()).and_then(|primaries| primaries.rec709())
    }
}

fn color_of(rgbe: [u8; 4], scales: &Scales, matrix: Option<&Mat3>) -> Vec3 {
    let scale = &scales[usize::from(rgbe[3])];
    let channel = |index: usize| (f64::from(rgbe[index]) * scale[index]).min(f64::from(f32::MAX)) as f32;
    let color = Vec3::new(channel(0), channel(1), channel(2));
    matrix.map_or(color, |matrix| converted(matrix, color))
}

/// As many numbers as are wanted, and nothing else.
fn numbers<const N: usize>(text: &str) -> Option<[f32; N]> {
    let numbers = text.split_ascii_whitespace().map(|word| word.parse().ok().filter(|n: &f32| n.is_finite()));
    numbers.collect::<Option<Vec<f32>>>()?.try_into().ok()
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
        let wrong = || malformed(format!("resolution '{}' is not like '-Y 512 +X 1024'", quoted(&line)));
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

    /// Gives a scanline away, turned round where it runs so.
    fn hand_over(&self, scanline: u32, colors: &mut [Vec3], sink: &mut dyn TexelSink) {
        let (width, height) = self.size();
        let is_backwards = if self.columns { self.rows_up } else { self.columns_left };
        if is_backwards {
            colors.reverse();
        }
        if self.columns {
            let x = if self.columns_left { width - 1 - scanline } else { scanline };
            for (y, color) in (0..).zip(&*colors) {
                sink.texels(x, y, std::slice::from_ref(color));
            }
        } else {
            sink.texels(0, if self.rows_up { height - 1 - scanline } else { scanline }, colors);
        }
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
