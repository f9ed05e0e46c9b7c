#import view
#import brdf_models
#import equirect_texture
#import gbuffer_surface
#import sample_pattern

// Filtered importance sampling (Krivanek and Colbert 2008): few samples of a lobe, each reads the mip level of the environment that has about
// as many texels as the sphere has samples of its density. The importer binds `environment_levels: texture_2d<f32>`.

struct LobeSample {
    // Unit vector in the world.
    direction: vec3f,
    // What it adds to the light that the lobe reflects of the environment.
    radiance: vec3f,
    // Share of what comes along it that the lobe reflects.
    reflected: vec3f,
}

// Lobes of this GGX alpha and above have all rays. They change little from pixel to pixel: the points of wide lights are enough for them.
const ROUGH_ALPHA: f32 = 0.15;
// Even a weak lobe shows the brightest lamps.
const LEAST_RAYS: u32 = 8u;
// Samples that tell how much of the light a lobe reflects.
const ALBEDO_SAMPLES: u32 = 4u;
// Samples of unshadowed light for each ray.
const SAMPLES_OF_RAY: u32 = 4u;

// The lobe's sample for `u` in the unit square, one of `count`; it adds nothing where it would go under the surface.
fn lobe_sample(surface: Surface, u: vec2f, count: u32) -> LobeSample {
    let wo = local_from_world(surface.frame, surface.wo);
    let wi = gloss_sample(surface, wo, u);
    let pdf = gloss_pdf(surface, wo, wi);
    if pdf <= 0.0 || wi.z <= 0.0 {
        return LobeSample(surface.n, vec3f(0.0), vec3f(0.0));
    }
    let size = vec2f(textureDimensions(environment_levels, 0));
    let texels_per_sample = size.x * size.y / (4.0 * PI) / (f32(count) * pdf);
    let level = 0.5 * log2(max(texels_per_sample, 1e-6));
    let direction = world_from_local(surface.frame, wi);
    let towards = (view.environment_from_world * vec4f(direction, 0.0)).xyz;
    let reflected = gloss_value(surface, wo, wi) * (wi.z / (pdf * f32(count)));
    let radiance = view.environment_factor * equirect_lookup_level(environment_levels, towards, level);
    return LobeSample(direction, reflected * radiance, reflected);
}

// Rays of a lobe: its share of all that the surface reflects, for the rest hides their grain, and fewer of narrow ones, where what all of them see
// is alike.
fn rays_of(surface: Surface) -> u32 {
    let alpha = widest_alpha(surface);
    var reflected = vec3f(0.0);
    for (var i = 0u; i < ALBEDO_SAMPLES; i++) {
        reflected += lobe_sample(surface, hammersley(i, ALBEDO_SAMPLES), ALBEDO_SAMPLES).reflected;
    }
    let glossy = luminance(reflected);
    let share = glossy / max(glossy + luminance(surface.diffuse_color), 1e-9);
    let rays = u32(share * min(sqrt(alpha / ROUGH_ALPHA), 1.0) * f32(view.gloss_samples));
    return glossy_parts(surface) * max(rays, min(LEAST_RAYS, view.gloss_samples));
}

// What a surface's lobe reflects of the whole environment, unshadowed.
fn sampled_specular(surface: Surface) -> vec3f {
    let count = SAMPLES_OF_RAY * rays_of(surface);
    var sum = vec3f(0.0);
    for (var i = 0u; i < count; i++) {
        sum += lobe_sample(surface, hammersley(i, count), count).radiance;
    }
    return sum;
}
