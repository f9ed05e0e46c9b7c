#import types
#import depth_moments

// Moments of all lights' shadow maps.

@group(GROUP_PASS) @binding(0) var depth_maps: texture_depth_2d_array;
@group(GROUP_PASS) @binding(1) var moment_maps: texture_storage_2d_array<rgba32float, write>;

@compute @workgroup_size(TILE, TILE)
fn moments(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(depth_maps)) {
        return;
    }
    let z = textureLoad(depth_maps, id.xy, id.z, 0);
    textureStore(moment_maps, id.xy, id.z, depth_moments(2.0 * z - 1.0));
}
