#import convolution_visibility

// Filtering by summed-area table (Crow 1984; Annen et al. 2008, section 4.1): the mean over a box of any width and height from
// the table's values at its corners. Tables hold differences to an unblocked texel's value, so what lies outside adds nothing.

// `footprint_scale` is made for the mip chain's bell-shaped kernels. Ringing suppression cuts less off the even slope that a box
// gives a penumbra, so a box needs less widening.
const BOX_SCALE: f32 = 0.85;

struct Kernel {
    half_texels: vec2f,
}

fn kernel_of(half_extent: vec2f) -> Kernel {
    // A box as wide as one texel is a bilinear lookup.
    return Kernel(max(BOX_SCALE * parameters.resolution * half_extent, vec2f(0.5)));
}

// Sum over all texels, the outermost in part, between the map's corner and `place` [texels].
fn sum_up_to(image: texture_2d_array<f32>, place: vec2f, layer: u32) -> vec4f {
    // A texel's centre holds the sum up to its far corner; before the first one the sum falls to 0.
    let inside = saturate(place);
    return inside.x * inside.y * textureSampleLevel(image, trilinear, (place - 0.5) / parameters.resolution, layer, 0.0);
}

fn filtered(image: texture_2d_array<f32>, uv: vec2f, layer: u32, kernel: Kernel, unblocked: vec4f) -> vec4f {
    let center = uv * parameters.resolution;
    let low = clamp(center - kernel.half_texels, vec2f(0.0), vec2f(parameters.resolution));
    let high = clamp(center + kernel.half_texels, vec2f(0.0), vec2f(parameters.resolution));
    let sum = (sum_up_to(image, high, layer) - sum_up_to(image, vec2f(low.x, high.y), layer))
        - (sum_up_to(image, vec2f(high.x, low.y), layer) - sum_up_to(image, low, layer));
    return unblocked + sum / (4.0 * kernel.half_texels.x * kernel.half_texels.y);
}
