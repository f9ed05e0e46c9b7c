#import frame
#import edges
#import marks

// Marks for every light of a batch which triangles face its centre, which edges bound those and which nodes hold such edges: a bit each.

@group(GROUP_PASS) @binding(0) var<uniform> counts: SilhouetteCounts;
@group(GROUP_PASS) @binding(1) var<storage, read> ray_nodes: array<RayNode>;
@group(GROUP_PASS) @binding(2) var<storage, read> ray_triangles: array<vec4u>;
@group(GROUP_PASS) @binding(3) var<storage, read> edges: array<vec2u>;
@group(GROUP_PASS) @binding(4) var<storage, read_write> marks: array<u32>;
// Nodes around edges, the lowest first.
@group(GROUP_PASS) @binding(5) var<storage, read> by_height: array<u32>;
// The first of the nodes that are all as high, and the one after the last; the same of triangles.
@group(GROUP_PASS) @binding(6) var<uniform> level: vec2u;

const NOTHING: u32 = 0xffffffffu;

fn number(workgroup: vec3u, groups: vec3u, local: u32) -> u32 {
    let place = level.x + (workgroup.y * groups.x + workgroup.x) * RAY_WORKGROUP + local;
    return select(NOTHING, place, place < level.y);
}

fn faces(light: u32, corner: vec3f, normal: vec3f) -> bool {
    if lights[light].kind == KIND_DISTANT {
        return dot(normal, lights[light].direction) > 0.0;
    }
    return dot(normal, lights[light].position - corner) > 0.0;
}

@compute @workgroup_size(RAY_WORKGROUP)
fn mark_triangles(
    @builtin(workgroup_id) workgroup: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let triangle = number(workgroup, groups, local);
    if triangle == NOTHING {
        return;
    }
    let a = ray_corner(triangle, 0u);
    let normal = cross(ray_corner(triangle, 1u) - a, ray_corner(triangle, 2u) - a);
    for (var first = 0u; first < batch.end_light; first += 32u) {
        var mark = 0u;
        for (var light = first; light < min(first + 32u, batch.end_light); light++) {
            mark |= select(0u, 1u, faces(light, a, normal)) << (light - first);
        }
        marks[triangle_word(triangle, first)] = mark;
    }
}

@compute @workgroup_size(RAY_WORKGROUP)
fn mark_edges(
    @builtin(workgroup_id) workgroup: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let place = number(workgroup, groups, local);
    if place == NOTHING {
        return;
    }
    let node = by_height[place];
    let first_edge = ray_nodes[node].members / RAY_LEAF;
    let count = ray_nodes[node].members % RAY_LEAF;
    for (var light = 0u; light < batch.end_light; light += 32u) {
        var any = 0u;
        for (var edge = first_edge; edge < first_edge + count; edge++) {
            let wings = edges[edge];
            var mark = 0xffffffffu;
            if wings.y != NO_WING {
                // Both triangles bound what is covered: that cancels where they run against each other and face the same way.
                let other = marks[triangle_word(wings.x / 4u, light)] ^ marks[triangle_word(wings.y / 4u, light)];
                mark = select(other, ~other, (wings.y & 1u) == 1u);
            }
            marks[edge_word(edge, light)] = mark;
            any |= mark;
        }
        marks[node_word(node, light)] = any;
    }
}

@compute @workgroup_size(RAY_WORKGROUP)
fn mark_nodes(
    @builtin(workgroup_id) workgroup: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let place = number(workgroup, groups, local);
    if place == NOTHING {
        return;
    }
    let node = by_height[place];
    let second = ray_nodes[node + 1u].skip;
    for (var light = 0u; light < batch.end_light; light += 32u) {
        marks[node_word(node, light)] = marks[node_word(node + 1u, light)] | marks[node_word(second, light)];
    }
}
