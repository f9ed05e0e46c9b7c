#import types

// One mip level from the one above it, all layers of one texture at once, through the kernel [1 3 3 1] / 8 each way. Texels of
// a 2 x 2 box do not overlap, and the width of an edge seen through them would depend on where it falls.

@group(GROUP_PASS) @binding(0) var fine: texture_2d_array<f32>;
@group(GROUP_PASS) @binding(1) var coarse_rgba16: texture_storage_2d_array<rgba16float, write>;
@group(GROUP_PASS) @binding(2) var coarse_r32: texture_storage_2d_array<r32float, write>;
@group(GROUP_PASS) @binding(3) var bilinear: sampler;
@group(GROUP_PASS) @binding(4) var coarse_rgba32: texture_storage_2d_array<rgba32float, write>;

fn filtered(texel: vec2u, layer: u32) -> vec4f {
    let size = vec2f(textureDimensions(fine));
    let center = 2.0 * vec2f(texel) + 1.0;
    // A bilinear lookup a quarter texel from a centre weighs its two texels 3 to 1: four of them are the 16 taps.
    let low = (center - 0.75) / size;
    let high = (center + 0.75) / size;
    return 0.25
        * (textureSampleLevel(fine, bilinear, low, layer, 0.0)
            + textureSampleLevel(fine, bilinear, vec2f(high.x, low.y), layer, 0.0)
            + textureSampleLevel(fine, bilinear, vec2f(low.x, high.y), layer, 0.0)
            + textureSampleLevel(fine, bilinear, high, layer, 0.0));
}

@compute @workgroup_size(TILE, TILE)
fn downsample_rgba16(@builtin(global_invocation_id) id: vec3u) {
    if all(id.xy < textureDimensions(coarse_rgba16)) {
        textureStore(coarse_rgba16, id.xy, id.z, filtered(id.xy, id.z));
    }
}

@compute @workgroup_size(TILE, TILE)
fn downsample_r32(@builtin(global_invocation_id) id: vec3u) {
    if all(id.xy < textureDimensions(coarse_r32)) {
        textureStore(coarse_r32, id.xy, id.z, filtered(id.xy, id.z));
    }
}

@compute @workgroup_size(TILE, TILE)
fn downsample_rgba32(@builtin(global_invocation_id) id: vec3u) {
    if all(id.xy < textureDimensions(coarse_rgba32)) {
        textureStore(coarse_rgba32, id.xy, id.z, filtered(id.xy, id.z));
    }
}
