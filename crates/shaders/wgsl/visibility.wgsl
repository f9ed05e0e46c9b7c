#import frame
#import gbuffer_surface
#import light_shading
#import stage_points
#import visibility_bytes
#import slot:shadow
#import slot:bumps

// Evaluates a shadow technique for every pair of a light of the batch and a shading point.

@group(GROUP_PASS) @binding(0) var<storage, read> points: array<ShadingPoint>;
@group(GROUP_PASS) @binding(1) var<storage, read> work: array<u32>;
@group(GROUP_PASS) @binding(2) var<uniform> point_count: u32;
@group(GROUP_PASS) @binding(3) var<storage, read_write> visibilities: array<u32>;
@group(GROUP_PASS) @binding(4) var<uniform> stage: PointStage;

@compute @workgroup_size(LIGHT_WORKGROUP)
fn write_visibility(
    @builtin(workgroup_id) workgroup: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let point = stage_point(workgroup.xy, local);
    if point == NO_POINT {
        return;
    }
    let surface = surface_of(point);
    let relief = relief_at(unpack_place(points[point].sample));
    for (var first = batch.first_light / 4u * 4u; first < batch.end_light; first += 4u) {
        var four = vec4f(0.0);
        for (var light = max(first, batch.first_light); light < min(first + 4u, batch.end_light); light++) {
            // Nobody asks for lights below the horizon, or of other groups.
            let form_factor = light_form_factor(light, surface.position_world, surface.n);
            if is_shown(light) && asks_for(form_factor, relief) {
                let n = asked_normal(form_factor, relief, surface);
                four[light - first] = visibility(light, point, surface.position_world, surface.geometric_normal, n);
            }
        }
        visibilities[visibility_word(first, point, point_count)] = pack4x8unorm(four);
    }
}
