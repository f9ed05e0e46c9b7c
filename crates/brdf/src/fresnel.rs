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

/// Fresnel's reflectance of unpolarised light at an interface from air to a medium of the complex index `n + i k`, channel by channel; `k`
/// of a dielectric is 0. `cosine` is that of incidence. (Pharr, Jakob, Humphreys, "Physically Based Rendering", 4th edition, section 9.3.6.)
pub fn f_exact(n: Vec3, k: Vec3, cosine: f32) -> Vec3 {
    Vec3::from_array([0, 1, 2].map(|channel| exact(n[channel], k[channel], cosine.clamp(0.0, 1.0))))
}

fn exact(n: f32, k: f32, cosine: f32) -> f32 {
    // In 64 bits: an index of 200 is squared twice.
    let (n, k, c) = (f64::from(n), f64::from(k), f64::from(cosine));
    let c2 = c * c;
    let s2 = 1.0 - c2;
    let difference = n * n - k * k - s2;
    let a2_b2 = (difference * difference + 4.0 * n * n * k * k).sqrt();
    let a = (0.5 * (a2_b2 + difference)).max(0.0).sqrt();
    let perpendicular = (a2_b2 + c2 - 2.0 * a * c) / (a2_b2 + c2 + 2.0 * a * c).max(1e-30);
    let along = c2 * a2_b2 + s2 * s2;
    let parallel = (along - 2.0 * a * c * s2) / (along + 2.0 * a * c * s2).max(1e-30);
    (0.5 * perpendicular * (1.0 + parallel)).clamp(0.0, 1.0) as f32
}

/// Complex index of a metal at 630, 532 and 465 nm, near the primaries of Rec. 709.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Metal {
    /// Name for people and files.
    pub name: &'static str,
    /// Real part.
    pub index: Vec3,
    /// Imaginary part.
    pub extinction: Vec3,
}

const fn metal(name: &'static str, [nr, ng, nb]: [f32; 3], [kr, kg, kb]: [f32; 3]) -> Metal {
    Metal { name, index: Vec3::new(nr, ng, nb), extinction: Vec3::new(kr, kg, kb) }
}

/// Metals as the tables that come with Mitsuba 3 have them, interpolated at those wavelengths.
pub const METALS: &[Metal] = &[
    metal("aluminium", [1.36, 0.88, 0.66], [7.59, 6.47, 5.65]),
    metal("chromium", [3.56, 2.98, 2.13], [4.36, 4.45, 4.30]),
    metal("copper", [0.25, 1.07, 1.16], [3.38, 2.59, 2.46]),
    metal("gold", [0.18, 0.46, 1.37], [3.07, 2.41, 1.82]),
    metal("silver", [0.13, 0.13, 0.14], [3.96, 3.19, 2.61]),
    metal("tungsten", [3.63, 3.49, 3.32], [2.91, 2.72, 2.58]),
];
