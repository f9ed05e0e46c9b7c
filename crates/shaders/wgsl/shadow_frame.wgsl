#import frame

// Receiver in a light's shadow map: uv in [0, 1], z the linear depth.
fn receiver_in_light(light: u32, position_world: vec3f, normal_world: vec3f) -> vec3f {
    let moved = position_world + normal_world * lights[light].normal_offset_world;
    let p = lights[light].light_from_world * vec4f(moved, 1.0);
    return vec3f(0.5 + 0.5 * p.x, 0.5 - 0.5 * p.y, saturate(p.z));
}

// Linear depth of what a depth map stores.
fn linear_from_stored_depth(light: u32, stored: f32) -> f32 {
    return stored;
}

// Its inverse: what a depth map stores for a point of linear depth `linear`.
fn stored_from_linear_depth(light: u32, linear: f32) -> f32 {
    return linear;
}

// Width, as a share of the map's side, of the light's footprint at a receiver of linear depth `d` behind a blocker of linear depth `z`,
// per unit of the light's own size: the penumbra (Annen et al. 2008, section 3). Times `lights[light].footprint` it is the width
// of the mip texel that filters the penumbra.
fn footprint_scale_uv(light: u32, d: f32, z: f32) -> f32 {
    return (d - z) * lights[light].depth_range_world / lights[light].map_width_world;
}
