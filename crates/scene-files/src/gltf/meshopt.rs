//! Compressed buffer views (`EXT_meshopt_compression`, appendices A and B: the bit streams are fixed there). Of
//! `KHR_meshopt_compression` this is the older form of vertices, which its files may hold; the newer is refused.

/// Vertices of one step share their prediction; deltas come in groups.
const BLOCK_BYTES: usize = 8192;
const MOST_IN_BLOCK: usize = 256;
const GROUP: usize = 16;

/// Decodes `count` elements of `stride` bytes, or says what is wrong.
pub fn decode(
    mode: &str,
    filter: Option<&str>,
    (count, stride): (usize, usize),
    bytes: &[u8],
) -> Result<Vec<u8>, String> {
    let cut_off = || "its compressed data is damaged or cut off".to_owned();
    let length = count.checked_mul(stride).ok_or_else(cut_off)?;
    let mut elements = match (mode, stride) {
        ("ATTRIBUTES", 4..=256) if stride.is_multiple_of(4) => match bytes.first() {
            Some(0xa1) => {
                return Err("vertices are compressed by a newer meshopt (its version 0 is known)".to_owned());
            }
            _ => attributes(length, stride, bytes).ok_or_else(cut_off)?,
        },
        ("TRIANGLES", 2 | 4) if count.is_multiple_of(3) => {
            indices_in(stride, triangles(count / 3, bytes).ok_or_else(cut_off)?)
        }
        ("INDICES", 2 | 4) => indices_in(stride, sequence(count, bytes).ok_or_else(cut_off)?),
        _ => {
            return Err(format!(
                "compression in mode {mode} of {count} elements of {stride} bytes is unknown"
            ));
        }
    };
    match (filter.unwrap_or("NONE"), mode, stride) {
        ("NONE", ..) => {}
        ("OCTAHEDRAL", "ATTRIBUTES", 4) => elements.as_chunks_mut().0.iter_mut().for_each(octahedral_8),
        ("OCTAHEDRAL", "ATTRIBUTES", 8) => elements.as_chunks_mut().0.iter_mut().for_each(octahedral_16),
        ("QUATERNION", "ATTRIBUTES", 8) => elements.as_chunks_mut().0.iter_mut().for_each(quaternion),
        ("EXPONENTIAL", "ATTRIBUTES", _) => elements.as_chunks_mut().0.iter_mut().for_each(exponential),
        (filter, ..) => return Err(format!("the filter {filter} of {mode} of {stride} bytes is unknown")),
    }
    Ok(elements)
}

/// Bytes that are read one after the other.
struct Reader<'a>(&'a [u8]);

impl<'a> Reader<'a> {
    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(taken)
    }

    fn byte(&mut self) -> Option<u8> {
        self.take(1).map(|bytes| bytes[0])
    }

    /// Seven bits a byte, the lowest first.
    fn variable(&mut self) -> Option<u32> {
        let mut value = 0;
        for shift in (0..35).step_by(7) {
            let byte = self.byte()?;
            value |= u32::from(byte & 127) << shift;
            if byte < 128 {
                break;
            }
        }
        Some(value)
    }

    /// An index as its difference to another.
    fn index_after(&mut self, last: u32) -> Option<u32> {
        let value = self.variable()?;
        Some(last.wrapping_add((value >> 1) ^ (value & 1).wrapping_neg()))
    }
}

fn attributes(length: usize, stride: usize, bytes: &[u8]) -> Option<Vec<u8>> {
    let body = bytes.strip_prefix(&[0xa0])?;
    // The first element lies at the end.
    let (body, tail) = body.split_at_checked(body.len().checked_sub(stride.max(32))?)?;
    let mut last = tail[tail.len() - stride..].to_vec();
    let mut reader = Reader(body);
    let mut elements = vec![0; length];
    let in_block = ((BLOCK_BYTES / stride) & !(GROUP - 1)).min(MOST_IN_BLOCK);
    for block in elements.chunks_mut(in_block * stride) {
        let count = block.len() / stride;
        let groups = count.div_ceil(GROUP);
        for (place, last) in last.iter_mut().enumerate() {
            let header = reader.take(groups.div_ceil(4))?;
            for group in 0..groups {
                let deltas = deltas(&mut reader, header[group / 4] >> (2 * (group % 4)) & 3)?;
                for (delta, element) in deltas.into_iter().zip(GROUP * group..count) {
                    *last = last.wrapping_add((delta >> 1) ^ (delta & 1).wrapping_neg());
                    block[element * stride + place] = *last;
                }
            }
        }
    }
    Some(elements)
}

