#import types
#import edges

// Brings boxes around edges to where the frame's vertices are. Those above them follow as those above triangles do (`ray_refit.wgsl`).

@group(GROUP_PASS) @binding(0) var<storage, read> ray_triangles: array<vec4u>;
@group(GROUP_PASS) @binding(1) var<storage, read> edges: array<vec2u>;
// Nodes, the lowest first.
@group(GROUP_PASS) @binding(2) var<storage, read> by_height: array<u32>;
@group(GROUP_PASS) @binding(3) var<storage, read_write> ray_nodes: array<RayNode>;
// The first of the leaves, and the one after the last.
@group(GROUP_PASS) @binding(4) var<uniform> level: vec2u;

@compute @workgroup_size(RAY_WORKGROUP)
fn refit_edge_leaves(
    @builtin(workgroup_id) workgroup: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let place = level.x + (workgroup.y * groups.x + workgroup.x) * RAY_WORKGROUP + local;
    if place >= level.y {
        return;
    }
    let node = by_height[place];
    let first = ray_nodes[node].members / RAY_LEAF;
    let count = ray_nodes[node].members % RAY_LEAF;
    var low = vec3f(3.4e38);
    var high = vec3f(-3.4e38);
    for (var i = first; i < first + count; i++) {
        let ends = edge_ends(edges[i].x);
        low = min(low, min(ends[0], ends[1]));
        high = max(high, max(ends[0], ends[1]));
    }
    let padding = BOX_PADDING * max(abs(low), abs(high));
    ray_nodes[node].low = low - padding;
    ray_nodes[node].high = high + padding;
}
