#import shadow_frame
#import series

// Convolution soft shadows (Annen et al. 2008, sections 3 and 4.1; Fig. 2).

@group(2) @binding(0) var<uniform> parameters: ConvolutionParameters;
@group(2) @binding(1) var basis_sin: texture_2d_array<f32>;
@group(2) @binding(2) var basis_cos: texture_2d_array<f32>;
@group(2) @binding(3) var basis_z_sin: texture_2d_array<f32>;
@group(2) @binding(4) var basis_z_cos: texture_2d_array<f32>;
@group(2) @binding(5) var linear_depth: texture_2d_array<f32>;
@group(2) @binding(6) var trilinear: sampler;

// Of the first kernel: less than this is blocked nowhere, up to the ringing of the series.
const FULLY_LIT: f32 = 0.995;

fn filtered_lit(light: u32, uv: vec2f, d: f32, level: f32) -> f32 {
    var s = 0.5;
    for (var group = 0u; group < parameters.groups; group++) {
        let layer = light * parameters.groups + group;
        s += series_lit(
            series_phases(d, group),
            textureSampleLevel(basis_sin, trilinear, uv, layer, level),
            textureSampleLevel(basis_cos, trilinear, uv, layer, level),
            series_weights(group, parameters.order),
        );
    }
    return s;
}

// Mean depth of what is nearer than `d` under the kernel of `level`, in scaled light depth, given the filtered series `lit`
// of the same kernel (2008, eq. 11).
fn average_blocker_depth(light: u32, uv: vec2f, d: f32, level: f32, lit: f32) -> f32 {
    var sum = 0.5 * textureSampleLevel(linear_depth, trilinear, uv, light, level).r;
    for (var group = 0u; group < parameters.groups; group++) {
        let layer = light * parameters.groups + group;
        sum += series_blocker_depth(
            series_phases(d, group),
            textureSampleLevel(basis_z_sin, trilinear, uv, layer, level),
            textureSampleLevel(basis_z_cos, trilinear, uv, layer, level),
            series_weights(group, parameters.order),
        );
    }
    // Where next to nothing blocks, the quotient means nothing and the kernel does not matter.
    return clamp(sum / max(1.0 - lit, 1e-3), 0.0, d);
}

fn visibility(light: u32, position_world: vec3f, normal_world: vec3f) -> f32 {
    let receiver = receiver_in_light(light, position_world, normal_world);
    if any(receiver.xy < vec2f(0.0)) || any(receiver.xy > vec2f(1.0)) {
        return 1.0;
    }
    // Width of a mip texel, in texels, per unit of penumbra width.
    let texels = parameters.footprint_scale * lights[light].footprint * parameters.resolution;
    let depth = SERIES_DEPTH_SCALE * receiver.z;

    // First kernel: where the cone to the light meets the near plane. It holds the final one, so where all of it is lit or
    // all of it is dark, so is the point. Its bias is the one at which the receiver's own surface counts as exactly lit:
    // less would mix the receiver's depth into the blockers'.
    let d_average = depth - parameters.average_bias;
    let first_level = min(level_from_width(texels * footprint_scale_uv(light, receiver.w, 0.0)), parameters.max_level);
    let first_lit = filtered_lit(light, receiver.xy, d_average, first_level);
    if first_lit >= FULLY_LIT {
        return 1.0;
    }
    if first_lit <= parameters.black_point {
        return 0.0;
    }
    let z_avg = average_blocker_depth(light, receiver.xy, d_average, first_level, first_lit);
    let blocker_distance = depth - z_avg;
    let level = min(level_from_width(texels * footprint_scale_uv(light, receiver.w, z_avg / SERIES_DEPTH_SCALE)), parameters.max_level);
    let lit = filtered_lit(light, receiver.xy, depth - parameters.depth_bias, level);
    let clean = suppress_ringing(lit, parameters.black_point, parameters.white_point);
    return sharpen(clean, blocker_distance, parameters.sharpening_a, parameters.sharpening_b);
}
