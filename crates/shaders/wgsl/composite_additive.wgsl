// Ambient rest plus shadowed lights (Arbree et al. 2005; Annen et al. 2008).
fn composite(full: vec3f, unshadowed: vec3f, shadowed: vec3f) -> vec3f {
    return shadowed;
}
