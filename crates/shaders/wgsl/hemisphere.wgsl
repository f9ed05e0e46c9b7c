#import math

// Hemisphere about +z mapped to the square [-1, 1]^2: the upper half of the octahedral map, turned by 45 degrees (Cigolle et al. 2014).

fn hemisphere_encode(n: vec3f) -> vec2f {
    let p = n.xy / (abs(n.x) + abs(n.y) + max(n.z, 0.0));
    return vec2f(p.x + p.y, p.x - p.y);
}

fn hemisphere_decode(e: vec2f) -> vec3f {
    let p = 0.5 * vec2f(e.x + e.y, e.x - e.y);
    return normalize(vec3f(p, 1.0 - abs(p.x) - abs(p.y)));
}
