#import frame
#import brdf_frame
#import form_factor

// A light as a receiver sees it, all from the receiver: the points c + x a + y b of a plane.
struct SeenLight {
    // Its centre.
    c: vec3f,
    // Half its width and height, so that the outline is the unit disk, or the square from -1 to 1; seen from the light from a to b is clockwise.
    a: vec3f,
    b: vec3f,
    // dot(k, v) is the share of the way to the light's plane at which v lies.
    k: vec3f,
}

// `size` is a factor on the light's own.
fn seen_light(light: u32, origin: vec3f, size: f32) -> SeenLight {
    let half_extent = size * lights[light].half_extent;
    var seen: SeenLight;
    seen.a = half_extent.x * lights[light].tangent;
    seen.b = half_extent.y * lights[light].bitangent;
    if lights[light].kind == KIND_DISTANT {
        seen.c = lights[light].direction;
        seen.k = seen.c;
    } else if lights[light].kind == KIND_FLAT {
        seen.c = lights[light].position - origin;
        seen.k = lights[light].direction / dot(lights[light].direction, seen.c);
    } else {
        // The cone about a sphere touches it along a circle.
        let to_center = lights[light].position - origin;
        let radius_over_distance = half_extent.x * inverseSqrt(dot(to_center, to_center));
        let near = max(1.0 - radius_over_distance * radius_over_distance, 1e-6);
        let about = frame_from_normal(normalize(to_center));
        seen.c = near * to_center;
        seen.k = seen.c / dot(seen.c, seen.c);
        seen.a = half_extent.x * sqrt(near) * about.t;
        seen.b = half_extent.x * sqrt(near) * about.b;
    }
    if dot(cross(seen.a, seen.b), seen.c) > 0.0 {
        seen.b = -seen.b;
    }
    return seen;
}

fn corner_count(light: u32) -> u32 {
    return select(4u, DISK_CORNERS, lights[light].shape == SHAPE_DISK);
}

// A corner of the polygon that stands for the outline, in the order in which edges make positive form factors. A disk has as large an area.
fn seen_corner(light: u32, seen: SeenLight, i: u32, size: f32) -> vec3f {
    if lights[light].shape == SHAPE_DISK {
        let angle = TAU * f32(i) / f32(DISK_CORNERS);
        return seen.c + DISK_CORNER_RADIUS * (cos(angle) * seen.a + sin(angle) * seen.b);
    }
    if lights[light].kind == KIND_DISTANT {
        let corner = lights[light].corners[i].xyz;
        return mix(seen.c, corner / dot(corner, seen.c), size);
    }
    let signs = vec2f(select(-1.0, 1.0, i == 1u || i == 2u), select(-1.0, 1.0, i >= 2u));
    return seen.c + signs.x * seen.a + signs.y * seen.b;
}

// Half the extent of the outline along each axis of the world, or along a direction.
fn half_extents(light: u32, seen: SeenLight) -> vec3f {
    if lights[light].shape == SHAPE_DISK {
        return DISK_CORNER_RADIUS * sqrt(seen.a * seen.a + seen.b * seen.b);
    }
    return abs(seen.a) + abs(seen.b);
}

fn half_extent_along(light: u32, seen: SeenLight, direction: vec3f) -> f32 {
    let along = abs(vec2f(dot(seen.a, direction), dot(seen.b, direction)));
    return select(along.x + along.y, DISK_CORNER_RADIUS * length(along), lights[light].shape == SHAPE_DISK);
}
