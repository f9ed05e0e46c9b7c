#import brdf_metallic_roughness
#import brdf_sheen

// What lies on the base of a surface, whatever model that has: a clear coat (KHR_materials_clearcoat) over sheen
// (KHR_materials_sheen). Twin: `finish.rs` of `gnomon_brdf`.

// As a view sees it.
struct Finish {
    // Shares of the light that the base gets, and that the coat reflects.
    base: f32,
    coat: f32,
    coat_roughness: f32,
    // In the tangent frame of the base.
    coat_normal: vec3f,
    // Factor of white sheen, and its roughness.
    sheen: vec3f,
    sheen_roughness: f32,
}

// Reflectance of a coat along its normal.
const COAT_F0: f32 = 0.04;

// Share of the light that a coat of this strength reflects.
fn coat_share(clearcoat: f32, n_dot_v: f32) -> f32 {
    return clearcoat * f_schlick(vec3f(COAT_F0), 1.0, n_dot_v).x;
}

// GGX without a Fresnel factor of its own: the share has it.
fn coat_lobe(finish: Finish) -> Lobe {
    return Lobe(0u, finish.coat_roughness, vec4f(finish.coat));
}

// The coat's own frame, in that of the base.
fn coat_frame(finish: Finish) -> Frame {
    return frame_from_normal(finish.coat_normal);
}

fn has_sheen(finish: Finish) -> bool {
    return any(finish.sheen > vec3f(0.0));
}

// Chance of sampling the coat among both.
fn coat_chance(finish: Finish) -> f32 {
    return select(1.0, select(0.0, 0.5, finish.coat > 0.0), has_sheen(finish));
}

// As it is seen by a view: `color` is that of the sheen, `n_dot_v` the cosine of the base.
fn seen_finish(coat: f32, coat_roughness: f32, coat_normal: vec3f, color: vec3f, sheen_roughness: f32, n_dot_v: f32) -> Finish {
    var albedo = 0.0;
    if any(color > vec3f(0.0)) {
        albedo = sheen_albedo(n_dot_v, sheen_roughness);
    }
    let base = (1.0 - coat) * (1.0 - max_component(color) * min(albedo, 1.0));
    return Finish(base, coat, coat_roughness, coat_normal, (1.0 - coat) / max(albedo, 1.0) * color, sheen_roughness);
}

// Value [1/sr], without the cosine, which is that of the base.
fn finish_value(finish: Finish, wo: vec3f, wi: vec3f) -> vec3f {
    let frame = coat_frame(finish);
    let wi_coat = local_from_world(frame, wi);
    var value = vec3f(0.0);
    if wi.z <= 0.0 {
        return value;
    }
    if finish.coat > 0.0 && wi_coat.z > 0.0 {
        // The cosine of the coat in the place of the base's.
        value = metallic_roughness_lobe(coat_lobe(finish), local_from_world(frame, wo), wi_coat) * (wi_coat.z / wi.z);
    }
    if has_sheen(finish) {
        value += finish.sheen * sheen_value(finish.sheen_roughness, wo, wi);
    }
    return value;
}

// A direction about in proportion to that; it may lie under the surface.
fn finish_sample(finish: Finish, wo: vec3f, u: vec2f) -> vec3f {
    // One number both chooses and, stretched again, samples.
    let of_coat = coat_chance(finish);
    if u.x >= of_coat {
        return sheen_sample(vec2f((u.x - of_coat) / (1.0 - of_coat), u.y));
    }
    let frame = coat_frame(finish);
    let own = vec2f(u.x / of_coat, u.y);
    let wi = metallic_roughness_sample(coat_lobe(finish), local_from_world(frame, wo), own);
    // What is under the coat is lost, though it may be above the base.
    return select(vec3f(0.0, 0.0, -1.0), world_from_local(frame, wi), wi.z > 0.0);
}

fn finish_pdf(finish: Finish, wo: vec3f, wi: vec3f) -> f32 {
    let frame = coat_frame(finish);
    let wi_coat = local_from_world(frame, wi);
    if wi.z <= 0.0 {
        return 0.0;
    }
    let of_coat = coat_chance(finish);
    var pdf = (1.0 - of_coat) * (0.5 / PI);
    if of_coat > 0.0 && wi_coat.z > 0.0 {
        pdf += of_coat * metallic_roughness_pdf(coat_lobe(finish), local_from_world(frame, wo), wi_coat);
    }
    return pdf;
}

// Integral of `finish_value` times the cosine over an area light.
fn finish_light(finish: Finish, wo: vec3f, light: LightPatch) -> vec3f {
    let frame = coat_frame(finish);
    var seen = light;
    seen.direction = local_from_world(frame, light.direction);
    seen.half_width = local_from_world(frame, light.half_width);
    seen.half_height = local_from_world(frame, light.half_height);
    var reflected = vec3f(0.0);
    if finish.coat > 0.0 {
        reflected = metallic_roughness_light_lobe(coat_lobe(finish), local_from_world(frame, wo), seen);
    }
    if has_sheen(finish) {
        reflected += finish.sheen * sheen_light(finish.sheen_roughness, wo, light);
    }
    return reflected;
}

// Luminance of the light that the finish reflects, about.
fn finish_strength(finish: Finish) -> f32 {
    return finish.coat + luminance(finish.sheen);
}
