#import shadow_frame
#import receiver_plane
#import light_outline
#import lit_outline

// Shadows of blockers near the receiver, from the depth map itself: nearer than filtered images resolve. A blocker search and
// percentage-closer filtering (Fernando 2005) of one layer of depths, their kernels no wider than that layer's penumbra. The
// importer brings `depth_maps` and `gathering`, a sampler that does not filter.

// Share of the reach within which a blocker counts in full; from there on it fades out.
const WHOLE_REACH: f32 = 0.9;
// Receivers are moved towards the light by this much, in linear depth, and by this factor on the offset along their normal. Texels
// are compared with the receiver's plane at their own place: only rounding and curvature are left to cover.
const CONTACT_DEPTH_BIAS: f32 = 0.002;
const CONTACT_NORMAL_OFFSET: f32 = 0.2;

// Four texels around a place: how far they are in front of the receiver's plane, in linear depth, which ones block, and their weights
// in a bilinear lookup.
struct DepthQuad {
    distances: vec4f,
    blocks: vec4<bool>,
    weights: vec4f,
}

fn depth_quad(light: u32, receiver: vec4f, gradient: vec2f, offset: vec2f) -> DepthQuad {
    let size = vec2f(textureDimensions(depth_maps));
    let place = (receiver.xy + offset) * size - 0.5;
    let low = floor(place);
    let t = place - low;
    // Where the four texels meet, so that rounding picks no others.
    let depths = textureGather(depth_maps, gathering, (low + 1.0) / size, light);
    let slope = dot(gradient, (low + 0.5) / size - receiver.xy);
    let step = gradient / size;
    // In the order of a gather: counter-clockwise from the lower left, v down.
    let rise = min(slope + vec4f(step.y, step.x + step.y, step.x, 0.0), vec4f(0.0));
    // A receiver may lie beyond the map's depths, where nothing is drawn.
    let plane = receiver.w + rise;
    let blocks = min(plane, vec4f(receiver.z)) > depths;
    let weights = vec4f((1.0 - t.x) * t.y, t.x * t.y, t.x * (1.0 - t.y), (1.0 - t.x) * (1.0 - t.y));
    return DepthQuad(plane - depths, blocks, weights);
}

// Share of the light that blockers nearer than `reach`, in linear depth, leave to a point. `samples` places are searched, and where
// there is such a blocker as many filtered.
fn contact_visibility(light: u32, position_world: vec3f, normal_world: vec3f, n: vec3f, samples: u32, reach: f32) -> f32 {
    let position = less_offset(light, position_world, normal_world, CONTACT_NORMAL_OFFSET);
    let receiver = receiver_in_light(light, position, normal_world);
    if any(receiver.xy < vec2f(0.0)) || any(receiver.xy > vec2f(1.0)) {
        return 1.0;
    }
    let gradient = receiver_depth_gradient(light, position, normal_world, receiver);
    let biased = receiver - vec4f(0.0, 0.0, CONTACT_DEPTH_BIAS, CONTACT_DEPTH_BIAS);
    // Different lights take different points, so that their banding does not add up (Roberts 2018, R2).
    let outline = light_outline(light, fract(f32(light) * vec2f(0.7548777, 0.5698403)));

    let search_scale = footprint_scale_uv(light, receiver.w, receiver.w - reach);
    let outline_seen = outline_from(light, position_world);
    var sum = 0.0;
    var count = 0.0;
    for (var i = 0u; i < samples; i++) {
        let offset = search_scale * outline_point(outline, i, samples);
        let quad = depth_quad(light, biased, gradient, offset);
        let blocks = quad.blocks & (quad.distances < vec4f(reach));
        sum += dot(select(vec4f(0.0), quad.distances, blocks), vec4f(1.0));
        count += dot(select(vec4f(0.0), vec4f(1.0), blocks), vec4f(1.0));
    }
    if count == 0.0 {
        return 1.0;
    }
    let scale = footprint_scale_uv(light, receiver.w, receiver.w - sum / count);
    var blocked = 0.0;
    var weights = 0.0;
    for (var i = 0u; i < samples; i++) {
        let point = outline_point(outline, i, samples);
        let weight = irradiance_weight(outline_seen, n, point);
        weights += weight;
        if is_behind_surface(outline_seen, normal_world, point) {
            blocked += weight;
            continue;
        }
        let quad = depth_quad(light, biased, gradient, scale * point);
        let share = saturate((reach - quad.distances) / ((1.0 - WHOLE_REACH) * reach));
        blocked += weight * dot(quad.weights, select(vec4f(0.0), share, quad.blocks));
    }
    return 1.0 - blocked / max(weights, 1e-9);
}
