//! Small damage, the same for the same seed.

/// Numbers by xorshift64 (Marsaglia 2003).
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// A sequence of its own for each seed.
    pub fn new(seed: u64) -> Self {
        // Neighbouring seeds are far apart (Steele, Lea and Flood 2014, splitmix64), and 0 would stay 0.
        let mut state = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
        state = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        state = (state ^ (state >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        Self((state ^ (state >> 31)) | 1)
    }

    /// A number below `end`, 0 for 0.
    pub fn below(&mut self, end: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        if end == 0 { 0 } else { ((self.0 >> 11) % end as u64) as usize }
    }

    fn pick<'a, T>(&mut self, from: &'a [T]) -> Option<&'a T> {
        from.get(self.below(from.len()))
    }
}

/// What readers trip over as numbers of bytes, counts and indices.
const NUMBERS: [i64; 12] =
    [0, 1, -1, 2, 127, 255, 256, 65_535, 65_536, i32::MAX as i64, i32::MIN as i64, u32::MAX as i64];
/// The same as text.
const WORDS: [&str; 14] = [
    "0",
    "-1",
    "1e999",
    "-1e-999",
    "nan",
    "inf",
    "4294967295",
    "99999999999999999999",
    "1.5",
    "",
    "\"",
    "{}",
    "[]",
    "null",
];

/// One of `seeds` with some damage; empty where there are no seeds.
pub fn mutated(seeds: &[Vec<u8>], random: &mut Random) -> Vec<u8> {
    let Some(seed) = random.pick(seeds) else { return Vec::new() };
    let mut bytes = seed.clone();
    for _ in 0..=random.below(4) {
        damage(&mut bytes, seeds, random);
    }
    bytes
}

fn damage(bytes: &mut Vec<u8>, seeds: &[Vec<u8>], random: &mut Random) {
    // Headers decide most.
    let near_the_start = random.below(2) == 0;
    let end = if near_the_start { bytes.len().min(512) } else { bytes.len() };
    let at = random.below(end);
    match random.below(9) {
        0 => bytes.iter_mut().skip(at).take(1).for_each(|byte| *byte ^= 1 << random.below(8)),
        1 => bytes.iter_mut().skip(at).take(1).for_each(|byte| *byte = random.below(256) as u8),
        2 => {
            let number = NUMBERS[random.below(NUMBERS.len())];
            let size = [1, 2, 4, 8][random.below(4)];
            let mut value = number.to_le_bytes()[..size].to_vec();
            if random.below(3) == 0 {
                value.reverse();
            }
            bytes.iter_mut().skip(at).zip(value).for_each(|(byte, value)| *byte = value);
        }
        3 => {
            let count = random.below(64).min(bytes.len() - at.min(bytes.len()));
            bytes.drain(at.min(bytes.len())..).take(count).for_each(drop);
        }
        4 => {
            let count = random.below(64).min(bytes.len() - at);
            let copy = bytes[at..at + count].to_vec();
            let to = random.below(bytes.len() + 1);
            bytes.splice(to..to, copy);
        }
        5 => bytes.truncate(at),
        6 => replace_token(bytes, at, random),
        7 => {
            // A line, or what looks like one, again elsewhere.
            let lines: Vec<&[u8]> = bytes.split_inclusive(|&byte| byte == b'\n').take(4096).collect();
            let line = lines.get(random.below(lines.len())).copied().unwrap_or_default();
            let copy = line[..line.len().min(4096)].to_vec();
            bytes.splice(at..at, copy);
        }
        _ => {
            if let Some(other) = random.pick(seeds) {
                let from = random.below(other.len());
                let count = random.below(256).min(other.len() - from);
                bytes.splice(at..at, other[from..from + count].iter().copied());
            }
        }
    }
}

/// Puts another word in the place of one of letters, digits and signs.
fn replace_token(bytes: &mut Vec<u8>, at: usize, random: &mut Random) {
    let is_token = |byte: &u8| byte.is_ascii_alphanumeric() || matches!(byte, b'+' | b'-' | b'.' | b'_');
    let Some(start) = bytes.iter().skip(at).position(is_token).map(|offset| at + offset) else { return };
    let length = bytes[start..].iter().take(64).take_while(|byte| is_token(byte)).count();
    let word = WORDS[random.below(WORDS.len())];
    bytes.splice(start..start + length, word.bytes());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_seed_makes_the_same_damage() {
        let seeds = vec![b"v 0 0 0\nv 1 0 0\nf 1 2 3\n".to_vec(), (0..=255).collect()];
        let all = |seed: u64| {
            let mut random = Random::new(seed);
            (0..300).map(|_| mutated(&seeds, &mut random)).collect::<Vec<_>>()
        };
        assert_eq!(all(7), all(7));
        assert_ne!(all(7), all(8));
        // Nearly every one is damaged, and none grows without bound.
        let changed = all(7).iter().filter(|bytes| !seeds.contains(bytes)).count();
        assert!(changed > 270, "{changed}");
        assert!(
            mutated(&[], &mut Random::new(0)).is_empty()
                && mutated(&[Vec::new()], &mut Random::new(0)).len() < 300
        );
    }
}
