#import frame
#import weighted_box

// Half width and height of the box with the light's variance along the map's axes, in the light's own size: a rectangle's own,
// for a disk of radius r that of variance r^2 / 4.
fn box_half_extent(light: u32) -> vec2f {
    return lights[light].half_extent * select(1.0, sqrt(0.75), lights[light].shape == SHAPE_DISK);
}

// c, a and b for the points c + x a + y b of a light's outline as the receiver sees it, along the axes of its map's uv, in the light's own size.
fn outline_from(light: u32, position_world: vec3f) -> mat3x3f {
    var to_light = lights[light].direction;
    if lights[light].kind != KIND_DISTANT {
        to_light = lights[light].position - position_world;
    }
    // Map v runs against the bitangent.
    return mat3x3f(to_light, lights[light].tangent, -lights[light].bitangent);
}

// How an outline's points are weighed at one receiver, prepared for many of them.
struct OutlineWeights {
    // n.c, n.a and n.b, over |c|.
    cosines: vec3f,
    // c.a, c.b and 1, over c.c: a and b are perpendicular unit vectors.
    squares: vec3f,
}

fn outline_weights(outline: mat3x3f, n: vec3f) -> OutlineWeights {
    let c = outline[0];
    let squared = dot(c, c);
    return OutlineWeights(n * outline * inverseSqrt(squared), vec3f(dot(c, outline[1]), dot(c, outline[2]), 1.0) / squared);
}

// n.v for the point v of the outline, over |c|.
fn outline_cosine(cosines: vec3f, point: vec2f) -> f32 {
    return cosines.x + dot(cosines.yz, point);
}

// What a point of the outline adds to irradiance, but for a factor that all of them share: n.v / |v|^4, of which |v|^-3 is the solid angle of
// a piece of the outline's plane.
fn outline_weight(weights: OutlineWeights, point: vec2f) -> f32 {
    let squared = 1.0 + 2.0 * dot(weights.squares.xy, point) + weights.squares.z * dot(point, point);
    return max(outline_cosine(weights.cosines, point), 0.0) / (squared * squared);
}

// The same for a normal `n`.
fn irradiance_weight(outline: mat3x3f, n: vec3f, point: vec2f) -> f32 {
    return outline_weight(outline_weights(outline, n), point);
}

// Whether the receiver's own surface, of the geometric normal `normal_world`, hides a point of the outline, on which side of the
// shading normal it may be.
fn is_behind_surface(outline: mat3x3f, normal_world: vec3f, point: vec2f) -> bool {
    return outline_cosine(normal_world * outline, point) <= 0.0;
}

// The part of a light's outline that shines on a receiver.
fn lit_box(light: u32, position_world: vec3f, n: vec3f) -> WeightedBox {
    return weighted_box(n * outline_from(light, position_world), box_half_extent(light));
}
