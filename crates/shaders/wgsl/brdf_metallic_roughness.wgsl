#import brdf_ggx
#import brdf_lobe
#import brdf_torrance_sparrow

// glTF 2.0 (appendix B.3.5) with KHR_materials_specular; the lobe is GGX.

// The direction to the viewer, lifted to at least MIN_N_DOT_V above the surface.
fn lifted(wo: vec3f) -> vec3f {
    if wo.z >= MIN_N_DOT_V {
        return wo;
    }
    return normalize(vec3f(wo.xy, MIN_N_DOT_V));
}

// GGX's slopes as a sum of Gaussian ones: their root mean squares in alphas, and shares. See the twin.
const GAUSSIANS = array(
    vec2f(0.6023, 0.1929), vec2f(1.0445, 0.4113), vec2f(1.8306, 0.2523), vec2f(3.2827, 0.1041), vec2f(6.7452, 0.0392)
);

fn metallic_roughness_lobe(lobe: Lobe, wo: vec3f, wi: vec3f) -> vec3f {
    let h = half_vector(wo, wi);
    let alpha = alpha_from_roughness(lobe.shape);
    let masking = v_smith_ggx_correlated(max(wo.z, MIN_N_DOT_V), wi.z, alpha);
    let bare = select(0.0, d_ggx(h.z, alpha) * masking, h.z > 0.0);
    return schlick_lobe(lobe, bare, dot(wo, h));
}

fn metallic_roughness_sample(lobe: Lobe, wo: vec3f, u: vec2f) -> vec3f {
    let above = lifted(wo);
    return reflect(-above, sample_ggx_vndf(above, alpha_from_roughness(lobe.shape), u));
}

fn metallic_roughness_pdf(lobe: Lobe, wo: vec3f, wi: vec3f) -> f32 {
    return pdf_ggx_vndf(lifted(wo), wi, alpha_from_roughness(lobe.shape));
}

fn metallic_roughness_light_lobe(lobe: Lobe, wo: vec3f, light: LightPatch) -> vec3f {
    let seen = half_vector_patch(wo, light);
    if !seen.is_seen {
        return vec3f(0.0);
    }
    let alpha = alpha_from_roughness(lobe.shape);
    var on_light = 0.0;
    for (var i = 0; i < 5; i++) {
        let gaussian = GAUSSIANS[i];
        on_light += gaussian.y * gaussian_slopes_on(seen, gaussian.x * alpha);
    }
    let masking = v_smith_ggx_correlated(max(wo.z, MIN_N_DOT_V), light.direction.z, alpha);
    return torrance_sparrow_light_lobe(lobe, light.direction.z, seen.v_dot_h, on_light, masking);
}

fn metallic_roughness_matte_weight(lobe: Lobe, interface_tint: vec4f, v_dot_h: f32) -> f32 {
    return 1.0 - max_component(f_schlick(interface_tint.rgb, interface_tint.w, v_dot_h));
}
