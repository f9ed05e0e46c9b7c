#import lobe_samples
#import ray_origin
#import ray_scene
#import summed_points

// What glossy surfaces reflect of the environment at every shading point, without shadows and with them: the samples of the lobe, and those
// of them whose way is open.

@group(GROUP_FRAME) @binding(1) var environment_levels: texture_2d<f32>;

@compute @workgroup_size(LIGHT_WORKGROUP)
fn gloss(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) local: u32) {
    let point = stage_point(workgroup.xy, local);
    if point == NO_POINT {
        return;
    }
    let surface = surface_of(point);
    if !has_lobe(surface.lobe) {
        return;
    }
    let alpha = alpha_from_roughness(reflectance_equivalent_roughness(surface.lobe));
    if stage.list != select(view.point_list_count - 1u, view.rough_gloss_list, alpha >= ROUGH_ALPHA) {
        return;
    }
    let origin = ray_origin(surface.position_world, surface.geometric_normal);
    let count = rays_of(surface.lobe);
    // Neighbours take other parts of one evenly spread sequence (Roberts 2018, R2), as do points of one pixel.
    let first = count * pixel_of_16(unpack_place(points[point].sample) / max(view.supersample / 2u, 1u));
    var reflected = vec3f(0.0);
    var open = vec3f(0.0);
    for (var i = 0u; i < count; i++) {
        let u = fract(0.5 + f32(first + i) * vec2f(0.7548777, 0.5698403));
        let sample = lobe_sample(surface, u, count);
        reflected += sample.radiance;
        if any(sample.radiance > vec3f(0.0)) && dot(sample.direction, surface.geometric_normal) > 0.0
            && !is_occluded(origin, sample.direction, 3.4e38) {
            open += sample.radiance;
        }
    }
    var sums = load_sums(point);
    sums.specular_unshadowed = sampled_specular(surface);
    sums.specular_shadowed = sums.specular_unshadowed * open / max(reflected, vec3f(1e-20));
    store_sums(point, sums);
}
