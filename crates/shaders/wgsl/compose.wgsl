#import environment
#import gbuffer_surface
#import cached_radiance
#import lobe_samples
#import sh
#import light_sums
#import form_factor
#import ground
#import slot:composite

// Radiance of every pixel: unshadowed light, what the lights' sums make of it, emission; or the environment itself. A pixel that shows one
// smooth surface is composed once, others sample by sample. Layers of surfaces that light passes come one after another, each weighted with
// what those in front of it leave (Porter and Duff 1984, over).

@group(GROUP_PASS) @binding(7) var radiance: texture_storage_2d<rgba32float, write>;
@group(GROUP_PASS) @binding(8) var<uniform> composition: Composition;
// Of every layer, by the G-buffer's texels.
@group(GROUP_PASS) @binding(9) var opacities: texture_2d_array<f32>;
// Of the layers in front.
@group(GROUP_PASS) @binding(10) var radiance_in_front: texture_2d<f32>;

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
    return view.environment_factor * irradiance;
}

// Of the ray that the camera sees a sample along.
fn view_direction_at(sample: vec2u) -> vec3f {
    let near = unproject(sample, 1.0);
    return normalize(near.xyz / near.w * view.eye_world.w - view.eye_world.xyz);
}

// What the camera sees of the environment in a direction of the world.
fn background_towards(direction: vec3f) -> vec3f {
    if (view.flags & FLAG_BACKGROUND) == 0u {
        return vec3f(0.0);
    }
    return equirect_lookup(background, environment_direction(direction), 0) * view.background_factor;
}

// The same through a sample.
fn background_at(sample: vec2u) -> vec3f {
    return background_towards(view_direction_at(sample));
}

// Share that is seen at a place of a fading ground of what it is near its middle.
fn fading_ground_share(position_world: vec3f) -> f32 {
    return ground_share(length(position_world - view.ground_center), view.ground_fade.x, view.ground_fade.y);
}

// Radiance of a surface under these sums, in the parts that make its sum.
struct Shaded {
    emission: vec3f,
    diffuse: vec3f,
    specular: vec3f,
    // Of the light on the matte part, the share that shadows leave, without the scene's own lights and with what they add.
    shadow: vec3f,
    lit: vec3f,
}

// Radiance of a prefiltered map towards a direction in its frame.
fn prefiltered_lookup(map: texture_2d<f32>, direction: vec3f, level: f32) -> vec3f {
    return view.environment_factor * equirect_lookup_level(map, direction, level);
}

// What lies on the base reflects of the ambient rest; sheen is taken as matte.
fn finish_ambient(surface: Surface) -> vec3f {
    let lobe = coat_lobe_of(surface);
    let n = coat_normal_of(surface);
    let n_dot_v = max(dot(n, surface.wo), 1e-4);
    let albedo = default_albedo(lobe, n_dot_v, environment_brdf(n_dot_v, lobe.shape));
    let level = prefiltered_level(alpha_from_roughness(lobe.shape), f32(textureNumLevels(prefiltered_residual) - 1u));
    let coat = prefiltered_lookup(prefiltered_residual, environment_direction(reflect(-surface.wo, n)), level) * albedo;
    let irradiance = max(sh_irradiance(view.residual_sh, environment_direction(surface.n)), vec3f(0.0));
    return coat + sheen_albedo_of(surface) / PI * irradiance;
}

