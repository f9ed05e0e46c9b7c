// Heights over a surface as slopes: of a height h the slope along the surface is h_u grad u + h_v grad v (Mikkelsen, "Bump Mapping
// Unparametrized Surfaces on the GPU", 2010). Twins: `height.rs` of the scene.

// How texture coordinates change along a surface [1/m].
struct UvGradients {
    u: vec3f,
    v: vec3f,
}

// From the changes of position and coordinates from sample to sample; those of the coordinates are multiplied by `share`, those of the position
// are not.
fn uv_gradients(n: vec3f, across: vec3f, down: vec3f, uv_across: vec2f, uv_down: vec2f, share: f32) -> UvGradients {
    let a = cross(down, n);
    let b = cross(n, across);
    let determinant = share * dot(across, a);
    let scale = select(0.0, 1.0 / determinant, determinant != 0.0);
    return UvGradients(scale * (uv_across.x * a + uv_down.x * b), scale * (uv_across.y * a + uv_down.y * b));
}

// Least share of a normal along the smooth one: a normal map cannot tilt further where heights bend it, too.
const LEAST_COSINE: f32 = 0.05;

// A unit normal, which a normal map may have bent away from the smooth one, bent further by heights that rise along the surface so:
// slopes add.
fn bent_by_heights(normal: vec3f, smooth_normal: vec3f, rise: vec3f) -> vec3f {
    return normalize(normal / max(dot(normal, smooth_normal), LEAST_COSINE) - rise);
}

// Roughness of a surface whose slopes spread by a variance, of both directions together, about their mean: Beckmann's alpha squared is
// twice that of one direction.
fn roughness_with_slopes(roughness: f32, variance: f32) -> f32 {
    let squared = roughness * roughness;
    return min(sqrt(sqrt(squared * squared + variance)), max(roughness, 1.0));
}
