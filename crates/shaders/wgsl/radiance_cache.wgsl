#import brdf_reflectance
#import equirect_texture
#import hemisphere
#import sample_pattern
#import types

// Radiance cache (DeCoro and Rusinkiewicz 2008, section 3.1): what each lobe reflects of the whole environment, unshadowed, for every normal
// that faces a viewer in the cache's direction. Filtered importance sampling (Krivanek and Colbert 2008): few samples of the
// lobe, each reads the environment's mip level that has about as many texels as the sphere has samples of its density.

@group(GROUP_PASS) @binding(0) var<uniform> cache: RadianceCache;
@group(GROUP_PASS) @binding(1) var environment: texture_2d<f32>;
// Shares that Schlick's f0 and f90 weigh, a layer a lobe.
@group(GROUP_PASS) @binding(2) var radiance_f0: texture_storage_2d_array<rgba32float, write>;
@group(GROUP_PASS) @binding(3) var radiance_f90: texture_storage_2d_array<rgba32float, write>;

@compute @workgroup_size(TILE, TILE)
fn fill_cache(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(radiance_f0);
    if any(id.xy >= size) {
        return;
    }
    // The outermost texels' centres lie on the map's border, so that lookups need nothing beyond it.
    let local = hemisphere_decode(2.0 * vec2f(id.xy) / vec2f(size - 1u) - 1.0);
    let wo = cache.to_viewer;
    let n = cache.right * local.x + cache.up * local.y + wo * local.z;
    let lobe = cache.lobes[id.z];
    let texels = vec2f(textureDimensions(environment, 0));
    let texels_per_steradian = texels.x * texels.y / (4.0 * PI);
    var sum_f0 = vec3f(0.0);
    var sum_f90 = vec3f(0.0);
    for (var i = 0u; i < cache.samples; i++) {
        let drawn = reflectance_sample(lobe.model, lobe.parameter, n, wo, hammersley(i, cache.samples));
        if drawn.pdf > 0.0 {
            let weight = reflectance_lobe(lobe.model, lobe.parameter, n, wo, drawn.wi) * (dot(n, drawn.wi) / drawn.pdf);
            let texels_per_sample = texels_per_steradian / (f32(cache.samples) * drawn.pdf);
            let level = 0.5 * log2(max(texels_per_sample, 1e-6));
            let wi_environment = (cache.environment_from_world * vec4f(drawn.wi, 0.0)).xyz;
            let radiance = equirect_lookup_level(environment, wi_environment, level);
            sum_f0 += weight.x * radiance;
            sum_f90 += weight.y * radiance;
        }
    }
    textureStore(radiance_f0, id.xy, id.z, vec4f(sum_f0 / f32(cache.samples), 0.0));
    textureStore(radiance_f90, id.xy, id.z, vec4f(sum_f90 / f32(cache.samples), 0.0));
}