fn shade(surface: Surface, sums: LightSums) -> Shaded {
    let n_dot_v = max(dot(surface.n, surface.wo), 1e-4);

    // Of the ambient rest, what the probes see.
    let open = select(1.0, sums.probed_open / sums.probed, sums.probed > 0.0);
    // What the interface lets through to the matte part, for light along the normal: v.h stays far from grazing for most light even
    // where n.v does not.
    let base_weight = matte_weight_of(surface, sqrt(0.5 + 0.5 * n_dot_v));
    let n_environment = environment_direction(surface.n);
    let ambient_diffuse = max(sh_irradiance(view.residual_sh, n_environment), vec3f(0.0));
    let fit_diffuse = ambient_diffuse + sums.diffuse_unshadowed;
    let has_own_light = (view.flags & FLAG_OWN_LIGHT) != 0u;
    var full_diffuse = fit_diffuse;
    if !has_own_light {
        full_diffuse = full_irradiance(n_environment);
    }
    let open_ambient = select(open * ambient_diffuse, vec3f(0.0), composition.part == PART_LIGHTS);
    let environment_diffuse = composite(full_diffuse, fit_diffuse, open_ambient + sums.diffuse_shadowed);
    let diffuse = base_weight * (environment_diffuse + sums.diffuse_near);
    var shaded: Shaded;
    shaded.emission = surface.emission;
    shaded.diffuse = surface.diffuse_color / PI * diffuse;
    let is_lit = full_diffuse > vec3f(1e-20);
    shaded.shadow = select(vec3f(1.0), environment_diffuse / max(full_diffuse, vec3f(1e-20)), is_lit);
    shaded.lit = shaded.shadow + select(vec3f(0.0), sums.diffuse_near / max(full_diffuse, vec3f(1e-20)), is_lit);
    if has_gloss(surface) {
        let roughness = reflectance_equivalent_roughness(surface.lobe);
        let specular_albedo = reflectance_albedo(surface.lobe, n_dot_v, environment_brdf(n_dot_v, roughness));
        let reflected = reflect(-surface.wo, surface.n);
        let reflected_environment = environment_direction(reflected);
        let level = prefiltered_level(alpha_from_roughness(roughness), f32(textureNumLevels(prefiltered_full) - 1u));
        // Traced gloss is of the whole environment.
        let is_traced = (view.flags & FLAG_TRACED_GLOSS) != 0u;
        var ambient_specular = vec3f(0.0);
        if !is_traced {
            ambient_specular = prefiltered_lookup(prefiltered_residual, reflected_environment, level) * specular_albedo;
            if has_finish(surface) {
                ambient_specular = base_share(surface) * ambient_specular + finish_ambient(surface);
            }
        }
        let fit_specular = ambient_specular + sums.specular_unshadowed;
        var full_specular: vec3f;
        let layer = cached_layer(surface.lobe);
        if is_traced || has_own_light {
            full_specular = fit_specular;
        } else if (view.flags & FLAG_SAMPLED_GLOSS) != 0u || is_tabulated(surface.lobe) || has_finish(surface) {
            full_specular = sampled_specular(surface);
        } else if layer >= 0 {
            full_specular = view.environment_factor * cached_radiance(layer, reflected, n_dot_v, surface.lobe);
        } else {
            full_specular = prefiltered_lookup(prefiltered_full, reflected_environment, level) * specular_albedo;
        }
        shaded.specular = composite(
            full_specular,
            fit_specular,
            open * ambient_specular + sums.specular_shadowed,
        ) + sums.specular_near;
    }
    return shaded;
}

// Whether a sample shows a catcher, a CATCHES constant.
fn catches_at(sample: vec2u) -> u32 {
    return materials[packed_surface_at(sample).material].catches;
}

// What is composed of a catcher in front of `behind`, and how much it hides of that. It has a share of a matte surface of its own, the
// albedo `surface.diffuse_color`.
fn part_of_catcher(behind: vec3f, share: f32, surface: Surface, shaded: Shaded) -> vec4f {
    let hidden = mix(saturate(1.0 - luminance(shaded.lit)), 1.0, share);
    switch composition.part {
        case PART_PICTURE: {
            return vec4f(mix(behind * shaded.lit, shaded.diffuse, share), hidden);
        }
        case PART_BACKGROUND: {
            return vec4f((1.0 - share) * behind * shaded.lit, hidden);
        }
        case PART_SHADOW: {
            return vec4f(shaded.shadow, hidden);
        }
        case PART_ALPHA: {
            return vec4f(hidden);
        }
        case PART_ALBEDO: {
            return share * vec4f(surface.diffuse_color, 1.0);
        }
        case PART_DIFFUSE, PART_LIGHTS: {
            return share * vec4f(shaded.diffuse, 1.0);
        }
        default: {
            return vec4f(0.0);
        }
    }
}

