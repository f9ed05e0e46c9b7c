#import packed_sums

// The importer binds the planes of sums for writing, too.

fn store_sums(point: u32, sums: LightSums) {
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
