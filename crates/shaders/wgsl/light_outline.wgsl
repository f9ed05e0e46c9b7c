#import frame
#import sample_pattern
#import unit_outline

// A light's outline on the tangent plane at its direction, in map axes, per metre of distance.
struct Outline {
    shape: u32,
    // Disk only.
    radius: f32,
    // Rectangle only: its first corner, the sides from there, and how far the corner across is off where they lead (of a quadrilateral).
    corner: vec2f,
    sides: mat2x2f,
    skew: vec2f,
    // Turns (disk: cosine and sine) or shifts (rectangle) the point set.
    jitter: vec2f,
}

fn light_outline(light: u32, jitter: vec2f) -> Outline {
    var outline: Outline;
    outline.shape = lights[light].shape;
    if outline.shape == SHAPE_DISK {
        outline.radius = tan(lights[light].angular_radius);
        outline.jitter = vec2f(cos(TAU * jitter.x), sin(TAU * jitter.x));
        return outline;
    }
    var corners: array<vec2f, 4>;
    for (var i = 0; i < 4; i++) {
        let corner = lights[light].corners[i].xyz;
        // Map v runs against the bitangent.
        corners[i] = vec2f(dot(corner, lights[light].tangent), -dot(corner, lights[light].bitangent))
            / dot(corner, lights[light].direction);
    }
    outline.corner = corners[0];
    outline.sides = mat2x2f(corners[1] - corners[0], corners[3] - corners[0]);
    outline.skew = corners[2] - corners[1] - outline.sides[1];
    outline.jitter = jitter;
    return outline;
}

// Point of the outline at a place of a point set in the unit disk or the unit square.
fn outline_at(outline: Outline, of_disk: vec2f, of_square: vec2f) -> vec2f {
    if outline.shape == SHAPE_DISK {
        let turn = outline.jitter;
        return outline.radius * vec2f(turn.x * of_disk.x - turn.y * of_disk.y, turn.x * of_disk.y + turn.y * of_disk.x);
    }
    let st = fract(of_square + outline.jitter);
    return outline.corner + outline.sides * st + (st.x * st.y) * outline.skew;
}

// Point `i` of `count`, evenly spread over the outline.
fn outline_point(outline: Outline, i: u32, count: u32) -> vec2f {
    if outline.shape == SHAPE_DISK {
        return outline_at(outline, vogel_disk(i, count, 0.0), vec2f(0.0));
    }
    return outline_at(outline, vec2f(0.0), hammersley(i, count));
}

fn unit_outline(outline: Outline) -> UnitOutline {
    if outline.shape == SHAPE_DISK {
        return unit_disk(outline.radius);
    }
    // A quadrilateral is taken for the parallelogram that it nearly is.
    let a = 0.5 * outline.sides[0] + 0.25 * outline.skew;
    let b = 0.5 * outline.sides[1] + 0.25 * outline.skew;
    return unit_parallelogram(outline.corner + a + b - 0.25 * outline.skew, a, b);
}
