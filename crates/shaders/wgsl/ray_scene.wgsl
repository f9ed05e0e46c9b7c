#import types
#import triangle_hit
#import micromap

// The scene's triangles in two levels of hierarchies of boxes, walked without a stack: nodes lie in depth-first order, each with the number
// of the next one where it is missed. The upper level's leaves are instances. The importer's pass binds both buffers.

@group(GROUP_SHADOW) @binding(1) var<storage, read> ray_nodes: array<RayNode>;
// Three to a triangle: corners, and in the first one's w where its micromap begins, 0 without a mask. Micromaps follow: a word with the
// divisions, then bits.
@group(GROUP_SHADOW) @binding(2) var<storage, read> ray_triangles: array<vec4u>;

// Components of a direction are never 0: a product with an infinite inverse would be no number.
const LEAST_COMPONENT: f32 = 1e-18;

fn is_hole(micromap: u32, v: f32, w: f32) -> bool {
    let bit = micro_triangle(v, w, ray_triangles[micromap].x);
    let word = ray_triangles[micromap + 1u + bit / 128u][(bit / 32u) % 4u];
    return ((word >> (bit % 32u)) & 1u) == 0u;
}

// Whether a triangle lies along a ray before `reach`, in lengths of `direction`.
fn is_hit(triangle: u32, origin: vec3f, direction: vec3f, reach: f32) -> bool {
    let a = ray_triangles[3u * triangle];
    let b = bitcast<vec3f>(ray_triangles[3u * triangle + 1u].xyz);
    let c = bitcast<vec3f>(ray_triangles[3u * triangle + 2u].xyz);
    let hit = triangle_hit(bitcast<vec3f>(a.xyz) - origin, b - origin, c - origin, direction);
    if hit.x <= 0.0 || hit.x >= reach {
        return false;
    }
    return a.w == 0u || !is_hole(a.w, hit.z, hit.w);
}

// What blocked the last ray of this invocation often blocks the next one.
var<private> last_blocker: u32 = 0xffffffffu;

// Whether anything lies along a ray before `reach`, in lengths of `direction`.
fn is_occluded(origin: vec3f, direction: vec3f, reach: f32) -> bool {
    if last_blocker != 0xffffffffu && is_hit(last_blocker, origin, direction, reach) {
        return true;
    }
    let tiny = abs(direction) < vec3f(LEAST_COMPONENT);
    let inverse = 1.0 / select(direction, vec3f(LEAST_COMPONENT), tiny);
    let shifted = -origin * inverse;
    let top_end = ray_nodes[0].skip;
    var node = 0u;
    var end = top_end;
    var resume = 0u;
    loop {
        if node >= end {
            if end == top_end {
                return false;
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
        let leaves = min(min(far.x, far.y), min(far.z, reach));
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
                if is_hit(members / RAY_LEAF + i, origin, direction, reach) {
                    last_blocker = members / RAY_LEAF + i;
                    return true;
                }
            }
            node++;
        }
    }
    return false;
}
