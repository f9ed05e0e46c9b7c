#import sample_places
#import gbuffer_packing
#import material_textures
#import partial_cover

// What is seen through every sample of the picture: normals, tangent, material, and what textures make of it. No light here. One surface a
// sample. Of surfaces that light passes, the nearest ones are peeled off (Everitt 2001), each a layer that is lit by itself; of those behind,
// samples show one by chance.

// Depth of the layer before, above which everything is peeled off, and of what is opaque.
@group(GROUP_PASS) @binding(0) var peeled: texture_depth_2d;
@group(GROUP_PASS) @binding(1) var opaque_depth: texture_depth_2d;

// Depths that differ by so small a share are one surface's.
const PEELED_WITH: f32 = 4e-7;
// Least opacity that is a layer: less is not seen in eight bits.
const LEAST_OPACITY: f32 = 0.5 / 255.0;

struct Vertex {
    @location(0) position_world: vec4f,
    @location(1) normal_world: vec4f,
    @location(2) tangent_world: vec4f,
    @location(3) uvs: vec4f,
    @location(4) color: vec4f,
}

struct Varying {
    @builtin(position) @invariant position_clip: vec4f,
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

// Instances count parts of the G-buffer, material after material.
@vertex
fn gbuffer_vertex(vertex: Vertex, @builtin(instance_index) instance: u32) -> Varying {
    let parts = view.interleave * view.interleave;
    var surface: Varying;
    let position_clip = view.clip_from_world * vec4f(vertex.position_world.xyz, 1.0);
    surface.position_clip = position_clip + vec4f(position_clip.w * part_shift(instance % parts), 0.0, 0.0);
    surface.position_world = vertex.position_world.xyz;
    surface.normal_world = vertex.normal_world.xyz;
    surface.tangent_world = vertex.tangent_world;
    surface.uvs = vertex.uvs;
    surface.color = vertex.color;
    surface.material = instance / parts;
    return surface;
}

// What the surface has, and its alpha.
struct Shown {
    sample: GBufferSample,
    alpha: f32,
}

fn shown(surface: Varying) -> Shown {
    let across = dpdx(surface.position_world);
    let down = dpdy(surface.position_world);
    // Texels of a part lie a whole pixel apart, its samples do not.
    let uvs_across = dpdx(surface.uvs) / f32(view.interleave);
    let uvs_down = dpdy(surface.uvs) / f32(view.interleave);

    let material = materials[surface.material];
    var color = surface.color;
    var packed: PackedSurface;
    packed.material = surface.material;
    packed.uv = fract(surface.uvs.xy);
    packed.emission = select(vec3f(1.0), surface.color.rgb, material.emissive_vertex_colors != 0u);
    packed.specular_color = vec3f(1.0);
    packed.specular = 1.0;
    packed.roughness = 1.0;
    packed.metallic = 1.0;
    var tilt = vec3f(0.0, 0.0, 1.0);
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
                let uv = texture_uv(texture, surface.uvs);
                packed.uv = vec2f(wrapped_coordinate(uv.x, texture.wrap.x), wrapped_coordinate(uv.y, texture.wrap.y));
            }
            case TEXTURE_SPECULAR: {
                packed.specular *= texel.a;
            }
            case TEXTURE_SPECULAR_COLOR: {
                packed.specular_color *= texel.rgb;
            }
            case TEXTURE_EMISSIVE: {
                packed.emission *= texel.rgb;
            }
            default: {}
        }
    }
    packed.base_color = color.rgb;

    // Every surface is two-sided: both normals are turned to the viewer's side of the triangle.
    let to_viewer = view.eye_world.xyz - surface.position_world * view.eye_world.w;
    let facet = cross(across, down);
    var geometric_normal = normalize(select(normalize(surface.normal_world), facet, dot(facet, facet) > 0.0));
    geometric_normal *= select(-1.0, 1.0, dot(geometric_normal, to_viewer) >= 0.0);

    var normal = normalize(surface.normal_world);
    let tangent_length = length(surface.tangent_world.xyz);
    if tangent_length > 0.0 {
        let tangent = surface.tangent_world.xyz / tangent_length;
        let bitangent = cross(normal, tangent) * surface.tangent_world.w;
        normal = normalize(tangent * tilt.x + bitangent * tilt.y + normal * tilt.z);
    }
    let turn = select(-1.0, 1.0, dot(normal, geometric_normal) >= 0.0);
    packed.geometric_normal = geometric_normal;
    // The bitangent stays where it is when the normal turns.
    packed.frame = frame_from_tangent(normal * turn, vec4f(surface.tangent_world.xyz, surface.tangent_world.w * turn));
    return Shown(GBufferSample(pack_geometry(packed), pack_reflectance(packed)), material.base_color.a * color.a);
}

fn depth_of(image: texture_depth_2d, surface: Varying) -> f32 {
    return textureLoad(image, vec2u(surface.position_clip.xy), 0);
}

fn is_peeled(surface: Varying) -> bool {
    return surface.position_clip.z >= depth_of(peeled, surface) * (1.0 - PEELED_WITH);
}

// Opacity of a material where it is seen.
fn opacity_seen(surface: Varying) -> f32 {
    let step = 1.0 / f32(view.interleave);
    return opacity_at(materials[surface.material], surface.color.a, surface.uvs, step * dpdx(surface.uvs), step * dpdy(surface.uvs));
}

// What no light passes, but through holes.
@fragment
fn gbuffer_fragment(surface: Varying) -> GBufferSample {
    let shown = shown(surface);
    if opacity_of(materials[surface.material], shown.alpha) == 0.0 {
        discard;
    }
    return shown.sample;
}

// Opacity of the next layer.
@fragment
fn layer_opacity(surface: Varying) -> @location(0) f32 {
    let opacity = opacity_seen(surface);
    if opacity < LEAST_OPACITY || is_peeled(surface) || surface.position_clip.z < depth_of(opaque_depth, surface) {
        discard;
    }
    return opacity;
}

// The rest of it, where its depth is known.
@fragment
fn layer_fragment(surface: Varying) -> GBufferSample {
    return shown(surface).sample;
}

// What lies behind all layers.
@fragment
fn rest_fragment(surface: Varying, @builtin(front_facing) is_front: bool) -> GBufferSample {
    let shown = shown(surface);
    let opacity = opacity_of(materials[surface.material], shown.alpha);
    let key = cover_key(u32(96.0 + 8.0 * log2(surface.position_clip.z + 1e-3)), surface.material, is_front);
    // Samples of a pixel are neighbours.
    let texel = vec2u(surface.position_clip.xy);
    let size = view.size / view.interleave;
    if is_peeled(surface) || !is_covered(opacity, view.interleave * (texel % size) + texel / size, key) {
        discard;
    }
    return shown.sample;
}