/// A group of differences, all 0 or of 2, 4 or 8 bits; the largest number of few bits stands for a byte that follows.
fn deltas(reader: &mut Reader, kind: u8) -> Option<[u8; GROUP]> {
    let mut deltas = [0; GROUP];
    let bits = match kind {
        0 => return Some(deltas),
        3 => return reader.take(GROUP)?.try_into().ok(),
        kind => 2 * kind,
    };
    let packed = reader.take(GROUP * usize::from(bits) / 8)?;
    let each = 8 / usize::from(bits);
    let most = (1 << bits) - 1;
    for (place, delta) in deltas.iter_mut().enumerate() {
        let shift = 8 - usize::from(bits) * (place % each + 1);
        let value = packed[place / each] >> shift & most;
        *delta = if value == most { reader.byte()? } else { value };
    }
    Some(deltas)
}

/// The last sixteen of something.
struct Recent<T> {
    items: [T; 16],
    next: usize,
}

impl<T: Copy> Recent<T> {
    fn push(&mut self, item: T) {
        self.items[self.next % 16] = item;
        self.next += 1;
    }

    /// The one that came so many before the next.
    fn before(&self, count: u8) -> T {
        self.items[self.next.wrapping_sub(usize::from(count)) % 16]
    }
}

/// The vertex after all that came.
fn new(next: &mut u32) -> u32 {
    let vertex = *next;
    *next = next.wrapping_add(1);
    vertex
}

fn triangles(count: usize, bytes: &[u8]) -> Option<Vec<u32>> {
    let version = bytes.first()?.checked_sub(0xe0).filter(|version| *version < 2)?;
    // Up to here an index is a recent vertex.
    let most_recent = if version == 1 { 13 } else { 15 };
    let (codes, rest) = bytes[1..].split_at_checked(count)?;
    let (data, table) = rest.split_at_checked(rest.len().checked_sub(16)?)?;
    let mut reader = Reader(data);
    let mut edges = Recent { items: [[u32::MAX; 2]; 16], next: 0 };
    let mut vertices = Recent { items: [u32::MAX; 16], next: 0 };
    let (mut next, mut last) = (0_u32, 0_u32);
    let mut indices = Vec::with_capacity(3 * count);
    for &code in codes {
        let [a, b, c];
        if code < 0xf0 {
            [a, b] = edges.before((code >> 4) + 1);
            let low = code & 15;
            c = match low {
                0 => new(&mut next),
                low if low < most_recent => vertices.before(low + 1),
                15 => reader.index_after(last)?,
                13 => last.wrapping_sub(1),
                _ => last.wrapping_add(1),
            };
            if low >= most_recent {
                last = c;
            }
            if low == 0 || low >= most_recent {
                vertices.push(c);
            }
        } else {
            let is_in_table = code < 0xfe;
            let pair = if is_in_table { table[usize::from(code & 15)] } else { reader.byte()? };
            let (high, low) = (pair >> 4, pair & 15);
            if !is_in_table && pair == 0 {
                next = 0;
            }
            // A vertex is new, or spelled out (not by the table), or recent: counted from before any of this triangle's.
            let is_new = |number: u8| number == 0 || (number == 15 && !is_in_table);
            let first = if code == 0xff { 15 } else { 0 };
            let mut corners = [first, high, low].map(|number| match number {
                0 => new(&mut next),
                number => vertices.before(number),
            });
            for (corner, number) in corners.iter_mut().zip([first, high, low]) {
                if number == 15 && !is_in_table {
                    *corner = reader.index_after(last)?;
                    last = *corner;
                }
                if is_new(number) {
                    vertices.push(*corner);
                }
            }
            [a, b, c] = corners;
            edges.push([b, a]);
        }
        edges.push([c, b]);
        edges.push([a, c]);
        indices.extend([a, b, c]);
    }
    reader.0.is_empty().then_some(indices)
}

fn sequence(count: usize, bytes: &[u8]) -> Option<Vec<u32>> {
    bytes.first()?.checked_sub(0xd0).filter(|version| *version < 2)?;
    let body = &bytes[1..];
    let mut reader = Reader(&body[..body.len().checked_sub(4)?]);
    // Two runs of indices, each its own differences.
    let mut last = [0_u32; 2];
    let mut indices = Vec::with_capacity(count.min(body.len()));
    for _ in 0..count {
        let value = reader.variable()?;
        let last = &mut last[(value & 1) as usize];
        let value = value >> 1;
        *last = last.wrapping_add((value >> 1) ^ (value & 1).wrapping_neg());
        indices.push(*last);
    }
    Some(indices)
}

