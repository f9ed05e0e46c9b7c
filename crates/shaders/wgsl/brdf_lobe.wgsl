#import brdf_area
#import brdf_frame
#import brdf_sampling

// What every reflectance model is given. `brdf_models` (made by src/models.rs from the list of `gnomon_brdf::Model`) chooses among
// the models' functions. Directions are in the surface's tangent frame.

// The glossy part of a surface point.
struct Lobe {
    model: u32,
    // What shapes it: roughness, shininess or slope.
    shape: f32,
    // What colours it: for models with Schlick's Fresnel the reflectance along the normal, and in w at grazing incidence. The lobe is
    // absent where all of it is 0.
    tint: vec4f,
}

fn has_lobe(lobe: Lobe) -> bool {
    return any(lobe.tint > vec4f(0.0));
}

// `gnomon_brdf::MIN_N_DOT_V`.
const MIN_N_DOT_V: f32 = 1e-4;

// Schlick 1994, eq. 15, with a free value at grazing incidence.
fn f_schlick(f0: vec3f, f90: f32, v_dot_h: f32) -> vec3f {
    let m = clamp(1.0 - v_dot_h, 0.0, 1.0);
    let m2 = m * m;
    return f0 + (vec3f(f90) - f0) * (m2 * m2 * m);
}

// A lobe's value under Schlick's Fresnel, `bare` being the same without Fresnel's factor.
fn schlick_lobe(lobe: Lobe, bare: f32, v_dot_h: f32) -> vec3f {
    return bare * f_schlick(lobe.tint.rgb, lobe.tint.w, v_dot_h);
}

// What stands in for functions that a model's file leaves out; `gnomon_brdf::ReflectanceModel` says what they are.

fn default_equivalent_roughness(lobe: Lobe) -> f32 {
    return lobe.shape;
}

fn default_albedo(lobe: Lobe, n_dot_v: f32, ggx: vec2f) -> vec3f {
    return lobe.tint.rgb * ggx.x + lobe.tint.w * ggx.y;
}

fn default_cached(lobe: Lobe, radiance_f0: vec3f, radiance_f90: vec3f, cosines: f32) -> vec3f {
    return lobe.tint.rgb * radiance_f0 + lobe.tint.w * radiance_f90;
}

fn default_matte_weight(lobe: Lobe, interface_tint: vec4f, v_dot_h: f32) -> f32 {
    return 1.0;
}
