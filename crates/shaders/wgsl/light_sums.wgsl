#import gbuffer_surface
#import shadow_buffer
#import packed_sums

// Inputs of the passes that make a picture of the sums; their output is binding 6.

@group(GROUP_PASS) @binding(0) var<storage, read> points: array<ShadingPoint>;
@group(GROUP_PASS) @binding(1) var<storage, read> point_of_tile: array<u32>;
@group(GROUP_PASS) @binding(2) var<storage, read> point_of_sample: array<u32>;
@group(GROUP_PASS) @binding(3) var<storage, read> diffuse_sums: array<vec4u>;
@group(GROUP_PASS) @binding(4) var<storage, read> specular_sums: array<u32>;
@group(GROUP_PASS) @binding(5) var<storage, read> near_sums: array<u32>;

fn add_weighted(sums: ptr<function, LightSums>, weight: f32, more: LightSums) {
    (*sums).diffuse_unshadowed += weight * more.diffuse_unshadowed;
    (*sums).probed += weight * more.probed;
    (*sums).diffuse_shadowed += weight * more.diffuse_shadowed;
    (*sums).probed_open += weight * more.probed_open;
    (*sums).specular_unshadowed += weight * more.specular_unshadowed;
    (*sums).specular_shadowed += weight * more.specular_shadowed;
    (*sums).diffuse_near += weight * more.diffuse_near;
    (*sums).specular_near += weight * more.specular_near;
}

// The sums of a sample: its own, or the mean of those of the tiles around it.
fn sums_at(sample: vec2u, position_world: vec3f, n: vec3f) -> LightSums {
    let tiles = (view.size + view.shadow_sampling - 1u) / view.shadow_sampling;
    let center = vec2i(sample / view.shadow_sampling);
    var sums: LightSums;
    if view.shadow_sampling == 1u {
        let point = point_of_tile[sample.y * tiles.x + sample.x];
        if point != NO_POINT {
            sums = load_sums(point);
        }
        return sums;
    }
    let own = point_of_sample[sample.y * view.size.x + sample.x];
    if own != NO_POINT {
        return load_sums(own);
    }
    let normal_power = normal_power_at(sample);
    var weights = 0.0;
    for (var i = 0; i < 9; i++) {
        let tile = center + vec2i(i % 3, i / 3) - 1;
        if all(tile >= vec2i(0)) && all(tile < vec2i(tiles)) {
            let point = point_of_tile[u32(tile.y) * tiles.x + u32(tile.x)];
            if point != NO_POINT {
                let weight = point_weight(points[point], sample, position_world, n, normal_power);
                add_weighted(&sums, weight, load_sums(point));
                weights += weight;
            }
        }
    }
    var mean: LightSums;
    if weights > 0.0 {
        add_weighted(&mean, 1.0 / weights, sums);
    }
    return mean;
}
