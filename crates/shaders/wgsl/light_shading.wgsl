#import frame
#import gbuffer_surface
#import brdf_area
#import form_factor

// Unshadowed light of one area light on a surface.

// Irradiance of a surface at `position_world` with the normal `n` per unit of the light's radiance [sr].
fn light_form_factor(light: u32, position_world: vec3f, n: vec3f) -> f32 {
    if lights[light].kind == KIND_DISTANT {
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
    if dot(to_light, lights[light].direction) <= 0.0 {
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

fn ggx_lobe(surface: Surface, wi: vec3f, alpha: f32) -> vec3f {
    let h = normalize(wi + surface.wo);
    let n_dot_v = max(dot(surface.n, surface.wo), 1e-4);
    let n_dot_l = max(dot(surface.n, wi), 0.0);
    return f_schlick(surface.f0, surface.f90, max(dot(surface.wo, h), 0.0))
        * (d_ggx(saturate(dot(surface.n, h)), alpha) * v_smith_ggx_correlated(n_dot_v, n_dot_l, surface.alpha) * n_dot_l);
}

// A light as a point of the scene sees it; its sides keep the solid angle.
fn light_patch(light: u32, position_world: vec3f) -> LightPatch {
    var seen: LightPatch;
    seen.is_disk = lights[light].shape == SHAPE_DISK;
    if lights[light].kind == KIND_DISTANT {
        seen.direction = lights[light].direction;
        let half_extent = lights[light].half_extent;
        let flat_area = select(4.0, PI, seen.is_disk) * half_extent.x * half_extent.y;
        let scale = sqrt(lights[light].solid_angle / max(flat_area, 1e-20));
        seen.half_width = lights[light].tangent * (scale * half_extent.x);
        seen.half_height = lights[light].bitangent * (scale * half_extent.y);
        return seen;
    }
    let to_light = lights[light].position - position_world;
    let distance = max(length(to_light), 1e-20);
    seen.direction = to_light / distance;
    let half_extent = min(lights[light].half_extent / distance, vec2f(1.0));
    if lights[light].kind == KIND_SPHERE {
        seen.half_width = world_from_local(seen.direction, vec3f(half_extent.x, 0.0, 0.0));
        seen.half_height = world_from_local(seen.direction, vec3f(0.0, half_extent.x, 0.0));
        return seen;
    }
    let tangent = lights[light].tangent;
    let bitangent = lights[light].bitangent;
    seen.half_width = half_extent.x * (tangent - seen.direction * dot(seen.direction, tangent));
    seen.half_height = half_extent.y * (bitangent - seen.direction * dot(seen.direction, bitangent));
    return seen;
}

// Radiance reflected by the surface's glossy part per unit of the light's radiance.
fn light_specular(light: u32, surface: Surface) -> vec3f {
    if surface.model != MODEL_METALLIC_ROUGHNESS {
        let seen = light_patch(light, surface.position_world);
        let lobe = light_lobe(surface.model, surface.parameter, surface.n, surface.wo, seen);
        return lobe.x * surface.f0 + lobe.y * surface.f90;
    }
    if lights[light].kind == KIND_DISTANT {
        // The light's extent widens the lobe (Karis 2013, area lights): alpha' = alpha + half the light's radius.
        let solid_angle = lights[light].solid_angle;
        let wide = saturate(surface.alpha + 0.5 * sqrt(solid_angle / PI));
        return ggx_lobe(surface, lights[light].direction, wide) * solid_angle;
    }
    let to_light = lights[light].position - surface.position_world;
    let distance2 = dot(to_light, to_light);
    let reflected = reflect(-surface.wo, surface.n);
    let radius = lights[light].half_extent.x;
    var seen_area = lights[light].solid_angle;
    // The point of the light that lies nearest to the mirrored view ray stands for all of it (Karis 2013).
    var nearest = to_light;
    if lights[light].kind == KIND_SPHERE {
        let aside = dot(to_light, reflected) * reflected - to_light;
        nearest += aside * saturate(radius / max(length(aside), 1e-20));
    } else {
        seen_area *= max(dot(to_light, lights[light].direction), 0.0) * inverseSqrt(distance2);
        let slant = dot(reflected, lights[light].direction);
        let distance = dot(to_light, lights[light].direction) / max(slant, 1e-3);
        let aside = reflected * distance - to_light;
        var place = vec2f(dot(aside, lights[light].tangent), dot(aside, lights[light].bitangent));
        if lights[light].shape == SHAPE_DISK {
            place *= saturate(radius / max(length(place), 1e-20));
        } else {
            place = clamp(place, -lights[light].half_extent, lights[light].half_extent);
        }
        nearest += place.x * lights[light].tangent + place.y * lights[light].bitangent;
    }
    // Its lobe keeps the energy of one widened by the light's extent.
    let solid_angle = min(seen_area / distance2, TAU);
    let wide = saturate(surface.alpha + 0.5 * sqrt(solid_angle / PI));
    let narrowing = surface.alpha / wide;
    return ggx_lobe(surface, normalize(nearest), surface.alpha) * (narrowing * narrowing * solid_angle);
}
