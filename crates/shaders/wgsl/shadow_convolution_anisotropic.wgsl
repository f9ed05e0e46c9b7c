#import convolution_visibility

// Filtering by mip chain with the outline's variance along each axis of the map: level by the short side, up to MAX_TAPS trilinear
// lookups along the long one, as anisotropic texture filtering does it.

const MAX_TAPS: f32 = 4.0;
// `footprint_scale` is made for bell-shaped kernels. Ringing suppression cuts less off the even slope that a row of taps gives a penumbra.
const ROW_SCALE: f32 = 0.9;

struct Kernel {
    level: f32,
    taps: f32,
    // From one tap to the next.
    step_uv: vec2f,
}

fn kernel_of(half_extent: vec2f) -> Kernel {
    // A box of half width h has the variance h^2 / 3.
    let sides = parameters.resolution / sqrt(3.0 * LOOKUP_VARIANCE) * half_extent;
    let long = max(max(ROW_SCALE * max(sides.x, sides.y), min(sides.x, sides.y)), 1.0);
    // A light longer than MAX_TAPS times its width is filtered as a wider one.
    let short = max(min(sides.x, sides.y), max(long / MAX_TAPS, 1.0));
    let taps = clamp(ceil(long / short), 1.0, MAX_TAPS);
    // n points at distance s have the variance s^2 (n^2 - 1) / 12; together with a lookup's it is that of the long side.
    let missing = LOOKUP_VARIANCE * (long * long - short * short);
    let step = sqrt(12.0 * missing / max(taps * taps - 1.0, 1.0)) / parameters.resolution;
    let along = select(vec2f(0.0, 1.0), vec2f(1.0, 0.0), sides.x >= sides.y);
    return Kernel(min(level_from_width(short), parameters.max_level), taps, step * along);
}

fn filtered(image: texture_2d_array<f32>, uv: vec2f, layer: u32, kernel: Kernel, unblocked: vec4f) -> vec4f {
    var sum = vec4f(0.0);
    for (var tap = 0.0; tap < kernel.taps; tap += 1.0) {
        let place = uv + (tap - 0.5 * (kernel.taps - 1.0)) * kernel.step_uv;
        let share = share_in_map(place, exp2(kernel.level) / parameters.resolution);
        sum += mix(unblocked, textureSampleLevel(image, trilinear, place, layer, kernel.level), share);
    }
    return sum / kernel.taps;
}
