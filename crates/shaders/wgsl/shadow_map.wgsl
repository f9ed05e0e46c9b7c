#import types

// Linear depth of the scene seen from every light; the draw's first instance picks the light.

@group(0) @binding(0) var<storage, read> lights: array<Light>;

@vertex
fn shadow_map(@location(0) position_world: vec4f, @builtin(instance_index) light: u32) -> @builtin(position) vec4f {
    return lights[light].light_from_world * vec4f(position_world.xyz, 1.0);
}
