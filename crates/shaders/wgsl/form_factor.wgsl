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

// Lambert's formula over a convex polygon, edge by edge, clipped against the horizon on the way.
struct HorizonClip {
    sum: f32,
    // Where the outline rises through the horizon, and where it sinks.
    entry: vec3f,
    exit: vec3f,
    crossings: u32,
}

fn add_edge(clip: ptr<function, HorizonClip>, n: vec3f, a: vec3f, b: vec3f) {
    let height_a = dot(a, n);
    let height_b = dot(b, n);
    if height_a >= 0.0 && height_b >= 0.0 {
        (*clip).sum += edge_form_factor(n, a, b);
    } else if height_a >= 0.0 {
        (*clip).exit = normalize(mix(a, b, height_a / (height_a - height_b)));
        (*clip).sum += edge_form_factor(n, a, (*clip).exit);
        (*clip).crossings++;
    } else if height_b >= 0.0 {
        (*clip).entry = normalize(mix(a, b, height_a / (height_a - height_b)));
        (*clip).sum += edge_form_factor(n, (*clip).entry, b);
        (*clip).crossings++;
    }
}

fn clipped_form_factor(clip: HorizonClip, n: vec3f) -> f32 {
    if clip.crossings == 2u {
        return max(clip.sum + edge_form_factor(n, clip.exit, clip.entry), 0.0);
    }
    return max(clip.sum, 0.0);
}

// Integral of max(0, n . w) over the convex quadrilateral seen towards four corners of any distance, counter-clockwise seen from the
// scene: Lambert's polygon formula after clipping against the horizon. [sr]
fn rectangle_form_factor(n: vec3f, corners: array<vec4f, 4>) -> f32 {
    var corner = corners;
    var clip = HorizonClip();
    for (var i = 0u; i < 4u; i++) {
        add_edge(&clip, n, corner[i].xyz, corner[(i + 1u) % 4u].xyz);
    }
    return clipped_form_factor(clip, n);
}

// Corners of the polygon that stands for a disk of the same area: `gnomon_lights::form_factor` states the error.
const DISK_CORNERS: u32 = 16u;
// sqrt(2 pi / (16 sin(2 pi / 16))).
const DISK_CORNER_RADIUS: f32 = 1.0130016;

// Integral of max(0, n . w) over a flat disk around `center`, whose radius along two axes is `a` and `b`, a x b away from
// its front. [sr]
fn flat_disk_form_factor(n: vec3f, center: vec3f, a: vec3f, b: vec3f) -> f32 {
    var clip = HorizonClip();
    var previous = center + DISK_CORNER_RADIUS * a;
    for (var i = 1u; i <= DISK_CORNERS; i++) {
        let angle = TAU * f32(i) / f32(DISK_CORNERS);
        let next = center + DISK_CORNER_RADIUS * (cos(angle) * a - sin(angle) * b);
        add_edge(&clip, n, previous, next);
        previous = next;
    }
    return clipped_form_factor(clip, n);
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
