use glam::{DVec2, Vec2};

/// Which numbers of a sample serve which decision: each is a two-dimensional sequence of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub(crate) enum Decision {
    /// Place in the pixel.
    Pixel,
    /// Direction of the light.
    Direction,
    /// Light or reflectance; which light, which lobe.
    Choice,
    /// Direction of the light that casts no shadows.
    UnshadowedDirection,
    /// The choices for the light that casts no shadows.
    UnshadowedChoice,
    /// Direction in which a glossy lobe sees the scene.
    Mirrored,
    /// The same as those above, where it meets the scene.
    MirroredDirection,
    /// The choices there.
    MirroredChoice,
    /// Direction of the light that casts no shadows there.
    MirroredUnshadowedDirection,
    /// The choices for it.
    MirroredUnshadowedChoice,
    /// Which of the surfaces that let light through a ray stops at: that of the camera, and that of a lobe.
    Opacity,
}

/// Numbers of decisions from here on are those of paths.
const FIRST_OF_PATHS: u32 = 64;

/// Owen-scrambled Sobol points, two dimensions at a time, every pair of dimensions shuffled and scrambled on its own
/// (Burley 2020, "Practical hash-based Owen scrambling"). Every point is uniform in `[0, 1)^2`; runs of a power of two
/// are stratified. Two sequences with different keys are independent.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sequence {
    key: u32,
}

impl Sequence {
    /// The sequence of one batch of samples of one pixel.
    pub(crate) fn new(seed: u64, pixel: u32, batch: u32) -> Self {
        let mut key = hash(seed as u32 ^ 0x9e37_79b9);
        for word in [(seed >> 32) as u32, pixel, batch] {
            key = hash(key ^ word.wrapping_mul(0x85eb_ca6b)).wrapping_add(word);
        }
        Self { key: hash(key) }
    }

    /// The `index`-th pair of numbers for a decision, 32 bits each, in `[0, 1)`.
    pub(crate) fn pair(&self, index: u32, decision: Decision) -> DVec2 {
        self.numbered(index, decision as u32)
    }

    /// The same for the decisions of a path, by their numbers.
    pub(crate) fn bounce(&self, index: u32, number: u32) -> DVec2 {
        self.numbered(index, FIRST_OF_PATHS + number)
    }

    fn numbered(&self, index: u32, number: u32) -> DVec2 {
        let key = hash(self.key ^ (number + 1).wrapping_mul(0x27d4_eb2f));
        let index = nested_scramble(index, key);
        let x = nested_scramble(index.reverse_bits(), hash(key ^ 0xa511_e9b3));
        let y = nested_scramble(sobol_second(index), hash(key ^ 0x63d8_3595));
        DVec2::new(f64::from(x), f64::from(y)) / 2f64.powi(32)
    }
}

/// Rounds a pair to 32-bit floats that stay below 1.
pub(crate) fn to_vec2(pair: DVec2) -> Vec2 {
    pair.as_vec2().min(Vec2::splat(1.0 - f32::EPSILON / 2.0))
}

/// Second dimension of the Sobol sequence as a 32-bit fraction: its direction numbers are rows of Pascal's triangle modulo
/// 2, so that the product with the index is five xors (a sum over supersets of bit positions, by Lucas' theorem).
fn sobol_second(index: u32) -> u32 {
    let mut v = index.reverse_bits();
    v ^= v << 16;
    v ^= (v & 0x00ff_00ff) << 8;
    v ^= (v & 0x0f0f_0f0f) << 4;
    v ^= (v & 0x3333_3333) << 2;
    v ^= (v & 0x5555_5555) << 1;
    v
}

/// Owen scrambling in base 2 of a 32-bit fraction: every bit is flipped by a hash of the bits above it.
fn nested_scramble(x: u32, key: u32) -> u32 {
    // Laine and Karras' permutation with Vegdahl's constants works from the low bits up, hence the reversal.
    let mut x = x.reverse_bits();
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(key);
    x = x.wrapping_mul((key >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^= x.wrapping_mul(0x53a2_2864);
    x.reverse_bits()
}

/// A 32-bit permutation with little bias (Wellons' lowbias32).
fn hash(mut x: u32) -> u32 {
    x ^= x >> 16;
    x = x.wrapping_mul(0x7feb_352d);
    x ^= x >> 15;
    x = x.wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn second_dimension_has_sobols_direction_numbers() {
        // v_1 = 1/2, v_{k+1} = v_k xor v_k / 2 (Bratley and Fox 1988, polynomial x + 1).
        let mut direction = 1u32 << 31;
        for bit in 0..32 {
            assert_eq!(sobol_second(1 << bit), direction, "bit {bit}");
            direction ^= direction >> 1;
        }
        assert_eq!(sobol_second(0b1011), sobol_second(1) ^ sobol_second(2) ^ sobol_second(8));
    }

    #[test]
    fn powers_of_two_fill_every_stratum_once() {
        for (pixel, decision) in [(0, Decision::Pixel), (17, Decision::Direction), (99, Decision::Choice)] {
            let sequence = Sequence::new(5, pixel, 3);
            for (columns, rows) in [(32, 1), (1, 32), (8, 4), (4, 8), (16, 2)] {
                let mut seen = vec![0; 32];
                for index in 0..32 {
                    let p = sequence.pair(index, decision);
                    let (x, y) = ((p.x * f64::from(columns)) as usize, (p.y * f64::from(rows)) as usize);
                    seen[y * columns as usize + x] += 1;
                }
                assert!(seen.iter().all(|&count| count == 1), "{columns} x {rows}: {seen:?}");
            }
        }
    }

    #[test]
    fn first_points_of_many_sequences_are_uniform_and_independent() {
        // 4096 sequences, one point each: means and covariance of uniform numbers within five standard errors.
        let count = 4096;
        let points: Vec<DVec2> =
            (0..count).map(|pixel| Sequence::new(1, pixel, 0).pair(0, Decision::Pixel)).collect();
        let n = f64::from(count);
        let mean = points.iter().sum::<DVec2>() / n;
        let tolerance = 5.0 * (1.0 / 12.0 / n).sqrt();
        assert!((mean - 0.5).abs().max_element() < tolerance, "{mean}");
        let covariance = points.iter().map(|p| (p.x - 0.5) * (p.y - 0.5)).sum::<f64>() / n;
        assert!(covariance.abs() < 5.0 / 12.0 / n.sqrt(), "{covariance}");
        let neighbours = points.windows(2).map(|p| (p[0].x - 0.5) * (p[1].x - 0.5)).sum::<f64>() / n;
        assert!(neighbours.abs() < 5.0 / 12.0 / n.sqrt(), "{neighbours}");
        let batches: f64 =
            (0..count).map(|batch| Sequence::new(1, 7, batch).pair(0, Decision::Pixel).x - 0.5).sum::<f64>()
                / n;
        assert!(batches.abs() < tolerance, "{batches}");
    }

    #[test]
    fn floats_stay_below_one() {
        assert!(to_vec2(DVec2::splat(1.0 - 2f64.powi(-32))).max_element() < 1.0);
    }
}
