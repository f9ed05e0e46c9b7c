const PI: f32 = 3.14159265358979;
const TAU: f32 = 6.28318530717959;

fn luminance(color: vec3f) -> f32 {
    return dot(color, vec3f(0.2126, 0.7152, 0.0722));
}

fn max_component(v: vec3f) -> f32 {
    return max(v.x, max(v.y, v.z));
}

// Octahedral map of a unit vector to [-1, 1]^2 (Cigolle et al. 2014).
fn octahedral_encode(n: vec3f) -> vec2f {
    let p = n.xy / (abs(n.x) + abs(n.y) + abs(n.z));
    if n.z >= 0.0 {
        return p;
    }
    return (1.0 - abs(p.yx)) * select(vec2f(-1.0), vec2f(1.0), p >= vec2f(0.0));
}

fn octahedral_decode(e: vec2f) -> vec3f {
    let z = 1.0 - abs(e.x) - abs(e.y);
    let t = max(-z, 0.0);
    return normalize(vec3f(e - select(vec2f(-t), vec2f(t), e >= vec2f(0.0)), z));
}

// CONVENTIONS.md, equirect.
fn uv_from_direction(direction: vec3f) -> vec2f {
    let u = atan2(direction.x, -direction.z) / TAU;
    let theta = atan2(length(direction.xz), direction.y);
    return vec2f(select(u, u + 1.0, u < 0.0), theta / PI);
}

fn direction_from_uv(uv: vec2f) -> vec3f {
    let phi = TAU * uv.x;
    let theta = PI * uv.y;
    return vec3f(sin(theta) * sin(phi), cos(theta), -sin(theta) * cos(phi));
}
