#import shadow_frame

// Shadow map of linear depth, compared by subtraction (Heidrich 2001, section 2.1): the depth range is resolved evenly, where a
// perspective z-buffer resolves near points more finely than far ones. Under an orthographic map both are the same.

@group(GROUP_SHADOW) @binding(0) var<uniform> parameters: HardParameters;
@group(GROUP_SHADOW) @binding(1) var depth_maps: texture_depth_2d_array;

fn visibility(light: u32, point: u32, position_world: vec3f, normal_world: vec3f, n: vec3f) -> f32 {
    let receiver = receiver_in_light(light, position_world, normal_world);
    let size = vec2i(textureDimensions(depth_maps));
    let texel = vec2i(floor(receiver.xy * vec2f(size)));
    if any(texel < vec2i(0)) || any(texel >= size) {
        return 1.0;
    }
    let z = textureLoad(depth_maps, texel, light, 0);
    return select(1.0, 0.0, receiver.z - z > lights[light].bias_scale * parameters.depth_bias);
}
