#import types
#import hit_normals
#import edges

// Brings the hierarchies of boxes to where the frame's vertices are, from the leaves up.

@group(GROUP_PASS) @binding(0) var<storage, read> positions_world: array<vec4f>;
// Vertices of a triangle, and where its micromap begins.
@group(GROUP_PASS) @binding(1) var<storage, read> ray_indices: array<vec4u>;
// Nodes, the lowest first.
@group(GROUP_PASS) @binding(2) var<storage, read> by_height: array<u32>;
@group(GROUP_PASS) @binding(3) var<storage, read_write> ray_nodes: array<RayNode>;
@group(GROUP_PASS) @binding(4) var<storage, read_write> ray_triangles: array<vec4u>;
// The first of the nodes that are all as high, and the one after the last.
@group(GROUP_PASS) @binding(5) var<uniform> level: vec2u;
@group(GROUP_PASS) @binding(6) var<storage, read> normals_world: array<vec4f>;

fn node_of(workgroup: vec3u, groups: vec3u, local: u32) -> u32 {
    let place = level.x + (workgroup.y * groups.x + workgroup.x) * RAY_WORKGROUP + local;
    if place >= level.y {
        return 0xffffffffu;
    }
    return by_height[place];
}

@compute @workgroup_size(RAY_WORKGROUP)
fn refit_leaves(
    @builtin(workgroup_id) workgroup: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let node = node_of(workgroup, groups, local);
    if node == 0xffffffffu {
        return;
    }
    let first = ray_nodes[node].members / RAY_LEAF;
    let count = ray_nodes[node].members % RAY_LEAF;
    var low = vec3f(3.4e38);
    var high = vec3f(-3.4e38);
    for (var i = first; i < first + count; i++) {
        let vertices = ray_indices[i];
        let normals =
            pack_thirds(normals_world[vertices.x].xyz, normals_world[vertices.y].xyz, normals_world[vertices.z].xyz);
        // What is known of the sides stands above the last normal.
        let sides = ray_triangles[3u * i + 2u].w & 0xf0000000u;
        let beside = vec3u(vertices.w, normals.x, normals.y | sides);
        for (var k = 0u; k < 3u; k++) {
            let corner = positions_world[vertices[k]].xyz;
            ray_triangles[3u * i + k] = vec4u(bitcast<vec3u>(corner), beside[k]);
            low = min(low, corner);
            high = max(high, corner);
        }
    }
    let padding = BOX_PADDING * max(abs(low), abs(high));
    ray_nodes[node].low = low - padding;
    ray_nodes[node].high = high + padding;
}

@compute @workgroup_size(RAY_WORKGROUP)
fn refit_nodes(
    @builtin(workgroup_id) workgroup: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let node = node_of(workgroup, groups, local);
    if node == 0xffffffffu {
        return;
    }
    let first = node + 1u;
    let second = ray_nodes[first].skip;
    ray_nodes[node].low = min(ray_nodes[first].low, ray_nodes[second].low);
    ray_nodes[node].high = max(ray_nodes[first].high, ray_nodes[second].high);
}
