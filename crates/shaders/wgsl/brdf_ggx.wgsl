#import math

// Symbols: n normal, v = wo, l = wi, h half vector; alpha = roughness^2.

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

// Schlick 1994, eq. 15, with a free value at grazing incidence.
fn f_schlick(f0: vec3f, f90: f32, v_dot_h: f32) -> vec3f {
    let m = clamp(1.0 - v_dot_h, 0.0, 1.0);
    let m2 = m * m;
    return f0 + (vec3f(f90) - f0) * (m2 * m2 * m);
}
