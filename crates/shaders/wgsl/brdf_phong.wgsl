#import brdf_lobe

// Phong's lobe: reciprocal, normalised along the normal (Lafortune and Willems 1994, eqs. 1 and 8).

fn phong_lobe(lobe: Lobe, wo: vec3f, wi: vec3f) -> vec3f {
    return lobe.tint.rgb * ((lobe.shape + 2.0) / TAU * cosine_power(dot(mirrored(wo), wi), lobe.shape));
}

fn phong_sample(lobe: Lobe, wo: vec3f, u: vec2f) -> vec3f {
    return world_from_local(frame_from_normal(mirrored(wo)), sample_cosine_power(lobe.shape, u));
}

fn phong_pdf(lobe: Lobe, wo: vec3f, wi: vec3f) -> f32 {
    let cosine = dot(mirrored(wo), wi);
    return select(0.0, (lobe.shape + 1.0) / TAU * cosine_power(cosine, lobe.shape), cosine > 0.0);
}

// About the mirrored view; the cosine at the light's middle.
fn phong_light_lobe(lobe: Lobe, wo: vec3f, light: LightPatch) -> vec3f {
    let wi = light.direction;
    if wi.z <= 0.0 {
        return vec3f(0.0);
    }
    let peak = mirrored(wo);
    let at = away(wi, peak, power_distance(dot(peak, wi), lobe.shape));
    let sigma = inverseSqrt(lobe.shape + 1.0);
    let on_light = gaussian_patch(at, light.half_width, light.half_height, sigma, light.is_disk);
    return lobe.tint.rgb * ((lobe.shape + 2.0) / (lobe.shape + 1.0) * on_light * wi.z);
}

// The exponent is a quarter of Blinn's.
fn phong_equivalent_roughness(lobe: Lobe) -> f32 {
    return sqrt(sqrt(2.0 / (4.0 * lobe.shape + 2.0)));
}

// That of a narrow lobe falls with the cosine.
fn phong_albedo(lobe: Lobe, n_dot_v: f32, ggx: vec2f) -> vec3f {
    return lobe.tint.rgb * n_dot_v;
}

// At its centre the lobe goes with the cosine to the light, which is that to the viewer.
fn phong_cached(lobe: Lobe, radiance_f0: vec3f, radiance_f90: vec3f, cosines: f32) -> vec3f {
    return cosines * lobe.tint.rgb * radiance_f0;
}
