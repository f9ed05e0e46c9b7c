#import math

// What the reflectance models' samplers share.

// wo mirrored about the surface's normal.
fn mirrored(wo: vec3f) -> vec3f {
    return vec3f(-wo.xy, wo.z);
}

// cosine^exponent, 0 for a negative cosine unless the exponent is 0.
fn cosine_power(cosine: f32, exponent: f32) -> f32 {
    return pow(max(cosine, 1e-20), exponent);
}

// A direction about +z with the density (exponent + 1) / (2 pi) z^exponent.
fn sample_cosine_power(exponent: f32, u: vec2f) -> vec3f {
    let z = pow(1.0 - u.x, 1.0 / (exponent + 1.0));
    let r = sqrt(max((1.0 - z) * (1.0 + z), 0.0));
    return vec3f(r * cos(TAU * u.y), r * sin(TAU * u.y), z);
}

// Unit vector that halves the angle between two; 0 where they are opposite.
fn half_vector(wo: vec3f, wi: vec3f) -> vec3f {
    let sum = wo + wi;
    let length2 = dot(sum, sum);
    return select(vec3f(0.0), sum * inverseSqrt(max(length2, 1e-30)), length2 > 0.0);
}
