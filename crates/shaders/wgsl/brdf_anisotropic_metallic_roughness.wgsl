#import brdf_metallic_roughness

// Tables for the lobe; the matte part lies under it as under the isotropic one.
fn anisotropic_metallic_roughness_matte_weight(lobe: Lobe, interface_tint: vec4f, v_dot_h: f32) -> f32 {
    return metallic_roughness_matte_weight(lobe, interface_tint, v_dot_h);
}
