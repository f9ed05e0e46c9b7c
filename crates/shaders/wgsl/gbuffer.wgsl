#import sample_places
#import gbuffer_packing
#import material_textures
#import height_slopes
#import placements

// What is seen through every sample of the picture: normals, tangent, material, and what textures make of it. No light here. One surface a
// sample; those that light passes in part are drawn in layers (`gbuffer_layers.wgsl`).

// In world space once it is placed.
struct Vertex {
    @location(0) position_world: vec4f,
    @location(1) normal_world: vec4f,
    @location(2) tangent_world: vec4f,
    @location(3) uvs: vec4f,
    @location(4) color: vec4f,
}

struct Varying {
    // The same in every pass that draws over another.
    @invariant @builtin(position) position_clip: vec4f,
    @location(0) position_world: vec3f,
    @location(1) normal_world: vec3f,
    @location(2) tangent_world: vec4f,
    @location(3) uvs: vec4f,
    @location(4) color: vec4f,
    @location(5) @interpolate(flat) material: u32,
}

struct GBufferSample {
    @location(0) geometry: vec4u,
    @location(1) reflectance: vec4u,
}

// Draws count parts of the G-buffer, material after material.
@vertex
fn gbuffer_vertex(vertex: Vertex, @builtin(instance_index) instance: u32) -> Varying {
    let parts = view.interleave * view.interleave;
    let draw = draw_of(instance);
    return varying_of(placed_vertex(vertex, placement_of(instance)), draw / parts, draw % parts);
}

fn placed_vertex(vertex: Vertex, placement: u32) -> Vertex {
    if placement == 0u {
        return vertex;
    }
    let linear = linear_part(placements[placement]);
    let normal_from_drawn = normal_matrix(linear);
    let normal = normal_from_drawn * vertex.normal_world.xyz;
    var placed = vertex;
    placed.position_world = vec4f(placed_position(vertex.position_world.xyz, placement), 1.0);
    placed.normal_world = vec4f(normal / max(length(normal), 1e-20), 0.0);
    placed.tangent_world =
        vec4f(normal_from_drawn * vertex.tangent_world.xyz, mirror_sign(linear) * vertex.tangent_world.w);
    return placed;
}

fn varying_of(vertex: Vertex, material: u32, part: u32) -> Varying {
    var surface: Varying;
    let position_clip = view.clip_from_world * vec4f(vertex.position_world.xyz, 1.0);
    surface.position_clip = position_clip + vec4f(position_clip.w * part_shift(part), 0.0, 0.0);
    surface.position_world = vertex.position_world.xyz;
    surface.normal_world = vertex.normal_world.xyz;
    surface.tangent_world = vertex.tangent_world;
    surface.uvs = vertex.uvs;
    surface.color = vertex.color;
    surface.material = material;
    return surface;
}

// A surface, and its opacity.
struct Drawn {
    surface: PackedSurface,
    opacity: f32,
}

@fragment
fn gbuffer_fragment(surface: Varying) -> GBufferSample {
    return packed_sample(drawn_surface(surface));
}

fn packed_sample(packed: PackedSurface) -> GBufferSample {
    return GBufferSample(pack_geometry(packed), pack_reflectance(packed));
}

// What is drawn of a surface; nothing where light passes it as if it were not there.
fn drawn_surface(surface: Varying) -> PackedSurface {
    let drawn = drawn_with_opacity(surface);
    if drawn.opacity == 0.0 {
        discard;
    }
    return drawn.surface;
}

// Unit. A mesh without normals is flat.
fn smooth_normal_of(surface: Varying, facet: vec3f, to_viewer: vec3f) -> vec3f {
    if dot(surface.normal_world, surface.normal_world) > 0.0 {
        return normalize(surface.normal_world);
    }
    return normalize(select(to_viewer, facet, dot(facet, facet) > 0.0));
}

