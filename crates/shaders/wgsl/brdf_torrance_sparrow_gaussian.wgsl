#import brdf_torrance_sparrow

// Torrance and Sparrow's microfacets with Gaussian angles; the lobe's shape is the angle at which the density has fallen to 1/e.

// Integral of exp(-(delta / m)^2) sin(2 delta) from 0 to pi/2 over m^2: polynomial in m^2 for m up to 1, relative error 1e-5.
fn gaussian_norm(slope: f32) -> f32 {
    let t = slope * slope;
    let high = 0.19254294 + t * (-0.14413678 + t * 0.03956238);
    return 1.00000802 + t * (-0.66748233 + t * (0.28008172 + t * (-0.15288954 + t * high)));
}

// Torrance and Sparrow 1967, eq. 6, projected area 1; 1 / sr.
fn d_gaussian(n_dot_h: f32, slope: f32) -> f32 {
    if n_dot_h <= 0.0 {
        return 0.0;
    }
    let angle = angle_from_cosine(n_dot_h);
    let m2 = slope * slope;
    return exp(-angle * angle / m2) / (PI * m2 * gaussian_norm(slope));
}

// The slope whose masking by `g1_smith_beckmann` is that of Gaussian angles, within 3 %.
fn gaussian_masking_slope(slope: f32) -> f32 {
    return slope * (1.0 + 0.1 * slope);
}

// Share of a Gaussian in the plane that lies within pi/2.
fn gaussian_share(slope: f32) -> f32 {
    let t = 0.5 * PI / slope;
    return 1.0 - exp(-t * t);
}

fn torrance_sparrow_gaussian_lobe(lobe: Lobe, wo: vec3f, wi: vec3f) -> vec3f {
    let h = half_vector(wo, wi);
    let masking = v_smith_beckmann(max(wo.z, MIN_N_DOT_V), wi.z, gaussian_masking_slope(lobe.shape));
    return schlick_lobe(lobe, d_gaussian(h.z, lobe.shape) * masking, dot(wo, h));
}

// wo mirrored about a microfacet drawn from what has a closed form, a Gaussian in the angle.
fn torrance_sparrow_gaussian_sample(lobe: Lobe, wo: vec3f, u: vec2f) -> vec3f {
    let angle = lobe.shape * sqrt(max(-log(1.0 - u.x * gaussian_share(lobe.shape)), 0.0));
    return reflect(-wo, vec3f(sin(angle) * cos(TAU * u.y), sin(angle) * sin(TAU * u.y), cos(angle)));
}

fn torrance_sparrow_gaussian_pdf(lobe: Lobe, wo: vec3f, wi: vec3f) -> f32 {
    let h = half_vector(wo, wi);
    let angle = angle_from_cosine(h.z);
    let m2 = lobe.shape * lobe.shape;
    let stretch = select(1.0, angle / sin(angle), angle > 1e-3);
    return pdf_mirrored(h.z, dot(wo, h), exp(-angle * angle / m2) * stretch / (PI * m2 * gaussian_share(lobe.shape)));
}

fn torrance_sparrow_gaussian_light_lobe(lobe: Lobe, wo: vec3f, light: LightPatch) -> vec3f {
    let seen = half_vector_patch(wo, light);
    if !seen.is_seen {
        return vec3f(0.0);
    }
    let on_light = half_vector_share(seen, angle_from_cosine(seen.n_dot_h), lobe.shape * 0.70710678)
        / gaussian_norm(lobe.shape);
    let masking_slope = gaussian_masking_slope(lobe.shape);
    let masking = v_smith_beckmann(max(wo.z, MIN_N_DOT_V), light.direction.z, masking_slope);
    return torrance_sparrow_light_lobe(lobe, light.direction.z, seen.v_dot_h, on_light, masking);
}

fn torrance_sparrow_gaussian_equivalent_roughness(lobe: Lobe) -> f32 {
    return sqrt(lobe.shape);
}
