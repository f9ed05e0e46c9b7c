#import types
#import placing

// Mesh space to world space, every frame: geometry may have moved. Morph targets first, then joints (linear blend
// skinning). One thread a vertex.

@group(GROUP_PASS) @binding(0) var<storage, read> vertices: array<MeshVertex>;
@group(GROUP_PASS) @binding(1) var<storage, read> instances: array<Instance>;
@group(GROUP_PASS) @binding(2) var<storage, read_write> positions_world: array<vec4f>;
@group(GROUP_PASS) @binding(3) var<storage, read_write> normals_world: array<vec4f>;
@group(GROUP_PASS) @binding(4) var<storage, read_write> tangents_world: array<vec4f>;
// Of each vertex that has any: number of joints, number of morph targets, then (joint, weight) of every joint and
// (target, position, normal, tangent) of every target that moves it. Floats as bits.
@group(GROUP_PASS) @binding(5) var<storage, read> records: array<u32>;
// World space from the pose in which meshes were bound.
@group(GROUP_PASS) @binding(6) var<storage, read> joints: array<mat4x4f>;
@group(GROUP_PASS) @binding(7) var<storage, read> weights: array<f32>;

struct Placed {
    position: vec3f,
    normal: vec3f,
    tangent: vec3f,
    // Of the bitangent: -1 where the mesh is mirrored, `mirror_sign` of the reference.
    side: f32,
}

fn record_vector(at: u32) -> vec3f {
    return bitcast<vec3f>(vec3u(records[at], records[at + 1u], records[at + 2u]));
}

fn deformed(vertex: MeshVertex, instance: Instance) -> Placed {
    let joint_count = records[vertex.record];
    let target_count = records[vertex.record + 1u];
    var at = vertex.record + 2u + 2u * joint_count;
    var placed = Placed(vertex.position, vertex.normal, vertex.tangent, 1.0);
    for (var i = 0u; i < target_count; i += 1u) {
        let weight = weights[instance.first_weight + records[at]];
        placed.position += weight * record_vector(at + 1u);
        placed.normal += weight * record_vector(at + 4u);
        placed.tangent += weight * record_vector(at + 7u);
        at += 10u;
    }
    var world_from_mesh = instance.world_from_mesh;
    if instance.first_joint != NO_SKIN && joint_count > 0u {
        world_from_mesh = mat4x4f();
        for (var i = 0u; i < joint_count; i += 1u) {
            let entry = vertex.record + 2u + 2u * i;
            world_from_mesh += bitcast<f32>(records[entry + 1u]) * joints[instance.first_joint + records[entry]];
        }
    }
    let linear = linear_part(world_from_mesh);
    let normal_from_mesh = normal_matrix(linear);
    // Not through the matrix's fourth row: weights sum to 1 only up to rounding.
    return Placed(
        linear * placed.position + world_from_mesh[3].xyz,
        normal_from_mesh * placed.normal,
        normal_from_mesh * placed.tangent,
        mirror_sign(linear),
    );
}

@compute @workgroup_size(VERTEX_WORKGROUP)
fn transform(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    // Two dimensions of workgroups: one holds at most 65535 of them.
    let index = id.y * groups.x * VERTEX_WORKGROUP + id.x;
    if index >= arrayLength(&vertices) {
        return;
    }
    let vertex = vertices[index];
    let instance = instances[vertex.instance];
    var placed: Placed;
    if vertex.record == 0u {
        placed.position = (instance.world_from_mesh * vec4f(vertex.position, 1.0)).xyz;
        placed.normal = (instance.normal_from_mesh * vec4f(vertex.normal, 0.0)).xyz;
        placed.tangent = (instance.normal_from_mesh * vec4f(vertex.tangent, 0.0)).xyz;
        placed.side = mirror_sign(linear_part(instance.world_from_mesh));
    } else {
        placed = deformed(vertex, instance);
        placed.tangent /= max(length(placed.tangent), 1e-20);
    }
    positions_world[index] = vec4f(placed.position, 1.0);
    normals_world[index] = vec4f(placed.normal / max(length(placed.normal), 1e-20), 0.0);
    tangents_world[index] = vec4f(placed.tangent, placed.side * vertex.tangent_sign);
}
