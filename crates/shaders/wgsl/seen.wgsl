#import gbuffer

// What is seen through the middle of every pixel, for geometry layers: one sample a pixel, never mixed over an edge.

@group(GROUP_FRAME) @binding(1) var<uniform> seen_frame: SeenFrame;
// Of every instance, counted from 1.
@group(GROUP_FRAME) @binding(2) var<storage, read> seen_draws: array<SeenDraw>;
// Of the frame before.
@group(GROUP_FRAME) @binding(3) var<storage, read> placements_before: array<mat4x4f>;

struct SeenVarying {
    @builtin(position) position_clip: vec4f,
    @location(0) position_world: vec3f,
    @location(1) normal_world: vec3f,
    @location(2) tangent_world: vec4f,
    @location(3) uvs: vec4f,
    @location(4) color: vec4f,
    @location(5) @interpolate(flat) material: u32,
    @location(6) @interpolate(flat) object: u32,
    // Where the point was seen in the frame before, in its clip space.
    @location(7) clip_before: vec4f,
}

struct SeenSample {
    @location(0) identity: vec4u,
    @location(1) place: vec4u,
}

@vertex
fn seen_vertex(
    vertex: Vertex,
    @location(5) position_before: vec4f,
    @builtin(instance_index) instance: u32,
) -> SeenVarying {
    let placement = placement_of(instance);
    let draw = draw_of(instance) + placement;
    let surface = varying_of(placed_vertex(vertex, placement), seen_draws[draw].material, 0u);
    let world_before = placements_before[placement] * vec4f(position_before.xyz, 1.0);
    var seen: SeenVarying;
    seen.position_clip = surface.position_clip;
    seen.position_world = surface.position_world;
    seen.normal_world = surface.normal_world;
    seen.tangent_world = surface.tangent_world;
    seen.uvs = surface.uvs;
    seen.color = surface.color;
    seen.material = surface.material;
    seen.object = seen_draws[draw].object;
    seen.clip_before = seen_frame.clip_before_from_world * vec4f(world_before.xyz, 1.0);
    return seen;
}

@fragment
fn seen_fragment(
    surface: Varying,
    @location(6) @interpolate(flat) object: u32,
    @location(7) clip_before: vec4f,
) -> SeenSample {
    let normal = drawn_surface(surface).frame.n;
    let depth = -dot(surface.position_world - seen_frame.world_from_camera[3].xyz, seen_frame.world_from_camera[2].xyz);
    let motion = motion_from(clip_before, surface.position_clip.xy);
    return SeenSample(
        vec4u(pack_normal(normal), object, surface.material, bitcast<u32>(depth)),
        bitcast<vec4u>(vec4f(surface.uvs.xy, motion)),
    );
}

// Way of a point in the picture to a place there since the frame before [pixels], to the right and down; none where it was behind the camera.
fn motion_from(clip_before: vec4f, place: vec2f) -> vec2f {
    if clip_before.w <= 0.0 {
        return vec2f(0.0);
    }
    let before = (clip_before.xy / clip_before.w * vec2f(0.5, -0.5) + 0.5) * vec2f(view.size);
    return place - before;
}
