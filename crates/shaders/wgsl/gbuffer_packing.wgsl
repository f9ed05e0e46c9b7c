#import math
#import brdf_frame

// A sample of the G-buffer: 32 bytes, WebGPU's default limit, packed by hand as two vectors of words. Twin: `gbuffer_packing.rs`.

// What a sample shows. Colours, roughness and metallic are what textures and vertices multiply the material's own with, and lie in [0, 1]
// but for the base colour and emission, which may be larger.
struct PackedSurface {
    // Its normal towards the viewer, as the triangle's.
    frame: Frame,
    geometric_normal: vec3f,
    // Number of the material, below 65536.
    material: u32,
    // What textures say of what lies on the base: `pack_coat`, or `pack_sheen` of a material with such textures.
    finish: u32,
    base_color: vec3f,
    emission: vec3f,
    specular_color: vec3f,
    specular: f32,
    roughness: f32,
    metallic: f32,
}

fn pack_normal(n: vec3f) -> u32 {
    return pack2x16snorm(octahedral_encode(n));
}

fn unpack_normal(word: u32) -> vec3f {
    return octahedral_decode(unpack2x16snorm(word));
}

// 15 bits of the tangent's angle in `frame_from_normal`, and one for the bitangent's sign. `n` as it was unpacked: that frame turns where
// n.z changes its sign.
fn pack_tangent(n: vec3f, frame: Frame) -> u32 {
    let local = local_from_world(frame_from_normal(n), frame.t);
    let turns = atan2(local.y, local.x) / TAU;
    let angle = u32(floor((turns + 1.0) * 32768.0 + 0.5)) & 0x7fffu;
    return select(0u, 0x8000u, dot(cross(frame.n, frame.t), frame.b) < 0.0) | angle;
}

fn unpack_frame(n: vec3f, bits: u32) -> Frame {
    let angle = f32(bits & 0x7fffu) * (TAU / 32768.0);
    let tangent = world_from_local(frame_from_normal(n), vec3f(cos(angle), sin(angle), 0.0));
    return Frame(tangent, cross(n, tangent) * select(1.0, -1.0, (bits & 0x8000u) != 0u), n);
}

// 2^exponent of a normal number, exactly.
fn power_of_two(exponent: i32) -> f32 {
    return bitcast<f32>(u32(exponent + 127) << 23u);
}

// Nine bits a channel and a common exponent of five (EXT_texture_shared_exponent).
fn pack_rgb9e5(color: vec3f) -> u32 {
    let clamped = clamp(color, vec3f(0.0), vec3f(65408.0));
    let largest = max_component(clamped);
    var exponent = max(i32(bitcast<u32>(largest) >> 23u) - 127, -16) + 16;
    if floor(largest / power_of_two(exponent - 24) + 0.5) >= 512.0 {
        exponent += 1;
    }
    let mantissas = vec3u(floor(clamped / power_of_two(exponent - 24) + 0.5));
    return mantissas.x | (mantissas.y << 9u) | (mantissas.z << 18u) | (u32(exponent) << 27u);
}

fn unpack_rgb9e5(word: u32) -> vec3f {
    let mantissas = (vec3u(word) >> vec3u(0u, 9u, 18u)) & vec3u(0x1ffu);
    return vec3f(mantissas) * power_of_two(i32(word >> 27u) - 24);
}

// `x` in [-1, 1] as 10 bits of its root with the sign, so that small ones keep their digits.
fn pack_signed_root(x: f32) -> u32 {
    return u32(512.5 + 511.0 * sign(x) * sqrt(min(abs(x), 1.0)));
}

fn unpack_signed_root(bits: u32) -> f32 {
    let root = (f32(bits & 0x3ffu) - 512.0) / 511.0;
    return root * abs(root);
}

// What textures multiply strength and roughness of the clear coat with, as 6 bits each of their roots, and x and y of the coat's normal in the
// tangent frame.
fn pack_coat(clearcoat: f32, roughness: f32, tilt: vec2f) -> u32 {
    let roots = vec2u(sqrt(saturate(vec2f(clearcoat, roughness))) * 63.0 + 0.5);
    return roots.x | (roots.y << 6u) | (pack_signed_root(tilt.x) << 12u) | (pack_signed_root(tilt.y) << 22u);
}

fn unpack_coat(word: u32) -> vec4f {
    let roots = vec2f(vec2u(word, word >> 6u) & vec2u(63u)) / 63.0;
    return vec4f(roots * roots, unpack_signed_root(word >> 12u), unpack_signed_root(word >> 22u));
}

// What textures multiply colour (roots) and roughness of the sheen with.
fn pack_sheen(color: vec3f, roughness: f32) -> u32 {
    return pack4x8unorm(vec4f(sqrt(saturate(color)), roughness));
}

fn unpack_sheen(word: u32) -> vec4f {
    let roots = unpack4x8unorm(word);
    return vec4f(roots.rgb * roots.rgb, roots.a);
}

// Normals, tangent and material, and what lies on the base.
fn pack_geometry(surface: PackedSurface) -> vec4u {
    let normal = pack_normal(surface.frame.n);
    let tangent = pack_tangent(unpack_normal(normal), surface.frame);
    return vec4u(
        normal,
        pack_normal(surface.geometric_normal),
        tangent | (surface.material << 16u),
        surface.finish,
    );
}

// Halves of the base colour without their signs, 10 bits of the root of the roughness, 7 of the metallic share, emission, specular tint
// (roots) and strength.
fn pack_reflectance(surface: PackedSurface) -> vec4u {
    let base_color = clamp(surface.base_color, vec3f(0.0), vec3f(65504.0));
    let roughness = u32(sqrt(saturate(surface.roughness)) * 1023.0 + 0.5);
    let metallic = u32(saturate(surface.metallic) * 127.0 + 0.5);
    return vec4u(
        pack2x16float(base_color.rg),
        pack2x16float(vec2f(base_color.b, 0.0)) | (roughness << 15u) | (metallic << 25u),
        pack_rgb9e5(surface.emission),
        pack4x8unorm(vec4f(sqrt(surface.specular_color), surface.specular)),
    );
}

fn unpack_surface(geometry: vec4u, reflectance: vec4u) -> PackedSurface {
    var surface: PackedSurface;
    surface.frame = unpack_frame(unpack_normal(geometry.x), geometry.z);
    surface.geometric_normal = unpack_normal(geometry.y);
    surface.material = geometry.z >> 16u;
    surface.finish = geometry.w;
    surface.base_color = vec3f(unpack2x16float(reflectance.x), unpack2x16float(reflectance.y & 0x7fffu).x);
    let root = f32((reflectance.y >> 15u) & 0x3ffu) / 1023.0;
    surface.roughness = root * root;
    surface.metallic = f32(reflectance.y >> 25u) / 127.0;
    surface.emission = unpack_rgb9e5(reflectance.z);
    let specular = unpack4x8unorm(reflectance.w);
    surface.specular_color = specular.rgb * specular.rgb;
    surface.specular = specular.a;
    return surface;
}
