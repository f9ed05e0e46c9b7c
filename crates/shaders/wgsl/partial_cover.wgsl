// Surfaces that stop a share of the rays, in images that hold one surface a texel: that share of neighbouring texels shows them.
// Thresholds are a lattice of low discrepancy (Roberts 2018, R2) in whole numbers, so that any few neighbours come near to the share. Twin:
// `partial_cover.rs`.

// Of a surface, from what tells it from others before or behind it. Equal keys cover the same texels; both sides of a body never do.
fn cover_key(slab: u32, material: u32, is_front: bool) -> u32 {
    var key = (slab * 0x85ebca6bu) ^ (material * 0xc2b2ae35u);
    key = (key ^ (key >> 16u)) * 0x7feb352du;
    key = (key ^ (key >> 15u)) * 0x846ca68bu;
    return ((key ^ (key >> 16u)) & 0xfffffffeu) | u32(is_front);
}

// Whether a texel shows a surface of this opacity. One of four lattices: two that differ cover each other by chance.
fn is_covered(opacity: f32, texel: vec2u, key: u32) -> bool {
    let place = select(texel, texel.yx, (key & 1u) != 0u);
    let second = select(2447445414u, 1847521882u, (key & 2u) != 0u);
    let threshold = place.x * 3242174889u + place.y * second + key;
    return f32(threshold >> 8u) / 16777216.0 < opacity;
}
