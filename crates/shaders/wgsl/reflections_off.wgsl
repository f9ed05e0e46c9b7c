#import lobe_samples
#import ray_scene

// Glossy surfaces reflect light alone; where the scene hides it they are dark.

struct Seen {
    // Whether the way is open.
    open: f32,
    // What is reflected of the scene.
    scene: vec3f,
}

// What the sample of a lobe sees from `origin`.
fn seen_along(origin: vec3f, sample: LobeSample, number: u32, count: u32) -> Seen {
    let is_open = any(sample.radiance > vec3f(0.0)) && !is_occluded(origin, sample.direction, 3.4e38);
    return Seen(select(0.0, 1.0, is_open), vec3f(0.0));
}
