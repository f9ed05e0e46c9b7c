#import brdf_sampling

// Symbols: n normal, v = wo, l = wi, h half vector; alpha = roughness^2.

// At least `gnomon_brdf::MIN_ALPHA`.
fn alpha_from_roughness(roughness: f32) -> f32 {
    return clamp(roughness * roughness, 0.002, 1.0);
}

// Trowbridge-Reitz (Walter et al. 2007, eq. 33), 1 / sr.
fn d_ggx(n_dot_h: f32, alpha: f32) -> f32 {
    let a2 = alpha * alpha;
    let t = 1.0 - n_dot_h * n_dot_h * (1.0 - a2);
    return a2 / (PI * t * t);
}

// Height-correlated Smith masking-shadowing over 4 (n.v)(n.l) (Heitz 2014, eq. 99).
fn v_smith_ggx_correlated(n_dot_v: f32, n_dot_l: f32, alpha: f32) -> f32 {
    let a2 = alpha * alpha;
    let v = n_dot_l * sqrt(n_dot_v * n_dot_v * (1.0 - a2) + a2);
    let l = n_dot_v * sqrt(n_dot_l * n_dot_l * (1.0 - a2) + a2);
    return 0.5 / max(v + l, 1e-7);
}

// Smith masking of one direction (Heitz 2014, eqs. 43 and 72) of a positive cosine.
fn g1_smith_ggx(cosine: f32, alpha: f32) -> f32 {
    let c2 = cosine * cosine;
    let a2_tan2 = alpha * alpha * max(1.0 - c2, 0.0) / c2;
    return 1.0 / (1.0 + 0.5 * a2_tan2 / (sqrt(1.0 + a2_tan2) + 1.0));
}

// Microfacet normal about +z, distributed as those that wo sees (Heitz 2018, appendix A).
fn sample_ggx_vndf(wo: vec3f, alpha: f32, u: vec2f) -> vec3f {
    // Stretch the view so that alpha becomes 1.
    let v = normalize(vec3f(alpha * wo.x, alpha * wo.y, wo.z));
    let length2 = v.x * v.x + v.y * v.y;
    let t1 = select(vec3f(1.0, 0.0, 0.0), vec3f(-v.y, v.x, 0.0) * inverseSqrt(max(length2, 1e-30)), length2 > 0.0);
    let t2 = cross(v, t1);
    // A point of the projected hemisphere: a disk whose lower half is foreshortened.
    let r = sqrt(u.x);
    let p1 = r * cos(TAU * u.y);
    let s = 0.5 * (1.0 + v.z);
    let p2 = (1.0 - s) * sqrt(max(1.0 - p1 * p1, 0.0)) + s * r * sin(TAU * u.y);
    let h = t1 * p1 + t2 * p2 + v * sqrt(max(1.0 - p1 * p1 - p2 * p2, 0.0));
    return normalize(vec3f(alpha * h.x, alpha * h.y, max(h.z, 1e-7)));
}

// Density of wo's reflection about such a normal, 1 / sr (Heitz 2018, eqs. 3 and 17).
fn pdf_ggx_vndf(wo: vec3f, wi: vec3f, alpha: f32) -> f32 {
    let h = half_vector(wo, wi);
    if wo.z <= 0.0 || dot(wo, h) <= 0.0 {
        return 0.0;
    }
    return g1_smith_ggx(wo.z, alpha) * d_ggx(saturate(h.z), alpha) / (4.0 * wo.z);
}
