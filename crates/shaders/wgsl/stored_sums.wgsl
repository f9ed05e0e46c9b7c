#import packed_sums

// The importer binds the planes of sums for writing, too.

fn store_sums(point: u32, sums: LightSums) {
    if sums_are_wide() {
        store_wide_sums(point, sums);
        return;
    }
    let words = packed_sums(sums);
    diffuse_sums[point] = words.diffuse;
    if (view.flags & FLAG_SPECULAR_SUMS) != 0u {
        for (var i = 0u; i < 3u; i++) {
            specular_sums[3u * point + i] = words.specular[i];
        }
    }
    if (view.flags & FLAG_NEAR_SUMS) != 0u {
        for (var i = 0u; i < 3u; i++) {
            near_sums[3u * point + i] = words.near[i];
        }
    }
}

fn store_wide_sums(point: u32, sums: LightSums) {
    let unshadowed = bitcast<vec3u>(sums.diffuse_unshadowed);
    let shadowed = bitcast<vec3u>(sums.diffuse_shadowed);
    diffuse_sums[2u * point] = vec4u(unshadowed, shadowed.x);
    diffuse_sums[2u * point + 1u].x = shadowed.y;
    diffuse_sums[2u * point + 1u].y = shadowed.z;
    diffuse_sums[2u * point + 1u].z = pack2x16float(vec2f(sums.probed, sums.probed_open));
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
