#import shadow_buffer
#import smooth_pixel
#import stored_sums

// The points that lights are summed at, in stages. A list has one for every tile of samples, and for samples that none of the tiles
// around them stands for (`refine`); once light is summed there, more where visibility changes from point to point (`refine_lit`). Wide
// lights have a list of large tiles; the list of the others starts from its sums. With tiles of one sample these are all samples that show a surface.

@group(GROUP_PASS) @binding(0) var<storage, read_write> points: array<ShadingPoint>;
@group(GROUP_PASS) @binding(1) var<storage, read_write> work: array<atomic<u32>>;
@group(GROUP_PASS) @binding(2) var<storage, read_write> point_of_tile: array<u32>;
@group(GROUP_PASS) @binding(3) var<storage, read_write> point_of_sample: array<u32>;
@group(GROUP_PASS) @binding(4) var<storage, read_write> diffuse_sums: array<vec4u>;
@group(GROUP_PASS) @binding(5) var<storage, read_write> specular_sums: array<u32>;
@group(GROUP_PASS) @binding(6) var<storage, read_write> near_sums: array<u32>;
@group(GROUP_PASS) @binding(7) var<uniform> stage: PointStage;

// Places in a tile that may show a surface where its centre does not.
const CANDIDATES: u32 = 16u;
// Most points of a block of samples: more surfaces than that share them.
const BLOCK_POINTS: u32 = 4u;

var<workgroup> group_count: atomic<u32>;
var<workgroup> group_start: u32;

// Places for `wanted` new entries that `total` counts. One global atomic a workgroup, and neighbours on the screen stay neighbours on the
// list. All invocations of a workgroup must come here.
fn reserve(total: u32, wanted: u32, local: u32) -> u32 {
    var place = 0u;
    if wanted > 0u {
        place = atomicAdd(&group_count, wanted);
    }
    workgroupBarrier();
    if local == 0u {
        group_start = atomicAdd(&work[total], atomicLoad(&group_count));
    }
    workgroupBarrier();
    return place + group_start;
}

fn shading_point(sample: vec2u, depth: f32) -> ShadingPoint {
    let position = position_at(sample, depth);
    return ShadingPoint(
        array(position.x, position.y, position.z),
        pack_place(sample),
        pack2x16float(octahedral_encode(normal_at(sample))),
    );
}

// Number of the first point of the stage's list.
fn first_point() -> u32 {
    let first_stage = view.point_lists[stage.list].first_stage;
    if first_stage == 0u {
        return 0u;
    }
    return atomicLoad(&work[WORK_STAGES + WORK_STAGE * (first_stage - 1u) + 3u]);
}

// A sample's place in `point_of_sample`.
fn number_of(sample: vec2u) -> u32 {
    return sample.y * view.size.x + sample.x;
}

// Whether a sample has a point of this list to itself.
fn has_own_point(sample: vec2u) -> bool {
    let own = point_of_sample[number_of(sample)];
    return own != NO_POINT && own >= first_point();
}

// Puts a point at its place; `NO_POINT` past the end. Of the list before it notes which point its sample had to itself, for `inherit`.
fn put(place: u32, point: ShadingPoint) -> u32 {
    if place >= arrayLength(&points) {
        return NO_POINT;
    }
    points[place] = point;
    if stage.list > 0u {
        let own = point_of_sample[number_of(unpack_place(point.sample))];
        note_inherited(place, select(own, NO_POINT, own >= first_point()));
    }
    return place;
}

// The note lies where the sums will be; wide ones leave it where it is, so that light can be summed again.
fn note_inherited(place: u32, own: u32) {
    if sums_are_wide() {
        diffuse_sums[2u * place + 1u].w = own;
    } else {
        diffuse_sums[place].x = own;
    }
}

fn inherited(place: u32) -> u32 {
    if sums_are_wide() {
        return diffuse_sums[2u * place + 1u].w;
    }
    return diffuse_sums[place].x;
}

// The stage's points start with what the list before knows of their samples.
@compute @workgroup_size(LIGHT_WORKGROUP)
fn inherit(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) local: u32) {
    let words = WORK_STAGES + WORK_STAGE * stage.stage;
    let place = atomicLoad(&work[words + 4u]) + (workgroup.y * atomicLoad(&work[words]) + workgroup.x) * LIGHT_WORKGROUP + local;
    if place >= atomicLoad(&work[words + 3u]) {
        return;
    }
    let own = inherited(place);
    let point = points[place];
    var sums: LightSums;
    if own != NO_POINT {
        sums = load_sums(own);
    } else {
        let sample = unpack_place(point.sample);
        let position = vec3f(point.position_world[0], point.position_world[1], point.position_world[2]);
        sums = gathered_sums(stage.list - 1u, sample, position, normal_at(sample));
    }
    store_sums(place, sums);
}

