#import frame
#import sample_pattern

// A light's outline on the tangent plane at its direction, in map axes, per metre of distance.
struct Outline {
    shape: u32,
    // Disk only.
    radius: f32,
    // Rectangle only.
    corners: mat4x2f,
    // Turns (disk) or shifts (rectangle) the point set.
    jitter: vec2f,
}

fn light_outline(light: u32, jitter: vec2f) -> Outline {
    var outline = Outline(lights[light].shape, tan(lights[light].angular_radius), mat4x2f(), jitter);
    if outline.shape == SHAPE_RECTANGLE {
        for (var i = 0; i < 4; i++) {
            let corner = lights[light].corners[i].xyz;
            // Map v runs against the bitangent.
            outline.corners[i] = vec2f(dot(corner, lights[light].tangent), -dot(corner, lights[light].bitangent))
                / dot(corner, lights[light].direction);
        }
    }
    return outline;
}

// Point `i` of `count`, evenly spread over the outline.
fn outline_point(outline: Outline, i: u32, count: u32) -> vec2f {
    if outline.shape == SHAPE_DISK {
        return outline.radius * vogel_disk(i, count, TAU * outline.jitter.x);
    }
    let st = fract(hammersley(i, count) + outline.jitter);
    let c = outline.corners;
    return mix(mix(c[0], c[1], st.x), mix(c[3], c[2], st.x), st.y);
}
