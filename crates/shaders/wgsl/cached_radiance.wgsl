#import types
#import brdf_models
#import hemisphere

// Lookups in the radiance cache.

@group(GROUP_FRAME) @binding(6) var<uniform> cache: RadianceCache;
@group(GROUP_FRAME) @binding(7) var cached_f0: texture_2d_array<f32>;
@group(GROUP_FRAME) @binding(8) var cached_f90: texture_2d_array<f32>;

// The layer of the same model's lobe whose shape is nearest in ratio, or -1.
fn cached_layer(lobe: Lobe) -> i32 {
    var nearest = -1;
    var least = 1e30;
    for (var i = 0u; i < cache.count; i++) {
        let ratio = abs(log2(max(lobe.shape, 1e-6) / max(cache.lobes[i].shape, 1e-6)));
        if cache.lobes[i].model == lobe.model && ratio < least {
            nearest = i32(i);
            least = ratio;
        }
    }
    return nearest;
}

fn cached_texel(map: texture_2d_array<f32>, position: vec2f, layer: i32) -> vec3f {
    let low = vec2i(position);
    let high = min(low + 1, vec2i(textureDimensions(map)) - 1);
    let t = position - vec2f(low);
    let top = mix(textureLoad(map, low, layer, 0).rgb, textureLoad(map, vec2i(high.x, low.y), layer, 0).rgb, t.x);
    let bottom = mix(textureLoad(map, vec2i(low.x, high.y), layer, 0).rgb, textureLoad(map, high, layer, 0).rgb, t.x);
    return mix(top, bottom, t.y);
}

// What a lobe reflects of the whole environment about `reflected`. The cache's viewer is at infinity: the normal that mirrors
// `reflected` to that viewer stands for the surface's own, so that the lobe lies where it should.
fn cached_radiance(layer: i32, reflected: vec3f, n_dot_v: f32, lobe: Lobe) -> vec3f {
    let sum = reflected + cache.to_viewer;
    let n = select(cache.to_viewer, normalize(sum), dot(sum, sum) > 1e-8);
    let place = hemisphere_encode(vec3f(dot(n, cache.right), dot(n, cache.up), dot(n, cache.to_viewer)));
    let size = vec2f(textureDimensions(cached_f0));
    let position = saturate(0.5 * place + 0.5) * (size - 1.0);
    let cosines = n_dot_v / max(dot(n, cache.to_viewer), 1e-4);
    return reflectance_cached(
        lobe,
        cached_texel(cached_f0, position, layer),
        cached_texel(cached_f90, position, layer),
        cosines,
    );
}
