// Distance (x) and barycentric coordinates (yzw) of where a ray meets a triangle whose corners are given from its origin; a distance below 0
// where it does not. The signs of the ray's Pluecker products with the three edges decide (as in Embree's robust mode): neighbours compute
// the same number for a shared edge but for its sign, so that no ray passes between them.
fn triangle_hit(a: vec3f, b: vec3f, c: vec3f, direction: vec3f) -> vec4f {
    let e0 = c - a;
    let e1 = a - b;
    let e2 = b - c;
    let u = dot(cross(e0, c + a), direction);
    let v = dot(cross(e1, a + b), direction);
    let w = dot(cross(e2, b + c), direction);
    let sum = u + v + w;
    let normal = cross(e1, e0);
    let denominator = dot(normal, direction);
    let outside = min(u, min(v, w)) < 0.0 && max(u, max(v, w)) > 0.0;
    if outside || sum == 0.0 || denominator == 0.0 {
        return vec4f(-1.0, 0.0, 0.0, 0.0);
    }
    return vec4f(dot(a, normal) / denominator, vec3f(w, u, v) / sum);
}
