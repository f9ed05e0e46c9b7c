#import brdf_finish
#import gbuffer_surface

// Surfaces of a scene some of whose materials have a finish: the base's parts, and what lies on them.

struct SurfaceFinish {
    seen: Finish,
    // Chance of sampling it among the glossy parts.
    chance: f32,
}

// Of a surface whose base has this lobe; `wo` in its tangent frame.
fn finish_of(material: Material, packed: PackedSurface, lobe: Lobe, wo: vec3f) -> SurfaceFinish {
    let texels = unpack_coat(packed.finish);
    let coat_normal = vec3f(texels.zw, sqrt(max(1.0 - dot(texels.zw, texels.zw), 0.0)));
    let coat = coat_share(material.clearcoat * texels.x, dot(coat_normal, wo));
    var sheen = vec4f(1.0);
    if material.has_sheen_textures != 0u {
        sheen = unpack_sheen(packed.finish);
    }
    let seen = seen_finish(
        coat,
        material.clearcoat_roughness * texels.y,
        coat_normal,
        min(material.sheen_color * sheen.rgb, vec3f(1.0)),
        material.sheen_roughness * sheen.a,
        wo.z,
    );
    // As often as the lobe: a coat reflects little, but the brightest lamps as sharp as no other part.
    let own = f32(parts_of_finish(seen));
    return SurfaceFinish(seen, own / max(own + select(0.0, 1.0, has_lobe(lobe)), 1.0));
}

fn parts_of_finish(seen: Finish) -> u32 {
    return select(0u, 1u, seen.coat > 0.0) + select(0u, 1u, has_sheen(seen));
}

fn has_finish(surface: Surface) -> bool {
    return finish_strength(surface.finish.seen) > 0.0;
}

fn has_gloss(surface: Surface) -> bool {
    return has_lobe(surface.lobe) || has_finish(surface);
}

// How many glossy parts share the samples of a surface.
fn glossy_parts(surface: Surface) -> u32 {
    return select(0u, 1u, has_lobe(surface.lobe)) + parts_of_finish(surface.finish.seen);
}

// Share of the light that the base gets.
fn base_share(surface: Surface) -> f32 {
    return surface.finish.seen.base;
}

// What leaves the surface of the base's emission.
fn emitted_through(finish: SurfaceFinish, emission: vec3f) -> vec3f {
    return emission * (1.0 - finish.seen.coat);
}

// Share of the light that reaches the matte part and returns.
fn matte_weight_of(surface: Surface, v_dot_h: f32) -> f32 {
    return base_share(surface) * reflectance_matte_weight(surface.lobe, surface.interface_tint, v_dot_h);
}

// Value of all glossy parts [1/sr], without the cosine; directions are in the tangent frame.
fn gloss_value(surface: Surface, wo: vec3f, wi: vec3f) -> vec3f {
    return base_share(surface) * reflectance_lobe(surface.lobe, wo, wi) + finish_value(surface.finish.seen, wo, wi);
}

// A direction about in proportion to it: one number both chooses a part and, stretched again, samples.
fn gloss_sample(surface: Surface, wo: vec3f, u: vec2f) -> vec3f {
    let chance = surface.finish.chance;
    if u.x < chance {
        return finish_sample(surface.finish.seen, wo, vec2f(u.x / chance, u.y));
    }
    return reflectance_sample(surface.lobe, wo, vec2f((u.x - chance) / max(1.0 - chance, 1e-6), u.y));
}

fn gloss_pdf(surface: Surface, wo: vec3f, wi: vec3f) -> f32 {
    let chance = surface.finish.chance;
    var pdf = 0.0;
    if chance > 0.0 {
        pdf += chance * finish_pdf(surface.finish.seen, wo, wi);
    }
    if chance < 1.0 {
        pdf += (1.0 - chance) * reflectance_pdf(surface.lobe, wo, wi);
    }
    return pdf;
}

// Radiance reflected by all glossy parts per unit of a light's.
fn gloss_light(surface: Surface, wo: vec3f, light: LightPatch) -> vec3f {
    var reflected = finish_light(surface.finish.seen, wo, light);
    if has_lobe(surface.lobe) {
        reflected += base_share(surface) * reflectance_light_lobe(surface.lobe, wo, light);
    }
    return reflected;
}

// GGX alphas of about the sharpest and the widest part.
fn sharpest_alpha(surface: Surface) -> f32 {
    let base = alpha_from_roughness(select(1.0, reflectance_equivalent_roughness(surface.lobe), has_lobe(surface.lobe)));
    let coat = alpha_from_roughness(select(1.0, surface.finish.seen.coat_roughness, surface.finish.seen.coat > 0.0));
    return min(base, coat);
}

fn widest_alpha(surface: Surface) -> f32 {
    let base = alpha_from_roughness(select(0.0, reflectance_equivalent_roughness(surface.lobe), has_lobe(surface.lobe)));
    let coat = alpha_from_roughness(select(0.0, surface.finish.seen.coat_roughness, surface.finish.seen.coat > 0.0));
    return max(max(base, coat), select(0.0, 1.0, has_sheen(surface.finish.seen)));
}

// The sharpest one's where no more is known of the surface.
fn sharpest_alpha_of(material: Material, packed: PackedSurface, lobe: Lobe) -> f32 {
    let base = select(1.0, alpha_from_roughness(reflectance_equivalent_roughness(lobe)), has_lobe(lobe));
    let coat = alpha_from_roughness(material.clearcoat_roughness * unpack_coat(packed.finish).y);
    return min(base, select(1.0, coat, material.clearcoat > 0.0));
}

// What reflects the ambient rest beside the lobe: a lobe, and the normal that it lies about.
fn coat_lobe_of(surface: Surface) -> Lobe {
    return coat_lobe(surface.finish.seen);
}

// Albedo of the sheen.
fn sheen_albedo_of(surface: Surface) -> vec3f {
    let seen = surface.finish.seen;
    return seen.sheen * sheen_albedo(dot(surface.n, surface.wo), seen.sheen_roughness);
}

fn coat_normal_of(surface: Surface) -> vec3f {
    return world_from_local(surface.frame, surface.finish.seen.coat_normal);
}
