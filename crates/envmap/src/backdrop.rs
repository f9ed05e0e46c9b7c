use glam::Vec3;

use crate::equirect::interpolate;

/// Bits of a channel, bias of the exponent, and largest value, of a texel with a shared exponent.
const BITS: i32 = 9;
const BIAS: i32 = 15;
const LARGEST: f32 = 65_408.0;
/// Power of two that is the largest unit: with it, the largest stored value is nearly that of a float.
const MOST_SCALE: f32 = 112.0;

/// A large environment as the camera sees it: an equirect picture of four bytes a texel, of radiance finite and not negative.
///
/// Its light is worked out from the smaller [`crate::Equirect`] that carries it. A texel has three channels of nine bits under one exponent,
/// as textures of shared exponents have them, in units of [`Backdrop::scale`]: a channel is off by at most 1/512 of the largest one.
#[derive(Clone, Debug, PartialEq)]
pub struct Backdrop {
    width: u32,
    height: u32,
    /// A power of two.
    scale: f32,
    texels: Vec<u32>,
}

impl Backdrop {
    /// A black one.
    pub(crate) fn new(width: u32, height: u32) -> Self {
        Self { width, height, scale: 1.0, texels: vec![0; width as usize * height as usize] }
    }

    /// Width in texels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Height in texels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Radiance of a stored 1.
    pub fn scale(&self) -> f32 {
        self.scale
    }

    /// Row by row from the top: red in the lowest nine bits, green, blue, and the exponent of base 2 in the highest five.
    pub fn texels(&self) -> &[u32] {
        &self.texels
    }

    /// Puts texels of row `y` from column `x` on.
    pub(crate) fn put(&mut self, x: u32, y: u32, texels: &[Vec3]) {
        let largest = texels.iter().map(|texel| texel.max_element()).fold(0.0, f32::max);
        if largest > LARGEST * self.scale {
            let wanted = (largest / LARGEST).log2().ceil().min(MOST_SCALE);
            self.darken((wanted - self.scale.log2()) as i32);
        }
        let from_unit = 1.0 / self.scale;
        let start = y as usize * self.width as usize + x as usize;
        for (stored, texel) in self.texels[start..].iter_mut().zip(texels) {
            *stored = encode(*texel * from_unit);
        }
    }

    /// Multiplies the unit by a power of two, for what is brighter than all before.
    fn darken(&mut self, power: i32) {
        self.scale *= (power as f32).exp2();
        let factor = (-power as f32).exp2();
        self.texels
            .iter_mut()
            .filter(|texel| **texel != 0)
            .for_each(|texel| *texel = encode(decode(*texel) * factor));
    }

    fn get(&self, x: u32, y: u32) -> Vec3 {
        decode(self.texels[y as usize * self.width as usize + x as usize]) * self.scale
    }

    /// Bilinear radiance towards a unit direction, as [`crate::Equirect::lookup`] finds it.
    pub fn lookup(&self, direction: Vec3) -> Vec3 {
        interpolate(direction, [self.width, self.height], |x, y| self.get(x, y))
    }

    /// The same at half the size, for adapters that have no larger textures.
    #[must_use]
    pub fn halved(&self) -> Self {
        let [width, height] = [self.width, self.height].map(|side| (side / 2).max(1));
        let source = |x: u32, y: u32| {
            decode(
                self.texels
                    [y.min(self.height - 1) as usize * self.width as usize + x.min(self.width - 1) as usize],
            )
        };
        let texel = |x: u32, y: u32| {
            let [x, y] = [2 * x, 2 * y];
            encode((source(x, y) + source(x + 1, y) + source(x, y + 1) + source(x + 1, y + 1)) * 0.25)
        };
        let texels =
            (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| texel(x, y)).collect();
        Self { width, height, scale: self.scale, texels }
    }
}

/// The exponent of the largest channel is that of all (Vulkan 1.3, "Shared Exponent to RGB").
fn encode(color: Vec3) -> u32 {
    let largest = color.max_element().min(LARGEST);
    if largest <= 0.0 {
        return 0;
    }
    let above = ((largest.to_bits() >> 23) as i32 - 126).max(-BIAS);
    let unit = |above: i32| power_of_two(BITS - above);
    // Rounding may need one bit more.
    let above = if (largest * unit(above)).round() >= 512.0 { above + 1 } else { above };
    let unit = unit(above);
    // Converting clips at 0.
    let [r, g, b] = color.to_array().map(|channel| ((channel * unit + 0.5) as u32).min(511));
    r | g << 9 | b << 18 | ((above + BIAS) as u32) << 27
}

fn decode(texel: u32) -> Vec3 {
    let channel = |shift: u32| (texel >> shift & 511) as f32;
    Vec3::new(channel(0), channel(9), channel(18)) * power_of_two((texel >> 27) as i32 - BIAS - BITS)
}

/// Of an exponent of a normal float. Millions of texels ask for one.
fn power_of_two(exponent: i32) -> f32 {
    f32::from_bits(((exponent + 127) as u32) << 23)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colors_come_back_within_half_a_step_of_the_largest_channel() {
        for i in 0..4000_u32 {
            let channel = |k: u32| ((i * 7919 + k * 104_729) % 1009) as f32 / 1009.0;
            let color = Vec3::new(channel(0), channel(1), channel(2)) * (i as f32 / 134.0 - 14.0).exp2();
            let back = decode(encode(color));
            let largest = color.max_element();
            // Below 2^-15 steps shrink no more.
            let step = (largest / 512.0).max(power_of_two(-25));
            assert!((back - color).abs().max_element() <= step, "{color} {back}");
        }
        assert_eq!(decode(encode(Vec3::new(LARGEST, 0.0, 1.0))), Vec3::new(LARGEST, 0.0, 0.0));
        assert_eq!(decode(encode(Vec3::splat(511.9))), Vec3::splat(512.0));
        assert_eq!(encode(Vec3::ZERO), 0);
    }

    #[test]
    fn a_sun_that_comes_late_darkens_what_is_there() {
        let mut backdrop = Backdrop::new(4, 2);
        backdrop.put(0, 0, &[Vec3::splat(2.0); 4]);
        backdrop.put(1, 1, &[Vec3::new(3e9, 1e9, 0.0)]);
        assert_eq!(backdrop.get(3, 0), Vec3::splat(2.0));
        let off = backdrop.get(1, 1) - Vec3::new(3e9, 1e9, 0.0);
        assert!(off.abs().max_element() <= 3e9 / 512.0, "{off}");
        assert_eq!(backdrop.get(2, 1), Vec3::ZERO);
        backdrop.put(0, 1, &[Vec3::splat(f32::MAX)]);
        assert!((backdrop.get(0, 1).x / f32::MAX - 1.0).abs() < 3e-3);
    }

    #[test]
    fn half_the_size_has_the_means() {
        let mut backdrop = Backdrop::new(4, 2);
        for y in 0..2 {
            backdrop.put(0, y, &[1.0, 3.0, 0.0, 8.0].map(Vec3::splat));
        }
        let half = backdrop.halved();
        assert_eq!((half.width(), half.height()), (2, 1));
        assert_eq!([half.get(0, 0).x, half.get(1, 0).x], [2.0, 4.0]);
    }
}
