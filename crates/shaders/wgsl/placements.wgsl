#import placing

// Copies of a rigid mesh share its vertices: a draw's instances are copies, and each has a placement. An instance's index counts placements,
// draw after draw.

// World space from the space that vertices are drawn from. The first one is that of vertices in world space.
@group(GROUP_PLACEMENTS) @binding(0) var<storage, read> placements: array<mat4x4f>;

fn draw_of(instance: u32) -> u32 {
    return instance / arrayLength(&placements);
}

fn placement_of(instance: u32) -> u32 {
    return instance % arrayLength(&placements);
}

fn placed_position(position: vec3f, placement: u32) -> vec3f {
    if placement == 0u {
        return position;
    }
    return (placements[placement] * vec4f(position, 1.0)).xyz;
}
