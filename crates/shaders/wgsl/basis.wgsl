#import types
#import series

// Basis images of all lights' shadow maps: B_k = sin(c_k z), cos(c_k z), and the CSM-Z images z B_k (Annen et al. 2008,
// section 3.2). Layer `light * groups + group` holds terms 4 group + 1 .. 4 group + 4.

@group(GROUP_PASS) @binding(0) var<uniform> parameters: ConvolutionParameters;
@group(GROUP_PASS) @binding(1) var depth_maps: texture_depth_2d_array;
@group(GROUP_PASS) @binding(2) var basis_sin: texture_storage_2d_array<rgba16float, write>;
@group(GROUP_PASS) @binding(3) var basis_cos: texture_storage_2d_array<rgba16float, write>;
@group(GROUP_PASS) @binding(4) var basis_z_sin: texture_storage_2d_array<rgba16float, write>;
@group(GROUP_PASS) @binding(5) var basis_z_cos: texture_storage_2d_array<rgba16float, write>;

@group(GROUP_PASS) @binding(6) var linear_depth: texture_storage_2d_array<r32float, write>;

@compute @workgroup_size(TILE, TILE)
fn basis(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(depth_maps)) {
        return;
    }
    let light = id.z / parameters.groups;
    let group = id.z % parameters.groups;
    let z = SERIES_DEPTH_SCALE * textureLoad(depth_maps, id.xy, light, 0);
    let phases = series_phases(z, group);
    textureStore(basis_sin, id.xy, id.z, phases[1]);
    textureStore(basis_cos, id.xy, id.z, phases[0]);
    textureStore(basis_z_sin, id.xy, id.z, z * phases[1]);
    textureStore(basis_z_cos, id.xy, id.z, z * phases[0]);
}

@compute @workgroup_size(TILE, TILE)
fn basis_depth(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(depth_maps)) {
        return;
    }
    let z = SERIES_DEPTH_SCALE * textureLoad(depth_maps, id.xy, id.z, 0);
    textureStore(linear_depth, id.xy, id.z, vec4f(z, 0.0, 0.0, 0.0));
}
