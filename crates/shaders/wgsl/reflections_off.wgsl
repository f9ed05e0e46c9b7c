#import lobe_samples
#import ray_scene

// Glossy surfaces reflect light alone; where the scene hides it they are dark.

struct Seen {
    // Share of the light that the way leaves.
    open: f32,
    // What is reflected of the scene.
    scene: vec3f,
}

// What the sample of a lobe sees from `origin`.
fn seen_along(origin: vec3f, sample: LobeSample, number: u32, count: u32) -> Seen {
    if all(sample.radiance <= vec3f(0.0)) {
        return Seen(0.0, vec3f(0.0));
    }
    return Seen(transmittance(origin, sample.direction, 3.4e38), vec3f(0.0));
}
