#import brdf_sampling

// Phong's lobe for a specular colour of 1, 1 / sr: reciprocal, normalised along the normal (Lafortune and Willems 1994, eqs. 1 and 8).
fn phong_lobe(shininess: f32, n: vec3f, wo: vec3f, wi: vec3f) -> f32 {
    return (shininess + 2.0) / TAU * cosine_power(dot(reflect(-wo, n), wi), shininess);
}

fn phong_sample(shininess: f32, n: vec3f, wo: vec3f, u: vec2f) -> vec3f {
    return world_from_local(reflect(-wo, n), sample_cosine_power(shininess, u));
}

fn phong_pdf(shininess: f32, n: vec3f, wo: vec3f, wi: vec3f) -> f32 {
    let cosine = dot(reflect(-wo, n), wi);
    return select(0.0, (shininess + 1.0) / TAU * cosine_power(cosine, shininess), cosine > 0.0);
}
