// One mip level from the one above it, all layers of one texture at once, through the kernel [1 3 3 1] / 8 each way. Texels of
// a 2 x 2 box do not overlap, and the width of an edge seen through them would depend on where it falls.

@group(0) @binding(0) var fine: texture_2d_array<f32>;
@group(0) @binding(1) var coarse_rgba16: texture_storage_2d_array<rgba16float, write>;
@group(0) @binding(2) var coarse_r32: texture_storage_2d_array<r32float, write>;

fn filtered(texel: vec2u, layer: u32) -> vec4f {
    let last = vec2i(textureDimensions(fine)) - 1;
    var sum = vec4f(0.0);
    for (var y = 0; y < 4; y++) {
        for (var x = 0; x < 4; x++) {
            let position = clamp(2 * vec2i(texel) + vec2i(x, y) - 1, vec2i(0), last);
            let weight = select(1.0, 3.0, x == 1 || x == 2) * select(1.0, 3.0, y == 1 || y == 2) / 64.0;
            sum += weight * textureLoad(fine, position, layer, 0);
        }
    }
    return sum;
}

@compute @workgroup_size(8, 8)
fn downsample_rgba16(@builtin(global_invocation_id) id: vec3u) {
    if all(id.xy < textureDimensions(coarse_rgba16)) {
        textureStore(coarse_rgba16, id.xy, id.z, filtered(id.xy, id.z));
    }
}

@compute @workgroup_size(8, 8)
fn downsample_r32(@builtin(global_invocation_id) id: vec3u) {
    if all(id.xy < textureDimensions(coarse_r32)) {
        textureStore(coarse_r32, id.xy, id.z, filtered(id.xy, id.z));
    }
}
