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

// The lobe over an area light of which `on_light` is the microfacets' share. Cosine, `masking` over the microfacet denominator, and Fresnel
// are those of its middle.
fn torrance_sparrow_light_lobe(lobe: Lobe, n_dot_l: f32, v_dot_h: f32, on_light: f32, masking: f32) -> vec3f {
    // The microfacet turns by half as much as the light: a quarter of its solid angle over v.h.
    return schlick_lobe(lobe, on_light * (4.0 * n_dot_l * masking * v_dot_h), v_dot_h);
}

// Share of microfacets with Gaussian slopes of this root mean square that mirror a light. The slope's own plane would be exact, but stretches
// a light at grazing half vectors without bound.
fn gaussian_slopes_on(seen: HalfVectorPatch, slope: f32) -> f32 {
    let n_dot_h = seen.n_dot_h;
    let tangent = sqrt(max(1.0 - n_dot_h, 0.0) * (1.0 + n_dot_h)) / n_dot_h;
    let c2 = n_dot_h * n_dot_h;
    return half_vector_share(seen, tangent, slope * 0.70710678) / (c2 * c2);
}

// Density of the mirrored direction, that of the microfacet's normal being `pdf_normal` (Walter et al. 2007, eq. 14).
fn pdf_mirrored(n_dot_h: f32, v_dot_h: f32, pdf_normal: f32) -> f32 {
    return select(0.0, pdf_normal / (4.0 * v_dot_h), n_dot_h > 0.0 && v_dot_h > 0.0);
}
