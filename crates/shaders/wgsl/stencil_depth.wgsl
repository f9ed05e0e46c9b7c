#import types

// Depth of what is seen, for a stencil beside it.

@group(GROUP_PASS) @binding(0) var gbuffer_depth: texture_depth_2d;

@vertex
fn whole_picture(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4f {
    return vec4f(select(-1.0, 3.0, vertex == 1u), select(-1.0, 3.0, vertex == 2u), 0.0, 1.0);
}

@fragment
fn seen_depth(@builtin(position) position: vec4f) -> @builtin(frag_depth) f32 {
    return textureLoad(gbuffer_depth, vec2u(position.xy), 0);
}
