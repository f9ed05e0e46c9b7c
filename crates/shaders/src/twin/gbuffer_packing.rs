//! Twins of `gbuffer_packing.wgsl`.

use glam::{UVec4, Vec2, Vec3, Vec4};
use gnomon_brdf::Frame;
use half::f16;

use super::math::{octahedral_decode, octahedral_encode};

/// What a sample of the G-buffer shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PackedSurface {
    /// Tangent frame.
    pub frame: Frame,
    /// Normal of the triangle.
    pub geometric_normal: Vec3,
    /// Number of the material.
    pub material: u32,
    /// What textures say of what lies on the base: [`pack_coat`].
    pub finish: u32,
    /// Factor of the material's own.
    pub base_color: Vec3,
    /// Factor of the material's own.
    pub emission: Vec3,
    /// Factor of the material's own.
    pub specular_color: Vec3,
    /// Factor of the material's own.
    pub specular: f32,
    /// Factor of the material's own.
    pub roughness: f32,
    /// Factor of the material's own.
    pub metallic: f32,
}

/// `x` in 0..1 as a whole number of `steps`.
fn unorm(x: f32, steps: f32) -> u32 {
    (x.clamp(0.0, 1.0) * steps + 0.5) as u32
}

fn snorm16(x: f32) -> u32 {
    u32::from((x.clamp(-1.0, 1.0) * 32767.0 + 0.5).floor() as i16 as u16)
}

fn from_snorm16(bits: u32) -> f32 {
    (f32::from(bits as u16 as i16) / 32767.0).max(-1.0)
}

fn half(x: f32) -> u32 {
    u32::from(f16::from_f32(x).to_bits())
}

fn from_half(bits: u32) -> f32 {
    f16::from_bits(bits as u16).to_f32()
}

/// Two words of 16 bits: the octahedral map.
pub fn pack_normal(n: Vec3) -> u32 {
    let e = octahedral_encode(n);
    snorm16(e.x) | snorm16(e.y) << 16
}

/// Inverse of [`pack_normal`].
pub fn unpack_normal(word: u32) -> Vec3 {
    octahedral_decode(Vec2::new(from_snorm16(word), from_snorm16(word >> 16)))
}

/// 15 bits of the tangent's angle in [`Frame::from_normal`], and one for the bitangent's sign. `n` as it was unpacked.
pub fn pack_tangent(n: Vec3, frame: &Frame) -> u32 {
    let local = Frame::from_normal(n).local_from_world(frame.t);
    let turns = local.y.atan2(local.x) / std::f32::consts::TAU;
    let angle = ((turns + 1.0) * 32768.0 + 0.5).floor() as u32 & 0x7fff;
    u32::from(frame.n.cross(frame.t).dot(frame.b) < 0.0) << 15 | angle
}

/// Inverse of [`pack_tangent`].
pub fn unpack_frame(n: Vec3, bits: u32) -> Frame {
    let (sin, cos) = ((bits & 0x7fff) as f32 * (std::f32::consts::TAU / 32768.0)).sin_cos();
    let t = Frame::from_normal(n).world_from_local(Vec3::new(cos, sin, 0.0));
    Frame { t, b: n.cross(t) * if bits & 0x8000 == 0 { 1.0 } else { -1.0 }, n }
}

fn power_of_two(exponent: i32) -> f32 {
    f32::from_bits(((exponent + 127) as u32) << 23)
}

/// Nine bits a channel and a common exponent of five (EXT_texture_shared_exponent).
pub fn pack_rgb9e5(color: Vec3) -> u32 {
    let clamped = color.clamp(Vec3::ZERO, Vec3::splat(65408.0));
    let largest = clamped.max_element();
    let mut exponent = ((largest.to_bits() >> 23) as i32 - 127).max(-16) + 16;
    if (largest / power_of_two(exponent - 24) + 0.5).floor() >= 512.0 {
        exponent += 1;
    }
    let [r, g, b] = (clamped / power_of_two(exponent - 24) + 0.5).floor().to_array().map(|m| m as u32);
    r | g << 9 | b << 18 | (exponent as u32) << 27
}

/// Inverse of [`pack_rgb9e5`].
pub fn unpack_rgb9e5(word: u32) -> Vec3 {
    Vec3::from([0, 9, 18].map(|shift| (word >> shift & 0x1ff) as f32))
        * power_of_two((word >> 27) as i32 - 24)
}

fn pack_signed_root(x: f32) -> u32 {
    (512.5 + 511.0 * x.abs().min(1.0).sqrt().copysign(x)) as u32
}

fn unpack_signed_root(bits: u32) -> f32 {
    let root = ((bits & 0x3ff) as f32 - 512.0) / 511.0;
    root * root.abs()
}

/// What textures multiply strength and roughness of the clear coat with, and x and y of its normal in the tangent frame.
pub fn pack_coat(clearcoat: f32, roughness: f32, tilt: Vec2) -> u32 {
    let [strength, roughness] = [clearcoat, roughness].map(|value| unorm(value.clamp(0.0, 1.0).sqrt(), 63.0));
    strength | roughness << 6 | pack_signed_root(tilt.x) << 12 | pack_signed_root(tilt.y) << 22
}

