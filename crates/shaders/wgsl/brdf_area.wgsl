#import brdf_reflectance

// Glossy lobes over area lights: `gnomon_brdf`'s area.rs says how far they hold.

// A light as a surface point sees it: unit vector to its middle, and from there to the middles of two sides (or the rim of a disk) at a
// distance of 1, perpendicular to it.
struct LightPatch {
    direction: vec3f,
    half_width: vec3f,
    half_height: vec3f,
    is_disk: bool,
}

// Abramowitz and Stegun 1964, 7.1.26; its series where that is the better.
fn erf(x: f32) -> f32 {
    let z = abs(x);
    if z < 0.1 {
        return 1.1283792 * x * (1.0 + z * z * (z * z * 0.1 - 1.0 / 3.0));
    }
    let t = 1.0 / (1.0 + 0.3275911 * z);
    let poly = t * (0.2548296 + t * (-0.28449674 + t * (1.4214137 + t * (-1.453152 + t * 1.0614054))));
    return (1.0 - poly * exp(-z * z)) * sign(x);
}

// Share of a normal distribution within 1 of `center`.
fn gaussian_interval(center: f32, sigma: f32) -> f32 {
    if sigma > 5.0 {
        // The difference of two error functions would lose its digits.
        let t2 = (center / sigma) * (center / sigma);
        let curvature = 1.0 + (t2 - 1.0) / (6.0 * sigma * sigma);
        return 0.7978846 / sigma * exp(-0.5 * t2) * curvature;
    }
    let scale = 0.70710678 / sigma;
    return 0.5 * (erf((center + 1.0) * scale) - erf((center - 1.0) * scale));
}

// Share of an isotropic normal distribution of the plane on a parallelogram or ellipse around `at` with the half sides a and b.
fn gaussian_patch(at: vec3f, a: vec3f, b: vec3f, sigma: f32, is_disk: bool) -> f32 {
    let aa = dot(a, a);
    let bb = dot(b, b);
    let ab = dot(a, b);
    let area2 = max(aa * bb - ab * ab, 1e-30);
    if is_disk {
        // `at` in radii.
        let along_a = dot(at, a);
        let along_b = dot(at, b);
        let distance = length(vec2f(along_a * bb - along_b * ab, along_b * aa - along_a * ab) / area2);
        let area = sqrt(area2);
        let radius = select(sqrt(area), length(at) / max(distance, 1e-4), distance > 1e-4);
        let sigma_across = sigma * radius / area;
        return gaussian_interval(distance, sigma / radius) * erf(0.25 * PI * 0.70710678 / sigma_across);
    }
    // The longer side keeps its direction.
    let first = select(b, a, aa >= bb);
    let second = select(a, b, aa >= bb);
    let length2 = max(max(aa, bb), 1e-30);
    let across = second - first * (ab / length2);
    let across2 = max(area2 / length2, 1e-30);
    return gaussian_interval(dot(at, first) / length2, sigma / max(sqrt(length2), 1e-15))
        * gaussian_interval(dot(at, across) / across2, sigma * inverseSqrt(across2));
}

// Distance at which a Gaussian of variance 1 / (s + 1) is cosine^s.
fn power_distance(cosine: f32, s: f32) -> f32 {
    return sqrt(-2.0 * s / (s + 1.0) * log(clamp(cosine, 1e-20, 1.0)));
}

// From `to`, `distance` away, to `from`, in the plane across `from`.
fn away(origin: vec3f, to: vec3f, distance: f32) -> vec3f {
    let across = to - origin * dot(origin, to);
    let length2 = dot(across, across);
    return select(vec3f(0.0), -distance * across * inverseSqrt(max(length2, 1e-30)), length2 > 0.0);
}

// What a half vector h of |wo + wi| = `sum` turns by as wi moves by e.
fn half_vector_turn(h: vec3f, sum: f32, e: vec3f) -> vec3f {
    return (e - h * dot(h, e)) / max(sum, 1e-6);
}

// `reflectance_lobe` times the cosine, integrated over an area light: radiance reflected per unit of the light's, x f0 + y f90.
fn light_lobe(model: u32, parameter: f32, n: vec3f, wo: vec3f, light: LightPatch) -> vec2f {
    let wi = light.direction;
    let a = light.half_width;
    let b = light.half_height;
    let n_dot_l = dot(n, wi);
    if n_dot_l <= 0.0 {
        return vec2f(0.0);
    }
    if model == MODEL_PHONG {
        let mirrored = reflect(-wo, n);
        let at = away(wi, mirrored, power_distance(dot(mirrored, wi), parameter));
        let on_light = gaussian_patch(at, a, b, inverseSqrt(parameter + 1.0), light.is_disk);
        return vec2f((parameter + 2.0) / (parameter + 1.0) * on_light * n_dot_l, 0.0);
    }
    if model == MODEL_METALLIC_ROUGHNESS {
        let flat_area = select(4.0, PI, light.is_disk) * length(cross(a, b));
        return reflectance_lobe(model, parameter, n, wo, wi) * (n_dot_l * flat_area);
    }
    let sum = length(wo + wi);
    let h = (wo + wi) / max(sum, 1e-6);
    let n_dot_h = dot(n, h);
    let v_dot_h = dot(wo, h);
    if model == MODEL_LAMBERT || n_dot_h <= 1e-2 || v_dot_h <= 1e-3 {
        return vec2f(0.0);
    }
    let turn_a = half_vector_turn(h, sum, a);
    let turn_b = half_vector_turn(h, sum, b);
    if model == MODEL_BLINN_PHONG {
        let at = away(h, n, power_distance(n_dot_h, parameter));
        let on_light = gaussian_patch(at, turn_a, turn_b, inverseSqrt(parameter + 1.0), light.is_disk);
        let norm = blinn_phong_norm(parameter) * TAU / (parameter + 1.0);
        return vec2f(norm * 4.0 * v_dot_h * on_light * n_dot_l, 0.0);
    }
    var on_light = 0.0;
    var masking_slope = parameter;
    let sigma = parameter * 0.70710678;
    if model == MODEL_TORRANCE_SPARROW_BECKMANN {
        let tangent = sqrt(max(1.0 - n_dot_h, 0.0) * (1.0 + n_dot_h)) / n_dot_h;
        let c2 = n_dot_h * n_dot_h;
        on_light = gaussian_patch(away(h, n, tangent), turn_a, turn_b, sigma, light.is_disk) / (c2 * c2);
    } else {
        let at = away(h, n, angle_from_cosine(n_dot_h));
        on_light = gaussian_patch(at, turn_a, turn_b, sigma, light.is_disk) / gaussian_norm(parameter);
        masking_slope = gaussian_masking_slope(parameter);
    }
    let n_dot_v = max(dot(n, wo), MIN_N_DOT_V);
    let masking = g1_smith_beckmann(n_dot_v, masking_slope) * g1_smith_beckmann(n_dot_l, masking_slope) / n_dot_v;
    let share = schlick_share(v_dot_h);
    return on_light * v_dot_h * masking * vec2f(1.0 - share, share);
}
