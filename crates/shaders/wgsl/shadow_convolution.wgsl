#import convolution_visibility

// Filtering by mip chain, one trilinear lookup: the square kernel of the outline's mean variance.

struct Kernel {
    level: f32,
}

fn kernel_of(light: u32, width: f32) -> Kernel {
    return Kernel(min(level_from_width(width * lights[light].footprint * parameters.resolution), parameters.max_level));
}

fn filtered(image: texture_2d_array<f32>, uv: vec2f, layer: u32, kernel: Kernel, unblocked: vec4f) -> vec4f {
    return textureSampleLevel(image, trilinear, uv, layer, kernel.level);
}
