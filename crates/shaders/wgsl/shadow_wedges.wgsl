#import frame
#import gbuffer_surface
#import ray_origin
#import ray_scene
#import edges
#import marks
#import seen_light
#import cut_outline

// Penumbra wedges (Akenine-Moeller and Assarsson 2002, 2003): how often the middle of the light is covered, by a ray to it, and what the edges
// of silhouettes add to that or take away, as far as they cut the light's outline. Edges are found in a hierarchy of boxes.

@group(GROUP_SHADOW) @binding(0) var<uniform> parameters: WedgeParameters;
@group(GROUP_SHADOW) @binding(3) var<storage, read> edges: array<vec2u>;
@group(GROUP_SHADOW) @binding(4) var<storage, read> marks: array<u32>;
@group(GROUP_SHADOW) @binding(5) var<uniform> counts: SilhouetteCounts;

// Share of a ray's length that is left free before a light: what it hangs on.
const END_CLEARANCE: f32 = 1e-4;
// A light whose outline is narrower, as seen from a distance of 1, has no penumbra.
const LEAST_WIDTH: f32 = 1e-4;

// Whether a triangle faces the light's centre.
fn faces(triangle: u32, light: u32) -> bool {
    return ((marks[triangle_word(triangle, light)] >> (light % 32u)) & 1u) == 1u;
}

// A triangle's share in what outer sides cover (x) and in what inner sides cover (y). Both are all of it where each side blocks light by
// itself.
fn shares(triangle: u32, faces_light: bool) -> vec2f {
    let kind = ray_triangles[3u * triangle + 2u].w >> SIDE_SHIFT;
    if (kind & SIDE_SHEET) != 0u {
        return vec2f(1.0);
    }
    return select(vec2f(0.0, 1.0), vec2f(1.0, 0.0), faces_light != ((kind & SIDE_TURNED) != 0u));
}

// Of the light of the middle, what surfaces with alpha leave: nothing tells where the edges of their holes are.
var<private> left: f32;

// How often a triangle covers a direction before `reach`, in lengths of it.
fn cover(triangle: u32, light: u32, origin: vec3f, direction: vec3f, reach: f32) -> vec2f {
    let micromap = ray_triangles[3u * triangle].w;
    let a = ray_corner(triangle, 0u) - origin;
    let b = ray_corner(triangle, 1u) - origin;
    let c = ray_corner(triangle, 2u) - origin;
    let side = side_of_line(a, b, direction);
    if side == 0.0 || side != side_of_line(b, c, direction) || side != side_of_line(c, a, direction) {
        return vec2f(0.0);
    }
    let normal = cross(b - a, c - a);
    let distance = dot(a, normal) / dot(normal, direction);
    if !(distance > 0.0 && distance < reach) {
        return vec2f(0.0);
    }
    if micromap != 0u {
        let hit = triangle_hit(a, b, c, direction);
        left *= 1.0 - micromap_opacity(micromap, hit.z, hit.w);
        return vec2f(0.0);
    }
    let faces_light = faces(triangle, light);
    return shares(triangle, faces_light) * select(-side, side, faces_light);
}

// How often the ray is covered before `reach`.
fn covers(light: u32, origin: vec3f, direction: vec3f, reach: f32) -> vec2f {
    let tiny = abs(direction) < vec3f(LEAST_COMPONENT);
    let inverse = 1.0 / select(direction, vec3f(LEAST_COMPONENT), tiny);
    let shifted = -origin * inverse;
    let top_end = ray_nodes[0].skip;
    var sum = vec2f(0.0);
    var node = 0u;
    var end = top_end;
    var resume = 0u;
    loop {
        if node >= end {
            if end == top_end {
                return sum;
            }
            node = resume;
            end = top_end;
            continue;
        }
        let low = ray_nodes[node].low * inverse + shifted;
        let high = ray_nodes[node].high * inverse + shifted;
        let near = min(low, high);
        let far = max(low, high);
        let enters = max(max(near.x, near.y), max(near.z, 0.0));
        let leaves = min(min(far.x, far.y), min(far.z, reach));
        let members = ray_nodes[node].members;
        let count = members % RAY_LEAF;
        if enters > leaves {
            node = ray_nodes[node].skip;
        } else if count == RAY_INSTANCE {
            resume = node + 1u;
            node = members / RAY_LEAF;
            end = ray_nodes[node].skip;
        } else {
            for (var i = 0u; i < count; i++) {
                sum += cover(members / RAY_LEAF + i, light, origin, direction, reach);
            }
            node++;
        }
    }
    return sum;
}

// What a box around edges is tested against: the hull of the receiver and the outline, above the receiver's surface.
struct Wedge {
    origin: vec3f,
    normal_world: vec3f,
    inverse: vec3f,
    half_extents: vec3f,
    is_near: bool,
}

