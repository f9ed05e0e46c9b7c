//! Twins of `half_pairs.wgsl`: colours in halves.

use glam::Vec3;
use half::f16;

/// Two colours in six halves, those too large as the largest half.
pub fn pack_color_pair(first: Vec3, second: Vec3) -> [f16; 6] {
    let [a, b] = [first, second].map(|color| color.min(Vec3::splat(f16::MAX.to_f32())));
    [a.x, a.y, a.z, b.x, b.y, b.z].map(f16::from_f32)
}

/// The two colours.
pub fn unpack_color_pair(halves: [f16; 6]) -> [Vec3; 2] {
    let [a, b, c, d, e, f] = halves.map(f16::to_f32);
    [Vec3::new(a, b, c), Vec3::new(d, e, f)]
}
