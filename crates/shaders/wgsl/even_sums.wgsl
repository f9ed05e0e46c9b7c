#import shadow_buffer
#import stage_points
#import stored_sums

// Averages sums by few rays over what the penumbrae allow (axis-aligned filtering: Mehta, Wang and Ramamoorthi 2012): of the matte light at
// a point the share that shadows leave becomes that of the tiles around it. A second pass puts it in place.

@group(GROUP_PASS) @binding(0) var<storage, read> points: array<ShadingPoint>;
@group(GROUP_PASS) @binding(1) var<storage, read> work: array<u32>;
@group(GROUP_PASS) @binding(2) var<storage, read> point_of_tile: array<u32>;
@group(GROUP_PASS) @binding(3) var<storage, read_write> diffuse_sums: array<vec4u>;
@group(GROUP_PASS) @binding(4) var<storage, read_write> lit_shares: array<vec4f>;
@group(GROUP_PASS) @binding(5) var<uniform> stage: PointStage;
// Planes that no entry point here touches.
@group(GROUP_PASS) @binding(6) var<storage, read_write> specular_sums: array<u32>;
@group(GROUP_PASS) @binding(7) var<storage, read_write> near_sums: array<u32>;

// Standard deviation of the mean, in widths of the penumbra that all light would have.
const EVEN_SIGMA: f32 = 0.05;
// Points count as long as their light differs by no more than this share of the variance by which few rays let it differ: where a bright
// light has an edge narrower than a tile, no point lies in its penumbra and tells.
const EVEN_VARIANCE: f32 = 0.3;

fn position_of(point: ShadingPoint) -> vec3f {
    return vec3f(point.position_world[0], point.position_world[1], point.position_world[2]);
}

// Distance over which sums may be averaged [m].
fn even_sigma(sums: LightSums) -> f32 {
    return EVEN_SIGMA * sqrt(luminance(sums.diffuse_unshadowed) / max(sums.sharpness, 1e-20));
}

// Whether a point lies on the surface of another, from 0 to 1; heights count in tiles of the width `extent`.
fn surface_weight(other: ShadingPoint, position_world: vec3f, n: vec3f, extent: f32) -> f32 {
    let height = dot(n, position_of(other) - position_world) / extent;
    let n_dot_n = dot(n, octahedral_decode(unpack2x16float(other.normal)));
    return resample_weight(vec2f(0.0), height, n_dot_n, RESAMPLE_NORMAL_POWER);
}

@compute @workgroup_size(LIGHT_WORKGROUP)
fn even_out(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) local: u32) {
    let place = stage_point(workgroup.xy, local);
    if place == NO_POINT {
        return;
    }
    let point = points[place];
    let sample = unpack_place(point.sample);
    let position_world = position_of(point);
    let n = octahedral_decode(unpack2x16float(point.normal));
    let own = load_diffuse(place);
    let list = view.point_lists[stage.list];
    let extent = f32(list.sampling) * sample_extent_at(position_world);

    // The light of one point says little: that of the nearest ones stands for it.
    var about = luminance(own.diffuse_shadowed);
    var about_weight = 1.0;
    for (var i = 0; i < 9; i++) {
        let other = neighbour_point(stage.list, sample, i);
        if other != NO_POINT && other != place {
            let weight = surface_weight(points[other], position_world, n, extent);
            about += weight * luminance(load_diffuse(other).diffuse_shadowed);
            about_weight += weight;
        }
    }
    about /= about_weight;

    let sigma = even_sigma(own);
    let reach = i32(min(ceil(2.0 * sigma / extent), f32(EVEN_REACH)));
    let shift = vec2u(firstTrailingBit(list.sampling));
    let tiles = vec2i((view.size + list.sampling - 1u) >> shift);
    let tile = vec2i(sample >> shift);
    let first = max(tile - reach, vec2i(0));
    let last = min(tile + reach, tiles - 1);
    var shadowed = own.diffuse_shadowed;
    var unshadowed = own.diffuse_unshadowed;
    for (var y = first.y; y <= last.y; y++) {
        for (var x = first.x; x <= last.x; x++) {
            let other = point_of_tile[list.first_tile + u32(y * tiles.x + x)];
            if other == NO_POINT || other == place {
                continue;
            }
            var weight = surface_weight(points[other], position_world, n, extent);
            if weight < NEIGHBOUR_MIN_WEIGHT {
                continue;
            }
            let sums = load_diffuse(other);
            let change = luminance(sums.diffuse_shadowed) - about;
            if change * change > EVEN_VARIANCE * (own.variance / about_weight + sums.variance) {
                continue;
            }
            let away = position_of(points[other]) - position_world;
            let least = min(sigma, even_sigma(sums));
            weight *= exp(-0.5 * dot(away, away) / max(least * least, 1e-20));
            shadowed += weight * sums.diffuse_shadowed;
            unshadowed += weight * sums.diffuse_unshadowed;
        }
    }
    // Of light that there is none of no share is left.
    lit_shares[place] = vec4f(shadowed / max(unshadowed, vec3f(1e-20)), 0.0);
}

@compute @workgroup_size(LIGHT_WORKGROUP)
fn keep_evened(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) local: u32) {
    let place = stage_point(workgroup.xy, local);
    if place == NO_POINT {
        return;
    }
    var sums = load_diffuse(place);
    sums.diffuse_shadowed = sums.diffuse_unshadowed * lit_shares[place].xyz;
    store_diffuse(place, sums);
}
