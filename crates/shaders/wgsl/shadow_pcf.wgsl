#import shadow_frame
#import receiver_plane
#import sample_pattern

// Percentage-closer filtering (Reeves et al. 1987): the mean of shadow tests over a disk of fixed size in the map. Every test is
// itself interpolated bilinearly between four texels.

@group(GROUP_SHADOW) @binding(0) var<uniform> parameters: PcfParameters;
@group(GROUP_SHADOW) @binding(1) var depth_maps: texture_depth_2d_array;
@group(GROUP_SHADOW) @binding(2) var lit_if_nearer: sampler_comparison;

fn visibility(light: u32, point: u32, position_world: vec3f, normal_world: vec3f, n: vec3f) -> f32 {
    let position = less_offset(light, position_world, normal_world, parameters.normal_offset_scale);
    let receiver = receiver_in_light(light, position, normal_world);
    if any(receiver.xy < vec2f(0.0)) || any(receiver.xy > vec2f(1.0)) {
        return 1.0;
    }
    let gradient = receiver_depth_gradient(light, position, normal_world, receiver);
    var lit = 0.0;
    for (var i = 0u; i < parameters.samples; i++) {
        let offset = parameters.radius_uv * vogel_disk(i, parameters.samples, 0.0);
        let d = receiver_plane_depth(receiver, gradient, offset) - lights[light].bias_scale * parameters.depth_bias;
        lit += textureSampleCompareLevel(depth_maps, lit_if_nearer, receiver.xy + offset, light, d);
    }
    return lit / f32(parameters.samples);
}
