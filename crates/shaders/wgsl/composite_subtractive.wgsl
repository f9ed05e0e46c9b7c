// Exact unshadowed light less what the lights' shadows take away (DeCoro and Rusinkiewicz 2008).
fn composite(full: vec3f, unshadowed: vec3f, shadowed: vec3f) -> vec3f {
    return max(full - (unshadowed - shadowed), vec3f(0.0));
}