// What an invocation of a pass over the picture works on: a block of samples in rows of workgroups, or a part of an edge pixel.
struct Part {
    // First sample of the block, or of the pixel.
    corner: vec2u,
    // Number of the part of an edge pixel.
    number: u32,
    exists: bool,
}

// Blocks of `side` samples a side, or an invocation for each sample of the edge pixels.
fn part_of(side: u32, workgroup: vec2u, local: u32) -> Part {
    if stage.over_edges == 0u {
        let corner = (workgroup * TILE + vec2u(local % TILE, local / TILE)) * side;
        return Part(corner, 0u, all(corner < view.size));
    }
    let samples = view.supersample * view.supersample;
    let pixels = LIGHT_WORKGROUP / samples;
    let size = view.size / view.supersample;
    let number = (workgroup.y * atomicLoad(&work[WORK_EDGE_DISPATCH]) + workgroup.x) * pixels + local / samples;
    if local >= pixels * samples || number >= atomicLoad(&work[WORK_EDGE_DISPATCH + 3u]) {
        return Part(vec2u(0u), 0u, false);
    }
    let pixel = atomicLoad(&work[WORK_PIXELS + size.x * size.y + number]);
    return Part(vec2u(pixel % size.x, pixel / size.x) * view.supersample, local % samples, true);
}

// Lists the pixels whose samples see more than one smooth surface. No sample has a point of its own yet.
@compute @workgroup_size(TILE, TILE)
fn find_edges(@builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) local: u32) {
    let size = view.size / view.supersample;
    let inside = all(id.xy < size);
    let pixel = id.y * size.x + id.x;
    let wanted = inside && !is_smooth(id.xy);
    let place = reserve(WORK_EDGES, u32(wanted), local);
    if inside {
        atomicStore(&work[WORK_PIXELS + pixel], u32(wanted));
    }
    if wanted {
        atomicStore(&work[WORK_PIXELS + size.x * size.y + place], pixel);
    }
    if inside && (view.point_lists[0].sampling > 1u || view.point_list_count > 1u) {
        let side = view.supersample;
        for (var y = 0u; y < side; y++) {
            let first = number_of(id.xy * side + vec2u(0u, y));
            for (var x = 0u; x < side; x++) {
                point_of_sample[first + x] = NO_POINT;
            }
        }
    }
}

fn is_edge(sample: vec2u) -> bool {
    let pixel = sample / view.supersample;
    return atomicLoad(&work[WORK_PIXELS + pixel.y * (view.size.x / view.supersample) + pixel.x]) != 0u;
}

// Workgroups of `compose_edges`: each has as many whole pixels as it has invocations for.
@compute @workgroup_size(1)
fn edge_dispatch() {
    let edges = atomicLoad(&work[WORK_EDGES]);
    let size = dispatch_of(edges, LIGHT_WORKGROUP / (view.supersample * view.supersample));
    atomicStore(&work[WORK_EDGE_DISPATCH], size.x);
    atomicStore(&work[WORK_EDGE_DISPATCH + 1u], size.y);
    atomicStore(&work[WORK_EDGE_DISPATCH + 2u], 1u);
    atomicStore(&work[WORK_EDGE_DISPATCH + 3u], edges);
}

// Workgroups for so many items: a dispatch has at most 65535 a side.
fn dispatch_of(items: u32, items_of_group: u32) -> vec2u {
    let groups = (items + items_of_group - 1u) / items_of_group;
    let rows = max((groups + 32767u) / 32768u, 1u);
    return vec2u((groups + rows - 1u) / rows, rows);
}

// Every other bit of a number of six bits, from its last one on.
fn even_bits(number: u32) -> u32 {
    return (number & 1u) | ((number >> 1u) & 2u) | ((number >> 2u) & 4u);
}

