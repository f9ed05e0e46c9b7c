// A smooth step from 1 at the distance `from_distance` to 0 at `to_distance`: what is seen near the middle of a ground gives way by it to
// what is seen far out.
fn ground_share(distance: f32, from_distance: f32, to_distance: f32) -> f32 {
    let t = saturate((distance - from_distance) / (to_distance - from_distance));
    return 1.0 - t * t * (3.0 - 2.0 * t);
}

// Where in the environment a place of a ground is seen along `direction`: near the middle where a camera so high over it saw the place.
fn ground_direction(from_center: vec3f, direction: vec3f, camera_height: f32, share: f32) -> vec3f {
    if camera_height <= 0.0 {
        return direction;
    }
    let seen = normalize(from_center - vec3f(0.0, camera_height, 0.0));
    let turned = mix(direction, seen, share);
    if dot(turned, turned) < 1e-12 {
        return direction;
    }
    return normalize(turned);
}