// What is composed of a surface whose matte part has the albedo `surface.diffuse_color`.
fn part_of(surface: Surface, shaded: Shaded) -> vec3f {
    switch composition.part {
        case PART_ALBEDO: {
            return surface.diffuse_color;
        }
        case PART_DIFFUSE, PART_LIGHTS: {
            return shaded.diffuse;
        }
        case PART_SPECULAR: {
            return shaded.specular;
        }
        case PART_EMISSION: {
            return shaded.emission;
        }
        case PART_BACKGROUND: {
            return vec3f(0.0);
        }
        case PART_SHADOW: {
            return shaded.shadow;
        }
        case PART_ALPHA: {
            return vec3f(1.0);
        }
        default: {
            return shaded.emission + shaded.diffuse + shaded.specular;
        }
    }
}

// The same where nothing is seen but the environment.
fn part_of_background(sample: vec2u) -> vec3f {
    switch composition.part {
        case PART_PICTURE, PART_BACKGROUND: {
            return background_at(sample);
        }
        case PART_SHADOW: {
            return vec3f(1.0);
        }
        default: {
            return vec3f(0.0);
        }
    }
}

// What is seen behind a catcher through a sample of it.
fn behind_catcher_at(sample: vec2u, catches: u32) -> vec3f {
    let direction = view_direction_at(sample);
    if catches != CATCHES_FADING {
        return background_towards(direction);
    }
    let position = position_at(sample, depth_at(sample));
    let share = fading_ground_share(position);
    let from_center = position - view.ground_center;
    return background_towards(ground_direction(from_center, direction, view.ground_camera_height, share));
}

// The colour of a sample that counts: what is averaged over the samples of a smooth pixel.
fn color_at(sample: vec2u, catches: u32) -> vec3f {
    if catches != CATCHES_NOT {
        return behind_catcher_at(sample, catches);
    }
    if composition.part == PART_ALBEDO {
        return base_color_at(sample);
    }
    return diffuse_color_at(sample);
}

// The sums of a sample. In a pixel that shows one smooth surface, a tile that lies within the pixel needs no neighbours: they would only
// blur it; and `own_of_pixel` stands for samples without a point of their own.
fn sums_of(sample: vec2u, surface: Surface, is_smooth: bool, own_of_pixel: u32) -> LightSums {
    let list = view.point_list_count - 1u;
    var point = own_point(sample);
    if point == NO_POINT && is_smooth {
        point = own_of_pixel;
        // Few rays are grainy, and neighbours have others.
        let is_grainy = (view.flags & FLAG_TRACED_GLOSS) != 0u && has_gloss(surface);
        if point == NO_POINT && !is_grainy && view.point_lists[list].sampling <= view.supersample {
            point = neighbour_point(list, sample, 4);
        }
    }
    if point != NO_POINT {
        return load_sums(point);
    }
    return gathered_sums(list, sample, surface.position_world, surface.n);
}

