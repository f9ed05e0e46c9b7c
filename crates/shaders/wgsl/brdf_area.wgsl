#import math

// Glossy lobes over area lights: `gnomon_brdf`'s area.rs says how far they hold.

// A light as a surface point sees it, in the point's tangent frame.
struct LightPatch {
    // Unit vector to its middle.
    direction: vec3f,
    // From there to the middles of two sides (or the rim of a disk) at a distance of 1, perpendicular to it.
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

// From `to`, `distance` away, to `origin`, in the plane across `origin`.
fn away(origin: vec3f, to: vec3f, distance: f32) -> vec3f {
    let across = to - origin * dot(origin, to);
    let length2 = dot(across, across);
    return select(vec3f(0.0), -distance * across * inverseSqrt(max(length2, 1e-30)), length2 > 0.0);
}

// A light in the plane across the half vector to its middle: what the half vector turns by as wi goes over the light.
struct HalfVectorPatch {
    h: vec3f,
    half_width: vec3f,
    half_height: vec3f,
    is_disk: bool,
    n_dot_h: f32,
    v_dot_h: f32,
    // False where the light's middle is under the surface, or the half vector about perpendicular to the normal or the view.
    is_seen: bool,
}

fn half_vector_patch(wo: vec3f, light: LightPatch) -> HalfVectorPatch {
    let sum = wo + light.direction;
    let sum_length = max(length(sum), 1e-6);
    let h = sum / sum_length;
    let v_dot_h = dot(wo, h);
    return HalfVectorPatch(
        h,
        (light.half_width - h * dot(h, light.half_width)) / sum_length,
        (light.half_height - h * dot(h, light.half_height)) / sum_length,
        light.is_disk,
        h.z,
        v_dot_h,
        light.direction.z > 0.0 && h.z > 1e-2 && v_dot_h > 1e-3,
    );
}

// Share of a normal distribution about the normal, which is `distance` away, that lies on the light.
fn half_vector_share(on: HalfVectorPatch, distance: f32, sigma: f32) -> f32 {
    let at = away(on.h, vec3f(0.0, 0.0, 1.0), distance);
    return gaussian_patch(at, on.half_width, on.half_height, sigma, on.is_disk);
}
