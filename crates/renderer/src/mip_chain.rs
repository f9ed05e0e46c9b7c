//! Mip levels of textures that hold more than colours of pictures.

use glam::Vec4;

/// Box-filtered levels of `width` x `height` texels down to one texel, the first as it is given. Odd sizes drop their last row or column.
pub(crate) fn mip_chain(fine: Vec<Vec4>, [mut width, mut height]: [usize; 2]) -> Vec<Vec<Vec4>> {
    let mut levels = vec![fine];
    while width > 1 || height > 1 {
        let [w, h] = [(width / 2).max(1), (height / 2).max(1)];
        let coarse = levels.last().map(|fine| {
            let at = |x: usize, y: usize| fine[y.min(height - 1) * width + x.min(width - 1)];
            let mean = |i: usize| {
                let (x, y) = (2 * (i % w), 2 * (i / w));
                0.25 * (at(x, y) + at(x + 1, y) + at(x, y + 1) + at(x + 1, y + 1))
            };
            (0..w * h).map(mean).collect()
        });
        levels.extend(coarse);
        [width, height] = [w, h];
    }
    levels
}

/// The bytes of levels in halves.
pub(crate) fn half_bytes(levels: &[Vec<Vec4>]) -> impl Iterator<Item = Vec<u8>> {
    let bytes =
        |texel: &Vec4| texel.to_array().map(|value| half::f16::from_f32(value).to_le_bytes()).concat();
    levels.iter().map(move |level| level.iter().flat_map(bytes).collect())
}
