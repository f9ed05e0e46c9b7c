// How far the unit direction `w` lies outside a distant light's outline [rad]; negative inside.
fn disk_signed_angle(w: vec3f, direction: vec3f, angular_radius: f32) -> f32 {
    return atan2(length(cross(w, direction)), dot(w, direction)) - angular_radius;
}

// Outside, the distance to the farthest of the four edges' great circles: a lower bound near corners.
fn rectangle_signed_angle(w: vec3f, corners: array<vec4f, 4>) -> f32 {
    var outline = corners;
    var farthest = -4.0;
    for (var i = 0u; i < 4u; i++) {
        let edge = normalize(cross(outline[i].xyz, outline[(i + 1u) % 4u].xyz));
        farthest = max(farthest, asin(clamp(dot(edge, w), -1.0, 1.0)));
    }
    return farthest;
}
