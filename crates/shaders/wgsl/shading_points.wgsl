#import gbuffer_surface
#import shadow_buffer

// The points that lights are summed at: one for every tile of `view.shadow_sampling` x `view.shadow_sampling` samples, and
// then every sample that none of the tiles around it stands for. With tiles of one sample these are all samples that show a surface.

@group(GROUP_PASS) @binding(0) var<storage, read_write> points: array<ShadingPoint>;
@group(GROUP_PASS) @binding(1) var<storage, read_write> count: atomic<u32>;
@group(GROUP_PASS) @binding(2) var<storage, read_write> point_of_tile: array<u32>;
@group(GROUP_PASS) @binding(3) var<storage, read_write> point_of_sample: array<u32>;
@group(GROUP_PASS) @binding(4) var<storage, read_write> dispatch: array<u32, 4>;

// Places in a tile that may show a surface where its centre does not.
const CANDIDATES: u32 = 16u;

var<workgroup> group_count: atomic<u32>;
var<workgroup> group_start: u32;

// Puts a point on the list for every invocation that has one; the place of each, `NO_POINT` without or past the end. One global atomic
// a workgroup, and neighbours on the screen stay neighbours on the list. All invocations of a workgroup must come here.
fn append(wanted: bool, local: u32, sample: vec2u, depth: f32) -> u32 {
    var place = 0u;
    if wanted {
        place = atomicAdd(&group_count, 1u);
    }
    workgroupBarrier();
    if local == 0u {
        group_start = atomicAdd(&count, atomicLoad(&group_count));
    }
    workgroupBarrier();
    place += group_start;
    if !wanted || place >= arrayLength(&points) {
        return NO_POINT;
    }
    let position = position_at(sample, depth);
    points[place] = ShadingPoint(
        array(position.x, position.y, position.z),
        sample.y * view.size.x + sample.x,
        pack2x16float(octahedral_encode(normal_at(sample))),
    );
    return place;
}

@compute @workgroup_size(TILE, TILE)
fn choose(@builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) local: u32) {
    let side = view.shadow_sampling;
    let tiles = (view.size + side - 1u) / side;
    var sample = vec2u(0u);
    var depth = 0.0;
    if all(id.xy < tiles) {
        for (var i = 0u; i < min(CANDIDATES, side * side) && depth == 0.0; i++) {
            // Roberts 2018, R2, from the tile's centre.
            let place = fract(0.5 + f32(i) * vec2f(0.7548777, 0.5698403));
            sample = min(id.xy * side + vec2u(place * f32(side)), view.size - 1u);
            depth = depth_at(sample);
        }
    }
    let point = append(depth > 0.0, local, sample, depth);
    if all(id.xy < tiles) {
        point_of_tile[id.y * tiles.x + id.x] = point;
    }
}

// Whether the tiles around a sample stand for it.
fn is_represented(sample: vec2u, position_world: vec3f, n: vec3f) -> bool {
    let tiles = (view.size + view.shadow_sampling - 1u) / view.shadow_sampling;
    let center = vec2i(sample / view.shadow_sampling);
    let normal_power = normal_power_at(sample);
    var sum = 0.0;
    // The sample's own tile first: mostly it is enough.
    for (var i = 4; i < 13 && sum < RESAMPLE_MIN_WEIGHT; i++) {
        let tile = center + vec2i(i % 3, (i / 3) % 3) - 1;
        if all(tile >= vec2i(0)) && all(tile < vec2i(tiles)) {
            let point = point_of_tile[u32(tile.y) * tiles.x + u32(tile.x)];
            if point != NO_POINT {
                sum += point_weight(points[point], sample, position_world, n, normal_power);
            }
        }
    }
    return sum >= RESAMPLE_MIN_WEIGHT;
}

@compute @workgroup_size(TILE, TILE)
fn refine(@builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) local: u32) {
    let inside = all(id.xy < view.size);
    var depth = 0.0;
    if inside {
        depth = depth_at(id.xy);
    }
    let wanted = depth > 0.0 && !is_represented(id.xy, position_at(id.xy, depth), normal_at(id.xy));
    let point = append(wanted, local, id.xy, depth);
    if inside {
        point_of_sample[id.y * view.size.x + id.x] = point;
    }
}

// Workgroups of `light` for the points on the list: a dispatch has at most 65535 a side.
@compute @workgroup_size(1)
fn dispatch_size() {
    let points_listed = min(atomicLoad(&count), arrayLength(&points));
    let groups = (points_listed + LIGHT_WORKGROUP - 1u) / LIGHT_WORKGROUP;
    let rows = (groups + 32767u) / 32768u;
    dispatch = array(select(0u, (groups + max(rows, 1u) - 1u) / max(rows, 1u), rows > 0u), rows, 1u, points_listed);
}
