#import types
#import visibility_bytes

// Visibility that passes before this one have written to a buffer.

@group(GROUP_SHADOW) @binding(0) var<uniform> point_count: u32;
@group(GROUP_SHADOW) @binding(1) var<storage, read> visibilities: array<u32>;

fn visibility(light: u32, point: u32, position_world: vec3f, normal_world: vec3f, n: vec3f) -> f32 {
    return unpack4x8unorm(visibilities[visibility_word(light, point, point_count)])[light % 4u];
}
