#import frame

// Distance by which a receiver is moved along its normal against self-shadowing [m]: texels of a perspective map grow with distance.
fn normal_offset(light: u32, position_world: vec3f) -> f32 {
    let distance = dot(lights[light].position - position_world, lights[light].direction);
    return lights[light].normal_offset_world * select(max(distance, 0.0), 1.0, lights[light].kind == KIND_DISTANT);
}

// Receiver in a light's shadow map: uv in [0, 1]; z the linear depth within the map, to be compared with what it stores; w the
// same beyond it, for distances to blockers. What lies behind a perspective map's plane lies outside of it.
fn receiver_in_light(light: u32, position_world: vec3f, normal_world: vec3f) -> vec4f {
    let moved = position_world + normal_world * normal_offset(light, position_world);
    let p = lights[light].light_from_world * vec4f(moved, 1.0);
    if lights[light].kind == KIND_DISTANT {
        return vec4f(0.5 + 0.5 * p.x, 0.5 - 0.5 * p.y, saturate(p.z), p.z);
    }
    if p.w <= 0.0 {
        return vec4f(-1.0);
    }
    let z = (p.w - lights[light].near_world) / lights[light].depth_range_world;
    return vec4f(0.5 + 0.5 * p.x / p.w, 0.5 - 0.5 * p.y / p.w, saturate(z), z);
}

// How far a place is in a map whose texels have this width [uv]: 0 from a texel beyond its edge on, where nothing blocks. A coarse texel at the
// edge holds blockers, and a sampler repeats it without end.
fn share_in_map(uv: vec2f, texel_width: f32) -> f32 {
    let inside = saturate(1.0 - max(abs(uv - 0.5) - 0.5, vec2f(0.0)) / texel_width);
    return inside.x * inside.y;
}

// Width, as a share of the map's side, of the light's footprint at a receiver of linear depth `d` behind a blocker of linear depth `z`,
// per unit of the light's own size: the penumbra (Annen et al. 2008, section 3).
fn footprint_scale_uv(light: u32, d: f32, z: f32) -> f32 {
    let range = lights[light].depth_range_world;
    let width = (d - z) * range / lights[light].map_width_world;
    if lights[light].kind == KIND_DISTANT {
        return width;
    }
    // Similar triangles: the cone from the receiver to the light, cut at the blocker, over the map's width there.
    let near = lights[light].near_world;
    return width / ((near + d * range) * (near + z * range));
}
