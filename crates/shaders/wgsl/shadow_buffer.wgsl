#import view
#import resample

// Weight of a shading point for a sample of the picture.
fn point_weight(point: ShadingPoint, sample: vec2u, position_world: vec3f, n: vec3f) -> f32 {
    let side = f32(view.shadow_sampling);
    let place = vec2f(vec2u(point.sample % view.size.x, point.sample / view.size.x));
    // Homogeneous w is the distance along the view, or 1 in a parallel one.
    let w = dot(vec4f(view.clip_from_world[0].w, view.clip_from_world[1].w, view.clip_from_world[2].w, view.clip_from_world[3].w),
        vec4f(position_world, 1.0));
    let height = dot(n, point.position_world - position_world) / (side * view.sample_extent * w);
    return resample_weight((place - vec2f(sample)) / side, height, dot(n, point.normal));
}