fn drawn_with_opacity(surface: Varying) -> Drawn {
    let across = dpdx(surface.position_world);
    let down = dpdy(surface.position_world);
    // Texels of a part lie a whole pixel apart, its samples do not.
    let uvs_across = dpdx(surface.uvs) / f32(view.interleave);
    let uvs_down = dpdy(surface.uvs) / f32(view.interleave);

    let material = materials[surface.material];
    var color = surface.color;
    var packed: PackedSurface;
    packed.material = surface.material;
    packed.emission = select(vec3f(1.0), surface.color.rgb, material.emissive_vertex_colors != 0u);
    packed.specular_color = vec3f(1.0);
    packed.specular = 1.0;
    packed.roughness = material.roughness;
    packed.metallic = 1.0;
    var tilt = vec3f(0.0, 0.0, 1.0);
    var direction = vec2f(1.0, 0.0);
    var coat = vec2f(1.0);
    var sheen = vec4f(1.0);
    var coat_tilt = vec3f(0.0, 0.0, 1.0);
    let to_viewer = view.eye_world.xyz - surface.position_world * view.eye_world.w;
    let facet = cross(across, down);
    let smooth_normal = smooth_normal_of(surface, facet, to_viewer);
    var rise = vec3f(0.0);
    var spread = 0.0;
    for (var i = material.first_texture; i < material.end_texture; i++) {
        let texture = material_textures[i];
        let texel = material_texel(texture, surface.uvs, uvs_across, uvs_down);
        switch texture.kind {
            case TEXTURE_BASE_COLOR: {
                color *= texel;
            }
            case TEXTURE_METALLIC_ROUGHNESS: {
                packed.roughness *= texel.g;
                packed.metallic *= texel.b;
            }
            case TEXTURE_METALLIC: {
                packed.metallic *= texel.b;
            }
            case TEXTURE_NORMAL: {
                tilt = (2.0 * texel.xyz - 1.0) * vec3f(material.normal_scale, material.normal_scale, 1.0);
            }
            case TEXTURE_HEIGHT: {
                let gradients = uv_gradients(
                    smooth_normal,
                    across,
                    down,
                    texture_uv_change(texture, uvs_across),
                    texture_uv_change(texture, uvs_down),
                    1.0 / f32(view.interleave),
                );
                let slope = texel.xy * material.height_slope;
                rise = slope.x * gradients.u + slope.y * gradients.v;
                // What lies within the texel's footprint besides its mean (Olano and Baker 2010).
                let variance = max(texel.zw - texel.xy * texel.xy, vec2f(0.0)) * material.height_slope * material.height_slope;
                spread = dot(variance, vec2f(dot(gradients.u, gradients.u), dot(gradients.v, gradients.v)));
            }
            case TEXTURE_SPECULAR: {
                packed.specular *= texel.a;
            }
            case TEXTURE_SPECULAR_COLOR: {
                packed.specular_color *= texel.rgb;
            }
            case TEXTURE_CLEARCOAT: {
                coat.x *= texel.r;
            }
            case TEXTURE_CLEARCOAT_ROUGHNESS: {
                coat.y *= texel.g;
            }
            case TEXTURE_CLEARCOAT_NORMAL: {
                coat_tilt = (2.0 * texel.xyz - 1.0) * vec3f(vec2f(material.clearcoat_normal_scale), 1.0);
            }
            case TEXTURE_ANISOTROPY: {
                direction = 2.0 * texel.rg - 1.0;
            }
            case TEXTURE_SHEEN_COLOR: {
                sheen *= vec4f(texel.rgb, 1.0);
            }
            case TEXTURE_SHEEN_ROUGHNESS: {
                sheen.a *= texel.a;
            }
            case TEXTURE_EMISSIVE: {
                packed.emission *= texel.rgb;
            }
            default: {}
        }
    }
    packed.base_color = color.rgb;

    // Every surface is two-sided: both normals are turned to the viewer's side of the triangle.
    var geometric_normal = normalize(select(smooth_normal, facet, dot(facet, facet) > 0.0));
    geometric_normal *= select(-1.0, 1.0, dot(geometric_normal, to_viewer) >= 0.0);

    var normal = smooth_normal;
    var coat_normal = smooth_normal;
    let tangent_length = length(surface.tangent_world.xyz);
    if tangent_length > 0.0 {
        let tangent = surface.tangent_world.xyz / tangent_length;
        let bitangent = cross(normal, tangent) * surface.tangent_world.w;
        normal = normalize(tangent * tilt.x + bitangent * tilt.y + normal * tilt.z);
        coat_normal = normalize(tangent * coat_tilt.x + bitangent * coat_tilt.y + smooth_normal * coat_tilt.z);
    }
    if view.bumps != 0u {
        normal = bent_by_heights(normal, smooth_normal, rise);
        packed.roughness = roughness_with_slopes(packed.roughness, spread);
    }
    let turn = select(-1.0, 1.0, dot(normal, geometric_normal) >= 0.0);
    packed.geometric_normal = geometric_normal;
    // The bitangent stays where it is when the normal turns.
    var tangent = surface.tangent_world.xyz;
    if any(direction != vec2f(1.0, 0.0)) && dot(direction, direction) > 1e-6 {
        let across = tangent - smooth_normal * dot(smooth_normal, tangent);
        tangent = across * direction.x + cross(smooth_normal, across) * (surface.tangent_world.w * direction.y);
    }
    packed.frame = frame_from_tangent(normal * turn, vec4f(tangent, surface.tangent_world.w * turn));
    coat_normal *= select(-1.0, 1.0, dot(coat_normal, geometric_normal) >= 0.0);
    if material.has_sheen_textures != 0u {
        packed.finish = pack_sheen(sheen.rgb, sheen.a);
    } else if material.clearcoat > 0.0 {
        // Bumps bend the coat with them.
        let is_bumpy = any(material.height_slope != vec2f(0.0));
        let tilt = select(local_from_world(packed.frame, coat_normal).xy, vec2f(0.0), is_bumpy);
        packed.finish = pack_coat(coat.x, coat.y, tilt);
    }
    return Drawn(packed, opacity_of(material, material.base_color.a * color.a));
}
