#import environment
#import gbuffer_surface
#import cached_radiance
#import sh
#import light_sums
#import form_factor
#import slot:composite

// Radiance of every sample: unshadowed light, what the lights' sums make of it, emission; or the environment itself.

@group(GROUP_PASS) @binding(6) var radiance: texture_storage_2d<rgba32float, write>;

// Irradiance of the whole environment on a normal in its frame, unshadowed.
fn full_irradiance(n: vec3f) -> vec3f {
    if (view.flags & FLAG_SPHERICAL_HARMONICS) != 0u {
        return max(sh_irradiance(view.full_sh, n), vec3f(0.0));
    }
    var irradiance = equirect_lookup(irradiance_rest, n, 0);
    for (var i = 0u; i < emitters.count; i++) {
        let emitter = emitters.emitters[i];
        irradiance += emitter.radiance * disk_form_factor(n, emitter.direction, emitter.angular_radius);
    }
    return irradiance;
}

@compute @workgroup_size(TILE, TILE)
fn compose(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= view.size) {
        return;
    }
    let depth = depth_at(id.xy);
    if depth == 0.0 {
        let near = unproject(id.xy, 1.0);
        let direction = environment_direction(normalize(near.xyz / near.w * view.eye_world.w - view.eye_world.xyz));
        let shown = (view.flags & FLAG_BACKGROUND) != 0u;
        textureStore(radiance, id.xy, vec4f(select(vec3f(0.0), equirect_lookup(background, direction, 0), shown), 0.0));
        return;
    }
    let surface = surface_at(id.xy, depth);
    let n_dot_v = max(dot(surface.n, surface.wo), 1e-4);
    let sums = sums_at(id.xy, surface.position_world, surface.n);

    // Of the ambient rest, what the probes see.
    let open = select(1.0, sums.probed_open / sums.probed, sums.probed > 0.0);
    // What the interface lets through to the matte part, for light along the normal: v.h stays far from grazing for most light even
    // where n.v does not.
    let base_weight = reflectance_matte_weight(surface.lobe, surface.interface_tint, sqrt(0.5 + 0.5 * n_dot_v));
    let n_environment = environment_direction(surface.n);
    let ambient_diffuse = max(sh_irradiance(view.residual_sh, n_environment), vec3f(0.0));
    let environment_diffuse = composite(
        full_irradiance(n_environment),
        ambient_diffuse + sums.diffuse_unshadowed,
        open * ambient_diffuse + sums.diffuse_shadowed,
    );
    let diffuse = base_weight * (environment_diffuse + sums.diffuse_near);
    var result = surface.emission + surface.diffuse_color / PI * diffuse;
    if has_lobe(surface.lobe) {
        let roughness = reflectance_equivalent_roughness(surface.lobe);
        let specular_albedo = reflectance_albedo(surface.lobe, n_dot_v, environment_brdf(n_dot_v, roughness));
        let reflected = reflect(-surface.wo, surface.n);
        let reflected_environment = environment_direction(reflected);
        let level = prefiltered_level(alpha_from_roughness(roughness), f32(textureNumLevels(prefiltered_full) - 1u));
        let ambient_specular = equirect_lookup_level(prefiltered_residual, reflected_environment, level) * specular_albedo;
        var full_specular: vec3f;
        let layer = cached_layer(surface.lobe);
        if layer >= 0 {
            full_specular = cached_radiance(layer, reflected, n_dot_v, surface.lobe);
        } else {
            full_specular = equirect_lookup_level(prefiltered_full, reflected_environment, level) * specular_albedo;
        }
        result += composite(
            full_specular,
            ambient_specular + sums.specular_unshadowed,
            open * ambient_specular + sums.specular_shadowed,
        ) + sums.specular_near;
    }
    textureStore(radiance, id.xy, vec4f(result, 1.0));
}
