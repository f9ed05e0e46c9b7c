//! Twins of `hit_normals.wgsl`.

use glam::{Vec2, Vec3};

use super::math::{octahedral_decode, octahedral_encode};

fn pack_20(n: Vec3) -> u32 {
    if n == Vec3::ZERO {
        return 0;
    }
    let q = ((octahedral_encode(n) * 0.5 + 0.5) * 1022.0 + 1.5).floor();
    q.x as u32 | (q.y as u32) << 10
}

fn unpack_20(bits: u32) -> Vec3 {
    if bits == 0 {
        return Vec3::ZERO;
    }
    let q = Vec2::new((bits & 0x3ff) as f32, (bits >> 10 & 0x3ff) as f32);
    octahedral_decode((q - 1.0) / 1022.0 * 2.0 - 1.0)
}

/// The normals of a triangle's corners, unit vectors or 0.
pub fn pack_thirds(a: Vec3, b: Vec3, c: Vec3) -> [u32; 2] {
    let middle = pack_20(b);
    [pack_20(a) | middle << 20, middle >> 12 | pack_20(c) << 8]
}

/// One of the three.
pub fn unpack_third(words: [u32; 2], which: usize) -> Vec3 {
    let [low, high] = words;
    unpack_20([low & 0xf_ffff, low >> 20 | (high & 0xff) << 12, high >> 8 & 0xf_ffff][which])
}
