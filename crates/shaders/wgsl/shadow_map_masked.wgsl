#import material_textures

// Depth of surfaces with holes, seen from every light: what is cut out of them by alpha casts no shadow. The draw's first instance picks
// material and light, `material * MAX_BATCH_LIGHTS + light`.

@group(GROUP_PASS) @binding(0) var<storage, read> lights: array<Light>;

struct MaskedVertex {
    @location(0) position_world: vec4f,
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
    let light = instance % MAX_BATCH_LIGHTS;
    let position = lights[light].light_from_world * vec4f(vertex.position_world.xyz, 1.0);
    let linear_depth = (position.w - lights[light].near_world) / lights[light].depth_range_world;
    return MaskedSurface(position, vertex.uvs, vertex.color.a, linear_depth, instance / MAX_BATCH_LIGHTS);
}

// As the G-buffer has it (`gbuffer.wgsl`).
fn is_hole(surface: MaskedSurface, uvs_across: vec4f, uvs_down: vec4f) -> bool {
    let material = materials[surface.material];
    var alpha = material.base_color.a * surface.alpha;
    for (var i = material.first_texture; i < material.end_texture; i++) {
        let texture = material_textures[i];
        if texture.kind == TEXTURE_BASE_COLOR {
            alpha *= material_texel(texture, surface.uvs, uvs_across, uvs_down).a;
        }
    }
    return alpha < material.alpha_cutoff;
}

// With the depth that the rasteriser has.
@fragment
fn masked_depth(surface: MaskedSurface) {
    if is_hole(surface, dpdx(surface.uvs), dpdy(surface.uvs)) {
        discard;
    }
}

// With linear depth under a perspective.
@fragment
fn masked_linear_depth(surface: MaskedSurface) -> @builtin(frag_depth) f32 {
    if is_hole(surface, dpdx(surface.uvs), dpdy(surface.uvs)) {
        discard;
    }
    return saturate(surface.linear_depth);
}
