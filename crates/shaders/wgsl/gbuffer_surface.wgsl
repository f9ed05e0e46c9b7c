#import sample_places
#import brdf_models

// What is seen through the samples of the picture.

@group(GROUP_SURFACE) @binding(0) var gbuffer_depth: texture_depth_2d;
@group(GROUP_SURFACE) @binding(1) var gbuffer_normals: texture_2d<f32>;
@group(GROUP_SURFACE) @binding(2) var gbuffer_base_color_metallic: texture_2d<f32>;
@group(GROUP_SURFACE) @binding(3) var gbuffer_f0_f90: texture_2d<f32>;
@group(GROUP_SURFACE) @binding(4) var gbuffer_emissive_roughness: texture_2d<f32>;

struct Surface {
    position_world: vec3f,
    // Shading and geometric normal, towards the viewer, and the direction to the viewer.
    n: vec3f,
    geometric_normal: vec3f,
    wo: vec3f,
    // Tangent frame about n.
    frame: Frame,
    // Albedo of the matte part.
    diffuse_color: vec3f,
    // Tint of the interface above the matte part, for models that have one.
    interface_tint: vec4f,
    // The glossy part.
    lobe: Lobe,
    emission: vec3f,
}

// Depth of a sample, 0 where it shows the background.
fn depth_at(sample: vec2u) -> f32 {
    return textureLoad(gbuffer_depth, gbuffer_texel(sample), 0);
}

// Homogeneous point of the world seen through a sample at a depth.
fn unproject(sample: vec2u, depth: f32) -> vec4f {
    let ndc = sample_place(sample) / vec2f(view.size) * vec2f(2.0, -2.0) + vec2f(-1.0, 1.0);
    return view.world_from_clip * vec4f(ndc, depth, 1.0);
}

fn position_at(sample: vec2u, depth: f32) -> vec3f {
    let homogeneous = unproject(sample, depth);
    return homogeneous.xyz / homogeneous.w;
}

fn normal_at(sample: vec2u) -> vec3f {
    return octahedral_decode(textureLoad(gbuffer_normals, gbuffer_texel(sample), 0).xy);
}

// The model that the G-buffer's metallic share stands for.
fn model_from_code(metallic: f32) -> u32 {
    return u32(max(0.5 - metallic, 0.0));
}

// What a sample of a depth above 0 shows.
fn surface_at(sample: vec2u, depth: f32) -> Surface {
    let texel = gbuffer_texel(sample);
    let normals = textureLoad(gbuffer_normals, texel, 0);
    let base_color_metallic = textureLoad(gbuffer_base_color_metallic, texel, 0);
    let f0_f90 = textureLoad(gbuffer_f0_f90, texel, 0);
    let emissive_roughness = textureLoad(gbuffer_emissive_roughness, texel, 0);
    // Negative: another model than metallic-roughness, its colours mixed already.
    let code = base_color_metallic.a;
    let metallic = max(code, 0.0);

    var surface: Surface;
    surface.position_world = position_at(sample, depth);
    surface.n = octahedral_decode(normals.xy);
    surface.geometric_normal = octahedral_decode(normals.zw);
    surface.wo = normalize(view.eye_world.xyz - surface.position_world * view.eye_world.w);
    surface.diffuse_color = base_color_metallic.rgb * (1.0 - metallic);
    surface.frame = frame_from_normal(surface.n);
    surface.interface_tint = f0_f90;
    let tint = mix(f0_f90, vec4f(base_color_metallic.rgb, 1.0), metallic);
    surface.lobe = Lobe(model_from_code(code), emissive_roughness.a, tint);
    surface.emission = emissive_roughness.rgb;
    return surface;
}
