#import brdf_sampling

// Torrance and Sparrow's microfacets with Smith's shadowing (Heidrich 2001, section 1.1). `slope` is m.

// Gaussian slopes (Walter et al. 2007, eq. 25), 1 / sr.
fn d_beckmann(n_dot_h: f32, slope: f32) -> f32 {
    if n_dot_h <= 1e-4 {
        return 0.0;
    }
    let c2 = n_dot_h * n_dot_h;
    let tan2 = max(1.0 - n_dot_h, 0.0) * (1.0 + n_dot_h) / c2;
    let m2 = slope * slope;
    return exp(-tan2 / m2) / (PI * m2 * c2 * c2);
}

fn angle_from_cosine(cosine: f32) -> f32 {
    return atan2(sqrt(max(1.0 - cosine, 0.0) * (1.0 + cosine)), cosine);
}

// Integral of exp(-(delta / m)^2) sin(2 delta) from 0 to pi/2 over m^2: polynomial in m^2 for m up to 1, relative error 1e-5.
fn gaussian_norm(slope: f32) -> f32 {
    let t = slope * slope;
    let high = 0.19254294 + t * (-0.14413678 + t * 0.03956238);
    return 1.00000802 + t * (-0.66748233 + t * (0.28008172 + t * (-0.15288954 + t * high)));
}

// Gaussian angles (Torrance and Sparrow 1967, eq. 6), projected area 1; 1 / sr.
fn d_gaussian(n_dot_h: f32, slope: f32) -> f32 {
    if n_dot_h <= 0.0 {
        return 0.0;
    }
    let angle = angle_from_cosine(n_dot_h);
    let m2 = slope * slope;
    return exp(-angle * angle / m2) / (PI * m2 * gaussian_norm(slope));
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

// The slope whose masking by `g1_smith_beckmann` is that of Gaussian angles, within 3 %.
fn gaussian_masking_slope(slope: f32) -> f32 {
    return slope * (1.0 + 0.1 * slope);
}

// Share of a Gaussian in the plane that lies within pi/2.
fn gaussian_share(slope: f32) -> f32 {
    let t = 0.5 * PI / slope;
    return 1.0 - exp(-t * t);
}

// Microfacet normals as they are drawn: D (n.h) of Beckmann's; of the other a Gaussian in the angle, which has a closed form.
fn beckmann_sample(slope: f32, u: vec2f) -> vec3f {
    let tangent = slope * sqrt(max(-log(1.0 - u.x), 0.0));
    let cosine = inverseSqrt(1.0 + tangent * tangent);
    let sine = tangent * cosine;
    return vec3f(sine * cos(TAU * u.y), sine * sin(TAU * u.y), cosine);
}

fn gaussian_sample(slope: f32, u: vec2f) -> vec3f {
    let angle = slope * sqrt(max(-log(1.0 - u.x * gaussian_share(slope)), 0.0));
    return vec3f(sin(angle) * cos(TAU * u.y), sin(angle) * sin(TAU * u.y), cos(angle));
}

fn beckmann_pdf(n_dot_h: f32, slope: f32) -> f32 {
    return d_beckmann(n_dot_h, slope) * n_dot_h;
}

fn gaussian_pdf(n_dot_h: f32, slope: f32) -> f32 {
    let angle = angle_from_cosine(n_dot_h);
    let m2 = slope * slope;
    let stretch = select(1.0, angle / sin(angle), angle > 1e-3);
    return exp(-angle * angle / m2) * stretch / (PI * m2 * gaussian_share(slope));
}
