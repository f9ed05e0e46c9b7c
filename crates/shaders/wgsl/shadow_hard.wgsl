#import shadow_frame

// Projective shadow map with a z-buffer test from the light's centre (Williams 1978; Heidrich 2001, section 2): both depths as
// a z-buffer stores them, after the perspective division. In the maps of distant lights, which have no perspective, these are
// linear depths.

@group(GROUP_SHADOW) @binding(0) var<uniform> hard_parameters: HardParameters;
@group(GROUP_SHADOW) @binding(1) var depth_maps: texture_depth_2d_array;

// What a z-buffer stores for a point of linear depth `linear`: f / (f - n) (w - n) / w at the distance w between near and far plane.
fn projected_depth(light: u32, linear: f32) -> f32 {
    if lights[light].kind == KIND_DISTANT {
        return linear;
    }
    let near = lights[light].near_world;
    let range = lights[light].depth_range_world;
    return linear * (near + range) / (near + linear * range);
}

fn visibility(light: u32, point: u32, position_world: vec3f, normal_world: vec3f, n: vec3f) -> f32 {
    let receiver = receiver_in_light(light, position_world, normal_world);
    let size = vec2i(textureDimensions(depth_maps));
    let texel = vec2i(floor(receiver.xy * vec2f(size)));
    if any(texel < vec2i(0)) || any(texel >= size) {
        return 1.0;
    }
    let stored = textureLoad(depth_maps, texel, light, 0);
    return select(0.0, 1.0, projected_depth(light, receiver.z) - lights[light].bias_scale * hard_parameters.depth_bias <= stored);
}
