#import materials
#import wrapped

// Textures of the materials, for passes that draw surfaces. Layers of an array are textures of one size, format and sampler. A draw binds
// up to TEXTURE_SLOTS arrays: WebGPU has no arrays of bindings.

@group(GROUP_SURFACE) @binding(1) var<storage, read> material_textures: array<MaterialTexture>;
@group(GROUP_SURFACE) @binding(2) var textures_0: texture_2d_array<f32>;
@group(GROUP_SURFACE) @binding(3) var sampler_0: sampler;
@group(GROUP_SURFACE) @binding(4) var textures_1: texture_2d_array<f32>;
@group(GROUP_SURFACE) @binding(5) var sampler_1: sampler;
@group(GROUP_SURFACE) @binding(6) var textures_2: texture_2d_array<f32>;
@group(GROUP_SURFACE) @binding(7) var sampler_2: sampler;
@group(GROUP_SURFACE) @binding(8) var textures_3: texture_2d_array<f32>;
@group(GROUP_SURFACE) @binding(9) var sampler_3: sampler;
@group(GROUP_SURFACE) @binding(10) var textures_4: texture_2d_array<f32>;
@group(GROUP_SURFACE) @binding(11) var sampler_4: sampler;
@group(GROUP_SURFACE) @binding(12) var textures_5: texture_2d_array<f32>;
@group(GROUP_SURFACE) @binding(13) var sampler_5: sampler;
@group(GROUP_SURFACE) @binding(14) var textures_6: texture_2d_array<f32>;
@group(GROUP_SURFACE) @binding(15) var sampler_6: sampler;
@group(GROUP_SURFACE) @binding(16) var textures_7: texture_2d_array<f32>;
@group(GROUP_SURFACE) @binding(17) var sampler_7: sampler;

// Least change of texture coordinates from sample to sample: far below a texel. Where they do not change at all, some drivers that filter
// anisotropically divide by zero (lavapipe 25).
const LEAST_UV_STEP: f32 = 1e-6;

fn uv_step(step: vec2f) -> vec2f {
    return select(vec2f(LEAST_UV_STEP, 0.0), step, dot(step, step) > LEAST_UV_STEP * LEAST_UV_STEP);
}

fn sample_slot(slot: u32, layer: u32, uv: vec2f, across: vec2f, down: vec2f) -> vec4f {
    switch slot {
        case 0u: {
            return textureSampleGrad(textures_0, sampler_0, uv, layer, across, down);
        }
        case 1u: {
            return textureSampleGrad(textures_1, sampler_1, uv, layer, across, down);
        }
        case 2u: {
            return textureSampleGrad(textures_2, sampler_2, uv, layer, across, down);
        }
        case 3u: {
            return textureSampleGrad(textures_3, sampler_3, uv, layer, across, down);
        }
        case 4u: {
            return textureSampleGrad(textures_4, sampler_4, uv, layer, across, down);
        }
        case 5u: {
            return textureSampleGrad(textures_5, sampler_5, uv, layer, across, down);
        }
        case 6u: {
            return textureSampleGrad(textures_6, sampler_6, uv, layer, across, down);
        }
        default: {
            return textureSampleGrad(textures_7, sampler_7, uv, layer, across, down);
        }
    }
}

// Coordinates of a texture (KHR_texture_transform) where the mesh's two sets are `uvs`.
fn texture_uv(texture: MaterialTexture, uvs: vec4f) -> vec2f {
    return texture_uv_change(texture, uvs) + vec2f(texture.uv_rows[0].z, texture.uv_rows[1].z);
}

fn texture_uv_change(texture: MaterialTexture, uvs_change: vec4f) -> vec2f {
    let change = select(uvs_change.xy, uvs_change.zw, texture.uv_set == 1u);
    return vec2f(dot(texture.uv_rows[0].xy, change), dot(texture.uv_rows[1].xy, change));
}

// The texel at `uvs`, which change from sample to sample as given.
fn material_texel(texture: MaterialTexture, uvs: vec4f, uvs_across: vec4f, uvs_down: vec4f) -> vec4f {
    let across = uv_step(texture_uv_change(texture, uvs_across));
    let down = uv_step(texture_uv_change(texture, uvs_down));
    return sample_slot(texture.slot, texture.layer, texture_uv(texture, uvs), across, down);
}

// Opacity of a material where `vertex_alpha` is that of the vertices.
fn opacity_at(material: Material, vertex_alpha: f32, uvs: vec4f, uvs_across: vec4f, uvs_down: vec4f) -> f32 {
    var alpha = material.base_color.a * vertex_alpha;
    for (var i = material.first_texture; i < material.end_texture; i++) {
        let texture = material_textures[i];
        if texture.kind == TEXTURE_BASE_COLOR {
            alpha *= material_texel(texture, uvs, uvs_across, uvs_down).a;
        }
    }
    return opacity_of(material, alpha);
}
