//! From radiance to a display: exposure, tone mapping, sRGB. The shader functions of the same names do the same arithmetic.

use glam::Vec3;
use gnomon_options::choices;

use crate::RgbImage;

choices! {
    /// How radiance is brought into the range of a display, after exposure and before sRGB encoding.
    pub enum ToneMapping {
        /// Khronos PBR Neutral: true colours below 0.76, highlights compressed and desaturated.
        Neutral = "neutral",
        /// Clip each channel to 0..1.
        Linear = "linear",
    }
}

impl ToneMapping {
    /// Display-linear colour in 0..1 of exposed radiance. NaN becomes 0.
    pub fn apply(self, color: Vec3) -> Vec3 {
        let color =
            Vec3::new(color.x.max(0.0), color.y.max(0.0), color.z.max(0.0)).min(Vec3::splat(f32::MAX));
        match self {
            Self::Linear => tone_map_linear(color),
            Self::Neutral => tone_map_neutral(color),
        }
    }
}

/// Clips each channel to 0..1.
pub fn tone_map_linear(color: Vec3) -> Vec3 {
    color.clamp(Vec3::ZERO, Vec3::ONE)
}

/// Khronos PBR Neutral tone mapper (KhronosGroup/ToneMapping, `PBR_Neutral/pbrNeutral.glsl`) for finite `color >= 0`;
/// the result is in 0..1. Base colours up to 0.8 under white light of radiance 1 come out as they are.
pub fn tone_map_neutral(color: Vec3) -> Vec3 {
    const START_COMPRESSION: f32 = 0.8 - 0.04;
    const DESATURATION: f32 = 0.15;
    let x = color.x.min(color.y).min(color.z);
    // The Fresnel reflection of 4 % that a white dielectric adds is taken off again.
    let offset = if x < 0.08 { x - 6.25 * x * x } else { 0.04 };
    let color = color - offset;
    let peak = color.x.max(color.y).max(color.z);
    if peak < START_COMPRESSION {
        return color;
    }
    let d = 1.0 - START_COMPRESSION;
    let new_peak = 1.0 - d * d / (peak + d - START_COMPRESSION);
    // Not `color * new_peak / peak`: the product overflows for radiance near the largest float.
    let color = color * (new_peak / peak);
    let g = 1.0 - 1.0 / (DESATURATION * (peak - new_peak) + 1.0);
    color + (Vec3::splat(new_peak) - color) * g
}

/// sRGB encoding of one display-linear channel in 0..1 (IEC 61966-2-1).
pub fn srgb_encode(linear: f32) -> f32 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// Inverse of [`srgb_encode`].
pub fn srgb_decode(encoded: f32) -> f32 {
    if encoded <= 0.040_45 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// Factor by which an exposure of `ev` stops multiplies radiance.
pub fn exposure_scale(ev: f32) -> f32 {
    ev.exp2()
}

/// A premultiplied picture divided by its alpha; black where that is 0.
pub fn straight(image: &RgbImage, alpha: &[f32]) -> RgbImage {
    let mut out = image.clone();
    for (texel, &alpha) in out.texels_mut().iter_mut().zip(alpha) {
        *texel = if alpha > 1e-6 { *texel / alpha } else { Vec3::ZERO };
    }
    out
}

/// Display-linear picture in 0..1: `tone_map(radiance * 2^ev)`, texel by texel.
pub fn tone_mapped(image: &RgbImage, mapping: ToneMapping, ev: f32) -> RgbImage {
    let scale = exposure_scale(ev);
    let mut out = image.clone();
    for texel in out.texels_mut() {
        *texel = mapping.apply(*texel * scale);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn srgb_matches_the_standard_at_its_published_points() {
        // IEC 61966-2-1: mid grey 0.5 encodes to 0.735357, 0.214041 decodes 0.5, the two branches meet.
        assert!((srgb_encode(0.5) - 0.735_357).abs() < 1e-5);
        assert!((srgb_encode(0.214_041_14) - 0.5).abs() < 1e-5);
        assert!((srgb_encode(0.003_130_8) - 0.040_449_9).abs() < 1e-5);
        assert_eq!((srgb_encode(0.0), srgb_encode(1.0)), (0.0, 1.055 - 0.055));
    }

    #[test]
    fn neutral_matches_values_worked_by_hand_from_the_published_formula() {
        // Grey 0.5: only the offset 0.04. White 1.0: peak 0.96, 1 - 0.24^2 / (0.96 + 0.24 - 0.76) = 0.8690909.
        assert!((tone_map_neutral(Vec3::splat(0.5)).x - 0.46).abs() < 1e-6);
        assert!((tone_map_neutral(Vec3::ONE).x - 0.869_090_9).abs() < 1e-6);
        // Red 4.0: offset 0, peak 4, new peak 1 - 0.0576 / 3.48 = 0.9834483, g = 1 - 1 / (0.15 * 3.0165517 + 1) = 0.3115189.
        let red = tone_map_neutral(Vec3::new(4.0, 0.0, 0.0));
        assert!((red.x - 0.983_448_3).abs() < 1e-5 && (red.y - 0.306_362_7).abs() < 1e-5, "{red}");
    }

    #[test]
    fn names_round_trip() {
        for rule in ToneMapping::ALL {
            assert_eq!(ToneMapping::from_name(rule.name()), Some(*rule));
        }
        assert_eq!(ToneMapping::from_name("filmic"), None);
    }

    #[test]
    fn exposure_counts_in_stops() {
        let image = RgbImage::filled(1, 1, Vec3::splat(0.1));
        assert_eq!(tone_mapped(&image, ToneMapping::Linear, 2.0).get(0, 0), Vec3::splat(0.4));
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(256))]
        #[test]
        fn srgb_round_trips(x in 0.0f32..=1.0) {
            prop_assert!((srgb_decode(srgb_encode(x)) - x).abs() < 2e-6);
        }

        #[test]
        fn every_mapping_stays_on_the_display(bits in any::<[u32; 3]>()) {
            let color = Vec3::from_array(bits.map(f32::from_bits));
            for rule in ToneMapping::ALL {
                let mapped = rule.apply(color);
                prop_assert!(mapped.min_element() >= 0.0 && mapped.max_element() <= 1.0, "{color} -> {mapped}");
            }
        }

        #[test]
        fn neutral_never_darkens_when_light_is_added(a in 0.0f32..50.0, b in 0.0f32..5.0) {
            let peak = |x: f32| tone_map_neutral(Vec3::splat(x)).x;
            prop_assert!(peak(a + b) >= peak(a) - 1e-6);
        }
    }
}