// Radiance of a sample, or of the whole of a smooth pixel: what textures say is averaged over four samples then, and the normal (facets may be
// as small as pixels), light over tiles smaller than the pixel and over samples that have points of their own.
fn radiance_of(corner: vec2u, sample: vec2u, is_smooth: bool) -> vec4f {
    let side = view.supersample;
    let depth = depth_at(sample);
    let spread = select(1u, 4u, is_smooth && side > 1u);
    var catches = CATCHES_NOT;
    if depth > 0.0 {
        catches = catches_at(sample);
    }
    var mean = vec3f(0.0);
    var mean_normal = vec3f(0.0);
    for (var i = 0u; i < spread; i++) {
        let place = select(sample, spread_sample(corner, side, i), spread > 1u);
        if depth == 0.0 {
            mean += part_of_background(place) / f32(spread);
        } else {
            mean += color_at(place, catches) / f32(spread);
            mean_normal += normal_at(place);
        }
    }
    if depth == 0.0 {
        return vec4f(mean, 0.0);
    }
    var surface = surface_at(sample, depth);
    surface.n = normalize(mean_normal);
    if catches == CATCHES_NOT {
        surface.diffuse_color = mean;
    }
    let own = own_point(sample);
    let sampling = view.point_lists[view.point_list_count - 1u].sampling;
    let step = select(side, select(min(sampling, side), 1u, own != NO_POINT), is_smooth);
    let steps = side / step;
    var sums: LightSums;
    for (var i = 0u; i < steps * steps; i++) {
        let place = select(sample, corner + step * vec2u(i % steps, i / steps) + step / 2u, is_smooth);
        add_weighted(&sums, 1.0 / f32(steps * steps), sums_of(place, surface, is_smooth, own));
    }
    let shaded = shade(surface, sums);
    if catches != CATCHES_NOT {
        var caught = shaded;
        var share = 0.0;
        if catches == CATCHES_FADING {
            share = fading_ground_share(surface.position_world);
            // What the scene's own lights add ends with the ground.
            caught.lit = mix(shaded.shadow, shaded.lit, share);
            // A projected ground shows nothing but the environment.
            share = select(share, 0.0, view.ground_camera_height > 0.0);
        }
        return part_of_catcher(mean, share, surface, caught);
    }
    return vec4f(part_of(surface, shaded), 1.0);
}

// Share of what a sample shows that is seen of this layer.
fn weight_of(sample: vec2u) -> f32 {
    let texel = gbuffer_texel(sample);
    var weight = 1.0;
    for (var layer = 0u; layer < composition.layer; layer++) {
        weight *= 1.0 - textureLoad(opacities, texel, layer, 0).r;
    }
    if composition.layer < composition.layer_count {
        weight *= textureLoad(opacities, texel, composition.layer, 0).r;
    }
    return weight;
}

// The same of a whole pixel.
fn weight_of_pixel(corner: vec2u) -> f32 {
    if composition.layer_count == 0u {
        return 1.0;
    }
    let side = view.supersample;
    var weight = 0.0;
    for (var i = 0u; i < side * side; i++) {
        weight += weight_of(corner + vec2u(i % side, i / side));
    }
    return weight / f32(side * side);
}

var<workgroup> of_samples: array<vec4f, LIGHT_WORKGROUP>;

// Smooth pixels, an invocation each; or the samples of edge pixels, as many whole pixels as a workgroup holds.
@compute @workgroup_size(LIGHT_WORKGROUP)
fn compose(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) local: u32) {
    let side = view.supersample;
    let size = view.size / side;
    let is_smooth = composition.over_edges == 0u;
    let samples = select(side * side, 1u, is_smooth);
    var pixel = workgroup.xy * TILE + vec2u(local % TILE, local / TILE);
    var inside = all(pixel < size) && work[WORK_PIXELS + pixel.y * size.x + pixel.x] == 0u;
    if !is_smooth {
        let pixels = LIGHT_WORKGROUP / samples;
        let number = (workgroup.y * work[WORK_EDGE_DISPATCH] + workgroup.x) * pixels + local / samples;
        inside = local < pixels * samples && number < work[WORK_EDGE_DISPATCH + 3u];
        let place = work[WORK_PIXELS + size.x * size.y + select(0u, number, inside)];
        pixel = vec2u(place % size.x, place / size.x);
    }
    if inside {
        let k = local % samples;
        let corner = pixel * side;
        let sample = corner + select(vec2u(k % side, k / side), vec2u(side / 2u), is_smooth);
        var weight: f32;
        if is_smooth {
            weight = weight_of_pixel(corner);
        } else {
            weight = weight_of(sample);
        }
        of_samples[local] = vec4f(0.0);
        if weight > 0.0 {
            of_samples[local] = weight * radiance_of(corner, sample, is_smooth);
        }
    }
    workgroupBarrier();
    if inside && local % samples == 0u {
        var sum = vec4f(0.0);
        for (var k = 0u; k < samples; k++) {
            sum += of_samples[local + k];
        }
        var in_front = vec4f(0.0);
        if composition.layer > 0u {
            in_front = textureLoad(radiance_in_front, pixel, 0);
        }
        textureStore(radiance, pixel, in_front + sum / f32(samples));
    }
}
