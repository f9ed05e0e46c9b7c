#import brdf_lobe

// Blinn's lobe of the half vector (Blinn 1977): normalised along the normal.

// Inverse of the integral of cos(theta / 2)^s cos(theta) over the hemisphere, 1 / sr.
fn blinn_phong_norm(shininess: f32) -> f32 {
    return (shininess + 2.0) * (shininess + 4.0) / (8.0 * PI * (exp2(-0.5 * shininess) + shininess));
}

fn blinn_phong_lobe(lobe: Lobe, wo: vec3f, wi: vec3f) -> vec3f {
    return lobe.tint.rgb * (blinn_phong_norm(lobe.shape) * cosine_power(half_vector(wo, wi).z, lobe.shape));
}

fn blinn_phong_sample(lobe: Lobe, wo: vec3f, u: vec2f) -> vec3f {
    return reflect(-wo, sample_cosine_power(lobe.shape, u));
}

fn blinn_phong_pdf(lobe: Lobe, wo: vec3f, wi: vec3f) -> f32 {
    let h = half_vector(wo, wi);
    let v_dot_h = dot(wo, h);
    if h.z <= 0.0 || v_dot_h <= 0.0 {
        return 0.0;
    }
    return (lobe.shape + 1.0) / TAU * cosine_power(h.z, lobe.shape) / (4.0 * v_dot_h);
}

// Of the half vector; the cosine at the light's middle.
fn blinn_phong_light_lobe(lobe: Lobe, wo: vec3f, light: LightPatch) -> vec3f {
    let seen = half_vector_patch(wo, light);
    if !seen.is_seen {
        return vec3f(0.0);
    }
    let on_light =
        half_vector_share(seen, power_distance(seen.n_dot_h, lobe.shape), inverseSqrt(lobe.shape + 1.0));
    let norm = blinn_phong_norm(lobe.shape) * TAU / (lobe.shape + 1.0);
    return lobe.tint.rgb * (norm * 4.0 * seen.v_dot_h * on_light * light.direction.z);
}

// Walter et al. 2007, section 5.3.
fn blinn_phong_equivalent_roughness(lobe: Lobe) -> f32 {
    return sqrt(sqrt(2.0 / (lobe.shape + 2.0)));
}

// That of a narrow lobe falls with the cosine's square.
fn blinn_phong_albedo(lobe: Lobe, n_dot_v: f32, ggx: vec2f) -> vec3f {
    return lobe.tint.rgb * (n_dot_v * n_dot_v);
}

// At its centre the lobe goes with the cosine to the light, which is that to the viewer.
fn blinn_phong_cached(lobe: Lobe, radiance_f0: vec3f, radiance_f90: vec3f, cosines: f32) -> vec3f {
    return cosines * lobe.tint.rgb * radiance_f0;
}
