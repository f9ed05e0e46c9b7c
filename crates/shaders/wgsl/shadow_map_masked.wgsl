#import material_textures
#import partial_cover
#import placements

// Depth of surfaces with alpha, seen from every light: what is cut out of them casts no shadow, and what stops a share of the light is in that
// share of neighbouring texels, which filters to it. The draw picks material and light, `material * MAX_BATCH_LIGHTS + light`.

// Parts of the map's depth within which surfaces of a material and side cover the same texels.
const SLABS: f32 = 256.0;

@group(GROUP_PASS) @binding(0) var<storage, read> lights: array<Light>;

struct MaskedVertex {
    @location(0) position: vec4f,
    @location(1) uvs: vec4f,
    @location(2) color: vec4f,
}

struct MaskedSurface {
    @builtin(position) position: vec4f,
    @location(0) uvs: vec4f,
    @location(1) alpha: f32,
    @location(2) linear_depth: f32,
    @location(3) @interpolate(flat) material: u32,
}

@vertex
fn masked_shadow_map(vertex: MaskedVertex, @builtin(instance_index) instance: u32) -> MaskedSurface {
    let draw = draw_of(instance);
    let light = draw % MAX_BATCH_LIGHTS;
    let position_world = placed_position(vertex.position.xyz, placement_of(instance));
    let position = lights[light].light_from_world * vec4f(position_world, 1.0);
    let along_axis = (position.w - lights[light].near_world) / lights[light].depth_range_world;
    let linear_depth = select(along_axis, position.z, lights[light].kind == KIND_DISTANT);
    return MaskedSurface(position, vertex.uvs, vertex.color.a, linear_depth, draw / MAX_BATCH_LIGHTS);
}

fn is_hole(surface: MaskedSurface, is_front: bool) -> bool {
    let material = materials[surface.material];
    let opacity = opacity_at(material, surface.alpha, surface.uvs, dpdx(surface.uvs), dpdy(surface.uvs));
    let key = cover_key(u32(SLABS * saturate(surface.linear_depth)), surface.material, is_front);
    return !is_covered(opacity, vec2u(surface.position.xy), key);
}

// With the depth that the rasteriser has.
@fragment
fn masked_depth(surface: MaskedSurface, @builtin(front_facing) is_front: bool) {
    if is_hole(surface, is_front) {
        discard;
    }
}

// With linear depth under a perspective.
@fragment
fn masked_linear_depth(surface: MaskedSurface, @builtin(front_facing) is_front: bool) -> @builtin(frag_depth) f32 {
    if is_hole(surface, is_front) {
        discard;
    }
    return saturate(surface.linear_depth);
}
