#import math
#import brdf_area
#import brdf_sampling
#import brdf_lobe

// Sheen of cloth (KHR_materials_sheen; Conty Estevez and Kulla 2017). Twin: `sheen.rs` of `gnomon_brdf`.

const MIN_SHEEN_ROUGHNESS: f32 = 0.1;

fn alpha_from_sheen_roughness(roughness: f32) -> f32 {
    let clamped = clamp(roughness, MIN_SHEEN_ROUGHNESS, 1.0);
    return clamped * clamped;
}

fn d_charlie(n_dot_h: f32, alpha: f32) -> f32 {
    let sine2 = max(max(1.0 - n_dot_h, 0.0) * (1.0 + n_dot_h), 1e-20);
    return (2.0 + 1.0 / alpha) / TAU * pow(sine2, 0.5 / alpha);
}

// Logarithm of Smith's auxiliary function below 60 degrees: the paper's fit.
fn log_lambda_charlie(x: f32, alpha: f32) -> f32 {
    let t = (1.0 - alpha) * (1.0 - alpha);
    let a = mix(21.5473, 25.3245, t);
    let b = mix(3.82987, 3.32435, t);
    let c = mix(0.19823, 0.16801, t);
    let d = mix(-1.97760, -1.27393, t);
    let e = mix(-4.32054, -4.85967, t);
    return a / (1.0 + b * pow(max(x, 1e-9), c)) + d * x + e;
}

fn lambda_charlie(cosine: f32, alpha: f32) -> f32 {
    if cosine < 0.5 {
        return exp(log_lambda_charlie(cosine, alpha));
    }
    return exp(2.0 * log_lambda_charlie(0.5, alpha) - log_lambda_charlie(1.0 - cosine, alpha));
}

// Value of white sheen [1/sr], without the cosine.
fn sheen_value(roughness: f32, wo: vec3f, wi: vec3f) -> f32 {
    if wi.z <= 0.0 {
        return 0.0;
    }
    let alpha = alpha_from_sheen_roughness(roughness);
    let n_dot_v = max(wo.z, MIN_N_DOT_V);
    let n_dot_l = max(wi.z, MIN_N_DOT_V);
    let masking = 1.0 + lambda_charlie(n_dot_v, alpha) + lambda_charlie(n_dot_l, alpha);
    return d_charlie(half_vector(wo, wi).z, alpha) / (masking * 4.0 * n_dot_v * n_dot_l);
}

// Uniform over the hemisphere.
fn sheen_sample(u: vec2f) -> vec3f {
    let r = sqrt(max((1.0 - u.x) * (1.0 + u.x), 0.0));
    return vec3f(r * cos(TAU * u.y), r * sin(TAU * u.y), u.x);
}

const SHEEN_LIGHT_POINTS: u32 = 3u;

// Integral of white sheen times the cosine over an area light: the mean of a few points of it.
fn sheen_light(roughness: f32, wo: vec3f, light: LightPatch) -> f32 {
    // A square for a disk, of its area.
    let scale = select(1.0, 0.5 * sqrt(PI), light.is_disk);
    let a = scale * light.half_width;
    let b = scale * light.half_height;
    let points = f32(SHEEN_LIGHT_POINTS);
    var sum = 0.0;
    for (var i = 0u; i < SHEEN_LIGHT_POINTS * SHEEN_LIGHT_POINTS; i++) {
        let place = (2.0 * vec2f(vec2u(i % SHEEN_LIGHT_POINTS, i / SHEEN_LIGHT_POINTS)) + 1.0) / points - 1.0;
        let wi = normalize(light.direction + place.x * a + place.y * b);
        sum += sheen_value(roughness, wo, wi) * max(wi.z, 0.0);
    }
    return sum * 4.0 * length(cross(a, b)) / (points * points);
}

// Share of uniform light that white sheen reflects: the exponential of a polynomial.
fn sheen_albedo(n_dot_v: f32, roughness: f32) -> f32 {
    let x = 2.0 * pow(clamp(n_dot_v, MIN_N_DOT_V, 1.0), 0.35) - 1.0;
    let least = sqrt(MIN_SHEEN_ROUGHNESS);
    let y = 2.0 * (sqrt(clamp(roughness, MIN_SHEEN_ROUGHNESS, 1.0)) - least) / (1.0 - least) - 1.0;
let c0 = ((((0.102027 * y + -0.397441) * y + -0.00734018) * y + 0.357819) * y + 0.274512) * y + -0.74026;
    let c1 = ((((0.277774 * y + -0.696752) * y + 0.860866) * y + -0.964969) * y + 1.00308) * y + -1.33475;
    let c2 = (((-0.476526 * y + 1.3289) * y + -1.39064) * y + 0.846554) * y + -0.686047;
    let c3 = ((0.511931 * y + -1.30587) * y + 0.994721) * y + -0.245873;
    let c4 = (-0.455921 * y + 1.0186) * y + -0.585693;
    let c5 = 0.395611 * y + -0.163936;
    let c6 = -0.348205;
    return exp((((((c6 * x + c5) * x + c4) * x + c3) * x + c2) * x + c1) * x + c0);
}
