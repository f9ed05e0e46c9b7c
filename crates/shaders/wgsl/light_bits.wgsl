// 64 points of a square, a bit each: the i-th from the left lies in row i % 8, a little higher than the one eight before it. So no two share a column
// or a row.

// Those left of a place between 0 and 1.
fn bits_left_of(x: f32) -> vec2u {
    let count = vec2i(i32(clamp(64.0 * x + 0.5, 0.0, 64.0))) - vec2i(0, 32);
    let some = clamp(count, vec2i(0), vec2i(32));
    return select((vec2u(1u) << (vec2u(some) % 32u)) - 1u, vec2u(0xffffffffu), some == vec2i(32));
}

// Those above such a place.
fn bits_above(y: f32) -> vec2u {
    let count = u32(clamp(64.0 * y + 0.5, 0.0, 64.0));
    if count == 64u {
        return vec2u(0xffffffffu);
    }
    // Whole rows, and of the next one the first few.
    let rows = 0x01010101u * ((1u << (count / 8u)) - 1u);
    let some = bits_left_of(f32(8u * (count % 8u)) / 64.0) & vec2u(0x01010101u << (count / 8u));
    return vec2u(rows) | some;
}
