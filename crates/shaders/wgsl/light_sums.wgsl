#import shadow_buffer

// Inputs of the passes that make a picture of the sums; their output is binding 7.

@group(GROUP_PASS) @binding(0) var<storage, read> points: array<ShadingPoint>;
@group(GROUP_PASS) @binding(1) var<storage, read> work: array<u32>;
@group(GROUP_PASS) @binding(2) var<storage, read> point_of_tile: array<u32>;
@group(GROUP_PASS) @binding(3) var<storage, read> point_of_sample: array<u32>;
@group(GROUP_PASS) @binding(4) var<storage, read> diffuse_sums: array<vec4u>;
@group(GROUP_PASS) @binding(5) var<storage, read> specular_sums: array<u32>;
@group(GROUP_PASS) @binding(6) var<storage, read> near_sums: array<u32>;

// Number of the point that a sample has to itself in the last list, `NO_POINT` if it has none.
fn own_point(sample: vec2u) -> u32 {
    let list = view.point_list_count - 1u;
    if view.point_lists[list].sampling == 1u {
        return NO_POINT;
    }
    let own = point_of_sample[sample.y * view.size.x + sample.x];
    let first_stage = view.point_lists[list].first_stage;
    if first_stage > 0u && own < work[WORK_STAGES + WORK_STAGE * (first_stage - 1u) + 3u] {
        return NO_POINT;
    }
    return own;
}

// The sums of a sample: its own, or the mean of those of the tiles around it.
fn sums_at(sample: vec2u, position_world: vec3f, n: vec3f) -> LightSums {
    let own = own_point(sample);
    if own != NO_POINT {
        return load_sums(own);
    }
    return gathered_sums(view.point_list_count - 1u, sample, position_world, n);
}
