#import gbuffer_surface
#import resample

// Exponent of n . n' for a sample that shows a surface.
fn normal_power_at(sample: vec2u) -> f32 {
    let packed = packed_surface_at(sample);
    let lobe = lobe_of(materials[packed.material], packed);
    let roughness = reflectance_equivalent_roughness(lobe);
    return resample_normal_power(select(1.0, alpha_from_roughness(roughness), has_lobe(lobe)));
}

// Weight of a shading point for a sample of the picture.
fn point_weight(point: ShadingPoint, sample: vec2u, position_world: vec3f, n: vec3f, normal_power: f32) -> f32 {
    let side = f32(view.shadow_sampling);
    let place = sample_place(vec2u(point.sample % view.size.x, point.sample / view.size.x));
    // Homogeneous w is the distance along the view, or 1 in a parallel one.
    let w = dot(vec4f(view.clip_from_world[0].w, view.clip_from_world[1].w, view.clip_from_world[2].w, view.clip_from_world[3].w),
        vec4f(position_world, 1.0));
    let position = vec3f(point.position_world[0], point.position_world[1], point.position_world[2]);
    let normal = octahedral_decode(unpack2x16float(point.normal));
    let height = dot(n, position - position_world) / (side * view.sample_extent * w);
    return resample_weight((place - sample_place(sample)) / side, height, dot(n, normal), normal_power);
}
