#import shadow_frame
#import receiver_plane
#import light_outline
#import lit_outline

// Percentage-closer soft shadows (Fernando 2005), filtered over the light's own outline, each of its points by what it adds to
// irradiance.

struct PcssInput {
    parameters: PcssParameters,
    // Point sets, one after the other, each point in the unit disk (xy) and in the unit square (zw): those of the search and of the kernel, and
    // the same with half as many points for near blockers.
    points: array<vec4f, PCSS_POINTS>,
}

@group(GROUP_SHADOW) @binding(0) var<uniform> input: PcssInput;
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
// What a blocker hides may lie so many texels beside the light, as seen from the receiver: a texel holds the depth of its middle alone.
const OUTLINE_MARGIN: f32 = 1.0;

// Linear depth of what the map holds `offset` uv beside a receiver.
fn map_depth(light: u32, receiver: vec4f, offset: vec2f) -> f32 {
    let size = vec2i(textureDimensions(depth_maps));
    // The margin of a map of the whole scene is empty: clamping to it finds nothing. That of a slice of the view lies half a penumbra
    // beyond what is seen.
    let texel = clamp(vec2i((receiver.xy + offset) * vec2f(size)), vec2i(0), size - 1);
    return textureLoad(depth_maps, texel, light, 0);
}

// A receiver, and the light's outline as it sees it.
struct Seen {
    light: u32,
    outline: Outline,
    unit: UnitOutline,
    weights: OutlineWeights,
    // Of the geometric normal.
    facet_cosines: vec3f,
    receiver: vec4f,
    gradient: vec2f,
    bias: f32,
}

// Point of the outline by its place among those of all sets.
fn point_of(seen: Seen, place: u32) -> vec2f {
    let point = input.points[place];
    return outline_at(seen.outline, point.xy, point.zw);
}

// What is nearer to the light than this, `offset` uv beside the receiver, blocks.
fn least_lit_depth(seen: Seen, offset: vec2f) -> f32 {
    return receiver_plane_depth(seen.receiver, seen.gradient, offset) - seen.bias;
}

// Whether a blocker `offset` uv beside the receiver hides any of the light (Guennebaud et al. 2006): from the foot of a wall, the floor
// before it is nearer to the light, but below all rays to it.
fn hides_light(seen: Seen, offset: vec2f, z: f32) -> bool {
    let scale = footprint_scale_uv(seen.light, seen.receiver.w, z);
    let margin = OUTLINE_MARGIN / f32(textureDimensions(depth_maps).x);
    return reach_in_outline(seen.unit, offset, scale) <= abs(scale) + margin * seen.unit.growth;
}

// Mean linear depth (x) and number (y) of the blockers found where the cone from the receiver to the light cuts the near plane.
fn blocker_search(seen: Seen) -> vec2f {
    let scale = footprint_scale_uv(seen.light, seen.receiver.w, 0.0);
    var sum = 0.0;
    var count = 0.0;
    for (var i = 0u; i < input.parameters.search_samples; i++) {
        let offset = scale * point_of(seen, i);
        let z = map_depth(seen.light, seen.receiver, offset);
        let blocks = z < least_lit_depth(seen, offset) && hides_light(seen, offset, z);
        sum += select(0.0, z, blocks);
        count += select(0.0, 1.0, blocks);
    }
    return vec2f(sum / max(count, 1.0), count);
}

// The same of blockers near to the receiver: each sample in a narrower cone than the one before, of what lies within that cone's share of the
// way to the near plane.
fn near_blocker_search(seen: Seen) -> vec2f {
    let scale = footprint_scale_uv(seen.light, seen.receiver.w, 0.0);
    let least = LEAST_TEXELS / f32(textureDimensions(depth_maps).x);
    let first = input.parameters.search_samples + input.parameters.filter_samples;
    let samples = max(input.parameters.search_samples / 2u, 1u);
    let step = pow(NEAREST / NEAR, 1.0 / f32(samples));
    var share = NEAR;
    var sum = 0.0;
    var count = 0.0;
    for (var i = 0u; i < samples; i++) {
        let offset = share * scale * point_of(seen, first + i);
        let z = map_depth(seen.light, seen.receiver, offset);
        if z < least_lit_depth(seen, offset) && z >= seen.receiver.w * (1.0 - share)
            && footprint_scale_uv(seen.light, seen.receiver.w, z) >= least {
            sum += z;
            count += 1.0;
        }
        share *= step;
    }
    return vec2f(sum / max(count, 1.0), count);
}

