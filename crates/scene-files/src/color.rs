//! Colours of vertices and faces as files have them.

use glam::Vec4;
use gnomon_picture::tonemap::srgb_decode;

/// Floats above this are of 0 to 255: brighter than white by so much no surface is.
const BRIGHTEST: f32 = 2.0;

/// What takes colours like these to linear ones: they are sRGB with linear alpha, of 0 to 1 or 0 to 255.
pub fn decoder(colors: &[Vec4]) -> impl Fn(Vec4) -> Vec4 + use<> {
    let scale = if is_of_bytes(colors) { 255_f32.recip() } else { 1.0 };
    move |color| {
        let [r, g, b] = (scale * color).truncate().to_array().map(srgb_decode);
        // Alpha that nobody gave is 1.
        Vec4::new(r, g, b, if color.w > 1.0 { color.w / 255.0 } else { color.w })
    }
}

/// Whether floats are of 0 to 255.
pub fn is_of_bytes(colors: &[Vec4]) -> bool {
    colors.iter().any(|color| color.truncate().max_element() > BRIGHTEST)
}
