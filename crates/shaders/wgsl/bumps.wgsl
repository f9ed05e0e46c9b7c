#import relief_surface
#import light_shading
#import lit_outline
#import sample_pattern

// What bumps hide of lights and scatter of them. The importer brings `lit_share(relief, direction, spread)`: of light around a direction of
// the field's own space, by so much to each side, how much they let through.

// Points of a light's outline, and how wide a light may be to be seen by few of them (half its width at a distance of 1).
const WIDE_POINTS: u32 = 16u;
const NARROW_POINTS: u32 = 4u;
const NARROW: f32 = 0.02;
// Prepared shapes are not exact: their edges are as soft as that.
const OWN_SPREAD: f32 = 0.03;

// Whether the sum of light asks for the visibility of a light with this form factor.
fn asks_for(form_factor: f32, relief: Relief) -> bool {
    return form_factor > 0.0 || (relief.covers && (view.flags & FLAG_BUMP_SCATTER) != 0u);
}

// The normal that it is weighed by: light that a bump turns its back to may still come by way of another.
fn asked_normal(form_factor: f32, relief: Relief, surface: Surface) -> vec3f {
    return select(relief.n, surface.n, form_factor > 0.0);
}

// How much of a light's irradiance bumps let through.
fn surface_visibility(light: u32, relief: Relief, surface: Surface) -> f32 {
    if !relief.covers {
        return 1.0;
    }
    var outline = outline_from(light, surface.position_world);
    if lights[light].kind == KIND_SPHERE {
        let about = frame_from_normal(normalize(outline[0]));
        outline = mat3x3f(outline[0], about.t, about.b);
    }
    let half_extent = lights[light].half_extent;
    let width = max(half_extent.x, half_extent.y) * inverseSqrt(dot(outline[0], outline[0]));
    let side = select(4u, 2u, width < NARROW);
    let count = select(WIDE_POINTS, NARROW_POINTS, width < NARROW);
    let spread = width / f32(side) + OWN_SPREAD;
    var weights = 0.0;
    var through = 0.0;
    for (var i = 0u; i < count; i++) {
        var place = 2.0 * (vec2f(vec2u(i % side, i / side)) + 0.5) / f32(side) - 1.0;
        if lights[light].shape == SHAPE_DISK {
            place = vogel_disk(i, count, 0.0);
        }
        place *= half_extent;
        let weight = irradiance_weight(outline, surface.n, place);
        weights += weight;
        if weight > 0.0 {
            let direction = relief_direction(relief, outline * vec3f(1.0, place));
            // The surface under the bumps is not transparent.
            through += weight * saturate(0.5 + direction.z / spread) * lit_share(relief, direction, spread);
        }
    }
    return select(0.0, through / weights, weights > 0.0);
}

// Irradiance by light that bumps scatter to the sample, per unit of the light's radiance (`scatter.rs`).
fn scattered_light(light: u32, relief: Relief, surface: Surface) -> vec3f {
    if !relief.covers || (view.flags & FLAG_BUMP_SCATTER) == 0u {
        return vec3f(0.0);
    }
    let form_factor = light_form_factor(light, surface.position_world, relief.n);
    let direction = relief_direction(relief, outline_from(light, surface.position_world)[0]);
    let share = max(relief.scattering.x + dot(relief.scattering.yz, direction.xy), 0.0);
    return form_factor * share * surface.diffuse_color / (1.0 - surface.diffuse_color * min(relief.scattering.w, 0.95));
}
