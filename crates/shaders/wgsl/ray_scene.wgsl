#import types
#import triangle_hit
#import micromap

// The scene's triangles in two levels of hierarchies of boxes, walked without a stack: nodes lie in depth-first order, each with the number
// of the next one where it is missed. The upper level's leaves are instances. The importer's pass binds both buffers.

@group(GROUP_SHADOW) @binding(1) var<storage, read> ray_nodes: array<RayNode>;
// Three to a triangle: corners, and in the first one's w where its micromap begins, 0 where it stops all light. Micromaps follow: the
// divisions and the number of bits of an opacity, then opacities.
@group(GROUP_SHADOW) @binding(2) var<storage, read> ray_triangles: array<vec4u>;

// Components of a direction are never 0: a product with an infinite inverse would be no number.
const LEAST_COMPONENT: f32 = 1e-18;

fn micromap_opacity(micromap: u32, v: f32, w: f32) -> f32 {
    let header = ray_triangles[micromap];
    let bit = header.y * micro_triangle(v, w, header.x);
    let word = ray_triangles[micromap + 1u + bit / 128u][(bit / 32u) % 4u] >> (bit % 32u);
    return select(f32(word & 0xffu) / 255.0, f32(word & 1u), header.y == 1u);
}

// What a ray meets.
struct RayHit {
    // In lengths of the ray's direction; not above 0 where there is nothing.
    distance: f32,
    // Share of rays that stop there.
    opacity: f32,
    triangle: u32,
    // Barycentric coordinates of its second and third corner.
    v: f32,
    w: f32,
}

fn no_hit() -> RayHit {
    return RayHit(-1.0, 0.0, NO_TRIANGLE, 0.0, 0.0);
}

const NO_TRIANGLE: u32 = 0xffffffffu;

fn ray_corners(triangle: u32) -> mat3x3f {
    let first = 3u * triangle;
    return mat3x3f(
        bitcast<vec3f>(ray_triangles[first].xyz),
        bitcast<vec3f>(ray_triangles[first + 1u].xyz),
        bitcast<vec3f>(ray_triangles[first + 2u].xyz),
    );
}

// Normals of its corners, see `hit_normals.wgsl`.
fn ray_normals(triangle: u32) -> vec2u {
    return vec2u(ray_triangles[3u * triangle + 1u].w, ray_triangles[3u * triangle + 2u].w);
}

// Where a triangle lies along a ray before `reach`, in lengths of `direction`.
fn hit_of(triangle: u32, origin: vec3f, direction: vec3f, reach: f32) -> RayHit {
    let corners = ray_corners(triangle);
    let hit = triangle_hit(corners[0] - origin, corners[1] - origin, corners[2] - origin, direction);
    if hit.x <= 0.0 || hit.x >= reach {
        return no_hit();
    }
    let micromap = ray_triangles[3u * triangle].w;
    var opacity = 1.0;
    if micromap != 0u {
        opacity = micromap_opacity(micromap, hit.z, hit.w);
    }
    return RayHit(hit.x, opacity, triangle, hit.z, hit.w);
}

// What blocked the last ray of this invocation often blocks the next one.
var<private> last_blocker: u32 = NO_TRIANGLE;

// Share of the light along a ray that nothing stops before `reach`, in lengths of `direction`.
fn transmittance(origin: vec3f, direction: vec3f, reach: f32) -> f32 {
    if last_blocker != NO_TRIANGLE && hit_of(last_blocker, origin, direction, reach).opacity == 1.0 {
        return 0.0;
    }
    let traced = trace(origin, direction, reach, -1.0);
    if traced.left == 0.0 {
        last_blocker = traced.hit.triangle;
    }
    return traced.left;
}

// The nearest of what stops a ray before `reach`; `chance`, in [0, 1), decides where only a share of rays stops.
fn nearest_hit(origin: vec3f, direction: vec3f, reach: f32, chance: f32) -> RayHit {
    return trace(origin, direction, reach, chance).hit;
}

// Along a ray: what stops it, or what of its light is left.
struct Traced {
    hit: RayHit,
    left: f32,
}

// The nearest of what stops a ray before `reach` by `chance`; where that is below 0, what is left of its light, and the first that is found of
// what stops all of it.
fn trace(origin: vec3f, direction: vec3f, reach: f32, chance: f32) -> Traced {
    let tiny = abs(direction) < vec3f(LEAST_COMPONENT);
    let inverse = 1.0 / select(direction, vec3f(LEAST_COMPONENT), tiny);
    let shifted = -origin * inverse;
    let top_end = ray_nodes[0].skip;
    var found = no_hit();
    var left = 1.0;
    var limit = reach;
    var node = 0u;
    var end = top_end;
    var resume = 0u;
    loop {
        if node >= end {
            if end == top_end {
                break;
            }
            node = resume;
            end = top_end;
            continue;
        }
        let low = ray_nodes[node].low * inverse + shifted;
        let high = ray_nodes[node].high * inverse + shifted;
        let near = min(low, high);
        let far = max(low, high);
        let enters = max(max(near.x, near.y), max(near.z, 0.0));
        let leaves = min(min(far.x, far.y), min(far.z, limit));
        let members = ray_nodes[node].members;
        let count = members % RAY_LEAF;
        if enters > leaves {
            node = ray_nodes[node].skip;
        } else if count == RAY_INSTANCE {
            resume = node + 1u;
            node = members / RAY_LEAF;
            end = ray_nodes[node].skip;
        } else {
            for (var i = 0u; i < count; i++) {
                let hit = hit_of(members / RAY_LEAF + i, origin, direction, limit);
                if chance >= 0.0 {
                    // Every triangle has a chance of its own.
                    if fract(chance + f32(hit.triangle % 4096u) * 0.61803399) < hit.opacity {
                        found = hit;
                        limit = hit.distance;
                    }
                } else if hit.opacity == 1.0 {
                    return Traced(hit, 0.0);
                } else {
                    left *= 1.0 - hit.opacity;
                }
            }
            node++;
        }
    }
    return Traced(found, left);
}
