use glam::Vec3;

use gnomon_picture::tonemap::srgb_decode;

/// Nodes of matplotlib's `magma` at multiples of 1/16, sRGB-encoded (van der Walt and Smith 2015, CC0).
const MAGMA: [Vec3; 17] = [
    Vec3::new(0.001, 0.000, 0.014),
    Vec3::new(0.040, 0.031, 0.134),
    Vec3::new(0.113, 0.065, 0.277),
    Vec3::new(0.212, 0.062, 0.419),
    Vec3::new(0.317, 0.072, 0.485),
    Vec3::new(0.415, 0.110, 0.505),
    Vec3::new(0.513, 0.148, 0.508),
    Vec3::new(0.614, 0.182, 0.499),
    Vec3::new(0.716, 0.215, 0.475),
    Vec3::new(0.817, 0.256, 0.436),
    Vec3::new(0.904, 0.320, 0.388),
    Vec3::new(0.961, 0.418, 0.360),
    Vec3::new(0.987, 0.536, 0.382),
    Vec3::new(0.996, 0.654, 0.446),
    Vec3::new(0.997, 0.770, 0.535),
    Vec3::new(0.992, 0.884, 0.640),
    Vec3::new(0.987, 0.991, 0.750),
];

/// Colour of a value in `[0, 1]` (clamped; NaN is 0) on the perceptually uniform `magma` map, black to pale yellow, as
/// linear display light.
pub fn magma(value: f32) -> Vec3 {
    let position = value.clamp(0.0, 1.0) * (MAGMA.len() - 1) as f32;
    // NaN survives the clamp and becomes index 0 with a NaN fraction.
    let position = if position.is_nan() { 0.0 } else { position };
    let index = (position as usize).min(MAGMA.len() - 2);
    let encoded = MAGMA[index].lerp(MAGMA[index + 1], position - index as f32);
    Vec3::from(encoded.to_array().map(srgb_decode))
}

#[cfg(test)]
mod tests {
    use gnomon_picture::LUMINANCE;

    use super::*;

    #[test]
    fn luminance_rises_all_the_way() {
        let luminances: Vec<f32> = (0..=100).map(|i| magma(i as f32 / 100.0).dot(LUMINANCE)).collect();
        assert!(luminances.windows(2).all(|pair| pair[0] < pair[1]));
        assert!(luminances[0] < 0.001 && luminances[100] > 0.9);
    }

    #[test]
    fn values_outside_are_clamped() {
        assert_eq!(magma(-1.0), magma(0.0));
        assert_eq!(magma(7.0), magma(1.0));
        assert_eq!(magma(f32::NAN), magma(0.0));
    }
}
