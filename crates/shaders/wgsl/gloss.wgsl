#import lobe_samples
#import ray_origin
#import summed_points
#import slot:reflections

// What glossy surfaces reflect of the environment at every shading point, without shadows and with them: the samples of the lobe, and those
// of them whose way is open. What blocks the others is reflected in their place where reflections of the scene are wanted.

@group(GROUP_FRAME) @binding(1) var environment_levels: texture_2d<f32>;

@compute @workgroup_size(LIGHT_WORKGROUP)
fn gloss(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) local: u32) {
    let point = stage_point(workgroup.xy, local);
    if point == NO_POINT {
        return;
    }
    var surface = surface_of(point);
    if !has_gloss(surface) {
        return;
    }
    let alpha = sharpest_alpha(surface);
    if stage.list != select(view.point_list_count - 1u, view.rough_gloss_list, alpha >= ROUGH_ALPHA) {
        return;
    }
    // What is reflected changes within a pixel: where it shows one smooth surface, rays begin at four places of it in turn.
    let side = view.supersample;
    let place = unpack_place(points[point].sample);
    let pixel = place / side;
    let stands_for_pixel = side > 1u && view.point_lists[stage.list].sampling <= side;
    let is_spread = stands_for_pixel && work[WORK_PIXELS + pixel.y * (view.size.x / side) + pixel.x] == 0u;
    let unshadowed = sampled_specular(surface);
    let count = max(rays_of(surface), select(1u, 4u, is_spread));
    // Neighbours take other parts of one evenly spread sequence (Roberts 2018, R2), as do points of one pixel.
    let first = count * pixel_of_16(place / max(side / 2u, 1u));
    var reflected = vec3f(0.0);
    var open = vec3f(0.0);
    var scene = vec3f(0.0);
    for (var number = first; number < first + count; number++) {
        if is_spread {
            let part = spread_sample(pixel * side, side, number % 4u);
            surface = surface_at(part, depth_at(part));
        }
        let sample = lobe_sample(surface, fract(0.5 + f32(number) * vec2f(0.7548777, 0.5698403)), count);
        reflected += sample.radiance;
        if dot(sample.direction, surface.geometric_normal) > 0.0 {
            let origin = ray_origin(surface.position_world, surface.geometric_normal);
            let seen = seen_along(origin, sample, number, count);
            open += seen.open * sample.radiance;
            scene += seen.scene;
        }
    }
    var sums = load_sums(point);
    sums.specular_unshadowed = unshadowed;
    sums.specular_shadowed = unshadowed * open / max(reflected, vec3f(1e-20));
    sums.specular_near += scene;
    store_sums(point, sums);
}