@compute @workgroup_size(LIGHT_WORKGROUP)
fn choose(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) local: u32) {
    // Points that follow one another on the list lie in squares (Morton 1966): so they see much the same, and `light` diverges less.
    let id = workgroup.xy * TILE + vec2u(even_bits(local), even_bits(local >> 1u));
    let side = view.point_lists[stage.list].sampling;
    let tiles = (view.size + side - 1u) >> vec2u(firstTrailingBit(side));
    var sample = vec2u(0u);
    var depth = 0.0;
    if all(id < tiles) {
        for (var i = 0u; i < min(CANDIDATES, side * side) && depth == 0.0; i++) {
            // Roberts 2018, R2, from the tile's centre.
            let place = fract(0.5 + f32(i) * vec2f(0.7548777, 0.5698403));
            sample = min(id * side + vec2u(place * f32(side)), view.size - 1u);
            depth = depth_at(sample);
        }
    }
    let place = reserve(WORK_POINTS, u32(depth > 0.0), local);
    if all(id < tiles) {
        var point = NO_POINT;
        if depth > 0.0 {
            point = put(place, shading_point(sample, depth));
        }
        point_of_tile[view.point_lists[stage.list].first_tile + id.y * tiles.x + id.x] = point;
    }
}

// Whether the tiles around a sample stand for it.
fn is_represented(sample: vec2u, position_world: vec3f, n: vec3f) -> bool {
    let normal_power = normal_power_at(sample);
    var sum = 0.0;
    // The sample's own tile first: mostly it is enough.
    for (var i = 4; i < 13 && sum < RESAMPLE_MIN_WEIGHT; i++) {
        let point = neighbour_point(stage.list, sample, i % 9);
        if point != NO_POINT {
            sum += point_weight(stage.list, points[point], sample, position_world, n, normal_power);
        }
    }
    return sum >= RESAMPLE_MIN_WEIGHT;
}

// Whether a sample of the same block may share a point: highlights allow less than the tiles do.
fn stands_for(point: ShadingPoint, sample: vec2u, position_world: vec3f, n: vec3f) -> bool {
    let normal_power = normal_power_at(sample);
    let n_dot_n = max(dot(n, octahedral_decode(unpack2x16float(point.normal))), 0.0);
    return pow(n_dot_n, normal_power) >= SMOOTH_NORMALS
        && point_weight(stage.list, point, sample, position_world, n, normal_power) >= RESAMPLE_MIN_WEIGHT;
}

// Lists points for samples: in blocks over the picture for those that none of the tiles stands for. Where tiles are no larger than a pixel
// they stand for all of a smooth one; at edges things touch, and shadows are narrower than tiles: there every block has its points.
@compute @workgroup_size(LIGHT_WORKGROUP)
fn refine(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) local: u32) {
    let part = part_of(stage.block, workgroup.xy, local);
    let all_own = stage.over_edges != 0u;
    let blocks = view.supersample / stage.block;
    let inside = part.exists && (!all_own || part.number < blocks * blocks);
    let corner = part.corner + select(vec2u(0u), stage.block * vec2u(part.number % blocks, part.number / blocks), all_own);
    let side = select(0u, stage.block, inside);
    // Of the block's samples those that none of the tiles stands for, and for each the point that does, two bits.
    var wanted = 0u;
    var owner = 0u;
    var own_points: array<ShadingPoint, BLOCK_POINTS>;
    var count = 0u;
    // A block that shows one smooth surface has samples that are alike.
    let middle = corner + side / 2u;
    let is_smooth_block = inside && all(middle < view.size) && !is_edge(middle);
    if is_smooth_block {
        let depth = depth_at(middle);
        if depth > 0.0 && !is_represented(middle, position_at(middle, depth), normal_at(middle)) {
            wanted = (1u << (side * side)) - 1u;
            own_points[0] = shading_point(middle, depth);
            count = 1u;
        }
    }
    for (var i = 0u; i < side * side && !is_smooth_block; i++) {
        let sample = corner + vec2u(i % side, i / side);
        if any(sample >= view.size) {
            continue;
        }
        let depth = depth_at(sample);
        if depth == 0.0 {
            continue;
        }
        let position_world = position_at(sample, depth);
        let n = normal_at(sample);
        if !all_own && is_represented(sample, position_world, n) {
            continue;
        }
        wanted |= 1u << i;
        var found = false;
        for (var k = 0u; k < count && !found; k++) {
            found = stands_for(own_points[k], sample, position_world, n);
            if found {
                owner |= k << (2u * i);
            }
        }
        if !found && count < BLOCK_POINTS {
            own_points[count] = shading_point(sample, depth);
            owner |= count << (2u * i);
            count += 1u;
        }
    }
    let start = reserve(WORK_POINTS, count, local);
    for (var k = 0u; k < count; k++) {
        _ = put(start + k, own_points[k]);
    }
    for (var i = 0u; i < side * side; i++) {
        let sample = corner + vec2u(i % side, i / side);
        if any(sample >= view.size) {
            continue;
        }
        if (wanted & (1u << i)) != 0u {
            let place = start + ((owner >> (2u * i)) & 3u);
            point_of_sample[number_of(sample)] = select(NO_POINT, place, place < arrayLength(&points));
        }
    }
}