fn meets(wedge: Wedge, seen: SeenLight, low_world: vec3f, high_world: vec3f) -> bool {
    let low = low_world - wedge.origin;
    let high = high_world - wedge.origin;
    let above = max(wedge.normal_world * low, wedge.normal_world * high);
    let along = max(seen.k * low, seen.k * high);
    var most = along.x + along.y + along.z;
    if most <= 0.0 || above.x + above.y + above.z <= 0.0 {
        return false;
    }
    most = select(most, min(most, 1.0), wedge.is_near);
    // Nowhere in the box is the hull wider than at its far end.
    let first = (low - most * wedge.half_extents) * wedge.inverse;
    let second = (high + most * wedge.half_extents) * wedge.inverse;
    let near = min(first, second);
    let far = max(first, second);
    return max(max(near.x, near.y), max(near.z, 0.0)) <= min(min(far.x, far.y), min(far.z, most));
}

// Whether the outline is ready to be cut.
var<private> is_prepared: bool;

fn prepare_whole(light: u32, seen: SeenLight, n: vec3f) {
    corner_total = corner_count(light);
    for (var i = 0u; i < corner_total; i++) {
        outline_corners[i] = seen_corner(light, seen, i, parameters.light_size);
    }
}

// What silhouettes add to the cover of the middle: irradiance, of outer and of inner sides.
fn cut_by_edges(light: u32, seen: SeenLight, wedge: Wedge, n: vec3f) -> vec2f {
    let bit = light % 32u;
    let top_end = ray_nodes[counts.first_node].skip;
    var sum = vec2f(0.0);
    var node = counts.first_node;
    var end = top_end;
    var resume = 0u;
    loop {
        if node >= end {
            if end == top_end {
                return sum;
            }
            node = resume;
            end = top_end;
            continue;
        }
        let is_marked = node < counts.first_marked || ((marks[node_word(node, light)] >> bit) & 1u) == 1u;
        if !is_marked || !meets(wedge, seen, ray_nodes[node].low, ray_nodes[node].high) {
            node = ray_nodes[node].skip;
            continue;
        }
        let members = ray_nodes[node].members;
        let count = members % RAY_LEAF;
        if count == RAY_INSTANCE {
            resume = node + 1u;
            node = members / RAY_LEAF;
            end = ray_nodes[node].skip;
            continue;
        }
        for (var edge = members / RAY_LEAF; edge < members / RAY_LEAF + count; edge++) {
            if ((marks[edge_word(edge, light)] >> bit) & 1u) == 1u {
                sum += cut_by_edge(edges[edge], light, seen, wedge, n);
            }
        }
        node++;
    }
    return sum;
}

fn cut_by_edge(wings: vec2u, light: u32, seen: SeenLight, wedge: Wedge, n: vec3f) -> vec2f {
    let ends = edge_ends(wings.x);
    if !meets(wedge, seen, min(ends[0], ends[1]), max(ends[0], ends[1])) {
        return vec2f(0.0);
    }
    if !is_prepared {
        prepare_whole(light, seen, n);
        prepare_outline(n, seen.c);
        is_prepared = true;
    }
    let cut = cut_off(ends[0] - wedge.origin, ends[1] - wedge.origin, n, seen.k, wedge.is_near);
    if cut == 0.0 {
        return vec2f(0.0);
    }
    // What faces the light runs against the outline as the receiver sees it.
    var first = faces(wings.x / 4u, light);
    var weights = shares(wings.x / 4u, first) * select(1.0, -1.0, first);
    if wings.y != NO_WING {
        let second = faces(wings.y / 4u, light);
        let same_sense = (wings.y & 1u) == 1u;
        weights += shares(wings.y / 4u, second) * select(1.0, -1.0, second == same_sense);
    }
    return weights * cut;
}

fn visibility(light: u32, point: u32, position_world: vec3f, normal_world: vec3f, n: vec3f) -> f32 {
    let origin = ray_origin(position_world, normal_world);
    let seen = seen_light(light, origin, parameters.light_size);
    let is_near = lights[light].kind != KIND_DISTANT;
    let reach = select(3.4e38, 1.0 - END_CLEARANCE, is_near);
    var middle = seen.c;
    var open = 1.0;
    is_prepared = false;
    let is_point = max(length(seen.a), length(seen.b)) < LEAST_WIDTH * length(seen.c);
    let is_above = dot(n, seen.c) >= half_extent_along(light, seen, n)
        && dot(normal_world, seen.c) >= half_extent_along(light, seen, normal_world);
    if !is_point && !is_above {
        prepare_whole(light, seen, n);
        cut_corners(n);
        if corner_total < 3u {
            return 0.0;
        }
        let all = corners_form_factor(n);
        cut_corners(normal_world);
        if corner_total < 3u {
            return 0.0;
        }
        middle = middle_of_corners();
        prepare_outline(n, middle);
        is_prepared = true;
        open = saturate(rim_sums[corner_total] / all);
    }
    left = 1.0;
    var covered = covers(light, origin, middle, reach);
    if !is_point {
        let inverse = 1.0 / select(seen.c, vec3f(LEAST_COMPONENT), abs(seen.c) < vec3f(LEAST_COMPONENT));
        let wedge = Wedge(origin, normal_world, inverse, half_extents(light, seen), is_near);
        let cut = cut_by_edges(light, seen, wedge, n);
        if is_prepared {
            covered += cut / max(rim_sums[corner_total], 1e-20);
        }
    }
    return open * left * (1.0 - saturate(max(covered.x, covered.y)));
}
