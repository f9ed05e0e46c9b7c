#import gbuffer
#import partial_cover

// Of surfaces that light passes in part, the nearest ones are peeled off (Everitt 2001), each a layer that is lit by itself; of those behind,
// samples show one by chance.

// Depth of the layer before, above which everything is peeled off, and of what is opaque.
@group(GROUP_PASS) @binding(0) var peeled: texture_depth_2d;
@group(GROUP_PASS) @binding(1) var opaque_depth: texture_depth_2d;

// Depths that differ by so small a share are one surface's.
const PEELED_WITH: f32 = 4e-7;
// Least opacity that is a layer: less is not seen in eight bits.
const LEAST_OPACITY: f32 = 0.5 / 255.0;

fn depth_of(image: texture_depth_2d, surface: Varying) -> f32 {
    return textureLoad(image, vec2u(surface.position_clip.xy), 0);
}

fn is_peeled(surface: Varying) -> bool {
    return surface.position_clip.z >= depth_of(peeled, surface) * (1.0 - PEELED_WITH);
}

// Opacity of a material where it is seen.
fn opacity_seen(surface: Varying) -> f32 {
    let step = 1.0 / f32(view.interleave);
    return opacity_at(materials[surface.material], surface.color.a, surface.uvs, step * dpdx(surface.uvs), step * dpdy(surface.uvs));
}

// Opacity of the next layer.
@fragment
fn layer_opacity(surface: Varying) -> @location(0) f32 {
    let opacity = opacity_seen(surface);
    if opacity < LEAST_OPACITY || is_peeled(surface) || surface.position_clip.z < depth_of(opaque_depth, surface) {
        discard;
    }
    return opacity;
}

// The rest of it, where its depth is known.
@fragment
fn layer_fragment(surface: Varying) -> GBufferSample {
    return packed_sample(drawn_with_opacity(surface).surface);
}

// What lies behind all layers.
@fragment
fn rest_fragment(surface: Varying, @builtin(front_facing) is_front: bool) -> GBufferSample {
    let drawn = drawn_with_opacity(surface);
    let key = cover_key(u32(96.0 + 8.0 * log2(surface.position_clip.z + 1e-3)), surface.material, is_front);
    // Samples of a pixel are neighbours.
    let texel = vec2u(surface.position_clip.xy);
    let size = view.size / view.interleave;
    if is_peeled(surface) || !is_covered(drawn.opacity, view.interleave * (texel % size) + texel / size, key) {
        discard;
    }
    return packed_sample(drawn.surface);
}
