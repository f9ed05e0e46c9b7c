#import sample_places
#import edges
#import marks

// Shadow volumes (Crow 1977; Heidmann 1991), whose faces count into a stencil where they lie behind what is seen: what faces a light, the
// same infinitely far behind it, and sides that join the silhouettes of both. Nothing is bound but what is pulled from buffers: the instance
// tells light, copy and part of the picture.

@group(GROUP_SHADOW) @binding(0) var<uniform> volumes: VolumeParameters;
@group(GROUP_SHADOW) @binding(1) var<storage, read> ray_triangles: array<vec4u>;
@group(GROUP_SHADOW) @binding(2) var<storage, read> edges: array<vec2u>;
@group(GROUP_SHADOW) @binding(3) var<storage, read> marks: array<u32>;
@group(GROUP_SHADOW) @binding(4) var<uniform> counts: SilhouetteCounts;
@group(GROUP_PASS) @binding(0) var<storage, read> lights: array<Light>;

fn faces(triangle: u32, light: u32) -> bool {
    return ((marks[triangle_word(triangle, light)] >> (light % 32u)) & 1u) == 1u;
}

// 1 for what bounds volumes: what faces the light of the outer sides of closed surfaces, everything of others.
fn bounds_volume(triangle: u32, faces_light: bool) -> bool {
    let kind = ray_triangles[3u * triangle + 2u].w >> SIDE_SHIFT;
    return (kind & SIDE_SHEET) != 0u || faces_light != ((kind & SIDE_TURNED) != 0u);
}

fn clipped(position: vec4f, part: u32) -> vec4f {
    let position_clip = view.clip_from_world * position;
    return position_clip + vec4f(position_clip.w * part_shift(part), 0.0, 0.0);
}

// Infinitely far behind a point as the light sees it. A parallel view ends somewhere: there it is as far as the scene is wide.
fn behind(light: u32, point: vec3f) -> vec4f {
    var away = -lights[light].direction;
    if lights[light].kind != KIND_DISTANT {
        away = point - lights[light].position;
    }
    if view.eye_world.w == 0.0 {
        return vec4f(point + volumes.length * normalize(away), 1.0);
    }
    return vec4f(away, 0.0);
}

// A place that no face covers.
fn nowhere() -> vec4f {
    return vec4f(0.0, 0.0, 0.0, 1.0);
}

struct Drawn {
    light: u32,
    copy: u32,
    part: u32,
}

fn drawn(instance: u32) -> Drawn {
    let parts = view.interleave * view.interleave;
    return Drawn(instance / (2u * parts), instance / parts % 2u, instance % parts);
}

// Six vertices for every edge. The second copy is for edges that bound what is covered twice.
@vertex
fn volume_sides(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> @builtin(position) vec4f {
    let what = drawn(instance);
    let edge = vertex / 6u;
    if ((marks[edge_word(edge, what.light)] >> (what.light % 32u)) & 1u) == 0u {
        return nowhere();
    }
    let wings = edges[edge];
    let first = faces(wings.x / 4u, what.light);
    var times = select(0, select(-1, 1, first), bounds_volume(wings.x / 4u, first));
    if wings.y != NO_WING {
        let second = faces(wings.y / 4u, what.light);
        let runs_with = second == ((wings.y & 1u) == 1u);
        times += select(0, select(-1, 1, runs_with), bounds_volume(wings.y / 4u, second));
    }
    if abs(times) <= i32(what.copy) {
        return nowhere();
    }
    let ends = edge_ends(wings.x);
    let begin = select(ends[1], ends[0], times > 0);
    let end = select(ends[0], ends[1], times > 0);
    switch vertex % 6u {
        case 0u, 3u: { return clipped(vec4f(end, 1.0), what.part); }
        case 1u: { return clipped(vec4f(begin, 1.0), what.part); }
        case 2u, 4u: { return clipped(behind(what.light, begin), what.part); }
        default: { return clipped(behind(what.light, end), what.part); }
    }
}

// Three vertices for every triangle; the second copy lies far behind the first.
@vertex
fn volume_ends(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> @builtin(position) vec4f {
    let what = drawn(instance);
    let triangle = vertex / 3u;
    let faces_light = faces(triangle, what.light);
    let has_alpha = ray_triangles[3u * triangle].w != 0u;
    if has_alpha || !bounds_volume(triangle, faces_light) {
        return nowhere();
    }
    // In front the side towards the light is the outer one, far behind the other side.
    let is_turned = faces_light == (what.copy == 1u);
    let corner = ray_corner(triangle, select(vertex % 3u, 2u - vertex % 3u, is_turned));
    if what.copy == 1u {
        return clipped(behind(what.light, corner), what.part);
    }
    return clipped(vec4f(corner, 1.0), what.part);
}
