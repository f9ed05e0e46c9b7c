// Tangent frame of a surface point: perpendicular unit vectors in world space. Local x is the tangent, y the bitangent, z the shading
// normal. The bitangent is the mesh's from both sides, so that a frame seen from behind is left-handed.
struct Frame {
    t: vec3f,
    b: vec3f,
    n: vec3f,
}

// Some frame about a unit normal (Duff et al. 2017).
fn frame_from_normal(n: vec3f) -> Frame {
    let s = select(-1.0, 1.0, n.z >= 0.0);
    let a = -1.0 / (s + n.z);
    let b = n.x * n.y * a;
    return Frame(vec3f(1.0 + s * n.x * n.x * a, s * b, -s * n.x), vec3f(b, s + n.y * n.y * a, -n.y), n);
}

// The frame whose tangent lies nearest to a mesh's, with the bitangent's sign in w: b = w n x t. Any frame where that tangent is zero or
// along the normal.
fn frame_from_tangent(n: vec3f, tangent: vec4f) -> Frame {
    let across = tangent.xyz - n * dot(n, tangent.xyz);
    let length2 = dot(across, across);
    if length2 <= 1e-8 * dot(tangent.xyz, tangent.xyz) {
        return frame_from_normal(n);
    }
    // What little is left of a tangent along the normal is rounding for the most part: once more makes it perpendicular.
    let t = normalize(across - n * dot(n, across));
    return Frame(t, cross(n, t) * select(1.0, -1.0, tangent.w < 0.0), n);
}

fn local_from_world(frame: Frame, world: vec3f) -> vec3f {
    return vec3f(dot(world, frame.t), dot(world, frame.b), dot(world, frame.n));
}

fn world_from_local(frame: Frame, local: vec3f) -> vec3f {
    return frame.t * local.x + frame.b * local.y + frame.n * local.z;
}
