#import types
#import hit_normals
#import edges
#import placing

// Brings the hierarchies of boxes to where the frame's vertices are, from the leaves up.

@group(GROUP_PASS) @binding(0) var<storage, read> positions_world: array<vec4f>;
// Vertices of a triangle, and where its micromap begins.
@group(GROUP_PASS) @binding(1) var<storage, read> ray_indices: array<vec4u>;
// Placements of the leaves, then all nodes, the lowest first.
@group(GROUP_PASS) @binding(2) var<storage, read> by_height: array<u32>;
@group(GROUP_PASS) @binding(3) var<storage, read_write> ray_nodes: array<RayNode>;
@group(GROUP_PASS) @binding(4) var<storage, read_write> ray_triangles: array<vec4u>;
// The first of the nodes that are all as high, and the one after the last.
@group(GROUP_PASS) @binding(5) var<uniform> level: vec2u;
@group(GROUP_PASS) @binding(6) var<storage, read> normals_world: array<vec4f>;
// World space from where vertices are, 0 of those in world space.
@group(GROUP_PASS) @binding(7) var<storage, read> placements: array<mat4x4f>;

fn place_of(workgroup: vec3u, groups: vec3u, local: u32) -> u32 {
    return level.x + (workgroup.y * groups.x + workgroup.x) * RAY_WORKGROUP + local;
}

fn node_of(workgroup: vec3u, groups: vec3u, local: u32) -> u32 {
    let place = place_of(workgroup, groups, local);
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
    let placement = by_height[place_of(workgroup, groups, local) - (level.y - level.x)];
    let world_from_drawn = placements[placement];
    let normal_from_drawn = normal_matrix(linear_part(world_from_drawn));
    let first = ray_nodes[node].members / RAY_LEAF;
    let count = ray_nodes[node].members % RAY_LEAF;
    var low = vec3f(3.4e38);
    var high = vec3f(-3.4e38);
    for (var i = first; i < first + count; i++) {
        let vertices = ray_indices[i];
        var normals_of = array(normals_world[vertices.x].xyz, normals_world[vertices.y].xyz, normals_world[vertices.z].xyz);
        if placement > 0u {
            for (var k = 0u; k < 3u; k++) {
                let normal = normal_from_drawn * normals_of[k];
                normals_of[k] = normal / max(length(normal), 1e-20);
            }
        }
        let normals = pack_thirds(normals_of[0], normals_of[1], normals_of[2]);
        // What is known of the sides stands above the last normal.
        let sides = ray_triangles[3u * i + 2u].w & 0xf0000000u;
        let beside = vec3u(vertices.w, normals.x, normals.y | sides);
        for (var k = 0u; k < 3u; k++) {
            var corner = positions_world[vertices[k]].xyz;
            if placement > 0u {
                corner = (world_from_drawn * vec4f(corner, 1.0)).xyz;
            }
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
