#import packed_sums

// The importer binds the planes of sums for writing, too.

// The last word of wide ones is another's: see `shading_points.wgsl`.
fn store_diffuse(point: u32, sums: LightSums) {
    if sums_are_wide() {
        let unshadowed = bitcast<vec3u>(sums.diffuse_unshadowed);
        let shadowed = bitcast<vec3u>(sums.diffuse_shadowed);
        diffuse_sums[2u * point] = vec4u(unshadowed, shadowed.x);
        diffuse_sums[2u * point + 1u].x = shadowed.y;
        diffuse_sums[2u * point + 1u].y = shadowed.z;
        diffuse_sums[2u * point + 1u].z = shared_word(sums);
    } else {
        let words =
            pack_color_pair(view.sum_scales.x * sums.diffuse_unshadowed, view.sum_scales.x * sums.diffuse_shadowed);
        diffuse_sums[point] = vec4u(words, shared_word(sums));
    }
}

fn store_sums(point: u32, sums: LightSums) {
    store_diffuse(point, sums);
    if sums_are_wide() {
        store_wide_rest(point, sums);
        return;
    }
    if (view.flags & FLAG_SPECULAR_SUMS) != 0u {
        let words =
            pack_color_pair(view.sum_scales.y * sums.specular_unshadowed, view.sum_scales.y * sums.specular_shadowed);
        for (var i = 0u; i < 3u; i++) {
            specular_sums[3u * point + i] = words[i];
        }
    }
    if (view.flags & FLAG_NEAR_SUMS) != 0u {
        let words = pack_color_pair(view.sum_scales.z * sums.diffuse_near, view.sum_scales.z * sums.specular_near);
        for (var i = 0u; i < 3u; i++) {
            near_sums[3u * point + i] = words[i];
        }
    }
}

fn store_wide_rest(point: u32, sums: LightSums) {
    let specular = array(bitcast<vec3u>(sums.specular_unshadowed), bitcast<vec3u>(sums.specular_shadowed));
    let near = array(bitcast<vec3u>(sums.diffuse_near), bitcast<vec3u>(sums.specular_near));
    for (var i = 0u; i < 6u; i++) {
        if (view.flags & FLAG_SPECULAR_SUMS) != 0u {
            specular_sums[6u * point + i] = specular[i / 3u][i % 3u];
        }
        if (view.flags & FLAG_NEAR_SUMS) != 0u {
            near_sums[6u * point + i] = near[i / 3u][i % 3u];
        }
    }
}
