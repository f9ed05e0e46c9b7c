#import sample_places
#import math
#import brdf_models

// What is seen through every sample of the picture: normals, reflectance, emission. No light here.

@group(GROUP_SURFACE) @binding(0) var<uniform> material: Material;
@group(GROUP_SURFACE) @binding(1) var base_color_texture: texture_2d<f32>;
@group(GROUP_SURFACE) @binding(2) var base_color_sampler: sampler;
@group(GROUP_SURFACE) @binding(3) var metallic_roughness_texture: texture_2d<f32>;
@group(GROUP_SURFACE) @binding(4) var metallic_roughness_sampler: sampler;
@group(GROUP_SURFACE) @binding(5) var normal_texture: texture_2d<f32>;
@group(GROUP_SURFACE) @binding(6) var normal_sampler: sampler;
@group(GROUP_SURFACE) @binding(7) var specular_texture: texture_2d<f32>;
@group(GROUP_SURFACE) @binding(8) var specular_sampler: sampler;
@group(GROUP_SURFACE) @binding(9) var specular_color_texture: texture_2d<f32>;
@group(GROUP_SURFACE) @binding(10) var specular_color_sampler: sampler;
@group(GROUP_SURFACE) @binding(11) var emissive_texture: texture_2d<f32>;
@group(GROUP_SURFACE) @binding(12) var emissive_sampler: sampler;

struct Vertex {
    @location(0) position_world: vec4f,
    @location(1) normal_world: vec4f,
    @location(2) tangent_world: vec4f,
    @location(3) uvs: vec4f,
    @location(4) color: vec4f,
}

struct Varying {
    @builtin(position) position_clip: vec4f,
    @location(0) position_world: vec3f,
    @location(1) normal_world: vec3f,
    @location(2) tangent_world: vec4f,
    @location(3) uvs: vec4f,
    @location(4) color: vec4f,
}

// 32 bytes a sample, WebGPU's default limit.
struct GBufferSample {
    // Octahedral shading normal, octahedral geometric normal; both face the viewer.
    @location(0) normals: vec4f,
    // Base colour, metallic; of other models than metallic-roughness the matte part's colour, and the model's number times -1.
    @location(1) base_color_metallic: vec4f,
    // Dielectric reflectance at normal incidence, and at grazing incidence; of other models that of the glossy part.
    @location(2) f0_f90: vec4f,
    // Emitted radiance, roughness; of other models the parameter of the lobe.
    @location(3) emissive_roughness: vec4f,
}

@vertex
fn gbuffer_vertex(vertex: Vertex, @builtin(instance_index) part: u32) -> Varying {
    var surface: Varying;
    let position_clip = view.clip_from_world * vec4f(vertex.position_world.xyz, 1.0);
    surface.position_clip = position_clip + vec4f(position_clip.w * part_shift(part), 0.0, 0.0);
    surface.position_world = vertex.position_world.xyz;
    surface.normal_world = vertex.normal_world.xyz;
    surface.tangent_world = vertex.tangent_world;
    surface.uvs = vertex.uvs;
    surface.color = vertex.color;
    return surface;
}

// Coordinates of texture `index` (KHR_texture_transform).
fn texture_uv(index: u32, uvs: vec4f) -> vec2f {
    let row_u = material.uv_rows[2u * index];
    let row_v = material.uv_rows[2u * index + 1u];
    let uv = vec3f(select(uvs.xy, uvs.zw, row_u.w > 0.5), 1.0);
    return vec2f(dot(row_u.xyz, uv), dot(row_v.xyz, uv));
}

// Least change of texture coordinates from pixel to pixel: far below a texel. Where they do not change at all, some drivers that filter
// anisotropically divide by zero (lavapipe 25).
const LEAST_UV_STEP: f32 = 1e-6;

fn uv_step(change: vec2f) -> vec2f {
    // Texels of a part lie a whole pixel apart, its samples do not.
    let step = change / f32(view.interleave);
    return select(vec2f(LEAST_UV_STEP, 0.0), step, dot(step, step) > LEAST_UV_STEP * LEAST_UV_STEP);
}

// Of texture `index`.
fn texel(image: texture_2d<f32>, filtering: sampler, index: u32, uvs: vec4f) -> vec4f {
    let uv = texture_uv(index, uvs);
    return textureSampleGrad(image, filtering, uv, uv_step(dpdx(uv)), uv_step(dpdy(uv)));
}

@fragment
fn gbuffer_fragment(surface: Varying) -> GBufferSample {
    let base_color =
        material.base_color * surface.color * texel(base_color_texture, base_color_sampler, 0u, surface.uvs);
    let metallic_roughness = texel(metallic_roughness_texture, metallic_roughness_sampler, 1u, surface.uvs);
    let normal_texel = texel(normal_texture, normal_sampler, 2u, surface.uvs).xyz;
    let specular = material.specular * texel(specular_texture, specular_sampler, 3u, surface.uvs).a;
    let specular_color =
        material.specular_color * texel(specular_color_texture, specular_color_sampler, 4u, surface.uvs).rgb;
    let emissive = material.emissive * texel(emissive_texture, emissive_sampler, 5u, surface.uvs).rgb;
    let across = dpdx(surface.position_world);
    let down = dpdy(surface.position_world);
    if base_color.a < material.alpha_cutoff {
        discard;
    }

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
        let tilt = (2.0 * normal_texel - 1.0) * vec3f(material.normal_scale, material.normal_scale, 1.0);
        normal = normalize(tangent * tilt.x + bitangent * tilt.y + normal * tilt.z);
    }
    normal *= select(-1.0, 1.0, dot(normal, geometric_normal) >= 0.0);

    // KHR_materials_ior and KHR_materials_specular.
    let r = (material.ior - 1.0) / (material.ior + 1.0);
    let f0 = min(r * r * specular_color, vec3f(1.0)) * specular;

    var packed: GBufferSample;
    packed.normals = vec4f(octahedral_encode(normal), octahedral_encode(geometric_normal));
    let metallic = material.metallic * metallic_roughness.b;
    if material.model == MODEL_METALLIC_ROUGHNESS {
        packed.base_color_metallic = vec4f(base_color.rgb, metallic);
        packed.f0_f90 = vec4f(f0, specular);
        packed.emissive_roughness = vec4f(emissive, material.roughness * metallic_roughness.g);
    } else {
        packed.base_color_metallic = vec4f(base_color.rgb * (1.0 - metallic), -f32(material.model));
        packed.f0_f90 = mix(vec4f(f0, specular), vec4f(base_color.rgb, 1.0), metallic);
        packed.emissive_roughness = vec4f(emissive, material.lobe_parameter);
    }
    return packed;
}