fn indices_in(stride: usize, indices: Vec<u32>) -> Vec<u8> {
    indices.into_iter().flat_map(|index| index.to_le_bytes().into_iter().take(stride)).collect()
}

/// A unit vector from its place on an octahedron whose corner is at `one`, scaled to `most`.
fn octahedral([x, y, one]: [f32; 3], most: f32) -> [f32; 3] {
    let z = one - x.abs() - y.abs();
    let fold = z.min(0.0);
    let (x, y) = (x + if x >= 0.0 { fold } else { -fold }, y + if y >= 0.0 { fold } else { -fold });
    // Casts of NaN and infinity are defined.
    let scale = most / (x * x + y * y + z * z).sqrt();
    [x, y, z].map(|value| (value * scale).round())
}

fn octahedral_8(element: &mut [u8; 4]) {
    let [x, y, one, _] = element.map(|byte| f32::from(byte as i8));
    for (byte, value) in element.iter_mut().zip(octahedral([x, y, one], 127.0)) {
        *byte = value as i8 as u8;
    }
}

fn shorts(element: &[u8; 8]) -> [i16; 4] {
    std::array::from_fn(|i| i16::from_le_bytes([element[2 * i], element[2 * i + 1]]))
}

fn octahedral_16(element: &mut [u8; 8]) {
    let [x, y, one, w] = shorts(element);
    let [x, y, z] = octahedral([x, y, one].map(f32::from), 32_767.0).map(|value| value as i16);
    *element = bytes_of([x, y, z, w]);
}

fn bytes_of(shorts: [i16; 4]) -> [u8; 8] {
    std::array::from_fn(|i| shorts[i / 2].to_le_bytes()[i % 2])
}

/// Three components of a unit quaternion; which is missing, and their scale, stands in the fourth.
fn quaternion(element: &mut [u8; 8]) {
    let [x, y, z, code] = shorts(element);
    let scale = std::f32::consts::FRAC_1_SQRT_2 / f32::from(code | 3);
    let given = [x, y, z].map(|value| f32::from(value) * scale);
    let missing = (1.0 - given.iter().map(|value| value * value).sum::<f32>()).max(0.0).sqrt();
    let mut rotation = [0; 4];
    let first = usize::from(code as u16 & 3);
    for (place, value) in [missing, given[0], given[1], given[2]].into_iter().enumerate() {
        rotation[(first + place) % 4] = (value * 32_767.0).round() as i16;
    }
    *element = bytes_of(rotation);
}

