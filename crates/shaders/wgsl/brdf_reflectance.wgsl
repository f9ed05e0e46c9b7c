#import brdf_ggx
#import brdf_phong
#import brdf_blinn_phong
#import brdf_torrance_sparrow

// Every reflectance model behind one interface. `gnomon_brdf::Model` numbers them. Directions are in world space about the unit normal n;
// `parameter` is the model's roughness, shininess or slope, as the G-buffer holds it.

const MODEL_METALLIC_ROUGHNESS: u32 = 0u;
const MODEL_LAMBERT: u32 = 1u;
const MODEL_PHONG: u32 = 2u;
const MODEL_BLINN_PHONG: u32 = 3u;
const MODEL_TORRANCE_SPARROW_BECKMANN: u32 = 4u;
const MODEL_TORRANCE_SPARROW_GAUSSIAN: u32 = 5u;

// `gnomon_brdf::MIN_N_DOT_V`.
const MIN_N_DOT_V: f32 = 1e-4;

// At least `gnomon_brdf::MIN_ALPHA`.
fn alpha_from_roughness(roughness: f32) -> f32 {
    return clamp(roughness * roughness, 0.002, 1.0);
}

// f90's share in Schlick's f0 (1 - share) + f90 share.
fn schlick_share(v_dot_h: f32) -> f32 {
    let m = clamp(1.0 - v_dot_h, 0.0, 1.0);
    let m2 = m * m;
    return m2 * m2 * m;
}

// The glossy part without the cosine, 1 / sr: x f0 + y f90. 0 for light from under the surface.
fn reflectance_lobe(model: u32, parameter: f32, n: vec3f, wo: vec3f, wi: vec3f) -> vec2f {
    let n_dot_l = dot(n, wi);
    if n_dot_l <= 0.0 {
        return vec2f(0.0);
    }
    let h = half_vector(wo, wi);
    let n_dot_v = max(dot(n, wo), MIN_N_DOT_V);
    var lobe = 0.0;
    switch model {
        case MODEL_METALLIC_ROUGHNESS: {
            let alpha = alpha_from_roughness(parameter);
            let n_dot_h = dot(n, h);
            lobe = d_ggx(n_dot_h, alpha) * v_smith_ggx_correlated(n_dot_v, n_dot_l, alpha);
            lobe = select(0.0, lobe, n_dot_h > 0.0);
        }
        case MODEL_PHONG: {
            return vec2f(phong_lobe(parameter, n, wo, wi), 0.0);
        }
        case MODEL_BLINN_PHONG: {
            return vec2f(blinn_phong_lobe(parameter, n, wo, wi), 0.0);
        }
        case MODEL_TORRANCE_SPARROW_BECKMANN: {
            lobe = d_beckmann(dot(n, h), parameter) * v_smith_beckmann(n_dot_v, n_dot_l, parameter);
        }
        case MODEL_TORRANCE_SPARROW_GAUSSIAN: {
            let masking_slope = gaussian_masking_slope(parameter);
            lobe = d_gaussian(dot(n, h), parameter) * v_smith_beckmann(n_dot_v, n_dot_l, masking_slope);
        }
        default: {}
    }
    let share = schlick_share(dot(wo, h));
    return lobe * vec2f(1.0 - share, share);
}

// Roughness of a GGX lobe about as wide (Walter et al. 2007, section 5.3; Phong's exponent is a quarter of Blinn's).
fn equivalent_roughness(model: u32, parameter: f32) -> f32 {
    switch model {
        case MODEL_PHONG: {
            return sqrt(sqrt(2.0 / (4.0 * parameter + 2.0)));
        }
        case MODEL_BLINN_PHONG: {
            return sqrt(sqrt(2.0 / (parameter + 2.0)));
        }
        case MODEL_TORRANCE_SPARROW_BECKMANN, MODEL_TORRANCE_SPARROW_GAUSSIAN: {
            return sqrt(parameter);
        }
        default: {
            return parameter;
        }
    }
}

// Share of uniform light that a lobe reflects, x f0 + y f90, given GGX's of equivalent roughness: that of narrow Phong lobes falls with the
// cosine and its square.
fn lobe_albedo(model: u32, n_dot_v: f32, ggx_albedo: vec2f) -> vec2f {
    switch model {
        case MODEL_PHONG: {
            return vec2f(n_dot_v, 0.0);
        }
        case MODEL_BLINN_PHONG: {
            return vec2f(n_dot_v * n_dot_v, 0.0);
        }
        default: {
            return ggx_albedo;
        }
    }
}

struct LobeSample {
    wi: vec3f,
    // 1 / sr; 0 where the sample is lost under the surface.
    pdf: f32,
}

// A direction of `reflectance_lobe` for u in [0, 1)^2, about in proportion to its value times the cosine.
fn reflectance_sample(model: u32, parameter: f32, n: vec3f, wo: vec3f, u: vec2f) -> LobeSample {
    var wi = n;
    switch model {
        case MODEL_METALLIC_ROUGHNESS: {
            let above = lifted(n, wo);
            let h = sample_ggx_vndf(local_from_world(n, above), alpha_from_roughness(parameter), u);
            wi = reflect(-above, world_from_local(n, h));
        }
        case MODEL_PHONG: {
            wi = phong_sample(parameter, n, wo, u);
        }
        case MODEL_BLINN_PHONG: {
            wi = blinn_phong_sample(parameter, n, wo, u);
        }
        case MODEL_TORRANCE_SPARROW_BECKMANN: {
            wi = reflect(-wo, world_from_local(n, beckmann_sample(parameter, u)));
        }
        case MODEL_TORRANCE_SPARROW_GAUSSIAN: {
            wi = reflect(-wo, world_from_local(n, gaussian_sample(parameter, u)));
        }
        default: {}
    }
    return LobeSample(wi, reflectance_pdf(model, parameter, n, wo, wi));
}

// Density of `reflectance_sample`, 1 / sr; its integral is 1 less the share of lost samples.
fn reflectance_pdf(model: u32, parameter: f32, n: vec3f, wo: vec3f, wi: vec3f) -> f32 {
    let h = half_vector(wo, wi);
    let n_dot_h = dot(n, h);
    let v_dot_h = dot(wo, h);
    if dot(n, wi) <= 0.0 {
        return 0.0;
    }
    switch model {
        case MODEL_METALLIC_ROUGHNESS: {
            return pdf_ggx_vndf(n, lifted(n, wo), wi, alpha_from_roughness(parameter));
        }
        case MODEL_PHONG: {
            return phong_pdf(parameter, n, wo, wi);
        }
        case MODEL_BLINN_PHONG: {
            return blinn_phong_pdf(parameter, n, wo, wi);
        }
        case MODEL_TORRANCE_SPARROW_BECKMANN: {
            return select(0.0, beckmann_pdf(n_dot_h, parameter) / (4.0 * v_dot_h), n_dot_h > 0.0 && v_dot_h > 0.0);
        }
        case MODEL_TORRANCE_SPARROW_GAUSSIAN: {
            return select(0.0, gaussian_pdf(n_dot_h, parameter) / (4.0 * v_dot_h), n_dot_h > 0.0 && v_dot_h > 0.0);
        }
        default: {
            return 0.0;
        }
    }
}

// The direction to the viewer, lifted to at least MIN_N_DOT_V above the surface.
fn lifted(n: vec3f, wo: vec3f) -> vec3f {
    let n_dot_v = dot(n, wo);
    if n_dot_v >= MIN_N_DOT_V {
        return wo;
    }
    return normalize(wo + n * (MIN_N_DOT_V - n_dot_v));
}
