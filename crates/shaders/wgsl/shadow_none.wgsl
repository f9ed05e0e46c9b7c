// Nothing casts shadows: ordinary image-based lighting.
fn visibility(light: u32, point: u32, position_world: vec3f, normal_world: vec3f, n: vec3f) -> f32 {
    return 1.0;
}