/// A power of two in the highest byte times a whole number in the others.
fn exponential(element: &mut [u8; 4]) {
    let bits = i32::from_le_bytes(*element);
    let (exponent, mantissa) = (bits >> 24, (bits << 8) >> 8);
    *element = (mantissa as f32 * (exponent as f32).exp2()).to_le_bytes();
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bytes(hex: &str) -> Vec<u8> {
        (0..hex.len() / 2).map(|i| u8::from_str_radix(&hex[2 * i..2 * i + 2], 16).unwrap()).collect()
    }

    fn decoded(mode: &str, filter: &str, layout: (usize, usize), hex: &str) -> Vec<u8> {
        decode(mode, Some(filter), layout, &bytes(hex)).unwrap()
    }

    fn floats(bytes: &[u8]) -> Vec<f32> {
        bytes.as_chunks().0.iter().map(|word| f32::from_le_bytes(*word)).collect()
    }

    // Streams that meshoptimizer's encoder made of the values beside them.
    const TRIANGLES: &str = "e1f01010ff10ff1eefdeffc801c801c801ffc904020250007687566778a9866589689801690000";
    const SEQUENCE: &str = "d114101681b51804020202bfa90700000000";

    #[test]
    fn triangles_keep_their_indices() {
        let indices: [u16; 27] =
            [0, 1, 2, 2, 1, 3, 3, 1, 4, 100, 200, 300, 300, 200, 5, 7, 8, 9, 9, 8, 10, 0, 2, 50, 4, 1, 51];
        let found = decoded("TRIANGLES", "NONE", (27, 2), TRIANGLES);
        let found: Vec<u16> = found.as_chunks().0.iter().map(|short| u16::from_le_bytes(*short)).collect();
        // A triangle may begin with another of its corners.
        for (found, given) in found.as_chunks::<3>().0.iter().zip(indices.as_chunks::<3>().0) {
            let turns = (0..3).map(|turn| [0, 1, 2].map(|corner| given[(corner + turn) % 3]));
            assert!(turns.into_iter().any(|turned| turned == *found), "{found:?}, not {given:?}");
        }
    }

    #[test]
    fn sequences_keep_their_indices() {
        let found = decoded("INDICES", "NONE", (9, 4), SEQUENCE);
        let found: Vec<u32> = found.as_chunks().0.iter().map(|word| u32::from_le_bytes(*word)).collect();
        assert_eq!(found, [5, 9, 3, 100_000, 4, 3, 2, 1, 70_000]);
    }

    #[test]
    fn filters_are_undone() {
        const EXPONENTIAL: &str = "a00130000000ff01300000004c000130000000100001300000004801200000000130000000100\
            13000000011011000000001100000000130000000100000000000000000000000000000000000000000001800f400dcfff4040000f4";
        let found = floats(&decoded("ATTRIBUTES", "EXPONENTIAL", (2, 12), EXPONENTIAL));
        // The encoder gives the numbers of an element one exponent, that of the largest.
        let given =
            [(1.5, 2.25), (-2.25, 2.25), (0.001, 2.25), (1000.0, 1000.0), (0.0, 1000.0), (-0.3, 1000.0)];
        for (found, (given, largest)) in found.iter().zip(given) {
            assert!((found - given).abs() < 1e-4 * largest, "{found}, not {given}");
        }
        const QUATERNION: &str = "a00130000000b201300000000b01300000004301100000000130000000b201300000000b0130000000\
            05000000000000000000000000000000000000000000000000000000c9060000ff07";
        let found = decoded("ATTRIBUTES", "QUATERNION", (2, 8), QUATERNION);
        let found: Vec<f32> = found
            .as_chunks()
            .0
            .iter()
            .map(|short| f32::from(i16::from_le_bytes(*short)) / 32_767.0)
            .collect();
        for (found, given) in found.iter().zip([0.0, 0.6, 0.0, 0.8, 0.5, -0.5, 0.5, -0.5]) {
            assert!((found - given).abs() < 2e-3, "{found}, not {given}");
        }
        const BYTES: &str = "a00130000000a501300000004c000130000000fe0000000000000000000000000000000000000000000\
            000000000000000367f00";
        const SHORTS: &str = "a00130000000b10130000000a70130000000d801300000004c000001100000000130000000fe00000000\
            00000000000000000000000000000000000000000000db36ff7f0000";
        let found = decoded("ATTRIBUTES", "OCTAHEDRAL", (2, 4), BYTES);
        let small = found.iter().map(|byte| f32::from(*byte as i8) / 127.0);
        let found = decoded("ATTRIBUTES", "OCTAHEDRAL", (2, 8), SHORTS);
        let large = found.as_chunks().0.iter().map(|short| f32::from(i16::from_le_bytes(*short)) / 32_767.0);
        let given = [0.0, 0.6, 0.8, 0.0, -0.48, 0.6, -0.64, 1.0];
        for (found, given) in small.zip(given) {
            assert!((found - given).abs() < 0.02, "{found}, not {given}");
        }
        for (found, given) in large.zip(given) {
            assert!((found - given).abs() < 1e-4, "{found}, not {given}");
        }
    }

    #[test]
    fn damaged_streams_end_in_a_message() {
        for (mode, layout, hex) in [("TRIANGLES", (27, 2), TRIANGLES), ("INDICES", (9, 4), SEQUENCE)] {
            let whole = bytes(hex);
            for length in 0..whole.len() {
                assert!(decode(mode, None, layout, &whole[..length]).is_err(), "{mode} {length}");
            }
            for place in 0..whole.len() {
                for bit in 0..8 {
                    let mut damaged = whole.clone();
                    damaged[place] ^= 1 << bit;
                    let _ = decode(mode, None, layout, &damaged);
                }
            }
        }
        for (mode, layout) in [("ATTRIBUTES", (1, 3)), ("TRIANGLES", (4, 2)), ("POINTS", (3, 4))] {
            assert!(decode(mode, None, layout, &[0xa0; 64]).unwrap_err().contains("unknown"));
        }
        assert!(decode("ATTRIBUTES", None, (1, 4), &[0xa1; 64]).unwrap_err().contains("newer"));
    }
}
