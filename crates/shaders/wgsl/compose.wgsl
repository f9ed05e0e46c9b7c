#import environment
#import gbuffer_surface
#import cached_radiance
#import sh
#import light_sums
#import form_factor
#import slot:composite

// Radiance of every pixel: unshadowed light, what the lights' sums make of it, emission; or the environment itself. A pixel that shows one
// smooth surface is composed once, others sample by sample.

@group(GROUP_PASS) @binding(7) var radiance: texture_storage_2d<rgba32float, write>;

// Irradiance of the whole environment on a normal in its frame, unshadowed.
fn full_irradiance(n: vec3f) -> vec3f {
    if (view.flags & FLAG_SPHERICAL_HARMONICS) != 0u {
        return max(sh_irradiance(view.full_sh, n), vec3f(0.0));
    }
    var irradiance = equirect_lookup(irradiance_rest, n, 0);
    for (var i = 0u; i < emitters.count; i++) {
        let emitter = emitters.emitters[i];
        irradiance += emitter.radiance * disk_form_factor(n, emitter.direction, emitter.angular_radius);
    }
    return irradiance;
}

// What the camera sees of the environment through a sample.
fn background_at(sample: vec2u) -> vec3f {
    if (view.flags & FLAG_BACKGROUND) == 0u {
        return vec3f(0.0);
    }
    let near = unproject(sample, 1.0);
    let direction = environment_direction(normalize(near.xyz / near.w * view.eye_world.w - view.eye_world.xyz));
    return equirect_lookup(background, direction, 0);
}

// Radiance of a surface under these sums.
fn shade(surface: Surface, sums: LightSums) -> vec3f {
    let n_dot_v = max(dot(surface.n, surface.wo), 1e-4);

    // Of the ambient rest, what the probes see.
    let open = select(1.0, sums.probed_open / sums.probed, sums.probed > 0.0);
    // What the interface lets through to the matte part, for light along the normal: v.h stays far from grazing for most light even
    // where n.v does not.
    let base_weight = reflectance_matte_weight(surface.lobe, surface.interface_tint, sqrt(0.5 + 0.5 * n_dot_v));
    let n_environment = environment_direction(surface.n);
    let ambient_diffuse = max(sh_irradiance(view.residual_sh, n_environment), vec3f(0.0));
    let fit_diffuse = ambient_diffuse + sums.diffuse_unshadowed;
    let omits_hidden = (view.flags & FLAG_OMITS_HIDDEN) != 0u;
    var full_diffuse = fit_diffuse;
    if !omits_hidden {
        full_diffuse = full_irradiance(n_environment);
    }
    let environment_diffuse = composite(full_diffuse, fit_diffuse, open * ambient_diffuse + sums.diffuse_shadowed);
    let diffuse = base_weight * (environment_diffuse + sums.diffuse_near);
    var result = surface.emission + surface.diffuse_color / PI * diffuse;
    if has_lobe(surface.lobe) {
        let roughness = reflectance_equivalent_roughness(surface.lobe);
        let specular_albedo = reflectance_albedo(surface.lobe, n_dot_v, environment_brdf(n_dot_v, roughness));
        let reflected = reflect(-surface.wo, surface.n);
        let reflected_environment = environment_direction(reflected);
        let level = prefiltered_level(alpha_from_roughness(roughness), f32(textureNumLevels(prefiltered_full) - 1u));
        let ambient_specular = equirect_lookup_level(prefiltered_residual, reflected_environment, level) * specular_albedo;
        let fit_specular = ambient_specular + sums.specular_unshadowed;
        var full_specular = fit_specular;
        let layer = cached_layer(surface.lobe);
        if layer >= 0 && !omits_hidden {
            full_specular = cached_radiance(layer, reflected, n_dot_v, surface.lobe);
        } else if !omits_hidden {
            full_specular = equirect_lookup_level(prefiltered_full, reflected_environment, level) * specular_albedo;
        }
        result += composite(
            full_specular,
            fit_specular,
            open * ambient_specular + sums.specular_shadowed,
        ) + sums.specular_near;
    }
    return result;
}