// Share of the light that blockers leave, as if all lay at the depth `z`.
fn share_left(seen: Seen, z: f32) -> f32 {
    let scale = footprint_scale_uv(seen.light, seen.receiver.w, z);
    let first = input.parameters.search_samples;
    var lit = 0.0;
    var weights = 0.0;
    for (var i = 0u; i < input.parameters.filter_samples; i++) {
        let point = point_of(seen, first + i);
        let weight = outline_weight(seen.weights, point);
        weights += weight;
        let offset = scale * point;
        let uv = seen.receiver.xy + offset;
        let open = textureSampleCompareLevel(depth_maps, lit_if_nearer, uv, seen.light, least_lit_depth(seen, offset));
        lit += select(0.0, weight * open, outline_cosine(seen.facet_cosines, point) > 0.0);
    }
    return lit / max(weights, 1e-9);
}

// The same of blockers behind the depth `front`. Where others hide them, they are taken to be as dense as where they are seen.
fn share_left_behind(seen: Seen, z: f32, front: f32) -> f32 {
    let scale = footprint_scale_uv(seen.light, seen.receiver.w, z);
    let samples = max(input.parameters.filter_samples / 2u, 1u);
    let first = input.parameters.search_samples + input.parameters.filter_samples + max(input.parameters.search_samples / 2u, 1u);
    var lit = 0.0;
    var told = 0.0;
    var weights = 0.0;
    for (var i = 0u; i < samples; i++) {
        let point = point_of(seen, first + i);
        let weight = outline_weight(seen.weights, point);
        weights += weight;
        let offset = scale * point;
        let uv = seen.receiver.xy + offset;
        let d = least_lit_depth(seen, offset);
        told += weight * textureSampleCompareLevel(depth_maps, lit_if_nearer, uv, seen.light, min(front, d));
        let open = textureSampleCompareLevel(depth_maps, lit_if_nearer, uv, seen.light, d);
        lit += select(0.0, weight * open, outline_cosine(seen.facet_cosines, point) > 0.0);
    }
    return select(lit / max(told, 1e-9), 1.0, told < LEAST_TOLD * weights);
}

fn visibility(light: u32, point: u32, position_world: vec3f, normal_world: vec3f, n: vec3f) -> f32 {
    let position = less_offset(light, position_world, normal_world, input.parameters.normal_offset_scale);
    let receiver = receiver_in_light(light, position, normal_world);
    if any(receiver.xy < vec2f(0.0)) || any(receiver.xy > vec2f(1.0)) {
        return 1.0;
    }
    let gradient = receiver_depth_gradient(light, position, normal_world, receiver);
    // Different lights take different points, so that their banding does not add up (Roberts 2018, R2).
    let outline = light_outline(light, fract(f32(light) * vec2f(0.7548777, 0.5698403)));
    let outline_seen = outline_from(light, position_world);
    let bias = lights[light].bias_scale * input.parameters.depth_bias;
    let seen =
        Seen(light, outline, unit_outline(outline), outline_weights(outline_seen, n), normal_world * outline_seen, receiver, gradient, bias);
    let half_size = box_half_extent(light);
    var left = 1.0;
    let blockers = blocker_search(seen);
    // The surface itself hides what is below it, on whichever side of the shading normal.
    let is_cut = seen.facet_cosines.x < dot(abs(seen.facet_cosines.yz), half_size) && any(n != normal_world);
    if blockers.y > 0.0 || is_cut {
        left = share_left(seen, select(receiver.w, blockers.x, blockers.y > 0.0));
    }
    // A curved surface that the light grazes would be its own near blocker.
    let n_dot_l = dot(normal_world, normalize(outline_seen[0]));
    let half_extent = half_size / select(length(outline_seen[0]), 1.0, lights[light].kind == KIND_DISTANT);
    if left > 0.0 && n_dot_l > 0.5 * max(half_extent.x, half_extent.y) {
        let near = near_blocker_search(seen);
        if near.y > 0.0 {
            let front = max(receiver.w - NEAR_REACH * (receiver.w - near.x), 1e-6);
            left = min(left, share_left_behind(seen, near.x, front));
        }
    }
    return left;
}