// Light so far, and what a change of it is measured by: by what would arrive without shadows. In an interior little of that does; there sums
// without grain are measured by themselves.
fn light_to_compare(point: u32) -> vec2f {
    let light = luminance_so_far(point);
    return select(light, light.xx, (view.flags & FLAG_EVENED_SUMS) != 0u);
}

// Whether light so far changes much among the points around a sample, for what it would be without shadows: at edges of shadows, and in
// highlights.
fn needs_more(sample: vec2u, depth: f32) -> bool {
    // Weights only take points out: where all that there are agree there is nothing to weigh.
    var all_least = vec2f(1e30);
    var all_most = 0.0;
    for (var i = 0; i < 9; i++) {
        let point = neighbour_point(stage.list, sample, i);
        if point != NO_POINT {
            let light = light_to_compare(point);
            all_least = min(all_least, light);
            all_most = max(all_most, light.x);
        }
    }
    if all_most - all_least.x <= stage.contrast * all_least.y {
        return false;
    }
    let position_world = position_at(sample, depth);
    let n = normal_at(sample);
    let normal_power = normal_power_at(sample);
    var least = 1e30;
    var most = vec2f(0.0);
    for (var i = 0; i < 9; i++) {
        let point = neighbour_point(stage.list, sample, i);
        if point != NO_POINT
            && point_weight(stage.list, points[point], sample, position_world, n, normal_power) > NEIGHBOUR_MIN_WEIGHT {
            let light = light_to_compare(point);
            least = min(least, light.x);
            most = max(most, light);
        }
    }
    return most.x - least > stage.contrast * most.y;
}

// Lists more points where light changes: for smooth pixels one for each of their blocks, for samples of edge pixels each by itself.
@compute @workgroup_size(LIGHT_WORKGROUP)
fn refine_lit(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) local: u32) {
    let over_edges = stage.over_edges != 0u;
    let part = part_of(view.supersample, workgroup.xy, local);
    let number = vec2u(part.number % view.supersample, part.number / view.supersample);
    let asked = part.corner + select(vec2u(view.supersample / 2u), number, over_edges);
    let block = select(stage.block, 1u, over_edges);
    let blocks = view.supersample / stage.block;
    var count = 0u;
    if part.exists && is_edge(asked) == over_edges {
        let depth = depth_at(asked);
        if depth > 0.0 && !has_own_point(asked) && needs_more(asked, depth) {
            count = select(blocks * blocks, 1u, over_edges);
        }
    }
    let start = reserve(WORK_POINTS, count, local);
    for (var k = 0u; k < count; k++) {
        let first = select(part.corner + block * vec2u(k % blocks, k / blocks), asked, over_edges);
        let sample = first + block / 2u;
        let point = put(start + k, shading_point(sample, depth_at(sample)));
        for (var i = 0u; i < block * block; i++) {
            let of_block = first + vec2u(i % block, i / block);
            point_of_sample[number_of(of_block)] = point;
        }
    }
}

// Ends a stage: workgroups of `light` for its points.
@compute @workgroup_size(1)
fn end_stage() {
    let end = min(atomicLoad(&work[WORK_POINTS]), arrayLength(&points));
    var first = 0u;
    if stage.stage > 0u {
        first = atomicLoad(&work[WORK_STAGES + WORK_STAGE * (stage.stage - 1u) + 3u]);
    }
    let size = dispatch_of(end - first, LIGHT_WORKGROUP);
    let words = WORK_STAGES + WORK_STAGE * stage.stage;
    atomicStore(&work[words], size.x);
    atomicStore(&work[words + 1u], size.y);
    atomicStore(&work[words + 2u], 1u);
    atomicStore(&work[words + 3u], end);
    atomicStore(&work[words + 4u], first);
}
