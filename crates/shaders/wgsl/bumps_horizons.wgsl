#import bumps

// Lit directions as those above the horizon, which is known in eight azimuths (Max 1988).

fn horizon_tangent(relief: Relief, azimuth: u32) -> f32 {
    let hidden = unpack4x8unorm(relief.lit[azimuth / 4u])[azimuth % 4u];
    return hidden / max(1.0 - hidden, 1e-3);
}

fn lit_share(relief: Relief, direction: vec3f, spread: f32) -> f32 {
    let place = 8.0 * fract(atan2(direction.y, direction.x) / TAU);
    let first = u32(place) % 8u;
    let tangent = mix(horizon_tangent(relief, first), horizon_tangent(relief, (first + 1u) % 8u), fract(place));
    // Sine of the angle above the horizon.
    let above = (direction.z - tangent * length(direction.xy)) * inverseSqrt(1.0 + tangent * tangent);
    return saturate(0.5 + 0.5 * above / spread);
}
