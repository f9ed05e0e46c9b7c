#import frame
#import gbuffer_surface
#import light_shading
#import summed_points
#import sharpness
#import slot:shadow
#import slot:bumps

// Sums a batch of lights with their visibility at every shading point.

@compute @workgroup_size(LIGHT_WORKGROUP)
fn light(
    @builtin(workgroup_id) workgroup: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let point = stage_point(workgroup.xy, local);
    if point == NO_POINT {
        return;
    }
    let surface = surface_of(point);
    let relief = relief_at(unpack_place(points[point].sample));

    var sums: LightSums;
    if (batch.flags & FLAG_FIRST) == 0u {
        sums = load_sums(point);
    }
    for (var light = batch.first_light; light < batch.end_light; light++) {
        var form_factor = light_form_factor(light, surface.position_world, surface.n);
        if !asks_for(form_factor, relief) {
            continue;
        }
        let radiance = light_radiance(light, surface.position_world);
        var arrives = 0.0;
        if is_shown(light) && any(radiance > vec3f(0.0)) {
            let n = asked_normal(form_factor, relief, surface);
            arrives = visibility(light, point, surface.position_world, surface.geometric_normal, n);
        }
        let visible = arrives * surface_visibility(light, relief, surface);
        if lights[light].role == ROLE_PROBE {
            sums.probed += form_factor;
            sums.probed_open += form_factor * visible;
            continue;
        }
        if known_form_factor >= 0.0 {
            form_factor = known_form_factor;
            known_form_factor = -1.0;
        }
        let diffuse = radiance * form_factor;
        // Shadowed light alone: the ratio to unshadowed light is then what bumps hide and add.
        let scattered = arrives * radiance * scattered_light(light, relief, surface);
        var specular = vec3f(0.0);
        let is_own = lights[light].kind != KIND_DISTANT || lights[light].role == ROLE_SUN;
        // What no map shows is mirrored here.
        let is_mirrored = is_own || lights[light].role == ROLE_TAKEN_OUT;
        let is_traced = (view.flags & FLAG_TRACED_GLOSS) != 0u && !is_mirrored;
        if form_factor > 0.0 && has_gloss(surface) && !is_traced {
            specular = light_specular(light, surface) * radiance;
        }
        if !is_own {
            sums.diffuse_unshadowed += diffuse;
            sums.diffuse_shadowed += diffuse * visible + scattered;
            sums.sharpness += luminance(diffuse) * shadow_sharpness;
            sums.variance += luminance(diffuse) * luminance(diffuse) * shadow_variance;
        } else {
            sums.diffuse_near += diffuse * visible + scattered;
        }
        if is_mirrored {
            sums.specular_near += specular * visible;
        } else {
            sums.specular_unshadowed += specular;
            sums.specular_shadowed += specular * visible;
        }
    }
    store_sums(point, sums);
}