fn edge_word(pixel: u32) -> u32 {
    return work[WORK_PIXELS + pixel];
}

// The sums of a sample of such a pixel. A tile that lies within the pixel needs no neighbours: they would only blur it.
fn smooth_sums(sample: vec2u, own_of_pixel: u32, surface: Surface) -> LightSums {
    let list = view.point_list_count - 1u;
    let own = own_point(sample);
    let point = select(neighbour_point(list, sample, 4), select(own, own_of_pixel, own == NO_POINT), own_of_pixel != NO_POINT);
    if point != NO_POINT && (own_of_pixel != NO_POINT || view.point_lists[list].sampling <= view.supersample) {
        return load_sums(point);
    }
    return gathered_sums(list, sample, surface.position_world, surface.n);
}

// A pixel that shows one smooth surface. What textures say is averaged over four samples, light over all that have points of their own.
fn smooth_radiance(corner: vec2u) -> vec4f {
    let side = view.supersample;
    let middle = corner + side / 2u;
    let depth = depth_at(middle);
    var mean = vec3f(0.0);
    if depth == 0.0 {
        for (var i = 0u; i < 4u; i++) {
            mean += 0.25 * background_at(spread_sample(corner, side, i));
        }
        return vec4f(mean, 0.0);
    }
    var surface = surface_at(middle, depth);
    if side > 1u {
        for (var i = 0u; i < 4u; i++) {
            mean += 0.25 * diffuse_color_at(spread_sample(corner, side, i));
        }
        surface.diffuse_color = mean;
    }
    let sampling = view.point_lists[view.point_list_count - 1u].sampling;
    // One value for each sample where some have points of their own, for each tile where tiles are smaller than the pixel.
    let own = own_point(middle);
    let step = select(min(sampling, side), 1u, own != NO_POINT);
    let steps = side / step;
    var sums: LightSums;
    for (var i = 0u; i < steps * steps; i++) {
        let sample = corner + step * vec2u(i % steps, i / steps) + step / 2u;
        add_weighted(&sums, 1.0 / f32(steps * steps), smooth_sums(sample, own, surface));
    }
    return vec4f(shade(surface, sums), 1.0);
}

@compute @workgroup_size(TILE, TILE)
fn compose_smooth(@builtin(global_invocation_id) id: vec3u) {
    let size = view.size / view.supersample;
    if any(id.xy >= size) || edge_word(id.y * size.x + id.x) != 0u {
        return;
    }
    textureStore(radiance, id.xy, smooth_radiance(id.xy * view.supersample));
}

var<workgroup> of_samples: array<vec4f, LIGHT_WORKGROUP>;

// The samples of edge pixels, an invocation each: as many whole pixels as a workgroup holds.
@compute @workgroup_size(LIGHT_WORKGROUP)
fn compose_edges(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) local: u32) {
    let side = view.supersample;
    let samples = side * side;
    let pixels = LIGHT_WORKGROUP / samples;
    let size = view.size / side;
    let number = (workgroup.y * work[WORK_EDGE_DISPATCH] + workgroup.x) * pixels + local / samples;
    let inside = local < pixels * samples && number < work[WORK_EDGE_DISPATCH + 3u];
    var pixel = vec2u(0u);
    if inside {
        let place = edge_word(size.x * size.y + number);
        pixel = vec2u(place % size.x, place / size.x);
        let k = local % samples;
        let sample = pixel * side + vec2u(k % side, k / side);
        let depth = depth_at(sample);
        if depth == 0.0 {
            of_samples[local] = vec4f(background_at(sample), 0.0);
        } else {
            let surface = surface_at(sample, depth);
            of_samples[local] = vec4f(shade(surface, sums_at(sample, surface.position_world, surface.n)), 1.0);
        }
    }
    workgroupBarrier();
    if inside && local % samples == 0u {
        var sum = vec4f(0.0);
        for (var k = 0u; k < samples; k++) {
            sum += of_samples[local + k];
        }
        textureStore(radiance, pixel, sum / f32(samples));
    }
}
