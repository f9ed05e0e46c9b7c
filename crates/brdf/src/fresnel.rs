use glam::Vec3;

/// Schlick's Fresnel approximation `f0 + (f90 - f0) (1 - v_dot_h)^5` (Schlick 1994, eq. 15; glTF 2.0 appendix B.3.3).
/// `v_dot_h` outside `[0, 1]` is clamped.
pub fn f_schlick(f0: Vec3, f90: f32, v_dot_h: f32) -> Vec3 {
    f0 + (Vec3::splat(f90) - f0) * schlick_share(v_dot_h)
}

/// Schlick's share of `f90` in `f0 (1 - share) + f90 share`.
pub(crate) fn schlick_share(v_dot_h: f32) -> f32 {
    let m = 1.0 - v_dot_h.clamp(0.0, 1.0);
    let m2 = m * m;
    m2 * m2 * m
}

/// Reflectance at normal incidence of an interface between air and a dielectric, `((ior - 1) / (ior + 1))^2`; 0.04 for 1.5.
///
/// `KHR_materials_ior` gives 0 a meaning of its own, full reflection, which the formula already yields.
pub fn f0_from_ior(ior: f32) -> f32 {
    let r = (ior - 1.0) / (ior + 1.0);
    r * r
}
