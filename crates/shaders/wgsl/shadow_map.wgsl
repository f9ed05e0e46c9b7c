#import types
#import placements

// Depth of the scene seen from every light, by its number: that of the draw, or of the instance where all is in world space already.

@group(GROUP_PASS) @binding(0) var<storage, read> lights: array<Light>;

fn in_light(position_world: vec3f, light: u32) -> vec4f {
    return lights[light].light_from_world * vec4f(position_world, 1.0);
}

// As the rasteriser has it: linear where the map is orthographic.
@vertex
fn shadow_map(@location(0) position_world: vec4f, @builtin(instance_index) light: u32) -> @builtin(position) vec4f {
    return in_light(position_world.xyz, light);
}

@vertex
fn placed_shadow_map(@location(0) position: vec4f, @builtin(instance_index) instance: u32) -> @builtin(position) vec4f {
    return in_light(placed_position(position.xyz, placement_of(instance)), draw_of(instance));
}

struct PerspectiveDepth {
    @builtin(position) position: vec4f,
    @location(0) linear_depth: f32,
}

fn with_linear_depth(position: vec4f, light: u32) -> PerspectiveDepth {
    return PerspectiveDepth(position, (position.w - lights[light].near_world) / lights[light].depth_range_world);
}

// Linear under a perspective: every fragment writes the distance.
@vertex
fn linear_shadow_map(
    @location(0) position_world: vec4f,
    @builtin(instance_index) light: u32,
) -> PerspectiveDepth {
    return with_linear_depth(in_light(position_world.xyz, light), light);
}

@vertex
fn placed_linear_shadow_map(
    @location(0) position: vec4f,
    @builtin(instance_index) instance: u32,
) -> PerspectiveDepth {
    let light = draw_of(instance);
    return with_linear_depth(in_light(placed_position(position.xyz, placement_of(instance)), light), light);
}

@fragment
fn linear_depth(fragment: PerspectiveDepth) -> @builtin(frag_depth) f32 {
    return saturate(fragment.linear_depth);
}
