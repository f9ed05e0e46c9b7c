// Irradiance from nine SH coefficients of radiance: A_l of 2 pi / 3 and pi / 4 for l = 1, 2 (Ramamoorthi and Hanrahan 2001, eq. 8).
fn sh_irradiance(c: array<vec4f, 9>, n: vec3f) -> vec3f {
    let a0 = 3.14159265;
    let a1 = 2.09439510;
    let a2 = 0.78539816;
    return c[0].rgb * (a0 * 0.28209479)
        + (c[1].rgb * n.y + c[2].rgb * n.z + c[3].rgb * n.x) * (a1 * 0.48860251)
        + (c[4].rgb * (n.x * n.y) + c[5].rgb * (n.y * n.z) + c[7].rgb * (n.x * n.z)) * (a2 * 1.09254843)
        + c[6].rgb * (a2 * 0.31539157 * (3.0 * n.z * n.z - 1.0))
        + c[8].rgb * (a2 * 0.54627422 * (n.x * n.x - n.y * n.y));
}
