#import math

// Point sets for filtering with few samples.

const GOLDEN_ANGLE: f32 = 2.39996323;

// Point `i` of `count` in the unit disk, evenly spread for any count (Vogel 1979), the whole turned by `rotation` [rad].
fn vogel_disk(i: u32, count: u32, rotation: f32) -> vec2f {
    let radius = sqrt((f32(i) + 0.5) / f32(count));
    let angle = f32(i) * GOLDEN_ANGLE + rotation;
    return radius * vec2f(cos(angle), sin(angle));
}

// Point `i` of `count` in the unit square (Hammersley), at the middle of its strata in both coordinates.
fn hammersley(i: u32, count: u32) -> vec2f {
    // The reversed bits' top 24: what an f32 holds, so that no point rounds up to 1.
    let radical_inverse = f32(reverseBits(i) >> 8u) / 16777216.0;
    return vec2f((f32(i) + 0.5) / f32(count), radical_inverse + 0.5 / exp2(ceil(log2(f32(count)))));
}
