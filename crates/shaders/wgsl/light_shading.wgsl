#import frame
#import gbuffer_surface
#import form_factor
#import cone_share

// Unshadowed light of one area light on a surface.

// Irradiance of a surface at `position_world` with the normal `n` per unit of the light's radiance [sr].
fn light_form_factor(light: u32, position_world: vec3f, n: vec3f) -> f32 {
    if lights[light].kind == KIND_DISTANT {
        // A parallel view has no slices.
        let distance = distance(position_world, view.eye_world.xyz);
        if distance < lights[light].from_distance || distance >= lights[light].to_distance {
            return 0.0;
        }
        if lights[light].shape == SHAPE_DISK {
            return disk_form_factor(n, lights[light].direction, lights[light].angular_radius);
        }
        // Most lights lie wholly above the horizon or below it; only the others need clipping.
        let corners = lights[light].corners;
        let heights = vec4f(dot(corners[0].xyz, n), dot(corners[1].xyz, n), dot(corners[2].xyz, n), dot(corners[3].xyz, n));
        if all(heights >= vec4f(0.0)) {
            return dot(lights[light].vector_irradiance, n);
        }
        if all(heights <= vec4f(0.0)) {
            return 0.0;
        }
        return rectangle_form_factor(n, corners);
    }
    let to_light = lights[light].position - position_world;
    let half_extent = lights[light].half_extent;
    if lights[light].kind == KIND_SPHERE {
        let distance = length(to_light);
        if distance <= half_extent.x {
            return 0.0;
        }
        return disk_form_factor(n, to_light / distance, asin(half_extent.x / distance));
    }
    // Emitting surfaces have their light a little before them, and are not lit by it.
    if dot(to_light, lights[light].direction) <= FLAT_CLEARANCE * min(half_extent.x, half_extent.y) {
        return 0.0;
    }
    let a = half_extent.x * lights[light].tangent;
    let b = half_extent.y * lights[light].bitangent;
    if lights[light].shape == SHAPE_DISK {
        return flat_disk_form_factor(n, to_light, a, b);
    }
    return rectangle_form_factor(
        n,
        array(
            vec4f(to_light - a - b, 0.0),
            vec4f(to_light - a + b, 0.0),
            vec4f(to_light + a + b, 0.0),
            vec4f(to_light + a - b, 0.0),
        ),
    );
}

// Radiance of a light towards a place: that of the direction from its centre, for all of it.
fn light_radiance(light: u32, position_world: vec3f) -> vec3f {
    let from_center = position_world - lights[light].position;
    let cosine = dot(from_center, lights[light].front) * inverseSqrt(max(dot(from_center, from_center), 1e-30));
    return lights[light].radiance * cone_share(cosine, lights[light].cone) * profile_share(light, cosine);
}

fn profile_value(light: u32, place: u32) -> f32 {
    return lights[light].profile[place / 4u][place % 4u];
}

// Share of its radiance that a light has by its profile in a direction of this cosine with its front.
fn profile_share(light: u32, cosine: f32) -> f32 {
    if lights[light].profile_end <= 0.0 {
        return 1.0;
    }
    let place = acos(clamp(cosine, -1.0, 1.0)) / lights[light].profile_end * f32(PROFILE_VALUES - 1u);
    if place > f32(PROFILE_VALUES - 1u) + 1e-3 {
        return 0.0;
    }
    let first = min(u32(place), PROFILE_VALUES - 2u);
    return mix(profile_value(light, first), profile_value(light, first + 1u), place - f32(first));
}

// A light as a surface sees it; the sides of a distant one keep its solid angle.
fn light_patch(light: u32, surface: Surface) -> LightPatch {
    var seen: LightPatch;
    seen.is_disk = lights[light].shape == SHAPE_DISK;
    let tangent = local_from_world(surface.frame, lights[light].tangent);
    let bitangent = local_from_world(surface.frame, lights[light].bitangent);
    if lights[light].kind == KIND_DISTANT {
        seen.direction = local_from_world(surface.frame, lights[light].direction);
        let half_extent = lights[light].half_extent;
        let flat_area = select(4.0, PI, seen.is_disk) * half_extent.x * half_extent.y;
        let scale = sqrt(lights[light].solid_angle / max(flat_area, 1e-20));
        seen.half_width = tangent * (scale * half_extent.x);
        seen.half_height = bitangent * (scale * half_extent.y);
        return seen;
    }
    let to_light = lights[light].position - surface.position_world;
    let distance = max(length(to_light), 1e-20);
    seen.direction = local_from_world(surface.frame, to_light / distance);
    let half_extent = min(lights[light].half_extent / distance, vec2f(1.0));
    if lights[light].kind == KIND_SPHERE {
        let about = frame_from_normal(seen.direction);
        seen.half_width = half_extent.x * about.t;
        seen.half_height = half_extent.x * about.b;
        return seen;
    }
    seen.half_width = half_extent.x * (tangent - seen.direction * dot(seen.direction, tangent));
    seen.half_height = half_extent.y * (bitangent - seen.direction * dot(seen.direction, bitangent));
    return seen;
}

// Radiance reflected by the surface's glossy parts per unit of the light's radiance.
fn light_specular(light: u32, surface: Surface) -> vec3f {
    let wo = local_from_world(surface.frame, surface.wo);
    return gloss_light(surface, wo, light_patch(light, surface));
}
