#import types

// Depth of the scene seen from every light; the draw's first instance picks the light.

@group(GROUP_PASS) @binding(0) var<storage, read> lights: array<Light>;

// As the rasteriser has it: linear where the map is orthographic.
@vertex
fn shadow_map(@location(0) position_world: vec4f, @builtin(instance_index) light: u32) -> @builtin(position) vec4f {
    return lights[light].light_from_world * vec4f(position_world.xyz, 1.0);
}

struct PerspectiveDepth {
    @builtin(position) position: vec4f,
    @location(0) linear_depth: f32,
}

// Linear under a perspective: every fragment writes the distance.
@vertex
fn linear_shadow_map(
    @location(0) position_world: vec4f,
    @builtin(instance_index) light: u32,
) -> PerspectiveDepth {
    let position = lights[light].light_from_world * vec4f(position_world.xyz, 1.0);
    return PerspectiveDepth(position, (position.w - lights[light].near_world) / lights[light].depth_range_world);
}

@fragment
fn linear_depth(fragment: PerspectiveDepth) -> @builtin(frag_depth) f32 {
    return saturate(fragment.linear_depth);
}
