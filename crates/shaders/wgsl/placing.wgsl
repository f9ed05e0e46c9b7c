// How transforms take vertices along.

// Cofactors, on the side that was the front: for normals, and for the tangents of normal maps, as the reference does it.
fn normal_matrix(m: mat3x3f) -> mat3x3f {
    let cofactors = mat3x3f(cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1]));
    return mirror_sign(m) * cofactors;
}

fn mirror_sign(m: mat3x3f) -> f32 {
    return select(1.0, -1.0, determinant(m) < 0.0);
}

fn linear_part(m: mat4x4f) -> mat3x3f {
    return mat3x3f(m[0].xyz, m[1].xyz, m[2].xyz);
}
