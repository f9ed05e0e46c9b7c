#import view

// Where in its pixel a sample lies, and in the G-buffer. Samples of an even number a pixel's side lie on a rotated grid: no two of
// 2 x 2 share a row or column, so that edges that are almost upright or level have four steps instead of two. A raster has its
// samples in rows; so each of the four kinds is drawn by itself, moved, into a quarter of the G-buffer.

// Shifts stand for divisions by numbers that are powers of two: a whole division costs as much as the lookup it is for.

// From the middle of a sample's cell [samples]; `part` is its place among `view.interleave` x `view.interleave` neighbours.
fn sample_offset(part: vec2u) -> vec2f {
    if view.interleave == 1u {
        return vec2f(0.0);
    }
    return vec2f(select(-0.25, 0.25, part.y == 0u), select(0.25, -0.25, part.x == 0u));
}

// A sample's place in the picture, from its upper left corner [samples].
fn sample_place(sample: vec2u) -> vec2f {
    return vec2f(sample) + 0.5 + sample_offset(sample & vec2u(view.interleave - 1u));
}

// The same in normalised device coordinates.
fn ndc_of(sample: vec2u) -> vec2f {
    return sample_place(sample) / vec2f(view.size) * vec2f(2.0, -2.0) + vec2f(-1.0, 1.0);
}

// The `i`-th of four samples that are spread over a pixel of `side` samples a side.
fn spread_sample(corner: vec2u, side: u32, i: u32) -> vec2u {
    return corner + (vec2u(2u * (i & 1u) + (i >> 1u), 2u * (i >> 1u) + 1u - (i & 1u)) * side) / 4u;
}

// A sample's texel in the G-buffer.
fn gbuffer_texel(sample: vec2u) -> vec2u {
    let shift = vec2u(firstTrailingBit(view.interleave));
    return (sample & vec2u(view.interleave - 1u)) * (view.size >> shift) + (sample >> shift);
}

// By how much a part is moved, in clip space for w = 1, so that its samples fall on texel centres.
fn part_shift(number: u32) -> vec2f {
    let part = vec2u(number % view.interleave, number / view.interleave);
    let center = 0.5 * f32(view.interleave);
    let shift = center - (vec2f(part) + 0.5 + sample_offset(part));
    return vec2f(2.0, -2.0) * shift / vec2f(view.size);
}
