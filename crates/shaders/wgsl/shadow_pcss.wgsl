#import shadow_frame
#import receiver_plane
#import light_outline
#import lit_outline

// Percentage-closer soft shadows (Fernando 2005), filtered over the light's own outline, each of its points by what it adds to
// irradiance.

@group(GROUP_SHADOW) @binding(0) var<uniform> parameters: PcssParameters;
@group(GROUP_SHADOW) @binding(1) var depth_maps: texture_depth_2d_array;
@group(GROUP_SHADOW) @binding(2) var lit_if_nearer: sampler_comparison;

// Blockers are also looked for in narrower cones, this share of the whole one and less: what is near to the receiver fills little of the whole
// cone, but may hide all of the light.
const NEAR: f32 = 0.4;
const NEAREST: f32 = 0.02;
// Nothing counts as near whose penumbra would be narrower than so many texels, if the light were 90 degrees wide: a curved surface would hide itself.
const LEAST_TEXELS: f32 = 2.0;
// Blockers up to so many times as far as the near ones are on average count among them.
const NEAR_REACH: f32 = 2.5;
// What is seen of the near ones in so small a share of their kernel tells nothing.
const LEAST_TOLD: f32 = 0.1;

// Linear depth of what the map holds `offset` uv beside a receiver.
fn map_depth(light: u32, receiver: vec4f, offset: vec2f) -> f32 {
    let size = vec2i(textureDimensions(depth_maps));
    // The margin of a map of the whole scene is empty: clamping to it finds nothing. That of a slice of the view lies half a penumbra
    // beyond what is seen.
    let texel = clamp(vec2i((receiver.xy + offset) * vec2f(size)), vec2i(0), size - 1);
    return textureLoad(depth_maps, texel, light, 0);
}

// Mean linear depth (x) and number (y) of the blockers found where the cone from the receiver to the light cuts the near plane.
fn blocker_search(light: u32, outline: Outline, receiver: vec4f, gradient: vec2f) -> vec2f {
    let scale = footprint_scale_uv(light, receiver.w, 0.0);
    var sum = 0.0;
    var count = 0.0;
    for (var i = 0u; i < parameters.search_samples; i++) {
        let offset = scale * outline_point(outline, i, parameters.search_samples);
        let z = map_depth(light, receiver, offset);
        if z < receiver_plane_depth(receiver, gradient, offset) - lights[light].bias_scale * parameters.depth_bias {
            sum += z;
            count += 1.0;
        }
    }
    return vec2f(sum / max(count, 1.0), count);
}

// The same of blockers near to the receiver: each sample in a narrower cone than the one before, of what lies within that cone's share of the
// way to the near plane.
fn near_blocker_search(light: u32, outline: Outline, receiver: vec4f, gradient: vec2f) -> vec2f {
    let scale = footprint_scale_uv(light, receiver.w, 0.0);
    let least = LEAST_TEXELS / f32(textureDimensions(depth_maps).x);
    let samples = max(parameters.search_samples / 2u, 1u);
    let step = pow(NEAREST / NEAR, 1.0 / f32(samples));
    var share = NEAR;
    var sum = 0.0;
    var count = 0.0;
    for (var i = 0u; i < samples; i++) {
        let offset = share * scale * outline_point(outline, i, samples);
        let z = map_depth(light, receiver, offset);
        if z >= receiver.w * (1.0 - share) && footprint_scale_uv(light, receiver.w, z) >= least
            && z < receiver_plane_depth(receiver, gradient, offset) - lights[light].bias_scale * parameters.depth_bias {
            sum += z;
            count += 1.0;
        }
        share *= step;
    }
    return vec2f(sum / max(count, 1.0), count);
}

// A receiver, and the light's outline as it sees it.
struct Seen {
    light: u32,
    outline: Outline,
    outline_seen: mat3x3f,
    receiver: vec4f,
    gradient: vec2f,
    normal_world: vec3f,
    n: vec3f,
}

// Share of the light that blockers behind the depth `front` leave, as if all lay at the depth `z`. Where others hide them, they are taken to be
// as dense as where they are seen.
fn share_left(seen: Seen, samples: u32, z: f32, front: f32) -> f32 {
    let scale = footprint_scale_uv(seen.light, seen.receiver.w, z);
    var lit = 0.0;
    var told = 0.0;
    var weights = 0.0;
    for (var i = 0u; i < samples; i++) {
        let point = outline_point(seen.outline, i, samples);
        let weight = irradiance_weight(seen.outline_seen, seen.n, point);
        let offset = scale * point;
        let uv = seen.receiver.xy + offset;
        let d = receiver_plane_depth(seen.receiver, seen.gradient, offset) - lights[seen.light].bias_scale * parameters.depth_bias;
        weights += weight;
        if front > 0.0 {
            told += weight * textureSampleCompareLevel(depth_maps, lit_if_nearer, uv, seen.light, min(front, d));
        }
        if !is_behind_surface(seen.outline_seen, seen.normal_world, point) {
            lit += weight * textureSampleCompareLevel(depth_maps, lit_if_nearer, uv, seen.light, d);
        }
    }
    if front > 0.0 {
        return select(lit / max(told, 1e-9), 1.0, told < LEAST_TOLD * weights);
    }
    return lit / max(weights, 1e-9);
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
    let seen = Seen(light, outline, outline_from(light, position_world), receiver, gradient, normal_world, n);
    var left = 1.0;
    let blockers = blocker_search(light, outline, receiver, gradient);
    if blockers.y > 0.0 {
        left = share_left(seen, parameters.filter_samples, blockers.x, 0.0);
    }
    // A curved surface that the light grazes would be its own near blocker.
    let n_dot_l = dot(normal_world, normalize(seen.outline_seen[0]));
    let half_extent = box_half_extent(light) / select(length(seen.outline_seen[0]), 1.0, lights[light].kind == KIND_DISTANT);
    if left > 0.0 && n_dot_l > 0.5 * max(half_extent.x, half_extent.y) {
        let near = near_blocker_search(light, outline, receiver, gradient);
        if near.y > 0.0 {
            let front = max(receiver.w - NEAR_REACH * (receiver.w - near.x), 1e-6);
            left = min(left, share_left(seen, max(parameters.filter_samples / 2u, 1u), near.x, front));
        }
    }
    return left;
}
