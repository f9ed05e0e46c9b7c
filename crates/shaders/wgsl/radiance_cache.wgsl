#import brdf_models
#import equirect_texture
#import hemisphere
#import sample_pattern
#import types

// Radiance cache (DeCoro and Rusinkiewicz 2008, section 3.1): what each lobe reflects of the whole environment, unshadowed, for every normal
// that faces a viewer in the cache's direction. Filtered importance sampling (Krivanek and Colbert 2008): few samples of the
// lobe, each reads the environment's mip level that has about as many texels as the sphere has samples of its density.

@group(GROUP_PASS) @binding(0) var<uniform> cache: RadianceCache;
@group(GROUP_PASS) @binding(1) var environment: texture_2d<f32>;
// What a lobe of the tints (1, 1, 1, 0) and (0, 0, 0, 1) reflects, a layer a lobe.
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
    let frame = frame_from_normal(n);
    let wo_local = local_from_world(frame, wo);
    // What the model reflects of either tint alone; `reflectance_cached` mixes the two.
    let lobe_f0 = Lobe(cache.lobes[id.z].model, cache.lobes[id.z].shape, vec4f(1.0, 1.0, 1.0, 0.0));
    let lobe_f90 = Lobe(lobe_f0.model, lobe_f0.shape, vec4f(0.0, 0.0, 0.0, 1.0));
    let texels = vec2f(textureDimensions(environment, 0));
    let texels_per_steradian = texels.x * texels.y / (4.0 * PI);
    var sum_f0 = vec3f(0.0);
    var sum_f90 = vec3f(0.0);
    for (var i = 0u; i < cache.samples; i++) {
        let wi = reflectance_sample(lobe_f0, wo_local, hammersley(i, cache.samples));
        let pdf = reflectance_pdf(lobe_f0, wo_local, wi);
        if pdf > 0.0 {
            let texels_per_sample = texels_per_steradian / (f32(cache.samples) * pdf);
            let level = 0.5 * log2(max(texels_per_sample, 1e-6));
            let wi_environment = (cache.environment_from_world * vec4f(world_from_local(frame, wi), 0.0)).xyz;
            let radiance = equirect_lookup_level(environment, wi_environment, level) * (wi.z / pdf);
            sum_f0 += reflectance_lobe(lobe_f0, wo_local, wi) * radiance;
            sum_f90 += reflectance_lobe(lobe_f90, wo_local, wi) * radiance;
        }
    }
    textureStore(radiance_f0, id.xy, id.z, vec4f(sum_f0 / f32(cache.samples), 0.0));
    textureStore(radiance_f90, id.xy, id.z, vec4f(sum_f90 / f32(cache.samples), 0.0));
}
