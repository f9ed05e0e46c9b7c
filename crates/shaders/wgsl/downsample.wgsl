// One mip level from the one above it: the mean of 2 x 2 texels, all layers of one texture at once.

@group(0) @binding(0) var fine: texture_2d_array<f32>;
@group(0) @binding(1) var coarse_rgba16: texture_storage_2d_array<rgba16float, write>;
@group(0) @binding(2) var coarse_r32: texture_storage_2d_array<r32float, write>;

fn mean_of_four(texel: vec2u, layer: u32) -> vec4f {
    let base = 2u * texel;
    return 0.25
        * (textureLoad(fine, base, layer, 0)
            + textureLoad(fine, base + vec2u(1u, 0u), layer, 0)
            + textureLoad(fine, base + vec2u(0u, 1u), layer, 0)
            + textureLoad(fine, base + vec2u(1u, 1u), layer, 0));
}

@compute @workgroup_size(8, 8)
fn downsample_rgba16(@builtin(global_invocation_id) id: vec3u) {
    if all(id.xy < textureDimensions(coarse_rgba16)) {
        textureStore(coarse_rgba16, id.xy, id.z, mean_of_four(id.xy, id.z));
    }
}

@compute @workgroup_size(8, 8)
fn downsample_r32(@builtin(global_invocation_id) id: vec3u) {
    if all(id.xy < textureDimensions(coarse_r32)) {
        textureStore(coarse_r32, id.xy, id.z, mean_of_four(id.xy, id.z));
    }
}
