#import shadow_frame

// Comparing a whole kernel with the depth of the receiver's tangent plane instead of the receiver's own depth keeps tilted
// receivers from shadowing themselves (receiver plane depth bias, Isidoro 2006).

// The point from which a technique that knows the receiver's plane looks at the light: the offset along the normal, meant for a
// comparison of plain depths, is taken back but for `scale` of it and what casters deviate by.
fn less_offset(light: u32, position_world: vec3f, normal_world: vec3f, scale: f32) -> vec3f {
    let offset = scale * normal_offset(light, position_world) + lights[light].caster_deviation_world;
    return position_world + (offset - normal_offset(light, position_world)) * normal_world;
}

// Planes are taken to be tilted no further from the light than this cosine, or their depth would vary without bound.
const MIN_TILT_COSINE: f32 = 0.05;

// Change of linear depth per unit of map uv along the receiver's tangent plane. `receiver` is its place in the map.
fn receiver_depth_gradient(light: u32, position_world: vec3f, normal_world: vec3f, receiver: vec4f) -> vec2f {
    // Two axes that make a right-handed frame with the normal (Duff et al. 2017).
    let n = normal_world;
    let s = select(-1.0, 1.0, n.z >= 0.0);
    let a = -1.0 / (s + n.z);
    let b = n.x * n.y * a;
    let step = 1e-3 * lights[light].map_width_world;
    let p = receiver_in_light(light, position_world + step * vec3f(1.0 + s * n.x * n.x * a, s * b, -s * n.x), n) - receiver;
    let q = receiver_in_light(light, position_world + step * vec3f(b, s + n.y * n.y * a, -n.y), n) - receiver;
    // Solves gradient . p.xy = p.w, gradient . q.xy = q.w. The determinant is negative where the light sees the plane's front.
    let determinant = min(p.x * q.y - p.y * q.x, -MIN_TILT_COSINE * (dot(p.xy, p.xy) + dot(q.xy, q.xy)));
    return vec2f(p.w * q.y - q.w * p.y, q.w * p.x - p.w * q.x) / determinant;
}

// Depth that a blocker `offset` uv beside a receiver must stay above: the tangent plane's, where it rises towards the light; the
// receiver's own where it falls, because no light comes from below. Of a receiver beyond the map's depths the plane
// begins there, too: only what comes of it is brought back to them.
fn receiver_plane_depth(receiver: vec4f, gradient: vec2f, offset: vec2f) -> f32 {
    return min(receiver.w + min(dot(gradient, offset), 0.0), receiver.z);
}
