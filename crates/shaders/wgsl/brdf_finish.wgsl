#import brdf_metallic_roughness

// What lies on the base of a surface, whatever model that has: a clear coat (KHR_materials_clearcoat). Twin: `finish.rs` of `gnomon_brdf`.

// As a view sees it.
struct Finish {
    // Shares of the light that the base gets, and that the coat reflects.
    base: f32,
    coat: f32,
    coat_roughness: f32,
    // In the tangent frame of the base.
    coat_normal: vec3f,
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

// Value [1/sr], without the cosine, which is that of the base.
fn finish_value(finish: Finish, wo: vec3f, wi: vec3f) -> vec3f {
    let frame = coat_frame(finish);
    let wi_coat = local_from_world(frame, wi);
    if wi.z <= 0.0 || wi_coat.z <= 0.0 {
        return vec3f(0.0);
    }
    // The cosine of the coat in the place of the base's.
    return metallic_roughness_lobe(coat_lobe(finish), local_from_world(frame, wo), wi_coat) * (wi_coat.z / wi.z);
}

// A direction about in proportion to that; it may lie under the surface.
fn finish_sample(finish: Finish, wo: vec3f, u: vec2f) -> vec3f {
    let frame = coat_frame(finish);
    return world_from_local(frame, metallic_roughness_sample(coat_lobe(finish), local_from_world(frame, wo), u));
}

fn finish_pdf(finish: Finish, wo: vec3f, wi: vec3f) -> f32 {
    let frame = coat_frame(finish);
    let wi_coat = local_from_world(frame, wi);
    if wi.z <= 0.0 || wi_coat.z <= 0.0 {
        return 0.0;
    }
    return metallic_roughness_pdf(coat_lobe(finish), local_from_world(frame, wo), wi_coat);
}

// Integral of `finish_value` times the cosine over an area light.
fn finish_light(finish: Finish, wo: vec3f, light: LightPatch) -> vec3f {
    let frame = coat_frame(finish);
    var seen = light;
    seen.direction = local_from_world(frame, light.direction);
    seen.half_width = local_from_world(frame, light.half_width);
    seen.half_height = local_from_world(frame, light.half_height);
    return metallic_roughness_light_lobe(coat_lobe(finish), local_from_world(frame, wo), seen);
}

// Luminance of the light that the finish reflects, about.
fn finish_strength(finish: Finish) -> f32 {
    return finish.coat;
}
