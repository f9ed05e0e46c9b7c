#import brdf_lobe

// Lambert's law: no glossy part.

fn lambert_lobe(lobe: Lobe, wo: vec3f, wi: vec3f) -> vec3f {
    return vec3f(0.0);
}

fn lambert_sample(lobe: Lobe, wo: vec3f, u: vec2f) -> vec3f {
    return vec3f(0.0, 0.0, 1.0);
}

fn lambert_pdf(lobe: Lobe, wo: vec3f, wi: vec3f) -> f32 {
    return 0.0;
}

fn lambert_light_lobe(lobe: Lobe, wo: vec3f, light: LightPatch) -> vec3f {
    return vec3f(0.0);
}
