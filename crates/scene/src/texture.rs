use std::sync::LazyLock;

use glam::{Vec2, Vec4};
use gnomon_picture::tonemap::srgb_decode;

use crate::{Texture, Wrap};

/// sRGB code value to linear light, 0..1 (IEC 61966-2-1).
static LINEAR_FROM_SRGB8: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|code| srgb_decode(code as f32 / 255.0)));

impl Wrap {
    /// Index in `0..size` of the texel that stands at an index, which may lie outside.
    pub fn texel(self, index: i64, size: u32) -> usize {
        let size = i64::from(size);
        let wrapped = match self {
            Self::Repeat => index.rem_euclid(size),
            Self::MirroredRepeat => {
                let period = index.rem_euclid(2 * size);
                period.min(2 * size - 1 - period)
            }
            Self::ClampToEdge => index.clamp(0, size - 1),
        };
        wrapped as usize
    }
}

impl Texture {
    /// Filtered RGBA, 0..1, of a texture that holds linear values. `uv` is (0, 0) at the top left corner of the picture
    /// and (1, 1) at its bottom right; a coordinate that is not finite counts as 0.
    pub fn sample_linear(&self, uv: Vec2) -> Vec4 {
        self.sample(uv, |texel| Vec4::from_array(texel.map(|code| f32::from(code) / 255.0)))
    }

    /// The same for a texture that holds sRGB colour: decoded to linear light before it is filtered; alpha is linear.
    pub fn sample_srgb(&self, uv: Vec2) -> Vec4 {
        let table = &*LINEAR_FROM_SRGB8;
        self.sample(uv, |[r, g, b, a]| {
            Vec4::new(table[r as usize], table[g as usize], table[b as usize], f32::from(a) / 255.0)
        })
    }

    fn sample(&self, uv: Vec2, decode: impl Fn([u8; 4]) -> Vec4) -> Vec4 {
        // Texel centres lie at half-integers; coordinates beyond i64 saturate in the cast.
        let place = |value: f32, size: u32| {
            if value.is_finite() { f64::from(value) * f64::from(size) } else { 0.0 }
        };
        let (x, y) = (place(uv.x, self.width), place(uv.y, self.height));
        let texel = |x: i64, y: i64| {
            let (x, y) = (self.wrap[0].texel(x, self.width), self.wrap[1].texel(y, self.height));
            decode(self.rgba8[y * self.width as usize + x])
        };
        if self.nearest {
            return texel(x.floor() as i64, y.floor() as i64);
        }
        let (x, y) = (x - 0.5, y - 0.5);
        let (fx, fy) = ((x - x.floor()) as f32, (y - y.floor()) as f32);
        let (x, y) = (x.floor() as i64, y.floor() as i64);
        let row = |y: i64| texel(x, y).lerp(texel(x.saturating_add(1), y), fx);
        row(y).lerp(row(y.saturating_add(1)), fy)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp(wrap: Wrap) -> Texture {
        let rgba8 = [0u8, 100, 200, 40].map(|v| [v, v, v, 255]).to_vec();
        Texture { width: 4, height: 1, rgba8, wrap: [wrap; 2], nearest: false }
    }

    #[test]
    fn texel_centres_return_the_texel_and_midpoints_the_mean() {
        let texture = ramp(Wrap::ClampToEdge);
        let at = |u: f32| texture.sample_linear(Vec2::new(u, 0.5)).x * 255.0;
        for (u, expected) in
            [(0.125, 0.0), (0.375, 100.0), (0.5, 150.0), (0.875, 40.0), (5.0, 40.0), (-3.0, 0.0)]
        {
            assert!((at(u) - expected).abs() < 1e-3, "u = {u}: {} instead of {expected}", at(u));
        }
    }

    #[test]
    fn wraps_follow_gl() {
        let at = |wrap, u: f32| ramp(wrap).sample_linear(Vec2::new(u, 0.0)).x * 255.0;
        // Across the edge, a repeating texture blends its last and first texel.
        assert!((at(Wrap::Repeat, 1.0) - 20.0).abs() < 1e-3);
        assert!((at(Wrap::Repeat, 1.375) - 100.0).abs() < 1e-3);
        assert!((at(Wrap::Repeat, -0.125) - 40.0).abs() < 1e-3);
        assert!((at(Wrap::MirroredRepeat, 1.0) - 40.0).abs() < 1e-3);
        assert!((at(Wrap::MirroredRepeat, 1.375) - 200.0).abs() < 1e-3);
        assert!((at(Wrap::MirroredRepeat, -0.375) - 100.0).abs() < 1e-3);
    }

    #[test]
    fn srgb_is_decoded_before_filtering_and_alpha_is_not() {
        let rgba8 = vec![[0, 0, 0, 0], [255, 188, 255, 255]];
        let texture = Texture { width: 2, height: 1, rgba8, wrap: [Wrap::ClampToEdge; 2], nearest: false };
        let half = texture.sample_srgb(Vec2::splat(0.5));
        assert!((half.x - 0.5).abs() < 1e-6);
        assert!((half.w - 0.5).abs() < 1e-6);
        // sRGB 188 is 0.5029 in linear light (IEC 61966-2-1).
        assert!((half.y - 0.25143).abs() < 1e-4, "{}", half.y);
    }

    #[test]
    fn any_coordinate_is_defined() {
        for wrap in [Wrap::Repeat, Wrap::MirroredRepeat, Wrap::ClampToEdge] {
            for u in [f32::NAN, f32::INFINITY, f32::MIN, f32::MAX, 1e19, -1e19] {
                let sample = ramp(wrap).sample_linear(Vec2::new(u, -u));
                assert!(sample.is_finite());
            }
        }
    }
}
