#import shadow_frame
#import receiver_plane
#import lit_outline

// Where in a light's depth map blockers of a receiver may lie, and what each covers of the light. The lit part of the light counts as the box
// that has its mean and variance (`lit_outline`).

@group(GROUP_SHADOW) @binding(0) var<uniform> parameters: WindowParameters;
@group(GROUP_SHADOW) @binding(1) var depth_maps: texture_depth_2d_array;
// Nearest and farthest depth; the first level has half the texels of the map.
@group(GROUP_SHADOW) @binding(2) var depth_ranges: texture_2d_array<f32>;

struct Window {
    light: u32,
    receiver: vec4f,
    gradient: vec2f,
    bias: f32,
    // Of the light, in its own size.
    lit: WeightedBox,
    // First texel and the one after the last; blockers are looked up every so manyth.
    low: vec2i,
    high: vec2i,
    step: i32,
    // What is visible where nothing has to be looked up; below 0 where it has.
    known: f32,
}

// Times that the window is made narrower.
const NARROWINGS: u32 = 3u;

// Nearest and farthest depth between two texels, both included.
fn depth_range(light: u32, low: vec2i, high: vec2i) -> vec2f {
    var level = 0u;
    while any((high >> vec2u(level)) - (low >> vec2u(level)) > vec2i(2)) {
        level++;
    }
    let first = low >> vec2u(level);
    let last = high >> vec2u(level);
    var range = vec2f(1.0, 0.0);
    for (var y = first.y; y <= last.y; y++) {
        for (var x = first.x; x <= last.x; x++) {
            var part = vec2f(0.0);
            if level == 0u {
                part = vec2f(textureLoad(depth_maps, vec2i(x, y), light, 0));
            } else {
                part = textureLoad(depth_ranges, vec2i(x, y), light, level - 1u).xy;
            }
            range = vec2f(min(range.x, part.x), max(range.y, part.y));
        }
    }
    return range;
}

fn blocker_window(light: u32, position_world: vec3f, normal_world: vec3f, n: vec3f) -> Window {
    var window: Window;
    window.light = light;
    window.known = 1.0;
    let position = less_offset(light, position_world, normal_world, parameters.normal_offset_scale);
    window.receiver = receiver_in_light(light, position, normal_world);
    if any(window.receiver.xy < vec2f(0.0)) || any(window.receiver.xy > vec2f(1.0)) {
        return window;
    }
    window.gradient = receiver_depth_gradient(light, position, normal_world, window.receiver);
    window.bias = lights[light].bias_scale * parameters.depth_bias;
    window.lit = lit_box(light, position_world, n);
    window.lit.half_extent = max(window.lit.half_extent, vec2f(1e-6));
    let size = vec2i(textureDimensions(depth_maps));
    var nearest = 0.0;
    for (var i = 0u; i < NARROWINGS; i++) {
        // Nothing nearer to the light than this blocks anything.
        let scale = footprint_scale_uv(light, window.receiver.w, nearest);
        let center = window.receiver.xy + scale * window.lit.center;
        let half_extent = abs(scale) * window.lit.half_extent;
        let low = vec2i(floor((center - half_extent) * vec2f(size)));
        let high = vec2i(floor((center + half_extent) * vec2f(size)));
        window.low = clamp(low, vec2i(0), size - 1);
        window.high = clamp(high, vec2i(0), size - 1) + 1;
        let range = depth_range(light, window.low, window.high - 1);
        if range.x >= window.receiver.z - window.bias {
            return window;
        }
        let reach = abs(scale * window.lit.center) + half_extent;
        let plane = receiver_plane_depth(window.receiver, abs(window.gradient), -reach);
        let is_inside = all(low >= vec2i(0)) && all(high < size);
        if is_inside && range.y < plane - window.bias {
            window.known = 0.0;
            return window;
        }
        nearest = range.x;
    }
    let extent = window.high - window.low;
    window.step = (max(extent.x, extent.y) + i32(parameters.texels) - 1) / i32(parameters.texels);
    window.known = -1.0;
    return window;
}

// Depth in the middle of a square of texels; 1 where it blocks nothing.
fn blocker_depth(window: Window, corner: vec2i) -> f32 {
    let size = vec2i(textureDimensions(depth_maps));
    let texel = clamp(corner + window.step / 2, vec2i(0), size - 1);
    let z = textureLoad(depth_maps, texel, window.light, 0);
    let offset = (vec2f(corner) + 0.5 * f32(window.step)) / vec2f(size) - window.receiver.xy;
    return select(1.0, z, z < receiver_plane_depth(window.receiver, window.gradient, offset) - window.bias);
}

// A place of the map at a depth, as seen from the receiver on the light: 0 to 1 across its lit part.
fn on_light(window: Window, texel: vec2i, z: f32) -> vec2f {
    let offset = vec2f(texel) / vec2f(textureDimensions(depth_maps)) - window.receiver.xy;
    let scale = max(footprint_scale_uv(window.light, window.receiver.w, z), 1e-9);
    return 0.5 + 0.5 * (offset / scale - window.lit.center) / window.lit.half_extent;
}

// What a square of texels that blocks covers of the light: low and high corner. It begins where its neighbours, which block too, end: between texels
// of a slope are neither gaps nor overlaps (Guennebaud et al. 2006, section 4.3).
fn covered_box(window: Window, corner: vec2i, z: f32) -> vec4f {
    let low = on_light(window, corner, z);
    let high = on_light(window, corner + window.step, z);
    let before = vec2f(
        blocker_depth(window, corner - vec2i(window.step, 0)),
        blocker_depth(window, corner - vec2i(0, window.step)),
    );
    let ends = vec2f(on_light(window, corner, before.x).x, on_light(window, corner, before.y).y);
    return vec4f(min(select(low, ends, before < vec2f(1.0)), high), high);
}
