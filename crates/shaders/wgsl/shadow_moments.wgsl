#import shadow_frame
#import receiver_plane
#import lit_outline
#import depth_moments
#import series

// Moment soft shadow maps (Peters, Muenstermann, Wetzstein and Klein 2016): two filtered lookups of four moments, one for the
// blockers' depth, one for the shadow.

@group(GROUP_SHADOW) @binding(0) var<uniform> parameters: MomentParameters;
@group(GROUP_SHADOW) @binding(1) var moment_maps: texture_2d_array<f32>;
@group(GROUP_SHADOW) @binding(2) var trilinear: sampler;

// Share of the first kernel below which nothing blocks but rounding.
const UNBLOCKED: f32 = 0.005;

// `blockers_in_front` of a receiver of linear depth `d` in a kernel of `width_uv`, the depth in its turn linear in [0, 1].
fn filtered_blockers(light: u32, uv: vec2f, d: f32, width_uv: f32) -> vec2f {
    let level = min(level_from_width(parameters.resolution * width_uv), parameters.max_level);
    let share = share_in_map(uv, exp2(level) / parameters.resolution);
    let moments = mix(depth_moments(1.0), textureSampleLevel(moment_maps, trilinear, uv, light, level), share);
    let found = blockers_in_front(three_atoms(biased_moments(moments, parameters.moment_bias), 2.0 * d - 1.0));
    return vec2f(found.x, 0.5 * found.y + 0.5);
}

fn visibility(light: u32, point: u32, position_world: vec3f, normal_world: vec3f, n: vec3f) -> f32 {
    let position = less_offset(light, position_world, normal_world, parameters.normal_offset_scale);
    let receiver = receiver_in_light(light, position, normal_world);
    if any(receiver.xy < vec2f(0.0)) || any(receiver.xy > vec2f(1.0)) {
        return 1.0;
    }
    let outline = lit_box(light, position_world, normal_world);
    let footprint = parameters.footprint_scale * length(outline.half_extent) / sqrt(6.0 * LOOKUP_VARIANCE);
    let d = receiver.z - lights[light].bias_scale * parameters.depth_bias;

    let search_scale = footprint_scale_uv(light, receiver.w, 0.0);
    let search_width = footprint * search_scale;
    let search = filtered_blockers(light, receiver.xy + search_scale * outline.center, d, search_width);
    if search.x < UNBLOCKED {
        return 1.0;
    }
    let scale = footprint_scale_uv(light, receiver.w, min(search.y, receiver.z));
    let width = footprint * scale;
    let shadow = filtered_blockers(light, receiver.xy + scale * outline.center, d, width).x;
    return 1.0 - min(parameters.intensity_scale * shadow, 1.0);
}
