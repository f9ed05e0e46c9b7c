#import frame
#import gbuffer_surface
#import light_shading
#import packed_sums
#import slot:shadow

// Sums a batch of lights with their visibility at every shading point.

@group(GROUP_PASS) @binding(0) var<storage, read> points: array<ShadingPoint>;
// Workgroups of this dispatch (x, y), and number of points (w).
@group(GROUP_PASS) @binding(1) var<storage, read> dispatch: vec4u;
@group(GROUP_PASS) @binding(2) var<storage, read_write> diffuse_sums: array<vec4u>;
@group(GROUP_PASS) @binding(3) var<storage, read_write> specular_sums: array<u32>;
@group(GROUP_PASS) @binding(4) var<storage, read_write> near_sums: array<u32>;

fn store_sums(point: u32, sums: LightSums) {
    let diffuse =
        pack_color_pair(view.sum_scales.x * sums.diffuse_unshadowed, view.sum_scales.x * sums.diffuse_shadowed);
    diffuse_sums[point] = vec4u(diffuse, pack2x16float(vec2f(sums.probed, sums.probed_open)));
    if (view.flags & FLAG_SPECULAR_SUMS) != 0u {
        let specular =
            pack_color_pair(view.sum_scales.y * sums.specular_unshadowed, view.sum_scales.y * sums.specular_shadowed);
        for (var i = 0u; i < 3u; i++) {
            specular_sums[3u * point + i] = specular[i];
        }
    }
    if (view.flags & FLAG_NEAR_SUMS) != 0u {
        let near = pack_color_pair(view.sum_scales.z * sums.diffuse_near, view.sum_scales.z * sums.specular_near);
        for (var i = 0u; i < 3u; i++) {
            near_sums[3u * point + i] = near[i];
        }
    }
}

@compute @workgroup_size(LIGHT_WORKGROUP)
fn light(
    @builtin(workgroup_id) workgroup: vec3u,
    @builtin(local_invocation_index) local: u32,
) {
    let point = (workgroup.y * dispatch.x + workgroup.x) * LIGHT_WORKGROUP + local;
    if point >= dispatch.w {
        return;
    }
    let place = points[point].sample;
    let sample = vec2u(place % view.size.x, place / view.size.x);
    let surface = surface_at(sample, depth_at(sample));

    var sums: LightSums;
    if (batch.flags & FLAG_FIRST) == 0u {
        sums = load_sums(point);
    }
    for (var light = batch.first_light; light < batch.end_light; light++) {
        let form_factor = light_form_factor(light, surface.position_world, surface.n);
        if form_factor <= 0.0 {
            continue;
        }
        let visible = visibility(light, point, surface.position_world, surface.geometric_normal, surface.n);
        if lights[light].role == ROLE_PROBE {
            sums.probed += form_factor;
            sums.probed_open += form_factor * visible;
            continue;
        }
        let diffuse = lights[light].radiance * form_factor;
        var specular = vec3f(0.0);
        if has_lobe(surface.lobe) {
            specular = light_specular(light, surface) * lights[light].radiance;
        }
        if lights[light].kind == KIND_DISTANT {
            sums.diffuse_unshadowed += diffuse;
            sums.diffuse_shadowed += diffuse * visible;
            sums.specular_unshadowed += specular;
            sums.specular_shadowed += specular * visible;
        } else {
            sums.diffuse_near += diffuse * visible;
            sums.specular_near += specular * visible;
        }
    }
    store_sums(point, sums);
}
