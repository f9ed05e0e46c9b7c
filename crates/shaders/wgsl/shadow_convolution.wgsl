#import convolution_visibility

// Filtering by mip chain, one trilinear lookup: the square kernel of the outline's mean variance.

struct Kernel {
    level: f32,
}

fn kernel_of(half_extent: vec2f) -> Kernel {
    // A box of half widths a, b has the variance (a^2 + b^2) / 6 on average.
    let width = length(half_extent) / sqrt(6.0 * LOOKUP_VARIANCE);
    return Kernel(min(level_from_width(parameters.resolution * width), parameters.max_level));
}

fn filtered(image: texture_2d_array<f32>, uv: vec2f, layer: u32, kernel: Kernel, unblocked: vec4f) -> vec4f {
    let share = share_in_map(uv, exp2(kernel.level) / parameters.resolution);
    return mix(unblocked, textureSampleLevel(image, trilinear, uv, layer, kernel.level), share);
}
