#import gbuffer_surface

// Surfaces of a scene none of whose materials has a finish: the base's parts are all. `finish_some.wgsl` says what the functions are.

struct SurfaceFinish {
    none: u32,
}

fn finish_of(material: Material, packed: PackedSurface, lobe: Lobe, wo: vec3f) -> SurfaceFinish {
    return SurfaceFinish(0u);
}

fn has_finish(surface: Surface) -> bool {
    return false;
}

fn has_gloss(surface: Surface) -> bool {
    return has_lobe(surface.lobe);
}

fn glossy_parts(surface: Surface) -> u32 {
    return 1u;
}

fn base_share(surface: Surface) -> f32 {
    return 1.0;
}

fn emitted_through(finish: SurfaceFinish, emission: vec3f) -> vec3f {
    return emission;
}

fn matte_weight_of(surface: Surface, v_dot_h: f32) -> f32 {
    return reflectance_matte_weight(surface.lobe, surface.interface_tint, v_dot_h);
}

fn gloss_value(surface: Surface, wo: vec3f, wi: vec3f) -> vec3f {
    return reflectance_lobe(surface.lobe, wo, wi);
}

fn gloss_sample(surface: Surface, wo: vec3f, u: vec2f) -> vec3f {
    return reflectance_sample(surface.lobe, wo, u);
}

fn gloss_pdf(surface: Surface, wo: vec3f, wi: vec3f) -> f32 {
    return reflectance_pdf(surface.lobe, wo, wi);
}

fn gloss_light(surface: Surface, wo: vec3f, light: LightPatch) -> vec3f {
    return reflectance_light_lobe(surface.lobe, wo, light);
}

fn sharpest_alpha(surface: Surface) -> f32 {
    return alpha_from_roughness(reflectance_equivalent_roughness(surface.lobe));
}

fn widest_alpha(surface: Surface) -> f32 {
    return alpha_from_roughness(reflectance_equivalent_roughness(surface.lobe));
}

fn sharpest_alpha_of(material: Material, packed: PackedSurface, lobe: Lobe) -> f32 {
    return select(1.0, alpha_from_roughness(reflectance_equivalent_roughness(lobe)), has_lobe(lobe));
}

fn coat_lobe_of(surface: Surface) -> Lobe {
    return surface.lobe;
}

fn sheen_albedo_of(surface: Surface) -> vec3f {
    return vec3f(0.0);
}

fn coat_normal_of(surface: Surface) -> vec3f {
    return surface.n;
}
