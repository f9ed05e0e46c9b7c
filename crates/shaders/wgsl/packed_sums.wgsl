#import view
#import half_pairs

// What the lights of the batches so far give one point: irradiance, and specular radiance; in memory in halves, or wide, in floats, in planes of
// which a scene has those that it needs. The importer binds `diffuse_sums: array<vec4u>`, `specular_sums: array<u32>` and `near_sums: array<u32>`.

struct LightSums {
    diffuse_unshadowed: vec3f,
    diffuse_shadowed: vec3f,
    // Projected solid angle of the probes: of all, and of what is visible of them.
    probed: f32,
    probed_open: f32,
    // Where sums are evened out, in the place of probes: how sharp shadows are (`sharpness.wgsl`), times the luminance of the light
    // [irradiance / m^2], and the variance of the luminance of the shadowed diffuse light.
    sharpness: f32,
    variance: f32,
    specular_unshadowed: vec3f,
    specular_shadowed: vec3f,
    // Of lights in the scene, shadowed: the environment's compositing rule does not concern them.
    diffuse_near: vec3f,
    specular_near: vec3f,
}

fn add_weighted(sums: ptr<function, LightSums>, weight: f32, more: LightSums) {
    (*sums).diffuse_unshadowed += weight * more.diffuse_unshadowed;
    (*sums).probed += weight * more.probed;
    (*sums).diffuse_shadowed += weight * more.diffuse_shadowed;
    (*sums).probed_open += weight * more.probed_open;
    (*sums).sharpness += weight * more.sharpness;
    (*sums).variance += weight * more.variance;
    (*sums).specular_unshadowed += weight * more.specular_unshadowed;
    (*sums).specular_shadowed += weight * more.specular_shadowed;
    (*sums).diffuse_near += weight * more.diffuse_near;
    (*sums).specular_near += weight * more.specular_near;
}

// Brings sharpness to a unit of the light that there is at most, so that its logarithm lies around 0 under any environment.
fn sharpness_scale() -> f32 {
    return view.sum_scales.x / 32768.0;
}

// One word holds what probes see or, where sums are evened out, their grain: there are no probes then.
fn shared_word(sums: LightSums) -> u32 {
    if (view.flags & FLAG_EVENED_SUMS) != 0u {
        let sharpness = sharpness_scale() * sums.sharpness;
        return pack2x16float(vec2f(log2(max(sharpness, 1e-30)), view.sum_scales.x * sqrt(sums.variance)));
    }
    return pack2x16float(vec2f(sums.probed, sums.probed_open));
}

fn share_word(sums: ptr<function, LightSums>, word: u32) {
    if (view.flags & FLAG_EVENED_SUMS) != 0u {
        let grain = unpack2x16float(word);
        (*sums).sharpness = exp2(grain.x) / sharpness_scale();
        (*sums).variance = grain.y * grain.y / (view.sum_scales.x * view.sum_scales.x);
        return;
    }
    let probes = unpack2x16float(word);
    (*sums).probed = probes.x;
    (*sums).probed_open = probes.y;
}

fn sums_are_wide() -> bool {
    return (view.flags & FLAG_WIDE_SUMS) != 0u;
}

// What environment lights give to a matte surface, with the word that goes with it: the other sums are 0.
fn load_diffuse(point: u32) -> LightSums {
    var sums: LightSums;
    // The last word of wide ones is another's: see `shading_points.wgsl`.
    if sums_are_wide() {
        let first = diffuse_sums[2u * point];
        let second = diffuse_sums[2u * point + 1u];
        sums.diffuse_unshadowed = color_from(first.xyz);
        sums.diffuse_shadowed = color_from(vec3u(first.w, second.xy));
        share_word(&sums, second.z);
        return sums;
    }
    let words = diffuse_sums[point];
    let diffuse = unpack_color_pair(words.xyz);
    sums.diffuse_unshadowed = diffuse.first / view.sum_scales.x;
    sums.diffuse_shadowed = diffuse.second / view.sum_scales.x;
    share_word(&sums, words.w);
    return sums;
}

fn load_sums(point: u32) -> LightSums {
    var sums = load_diffuse(point);
    if sums_are_wide() {
        load_wide_rest(point, &sums);
        return sums;
    }
    if (view.flags & FLAG_SPECULAR_SUMS) != 0u {
        let specular =
            unpack_color_pair(vec3u(specular_sums[3u * point], specular_sums[3u * point + 1u], specular_sums[3u * point + 2u]));
        sums.specular_unshadowed = specular.first / view.sum_scales.y;
        sums.specular_shadowed = specular.second / view.sum_scales.y;
    }
    if (view.flags & FLAG_NEAR_SUMS) != 0u {
        let near = unpack_color_pair(vec3u(near_sums[3u * point], near_sums[3u * point + 1u], near_sums[3u * point + 2u]));
        sums.diffuse_near = near.first / view.sum_scales.z;
        sums.specular_near = near.second / view.sum_scales.z;
    }
    return sums;
}

fn color_from(words: vec3u) -> vec3f {
    return bitcast<vec3f>(words);
}

fn load_wide_rest(point: u32, sums: ptr<function, LightSums>) {
    let i = 6u * point;
    if (view.flags & FLAG_SPECULAR_SUMS) != 0u {
        (*sums).specular_unshadowed = color_from(vec3u(specular_sums[i], specular_sums[i + 1u], specular_sums[i + 2u]));
        (*sums).specular_shadowed = color_from(vec3u(specular_sums[i + 3u], specular_sums[i + 4u], specular_sums[i + 5u]));
    }
    if (view.flags & FLAG_NEAR_SUMS) != 0u {
        (*sums).diffuse_near = color_from(vec3u(near_sums[i], near_sums[i + 1u], near_sums[i + 2u]));
        (*sums).specular_near = color_from(vec3u(near_sums[i + 3u], near_sums[i + 4u], near_sums[i + 5u]));
    }
}

// Luminance so far, as irradiance that a white surface would reflect: what arrives (x), and what would without shadows (y), as far as
// that is known. Traced gloss counts without its shadows and the scene, which are grainy: grain asks for no more points.
fn luminance_so_far(point: u32) -> vec2f {
    var sums = load_sums(point);
    if (view.flags & FLAG_TRACED_GLOSS) != 0u {
        sums.specular_shadowed = sums.specular_unshadowed;
    }
    if (view.flags & FLAG_MIRRORED_SCENE) != 0u {
        sums.specular_near = vec3f(0.0);
    }
    let near = luminance(sums.diffuse_near + PI * sums.specular_near);
    return vec2f(
        luminance(sums.diffuse_shadowed + PI * sums.specular_shadowed) + near,
        luminance(sums.diffuse_unshadowed + PI * sums.specular_unshadowed) + near,
    );
}
