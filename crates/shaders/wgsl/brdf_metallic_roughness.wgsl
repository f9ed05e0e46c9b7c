#import brdf_ggx
#import brdf_lobe

// glTF 2.0 (appendix B.3.5) with KHR_materials_specular; the lobe is GGX.

// The direction to the viewer, lifted to at least MIN_N_DOT_V above the surface.
fn lifted(wo: vec3f) -> vec3f {
    if wo.z >= MIN_N_DOT_V {
        return wo;
    }
    return normalize(vec3f(wo.xy, MIN_N_DOT_V));
}

// GGX with an alpha of its own for the microfacets' distribution.
fn ggx_lobe(lobe: Lobe, wo: vec3f, wi: vec3f, alpha_of_d: f32) -> vec3f {
    let h = half_vector(wo, wi);
    let masking = v_smith_ggx_correlated(max(wo.z, MIN_N_DOT_V), wi.z, alpha_from_roughness(lobe.shape));
    let bare = select(0.0, d_ggx(h.z, alpha_of_d) * masking, h.z > 0.0);
    return schlick_lobe(lobe, bare, dot(wo, h));
}

fn metallic_roughness_lobe(lobe: Lobe, wo: vec3f, wi: vec3f) -> vec3f {
    return ggx_lobe(lobe, wo, wi, alpha_from_roughness(lobe.shape));
}

fn metallic_roughness_sample(lobe: Lobe, wo: vec3f, u: vec2f) -> vec3f {
    let above = lifted(wo);
    return reflect(-above, sample_ggx_vndf(above, alpha_from_roughness(lobe.shape), u));
}

fn metallic_roughness_pdf(lobe: Lobe, wo: vec3f, wi: vec3f) -> f32 {
    return pdf_ggx_vndf(lifted(wo), wi, alpha_from_roughness(lobe.shape));
}

// No integral: the light's extent widens the lobe, alpha' = alpha + half the light's radius. Of a light in the scene the point nearest to
// the mirrored view stands for all of it, and its lobe keeps the energy of the widened one (Karis 2013, area lights).
fn metallic_roughness_light_lobe(lobe: Lobe, wo: vec3f, light: LightPatch) -> vec3f {
    let wi = light.nearest;
    if wi.z <= 0.0 {
        return vec3f(0.0);
    }
    let alpha = alpha_from_roughness(lobe.shape);
    let wide = min(alpha + 0.5 * sqrt(light.solid_angle / PI), 1.0);
    let narrowing = select(alpha / wide, 1.0, light.is_distant);
    return ggx_lobe(lobe, wo, wi, select(alpha, wide, light.is_distant))
        * (narrowing * narrowing * wi.z * light.solid_angle);
}

fn metallic_roughness_matte_weight(lobe: Lobe, interface_tint: vec4f, v_dot_h: f32) -> f32 {
    return 1.0 - max_component(f_schlick(interface_tint.rgb, interface_tint.w, v_dot_h));
}
