// Exact unshadowed light times the shadowed share of the fit (Heitz et al. 2018): never negative, exact without shadows.
fn composite(full: vec3f, unshadowed: vec3f, shadowed: vec3f) -> vec3f {
    return full * select(vec3f(1.0), shadowed / max(unshadowed, vec3f(1e-20)), unshadowed > vec3f(1e-20));
}
