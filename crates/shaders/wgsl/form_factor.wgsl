#import math

// One edge of Lambert's polygon formula (Lambert 1760): half its angle times the normal of its plane, along n.
fn edge_form_factor(n: vec3f, a: vec3f, b: vec3f) -> f32 {
    // (b - a) x a equals b x a, and keeps its digits for the short edges of small lights.
    let c = cross(b - a, a);
    let sine = length(c);
    if sine == 0.0 {
        return 0.0;
    }
    return 0.5 * atan2(sine, dot(a, b)) * dot(c, n) / sine;
}

// Integral of max(0, n . w) over the convex quadrilateral with unit corner directions, counter-clockwise seen from the scene:
// Lambert's polygon formula after clipping against the horizon. [sr]
fn rectangle_form_factor(n: vec3f, corners: array<vec4f, 4>) -> f32 {
    var corner = corners;
    var sum = 0.0;
    var entry = vec3f(0.0);
    var exit = vec3f(0.0);
    var crossings = 0u;
    for (var i = 0u; i < 4u; i++) {
        let a = corner[i].xyz;
        let b = corner[(i + 1u) % 4u].xyz;
        let height_a = dot(a, n);
        let height_b = dot(b, n);
        if height_a >= 0.0 && height_b >= 0.0 {
            sum += edge_form_factor(n, a, b);
        } else if height_a >= 0.0 {
            exit = normalize(mix(a, b, height_a / (height_a - height_b)));
            sum += edge_form_factor(n, a, exit);
            crossings++;
        } else if height_b >= 0.0 {
            entry = normalize(mix(a, b, height_a / (height_a - height_b)));
            sum += edge_form_factor(n, entry, b);
            crossings++;
        }
    }
    if crossings == 2u {
        sum += edge_form_factor(n, exit, entry);
    }
    return max(sum, 0.0);
}

// Integral of max(0, n . w) over the cone of `angular_radius` about `direction`, in closed form (Snyder 1996; Lagarde and
// de Rousiers 2014, listing 7). [sr]
fn disk_form_factor(n: vec3f, direction: vec3f, angular_radius: f32) -> f32 {
    let cos_theta = clamp(dot(n, direction), -1.0, 1.0);
    let sin_radius = sin(angular_radius);
    let sin2_radius = sin_radius * sin_radius;
    if cos_theta >= sin_radius {
        return PI * sin2_radius * cos_theta;
    }
    if cos_theta <= -sin_radius {
        return 0.0;
    }
    let sin_theta = sqrt(max(1.0 - cos_theta * cos_theta, 1e-12));
    let x = sqrt(max(1.0 / sin2_radius - 1.0, 0.0));
    let y = clamp(-x * (cos_theta / sin_theta), -1.0, 1.0);
    let root = sin_theta * sqrt(max(1.0 - y * y, 0.0));
    return max((cos_theta * acos(y) - x * root) * sin2_radius + atan2(root, x), 0.0);
}
