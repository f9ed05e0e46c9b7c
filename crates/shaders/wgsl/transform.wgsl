#import types

// Mesh space to world space, every frame: geometry may have moved. One thread a vertex.

@group(0) @binding(0) var<storage, read> vertices: array<MeshVertex>;
@group(0) @binding(1) var<storage, read> instances: array<Instance>;
@group(0) @binding(2) var<storage, read_write> positions_world: array<vec4f>;
@group(0) @binding(3) var<storage, read_write> normals_world: array<vec4f>;
@group(0) @binding(4) var<storage, read_write> tangents_world: array<vec4f>;

const WORKGROUP: u32 = 64u;

@compute @workgroup_size(WORKGROUP)
fn transform(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    // Two dimensions of workgroups: one holds at most 65535 of them.
    let index = id.y * groups.x * WORKGROUP + id.x;
    if index >= arrayLength(&vertices) {
        return;
    }
    let vertex = vertices[index];
    let instance = instances[vertex.instance];
    let normal = (instance.normal_from_mesh * vec4f(vertex.normal, 0.0)).xyz;
    positions_world[index] = instance.world_from_mesh * vec4f(vertex.position, 1.0);
    normals_world[index] = vec4f(normal / max(length(normal), 1e-20), 0.0);
    tangents_world[index] = vec4f((instance.normal_from_mesh * vec4f(vertex.tangent, 0.0)).xyz, vertex.tangent_sign);
}
