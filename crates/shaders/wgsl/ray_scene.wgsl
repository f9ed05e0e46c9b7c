#import types
#import triangle_hit
#import micromap
#import pyramid_meets_box

// The scene's triangles in two levels of hierarchies of boxes, walked without a stack: nodes lie in depth-first order, each with the number
// of the next one where it is missed. The upper level's leaves are instances: nodes in world space, or a copy of a mesh, to whose space rays
// are taken; their directions there are as long as the distances that they count need. The importer's pass binds both buffers.

@group(GROUP_SHADOW) @binding(1) var<storage, read> ray_nodes: array<RayNode>;
// Three to a triangle: corners, and in the first one's w where its micromap begins, 0 where it stops all light. Micromaps follow: the
// divisions and the number of bits of an opacity, then opacities. Then copies: rows of the transform from world space to the mesh's, rows of
// that back, the first node.
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
    // Where the copy that it is of begins, 0 in world space.
    copy: u32,
}

fn no_hit() -> RayHit {
    return RayHit(-1.0, 0.0, NO_TRIANGLE, 0.0, 0.0, 0u);
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

// Through three rows of a transform that begin there.
fn through_rows(first: u32, value: vec4f) -> vec3f {
    return vec3f(
        dot(bitcast<vec4f>(ray_triangles[first]), value),
        dot(bitcast<vec4f>(ray_triangles[first + 1u]), value),
        dot(bitcast<vec4f>(ray_triangles[first + 2u]), value),
    );
}

// A copy's normal in world space, up to its length: by the transpose of the transform to its mesh.
fn normal_of_copy(copy: u32, normal: vec3f) -> vec3f {
    return bitcast<vec3f>(ray_triangles[copy].xyz) * normal.x
        + bitcast<vec3f>(ray_triangles[copy + 1u].xyz) * normal.y
        + bitcast<vec3f>(ray_triangles[copy + 2u].xyz) * normal.z;
}

// A ray as the triangles of a copy, 0 for those in world space, are given.
struct Ray {
    origin: vec3f,
    direction: vec3f,
    // To the planes of boxes.
    inverse: vec3f,
    shifted: vec3f,
    copy: u32,
}

fn ray_to(copy: u32, origin: vec3f, direction: vec3f) -> Ray {
    var ray: Ray;
    ray.origin = origin;
    ray.direction = direction;
    ray.copy = copy;
    if copy != 0u {
        ray.origin = through_rows(copy, vec4f(origin, 1.0));
        ray.direction = through_rows(copy, vec4f(direction, 0.0));
    }
    let tiny = abs(ray.direction) < vec3f(LEAST_COMPONENT);
    ray.inverse = 1.0 / select(ray.direction, vec3f(LEAST_COMPONENT), tiny);
    ray.shifted = -ray.origin * ray.inverse;
    return ray;
}

// Where a triangle lies along a ray before `reach`, in lengths of `direction`.
fn hit_of(triangle: u32, ray: Ray, reach: f32) -> RayHit {
    let corners = ray_corners(triangle);
    let hit = triangle_hit(corners[0] - ray.origin, corners[1] - ray.origin, corners[2] - ray.origin, ray.direction);
    if hit.x <= 0.0 || hit.x >= reach {
        return no_hit();
    }
    let micromap = ray_triangles[3u * triangle].w;
    var opacity = 1.0;
    if micromap != 0u {
        opacity = micromap_opacity(micromap, hit.z, hit.w);
    }
    return RayHit(hit.x, opacity, triangle, hit.z, hit.w, ray.copy);
}

// What blocked the last ray of this invocation often blocks the next one.
var<private> last_blocker: u32 = NO_TRIANGLE;
var<private> last_copy: u32;
// Where the last ray that met anything met it, in lengths of its direction: the first that was found, not the nearest.
var<private> last_distance: f32;

// Parts of the hierarchies in depth-first order, of the mesh in world space or the copy (z) that they belong to: from a node (x) to before
// another (y).
var<private> gathered: array<vec3u, RAY_PARTS>;
var<private> gathered_parts: u32;

const RAY_PARTS: u32 = 8u;
// Leaves so many nodes apart belong to one part: boxes in between cost less than another part.
const RAY_PART_GAP: u32 = 6u;
// Of a mesh of which more leaves are met, its rays meet enough: the rest of it is one part.
const RAY_MOST_LEAVES: u32 = 24u;

// Gathers what rays from one origin may meet before `reach`, in lengths of their directions, whose components lie between `least` and `most`.
// False where that is too much.
fn gather(origin: vec3f, least: vec3f, most: vec3f, reach: f32) -> bool {
    let top_end = ray_nodes[0].skip;
    gathered_parts = 0u;
    var node = 0u;
    var end = top_end;
    var resume = 0u;
    // Leaves of the mesh that were met, 0 at its beginning.
    var leaves = 0u;
    loop {
        if node >= end {
            if end == top_end {
                return true;
            }
            node = resume;
            end = top_end;
            continue;
        }
        let is_met =
            pyramid_meets_box(least, most, ray_nodes[node].low - origin, ray_nodes[node].high - origin, reach);
        let members = ray_nodes[node].members;
        let count = members % RAY_LEAF;
        if !is_met {
            node = ray_nodes[node].skip;
        } else if count == RAY_INSTANCE {
            resume = node + 1u;
            node = members / RAY_LEAF;
            end = ray_nodes[node].skip;
            leaves = 0u;
        } else if count == 0u {
            node++;
        } else {
            var part = vec3u(node, node + 1u, 0u);
            if count == RAY_COPY {
                let copy = members / RAY_LEAF;
                let first = ray_triangles[copy + 6u].x;
                part = vec3u(first, ray_nodes[first].skip, copy);
            }
            leaves++;
            let is_dense = end != top_end && leaves >= RAY_MOST_LEAVES;
            let is_last = end != top_end && leaves > 1u && gathered_parts == RAY_PARTS;
            let last = gathered_parts - 1u;
            if is_dense || is_last {
                gathered[last].y = end;
                node = end;
            } else {
                if leaves > 1u && end != top_end && part.x - gathered[last].y <= RAY_PART_GAP {
                    gathered[last].y = part.y;
                } else if gathered_parts == RAY_PARTS {
                    return false;
                } else {
                    gathered[gathered_parts] = part;
                    gathered_parts++;
                }
                node++;
            }
        }
    }
    return true;
}

// Share of the light along a ray that nothing stops before `reach`, in lengths of `direction`.
fn transmittance(origin: vec3f, direction: vec3f, reach: f32) -> f32 {
    return transmittance_through(origin, direction, reach, false);
}

// The same of one of the rays for which `gather` was called last, if `is_gathered`.
fn transmittance_through(origin: vec3f, direction: vec3f, reach: f32, is_gathered: bool) -> f32 {
    if is_gathered && gathered_parts == 0u {
        return 1.0;
    }
    if last_blocker != NO_TRIANGLE {
        let again = hit_of(last_blocker, ray_to(last_copy, origin, direction), reach);
        if again.opacity == 1.0 {
            last_distance = again.distance;
            return 0.0;
        }
    }
    let traced = trace(origin, direction, reach, -1.0, is_gathered);
    if traced.left < 1.0 {
        last_distance = traced.hit.distance;
    }
    if traced.left == 0.0 {
        last_blocker = traced.hit.triangle;
        last_copy = traced.hit.copy;
    }
    return traced.left;
}

// The nearest of what stops a ray before `reach`; `chance`, in [0, 1), decides where only a share of rays stops.
fn nearest_hit(origin: vec3f, direction: vec3f, reach: f32, chance: f32) -> RayHit {
    return trace(origin, direction, reach, chance, false).hit;
}

// Along a ray: what stops it, or what of its light is left.
struct Traced {
    hit: RayHit,
    left: f32,
}

// The nearest of what stops a ray before `reach` by `chance`; where that is below 0, what is left of its light, and the first that is found of
// what stops all of it. Of what was gathered alone, if `is_gathered`.
fn trace(origin: vec3f, direction: vec3f, reach: f32, chance: f32, is_gathered: bool) -> Traced {
    let in_world = ray_to(0u, origin, direction);
    var ray = in_world;
    let top_end = ray_nodes[0].skip;
    var found = no_hit();
    var left = 1.0;
    var limit = reach;
    var node = 0u;
    var end = select(top_end, 0u, is_gathered);
    var resume = 0u;
    var part = 0u;
    loop {
        if node >= end {
            if is_gathered {
                if part == gathered_parts {
                    break;
                }
                node = gathered[part].x;
                end = gathered[part].y;
                if gathered[part].z != ray.copy {
                    ray = ray_to(gathered[part].z, origin, direction);
                }
                part++;
                continue;
            }
            if end == top_end {
                break;
            }
            node = resume;
            end = top_end;
            ray = in_world;
            continue;
        }
        let low = ray_nodes[node].low * ray.inverse + ray.shifted;
        let high = ray_nodes[node].high * ray.inverse + ray.shifted;
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
        } else if count == RAY_COPY {
            resume = node + 1u;
            let copy = members / RAY_LEAF;
            ray = ray_to(copy, origin, direction);
            node = ray_triangles[copy + 6u].x;
            end = ray_nodes[node].skip;
        } else {
            for (var i = 0u; i < count; i++) {
                let hit = hit_of(members / RAY_LEAF + i, ray, limit);
                if chance >= 0.0 {
                    // Every triangle has a chance of its own.
                    if fract(chance + f32((hit.triangle + hit.copy) % 4096u) * 0.61803399) < hit.opacity {
                        found = hit;
                        limit = hit.distance;
                    }
                } else if hit.opacity == 1.0 {
                    return Traced(hit, 0.0);
                } else {
                    left *= 1.0 - hit.opacity;
                    if hit.opacity > 0.0 {
                        found = hit;
                    }
                }
            }
            node++;
        }
    }
    return Traced(found, left);
}
