#import brdf_lobe

// What Torrance and Sparrow's microfacets share: Smith's shadowing (Heidrich 2001, section 1.1).

fn angle_from_cosine(cosine: f32) -> f32 {
    return atan2(sqrt(max(1.0 - cosine, 0.0) * (1.0 + cosine)), cosine);
}

// Smith's masking of one direction, rational form of Walter et al. 2007, eq. 27.
fn g1_smith_beckmann(cosine: f32, slope: f32) -> f32 {
    if cosine <= 0.0 {
        return 0.0;
    }
    let sine = sqrt(max(1.0 - cosine, 0.0) * (1.0 + cosine));
    if cosine >= 1.6 * slope * sine {
        return 1.0;
    }
    let a = cosine / (slope * sine);
    return a * (3.535 + 2.181 * a) / (1.0 + a * (2.276 + 2.577 * a));
}

// G1 G1 over 4 (n.v)(n.l) (Walter et al. 2007, eqs. 20 and 23).
fn v_smith_beckmann(n_dot_v: f32, n_dot_l: f32, slope: f32) -> f32 {
    return g1_smith_beckmann(n_dot_v, slope) * g1_smith_beckmann(n_dot_l, slope) / (4.0 * n_dot_v * n_dot_l);
}

// The lobe over an area light of which `on_light` is the microfacets' share. Cosine, masking and Fresnel are those of its middle.
fn torrance_sparrow_light_lobe(
    lobe: Lobe,
    wo: vec3f,
    n_dot_l: f32,
    v_dot_h: f32,
    on_light: f32,
    masking_slope: f32,
) -> vec3f {
    let n_dot_v = max(wo.z, MIN_N_DOT_V);
    let masking = g1_smith_beckmann(n_dot_v, masking_slope) * g1_smith_beckmann(n_dot_l, masking_slope) / n_dot_v;
    return schlick_lobe(lobe, on_light * v_dot_h * masking, v_dot_h);
}

// Density of the mirrored direction, that of the microfacet's normal being `pdf_normal` (Walter et al. 2007, eq. 14).
fn pdf_mirrored(n_dot_h: f32, v_dot_h: f32, pdf_normal: f32) -> f32 {
    return select(0.0, pdf_normal / (4.0 * v_dot_h), n_dot_h > 0.0 && v_dot_h > 0.0);
}
