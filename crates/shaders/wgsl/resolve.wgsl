#import types
#import tonemap

// Box-filters the samples of every pixel in linear radiance, and makes the displayed picture of the mean.

@group(GROUP_PASS) @binding(0) var<uniform> parameters: ResolveParameters;
@group(GROUP_PASS) @binding(1) var samples: texture_2d<f32>;
@group(GROUP_PASS) @binding(2) var radiance: texture_storage_2d<rgba32float, write>;
@group(GROUP_PASS) @binding(3) var display: texture_storage_2d<rgba8unorm, write>;

@compute @workgroup_size(TILE, TILE)
fn resolve(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(radiance)) {
        return;
    }
    var sum = vec4f(0.0);
    for (var y = 0u; y < parameters.samples; y++) {
        for (var x = 0u; x < parameters.samples; x++) {
            sum += textureLoad(samples, id.xy * parameters.samples + vec2u(x, y), 0);
        }
    }
    let mean = sum / f32(parameters.samples * parameters.samples);
    let exposed = mean.rgb * parameters.exposure;
    let mapped = select(exposed, tone_map_neutral(exposed), parameters.tone_mapping == TONE_NEUTRAL);
    textureStore(radiance, id.xy, mean);
    textureStore(display, id.xy, vec4f(srgb_encode(mapped.r), srgb_encode(mapped.g), srgb_encode(mapped.b), 1.0));
}
