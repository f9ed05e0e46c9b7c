#import shadow_frame
#import receiver_plane
#import light_outline
#import lit_outline

// Percentage-closer soft shadows (Fernando 2005), filtered over the light's own outline, each of its points by what it adds to
// irradiance.

@group(GROUP_SHADOW) @binding(0) var<uniform> parameters: PcssParameters;
@group(GROUP_SHADOW) @binding(1) var depth_maps: texture_depth_2d_array;
@group(GROUP_SHADOW) @binding(2) var lit_if_nearer: sampler_comparison;

// Mean linear depth (x) and number (y) of the blockers found where the cone from the receiver to the light cuts the near plane.
fn blocker_search(light: u32, outline: Outline, receiver: vec4f, gradient: vec2f) -> vec2f {
    let scale = footprint_scale_uv(light, receiver.w, 0.0);
    let size = vec2i(textureDimensions(depth_maps));
    var sum = 0.0;
    var count = 0.0;
    for (var i = 0u; i < parameters.search_samples; i++) {
        let offset = scale * outline_point(outline, i, parameters.search_samples);
        // The map's margin is empty, so that clamping to it finds nothing.
        let texel = clamp(vec2i((receiver.xy + offset) * vec2f(size)), vec2i(0), size - 1);
        let z = textureLoad(depth_maps, texel, light, 0);
        if z < receiver_plane_depth(receiver, gradient, offset) - parameters.depth_bias {
            sum += z;
            count += 1.0;
        }
    }
    return vec2f(sum / max(count, 1.0), count);
}

fn visibility(light: u32, point: u32, position_world: vec3f, normal_world: vec3f, n: vec3f) -> f32 {
    let position = less_offset(light, position_world, normal_world, parameters.normal_offset_scale);
    let receiver = receiver_in_light(light, position, normal_world);
    if any(receiver.xy < vec2f(0.0)) || any(receiver.xy > vec2f(1.0)) {
        return 1.0;
    }
    let gradient = receiver_depth_gradient(light, position, normal_world, receiver);
    // Different lights take different points, so that their banding does not add up (Roberts 2018, R2).
    let outline = light_outline(light, fract(f32(light) * vec2f(0.7548777, 0.5698403)));
    let blockers = blocker_search(light, outline, receiver, gradient);
    if blockers.y == 0.0 {
        return 1.0;
    }
    let scale = footprint_scale_uv(light, receiver.w, blockers.x);
    let outline_seen = outline_from(light, position_world);
    var lit = 0.0;
    var weights = 0.0;
    for (var i = 0u; i < parameters.filter_samples; i++) {
        let point = outline_point(outline, i, parameters.filter_samples);
        let weight = irradiance_weight(outline_seen, n, point);
        weights += weight;
        if is_behind_surface(outline_seen, normal_world, point) {
            continue;
        }
        let offset = scale * point;
        let d = receiver_plane_depth(receiver, gradient, offset) - parameters.depth_bias;
        lit += weight * textureSampleCompareLevel(depth_maps, lit_if_nearer, receiver.xy + offset, light, d);
    }
    return lit / max(weights, 1e-9);
}
