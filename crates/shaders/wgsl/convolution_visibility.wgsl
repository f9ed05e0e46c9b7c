#import shadow_frame
#import lit_outline
#import series
#import contact_shadow

// Convolution soft shadows (Annen et al. 2008, sections 3 and 4.1; Fig. 2) over images that are filtered in one of several ways, and
// the depth map itself for what is too near for the series. The importer brings `Kernel`, `kernel_of(half_extent)` with half width and
// height of the box that it stands for, as shares of the map's side, and `filtered(image, uv, layer, kernel, unblocked)`, the
// mean over the kernel, with the value of a texel that nothing blocks.

@group(GROUP_SHADOW) @binding(0) var<uniform> parameters: ConvolutionParameters;
@group(GROUP_SHADOW) @binding(1) var basis_sin: texture_2d_array<f32>;
@group(GROUP_SHADOW) @binding(2) var basis_cos: texture_2d_array<f32>;
@group(GROUP_SHADOW) @binding(3) var basis_z_sin: texture_2d_array<f32>;
@group(GROUP_SHADOW) @binding(4) var basis_z_cos: texture_2d_array<f32>;
@group(GROUP_SHADOW) @binding(5) var linear_depth: texture_2d_array<f32>;
@group(GROUP_SHADOW) @binding(6) var trilinear: sampler;
@group(GROUP_SHADOW) @binding(7) var depth_maps: texture_depth_2d_array;
@group(GROUP_SHADOW) @binding(8) var gathering: sampler;

// Of the first kernel: less than this is blocked nowhere, up to the ringing of the series.
const FULLY_LIT: f32 = 0.995;

// A kernel and its place in the map.
struct Lookup {
    uv: vec2f,
    kernel: Kernel,
}

// The lookup for a receiver at `receiver` in the map, where the shadow map's plane lies at the linear depth `z` and `outline` shines.
fn lookup_at(light: u32, outline: WeightedBox, receiver: vec4f, z: f32) -> Lookup {
    let scale = footprint_scale_uv(light, receiver.w, z);
    return Lookup(receiver.xy + scale * outline.center, kernel_of(parameters.footprint_scale * scale * outline.half_extent));
}

fn filtered_lit(light: u32, lookup: Lookup, d: f32) -> f32 {
    var s = 0.5;
    for (var group = 0u; group < parameters.groups; group++) {
        let layer = light * parameters.groups + group;
        s += series_lit(
            series_phases(d, group),
            filtered(basis_sin, lookup.uv, layer, lookup.kernel, parameters.far_sin[group]),
            filtered(basis_cos, lookup.uv, layer, lookup.kernel, parameters.far_cos[group]),
            series_weights(group, parameters.order),
        );
    }
    return s;
}

// Mean depth of what is nearer than `d` under a kernel, in scaled light depth, given the filtered series `lit` of the same lookup
// (2008, eq. 11).
fn average_blocker_depth(light: u32, lookup: Lookup, d: f32, lit: f32) -> f32 {
    var sum = 0.5 * filtered(linear_depth, lookup.uv, light, lookup.kernel, vec4f(SERIES_DEPTH_SCALE)).r;
    for (var group = 0u; group < parameters.groups; group++) {
        let layer = light * parameters.groups + group;
        sum += series_blocker_depth(
            series_phases(d, group),
            filtered(basis_z_sin, lookup.uv, layer, lookup.kernel, SERIES_DEPTH_SCALE * parameters.far_sin[group]),
            filtered(basis_z_cos, lookup.uv, layer, lookup.kernel, SERIES_DEPTH_SCALE * parameters.far_cos[group]),
            series_weights(group, parameters.order),
        );
    }
    // Where next to nothing blocks, the quotient means nothing and the kernel does not matter.
    return clamp(sum / max(1.0 - lit, 1e-3), 0.0, d);
}

// Behind blockers as the filtered series sees them.
fn series_visibility(light: u32, position_world: vec3f, normal_world: vec3f) -> f32 {
    let receiver = receiver_in_light(light, position_world, normal_world);
    if any(receiver.xy < vec2f(0.0)) || any(receiver.xy > vec2f(1.0)) {
        return 1.0;
    }
    // Nothing is nearer than the map's near plane.
    if receiver.w <= 0.0 {
        return 1.0;
    }
    let depth = SERIES_DEPTH_SCALE * receiver.z;

    // First kernel: where the cone to the light meets the near plane. It holds the final one, wherever its centre is between the
    // outline's and the receiver's place: where all of it is lit or all of it is dark, so is the point. Its bias is the one at
    // which the receiver's own surface counts as exactly lit:
    // less would mix the receiver's depth into the blockers'.
    let d_average = max(depth - parameters.average_bias, SERIES_LEAST_DEPTH);
    let outline = lit_box(light, position_world, normal_world);
    let reach = abs(outline.center) / max(parameters.footprint_scale, 1e-3);
    let whole = WeightedBox(outline.center, max(outline.half_extent, reach));
    var lookup = lookup_at(light, whole, receiver, 0.0);
    let first_lit = filtered_lit(light, lookup, d_average);
    if first_lit >= FULLY_LIT {
        return 1.0;
    }
    if first_lit <= parameters.black_point {
        return 0.0;
    }

    // The plane moves to the average blocker; again, from there (2008, section 3.2).
    var blocker_distance = depth;
    var lit_before = first_lit;
    for (var i = 0u; i < parameters.plane_iterations; i++) {
        if i > 0u {
            lit_before = filtered_lit(light, lookup, d_average);
            if lit_before >= FULLY_LIT {
                break;
            }
        }
        let z_avg = average_blocker_depth(light, lookup, d_average, lit_before);
        blocker_distance = depth - z_avg;
        lookup = lookup_at(light, outline, receiver, z_avg / SERIES_DEPTH_SCALE);
    }
    let lit = filtered_lit(light, lookup, max(depth - parameters.depth_bias, SERIES_LEAST_DEPTH));
    let clean = suppress_ringing(lit, parameters.black_point, parameters.white_point);
    if parameters.plane_iterations == 0u {
        return clean;
    }
    return sharpen(clean, blocker_distance, parameters.sharpening_a, parameters.sharpening_b);
}

fn visibility(light: u32, point: u32, position_world: vec3f, normal_world: vec3f, n: vec3f) -> f32 {
    let lit = series_visibility(light, position_world, normal_world);
    if parameters.contact_samples == 0u || lit == 0.0 {
        return lit;
    }
    // Both see a blocker at the end of the reach: a product would darken its penumbra twice.
    let samples = parameters.contact_samples;
    return min(lit, contact_visibility(light, position_world, normal_world, n, samples, parameters.contact_reach));
}