/// Inverse of [`pack_coat`].
pub fn unpack_coat(word: u32) -> Vec4 {
    let [strength, roughness] = [word, word >> 6].map(|bits| (bits & 63) as f32 / 63.0);
    Vec4::new(
        strength * strength,
        roughness * roughness,
        unpack_signed_root(word >> 12),
        unpack_signed_root(word >> 22),
    )
}

/// What textures multiply colour and roughness of the sheen with.
pub fn pack_sheen(color: Vec3, roughness: f32) -> u32 {
    let [r, g, b, a] = color
        .clamp(Vec3::ZERO, Vec3::ONE)
        .map(f32::sqrt)
        .extend(roughness)
        .to_array()
        .map(|v| unorm(v, 255.0));
    r | g << 8 | b << 16 | a << 24
}

/// Inverse of [`pack_sheen`].
pub fn unpack_sheen(word: u32) -> Vec4 {
    let roots = Vec4::from([0, 8, 16, 24].map(|shift| (word >> shift & 0xff) as f32 / 255.0));
    (roots.truncate() * roots.truncate()).extend(roots.w)
}

/// Normals, tangent and material, and what lies on the base.
pub fn pack_geometry(surface: &PackedSurface) -> UVec4 {
    let normal = pack_normal(surface.frame.n);
    let tangent = pack_tangent(unpack_normal(normal), &surface.frame);
    UVec4::new(
        normal,
        pack_normal(surface.geometric_normal),
        tangent | surface.material << 16,
        surface.finish,
    )
}

/// Colours, roughness and metallic.
pub fn pack_reflectance(surface: &PackedSurface) -> UVec4 {
    let [r, g, b] = surface.base_color.clamp(Vec3::ZERO, Vec3::splat(65504.0)).to_array().map(half);
    let roughness = unorm(surface.roughness.clamp(0.0, 1.0).sqrt(), 1023.0);
    let metallic = unorm(surface.metallic, 127.0);
    let [x, y, z, w] =
        surface.specular_color.map(f32::sqrt).extend(surface.specular).to_array().map(|v| unorm(v, 255.0));
    UVec4::new(
        r | g << 16,
        b | roughness << 15 | metallic << 25,
        pack_rgb9e5(surface.emission),
        x | y << 8 | z << 16 | w << 24,
    )
}

/// Inverse of [`pack_geometry`] and [`pack_reflectance`].
pub fn unpack_surface(geometry: UVec4, reflectance: UVec4) -> PackedSurface {
    let root = (reflectance.y >> 15 & 0x3ff) as f32 / 1023.0;
    let specular = Vec4::from([0, 8, 16, 24].map(|shift| (reflectance.w >> shift & 0xff) as f32 / 255.0));
    PackedSurface {
        frame: unpack_frame(unpack_normal(geometry.x), geometry.z),
        geometric_normal: unpack_normal(geometry.y),
        material: geometry.z >> 16,
        finish: geometry.w,
        base_color: Vec3::new(
            from_half(reflectance.x),
            from_half(reflectance.x >> 16),
            from_half(reflectance.y & 0x7fff),
        ),
        emission: unpack_rgb9e5(reflectance.z),
        specular_color: specular.truncate() * specular.truncate(),
        specular: specular.w,
        roughness: root * root,
        metallic: (reflectance.y >> 25) as f32 / 127.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_no_texture_changes_comes_back_exactly() {
        for (tangent, bitangent_sign, material) in [(Vec3::X, 1.0, 0), (Vec3::Z, -1.0, 65535)] {
            let frame = Frame::from_tangent(Vec3::Y, tangent.extend(bitangent_sign));
            let surface = PackedSurface {
                frame,
                geometric_normal: Vec3::NEG_Z,
                material,
                finish: pack_coat(1.0, 0.0, Vec2::ZERO),
                base_color: Vec3::ONE,
                emission: Vec3::ONE,
                specular_color: Vec3::ONE,
                specular: 1.0,
                roughness: 1.0,
                metallic: 1.0,
            };
            let back = unpack_surface(pack_geometry(&surface), pack_reflectance(&surface));
            assert!(back.frame.t.distance(tangent) < 1e-4 && back.frame.b.distance(frame.b) < 1e-4);
            assert_eq!(PackedSurface { frame, ..back }, surface);
        }
    }

    #[test]
    fn a_coat_without_textures_comes_back_exactly() {
        assert_eq!(unpack_coat(pack_coat(1.0, 1.0, Vec2::ZERO)), Vec4::new(1.0, 1.0, 0.0, 0.0));
        assert_eq!(unpack_coat(pack_coat(0.0, 0.0, Vec2::new(1.0, -1.0))), Vec4::new(0.0, 0.0, 1.0, -1.0));
    }

    #[test]
    fn shared_exponents_keep_small_and_large_colours() {
        for color in [Vec3::ZERO, Vec3::new(1e-3, 0.5, 0.999), Vec3::new(4e4, 1.0, 6e4), Vec3::splat(511.5)] {
            let back = unpack_rgb9e5(pack_rgb9e5(color));
            // Nine bits of the largest component: half a step is at most a 512th of it.
            assert!((back - color).abs().max_element() <= color.max_element() / 512.0, "{color}: {back}");
        }
    }
}
