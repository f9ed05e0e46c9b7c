#import lobe_samples
#import ray_scene
#import hit_surface

// Glossy surfaces reflect the scene as it is in direct light: a ray of the lobe that meets a surface takes what that one sends of the sky's
// light. Few directions of the sky stand for all of it there; one is chosen by its cosine, and a ray tells whether it is open. What
// glossy surfaces reflect of others goes no further: they reflect the environment alone.

// Directions from each of which comes as much of the light: the direction in the environment, and what it gives to a surface that it meets
// straight on.
@group(GROUP_SHADOW) @binding(7) var sky_samples: texture_2d<f32>;

struct Seen {
    // Whether the way is open.
    open: f32,
    // What is reflected of the scene.
    scene: vec3f,
}

// Light is asked for at a point's hits about so often.
const LIGHT_RAYS: u32 = 16u;
// The glossy part of a surface that is seen in another is one of so many samples of its lobe.
const FAR_LOBE_SAMPLES: u32 = 4u;

// Number `i` of an evenly spread sequence, in [0, 1).
fn spread(i: u32) -> f32 {
    return fract(0.5 + f32(i) * 0.61803399);
}

// What a surface sends towards its viewer of direct light, estimated by one ray.
fn sent_by(surface: Surface, origin: vec3f, number: u32) -> vec3f {
    let first = SKY_BLOCK * (number % (SKY_SAMPLES / SKY_BLOCK));
    var cosines = 0.0;
    var chosen = 0u;
    var u = spread(number);
    for (var i = first; i < first + SKY_BLOCK; i++) {
        let direction = textureLoad(sky_samples, vec2u(i, 0u), 0).xyz;
        let cosine = max(dot((vec4f(direction, 0.0) * view.environment_from_world).xyz, surface.n), 0.0);
        cosines += cosine;
        // A reservoir of one, by one number that is stretched again after each decision.
        let takes = u * cosines < cosine;
        chosen = select(chosen, i, takes);
        u = select((u * cosines - cosine) / max(cosines - cosine, 1e-20), u * cosines / max(cosine, 1e-20), takes);
    }
    let towards_sky = (vec4f(textureLoad(sky_samples, vec2u(chosen, 0u), 0).xyz, 0.0) * view.environment_from_world).xyz;
    let given = view.environment_factor * textureLoad(sky_samples, vec2u(chosen, 1u), 0).rgb;
    let irradiance = given * (cosines * f32(SKY_SAMPLES / SKY_BLOCK));
    let n_dot_v = max(dot(surface.n, surface.wo), 1e-4);
    let weight = matte_weight_of(surface, sqrt(0.5 + 0.5 * n_dot_v));
    var sent = surface.diffuse_color / PI * weight * irradiance;
    var direction = towards_sky;
    if has_gloss(surface) {
        let place = fract(0.5 + f32(number) * vec2f(0.7548777, 0.5698403));
        let sample = lobe_sample(surface, place, FAR_LOBE_SAMPLES);
        let glossy = f32(FAR_LOBE_SAMPLES) * sample.radiance;
        let share = luminance(glossy) / max(luminance(glossy) + luminance(sent), 1e-20);
        let probability = clamp(share, select(0.1, 0.0, share == 0.0), select(0.9, 1.0, share == 1.0));
        if spread(7u * number + 3u) < probability {
            sent = glossy / probability;
            direction = sample.direction;
        } else {
            sent /= 1.0 - probability;
        }
    }
    if all(sent <= vec3f(0.0)) || dot(direction, surface.geometric_normal) <= 0.0 {
        return surface.emission;
    }
    return surface.emission + transmittance(origin, direction, 3.4e38) * sent;
}

// What the sample of a lobe, one of `count`, sees from `origin`; `number` is another for every sample of a point and those around it.
fn seen_along(origin: vec3f, sample: LobeSample, number: u32, count: u32) -> Seen {
    if all(sample.reflected == vec3f(0.0)) {
        return Seen(0.0, vec3f(0.0));
    }
    let hit = nearest_hit(origin, sample.direction, 3.4e38, spread(5u * number + 1u));
    if hit.distance <= 0.0 {
        return Seen(1.0, vec3f(0.0));
    }
    let surface = surface_of_hit(hit, sample.direction);
    let beyond = origin_of_hit(surface, hit.distance);
    let times = max(LIGHT_RAYS / count, 1u);
    var sent = vec3f(0.0);
    for (var i = 0u; i < times; i++) {
        sent += sent_by(surface, beyond, number * times + i);
    }
    return Seen(0.0, sample.reflected * sent / f32(times));
}
