#import frame

// Receiver in a light's shadow map: uv in [0, 1], z the linear depth.
fn receiver_in_light(light: u32, position_world: vec3f, normal_world: vec3f) -> vec3f {
    let moved = position_world + normal_world * lights[light].normal_offset_world;
    let p = lights[light].light_from_world * vec4f(moved, 1.0);
    return vec3f(0.5 + 0.5 * p.x, 0.5 - 0.5 * p.y, p.z);
}
