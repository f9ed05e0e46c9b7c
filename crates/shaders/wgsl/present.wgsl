#import types
#import tonemap

// A finished picture over a whole window. A surface cannot be written by a compute pass on every driver.

@group(GROUP_PASS) @binding(0) var picture: texture_2d<f32>;
@group(GROUP_PASS) @binding(1) var picture_sampler: sampler;

struct Corner {
    @builtin(position) position_clip: vec4f,
    @location(0) uv: vec2f,
}

// One triangle that covers the window.
@vertex
fn present_vertex(@builtin(vertex_index) index: u32) -> Corner {
    let uv = vec2f(f32((index << 1u) & 2u), f32(index & 2u));
    return Corner(vec4f(uv * vec2f(2.0, -2.0) + vec2f(-1.0, 1.0), 0.0, 1.0), uv);
}

// The picture is encoded already: right for a target that stores what it is given.
@fragment
fn present_encoded(corner: Corner) -> @location(0) vec4f {
    return vec4f(textureSample(picture, picture_sampler, corner.uv).rgb, 1.0);
}

// For an sRGB target, which encodes what it is given.
@fragment
fn present_decoded(corner: Corner) -> @location(0) vec4f {
    let encoded = textureSample(picture, picture_sampler, corner.uv).rgb;
    return vec4f(srgb_decode(encoded.r), srgb_decode(encoded.g), srgb_decode(encoded.b), 1.0);
}
