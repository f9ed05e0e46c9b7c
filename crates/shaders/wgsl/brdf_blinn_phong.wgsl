#import brdf_sampling

// Inverse of the integral of cos(theta / 2)^s cos(theta) over the hemisphere, 1 / sr.
fn blinn_phong_norm(shininess: f32) -> f32 {
    return (shininess + 2.0) * (shininess + 4.0) / (8.0 * PI * (exp2(-0.5 * shininess) + shininess));
}

// Blinn's lobe for a specular colour of 1 (Blinn 1977), 1 / sr: normalised along the normal.
fn blinn_phong_lobe(shininess: f32, n: vec3f, wo: vec3f, wi: vec3f) -> f32 {
    return blinn_phong_norm(shininess) * cosine_power(dot(n, half_vector(wo, wi)), shininess);
}

fn blinn_phong_sample(shininess: f32, n: vec3f, wo: vec3f, u: vec2f) -> vec3f {
    return reflect(-wo, world_from_local(n, sample_cosine_power(shininess, u)));
}

fn blinn_phong_pdf(shininess: f32, n: vec3f, wo: vec3f, wi: vec3f) -> f32 {
    let h = half_vector(wo, wi);
    let n_dot_h = dot(n, h);
    let v_dot_h = dot(wo, h);
    if n_dot_h <= 0.0 || v_dot_h <= 0.0 {
        return 0.0;
    }
    return (shininess + 1.0) / TAU * cosine_power(n_dot_h, shininess) / (4.0 * v_dot_h);
}
