#import brdf_torrance_sparrow

// Torrance and Sparrow's microfacets with Gaussian slopes, whose root mean square is the lobe's shape.

// Walter et al. 2007, eq. 25, 1 / sr.
fn d_beckmann(n_dot_h: f32, slope: f32) -> f32 {
    if n_dot_h <= 1e-4 {
        return 0.0;
    }
    let c2 = n_dot_h * n_dot_h;
    let tan2 = max(1.0 - n_dot_h, 0.0) * (1.0 + n_dot_h) / c2;
    let m2 = slope * slope;
    return exp(-tan2 / m2) / (PI * m2 * c2 * c2);
}

fn torrance_sparrow_beckmann_lobe(lobe: Lobe, wo: vec3f, wi: vec3f) -> vec3f {
    let h = half_vector(wo, wi);
    let masking = v_smith_beckmann(max(wo.z, MIN_N_DOT_V), wi.z, lobe.shape);
    return schlick_lobe(lobe, d_beckmann(h.z, lobe.shape) * masking, dot(wo, h));
}

// wo mirrored about a microfacet drawn from D (n.h).
fn torrance_sparrow_beckmann_sample(lobe: Lobe, wo: vec3f, u: vec2f) -> vec3f {
    let tangent = lobe.shape * sqrt(max(-log(1.0 - u.x), 0.0));
    let cosine = inverseSqrt(1.0 + tangent * tangent);
    let sine = tangent * cosine;
    return reflect(-wo, vec3f(sine * cos(TAU * u.y), sine * sin(TAU * u.y), cosine));
}

fn torrance_sparrow_beckmann_pdf(lobe: Lobe, wo: vec3f, wi: vec3f) -> f32 {
    let h = half_vector(wo, wi);
    return pdf_mirrored(h.z, dot(wo, h), d_beckmann(h.z, lobe.shape) * h.z);
}

fn torrance_sparrow_beckmann_light_lobe(lobe: Lobe, wo: vec3f, light: LightPatch) -> vec3f {
    let seen = half_vector_patch(wo, light);
    if !seen.is_seen {
        return vec3f(0.0);
    }
    let masking = v_smith_beckmann(max(wo.z, MIN_N_DOT_V), light.direction.z, lobe.shape);
    return torrance_sparrow_light_lobe(lobe, light.direction.z, seen.v_dot_h, gaussian_slopes_on(seen, lobe.shape), masking);
}

fn torrance_sparrow_beckmann_equivalent_roughness(lobe: Lobe) -> f32 {
    return sqrt(lobe.shape);
}
