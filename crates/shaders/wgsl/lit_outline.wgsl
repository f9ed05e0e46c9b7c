#import frame
#import weighted_box

// Half width and height of the box with the light's variance along the map's axes, in the light's own size: a rectangle's own,
// for a disk of radius r that of variance r^2 / 4.
fn box_half_extent(light: u32) -> vec2f {
    return lights[light].half_extent * select(1.0, sqrt(0.75), lights[light].shape == SHAPE_DISK);
}

// n.c, n.a and n.b for the points c + x a + y b of a light's outline, along the axes of its map's uv, in the light's own size.
fn outline_cosines(light: u32, position_world: vec3f, n: vec3f) -> vec3f {
    var to_light = lights[light].direction;
    if lights[light].kind != KIND_DISTANT {
        to_light = lights[light].position - position_world;
    }
    // Map v runs against the bitangent.
    return n * mat3x3f(to_light, lights[light].tangent, -lights[light].bitangent);
}

// The part of a light's outline that shines on a receiver.
fn lit_box(light: u32, position_world: vec3f, n: vec3f) -> WeightedBox {
    return weighted_box(outline_cosines(light, position_world, n), box_half_extent(light));
}
