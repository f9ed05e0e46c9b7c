#import types

// Nearest (x) and farthest (y) depth in ever larger squares of texels of depth maps, all layers at once: level by level, of two by two texels of the
// one before.

@group(GROUP_PASS) @binding(0) var depth_maps: texture_depth_2d_array;
@group(GROUP_PASS) @binding(1) var fine: texture_2d_array<f32>;
@group(GROUP_PASS) @binding(2) var coarse: texture_storage_2d_array<rg32float, write>;

@compute @workgroup_size(TILE, TILE)
fn first_level(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(coarse)) {
        return;
    }
    var range = vec2f(1.0, 0.0);
    for (var i = 0u; i < 4u; i++) {
        let depth = textureLoad(depth_maps, 2u * id.xy + vec2u(i & 1u, i >> 1u), id.z, 0);
        range = vec2f(min(range.x, depth), max(range.y, depth));
    }
    textureStore(coarse, id.xy, id.z, vec4f(range, 0.0, 0.0));
}

@compute @workgroup_size(TILE, TILE)
fn next_level(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(coarse)) {
        return;
    }
    var range = vec2f(1.0, 0.0);
    for (var i = 0u; i < 4u; i++) {
        let part = textureLoad(fine, 2u * id.xy + vec2u(i & 1u, i >> 1u), id.z, 0).xy;
        range = vec2f(min(range.x, part.x), max(range.y, part.y));
    }
    textureStore(coarse, id.xy, id.z, vec4f(range, 0.0, 0.0));
}
