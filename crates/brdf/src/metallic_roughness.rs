use glam::{Vec2, Vec3};

use crate::lobe::lifted;
use crate::{
    MIN_N_DOT_V, Reflectance, Sample, Surface, alpha_from_roughness, d_ggx, f_schlick, f0_from_ior,
    fd_lambert, local_from_world, pdf_ggx_vndf, sample_cosine_hemisphere, sample_ggx_vndf,
    v_smith_ggx_correlated,
};

/// Rec. 709 luminance weights, to choose between lobes.
pub(crate) const LUMINANCE: Vec3 = Vec3::new(0.2126, 0.7152, 0.0722);

/// Least chance of a lobe that reflects anything, so that no direction of that lobe is starved of samples.
pub(crate) const MIN_LOBE_PROBABILITY: f32 = 0.1;

/// glTF 2.0 reflectance for world-space directions about the unit normal `n` [1/sr, without the cosine].
///
/// Appendix B.3.5 with `KHR_materials_specular`: a dielectric is `(1 - max F) diffuse + F specular`, its `F` running from
/// `min(f0(ior) * specular_color, 1) * specular` to `specular`; a metal is `F specular` with `f0 = base_color`, `f90 = 1`.
/// Zero for a `wi` under the surface; `wo` is taken at least [`MIN_N_DOT_V`] above it. With `specular` and `metallic` 0 the
/// value is `base_color / pi` bit for bit.
pub fn evaluate_metallic_roughness(surface: &Surface, n: Vec3, wo: Vec3, wi: Vec3) -> Vec3 {
    let h = (wo + wi).normalize_or_zero();
    evaluate(surface, n.dot(wo), n.dot(wi), n.dot(h), wo.dot(h))
}

fn evaluate(surface: &Surface, n_dot_v: f32, n_dot_l: f32, n_dot_h: f32, v_dot_h: f32) -> Vec3 {
    if n_dot_l <= 0.0 {
        return Vec3::ZERO;
    }
    let n_dot_v = n_dot_v.max(MIN_N_DOT_V);
    let alpha = alpha_from_roughness(surface.roughness);
    let specular = d_ggx(n_dot_h, alpha) * v_smith_ggx_correlated(n_dot_v, n_dot_l, alpha);
    let diffuse = surface.base_color * fd_lambert();

    let f_dielectric = f_schlick(dielectric_f0(surface), surface.specular, v_dot_h);
    let dielectric = (1.0 - f_dielectric.max_element()) * diffuse + f_dielectric * specular;
    let metal = f_schlick(surface.base_color, 1.0, v_dot_h) * specular;
    (1.0 - surface.metallic) * dielectric + surface.metallic * metal
}

/// `dielectric_f0` of `KHR_materials_specular`, section "Implementation".
pub(crate) fn dielectric_f0(surface: &Surface) -> Vec3 {
    (f0_from_ior(surface.ior) * surface.specular_color).min(Vec3::ONE) * surface.specular
}

/// The glTF 2.0 surface as a model that can be sampled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MetallicRoughness {
    surface: Surface,
    alpha: f32,
}

impl MetallicRoughness {
    /// The model over these parameters.
    pub fn new(surface: Surface) -> Self {
        Self { surface, alpha: alpha_from_roughness(surface.roughness) }
    }

    /// The model's parameters.
    pub fn surface(&self) -> &Surface {
        &self.surface
    }

    /// [`Reflectance::pdf`] for world-space directions about the unit normal `n`.
    pub fn pdf_world(&self, n: Vec3, wo: Vec3, wi: Vec3) -> f32 {
        self.pdf(local_from_world(n, wo), local_from_world(n, wi))
    }

    /// Chance of sampling the microfacet lobe: its share of the reflected luminance, estimated by Fresnel at `n_dot_v`.
    /// `None` where nothing is reflected.
    fn specular_probability(&self, n_dot_v: f32) -> Option<f32> {
        let s = &self.surface;
        let f_dielectric = f_schlick(dielectric_f0(s), s.specular, n_dot_v);
        let f_metal = f_schlick(s.base_color, 1.0, n_dot_v);
        let specular = ((1.0 - s.metallic) * f_dielectric + s.metallic * f_metal).dot(LUMINANCE);
        let diffuse =
            (1.0 - s.metallic) * (1.0 - f_dielectric.max_element()).max(0.0) * s.base_color.dot(LUMINANCE);
        let has_specular = s.metallic > 0.0 || s.specular > 0.0;
        let has_diffuse = diffuse > 0.0;
        match (has_specular, has_diffuse) {
            (false, false) => None,
            (true, false) => Some(1.0),
            (false, true) => Some(0.0),
            (true, true) => Some(
                (specular / (specular + diffuse)).clamp(MIN_LOBE_PROBABILITY, 1.0 - MIN_LOBE_PROBABILITY),
            ),
        }
    }
}

impl Reflectance for MetallicRoughness {
    fn evaluate(&self, wo: Vec3, wi: Vec3) -> Vec3 {
        let h = (wo + wi).normalize_or_zero();
        evaluate(&self.surface, wo.z, wi.z, h.z, wo.dot(h))
    }

    fn sample(&self, wo: Vec3, u: Vec2, u_lobe: f32) -> Option<Sample> {
        let lifted_wo = lifted(Vec3::Z, wo);
        let wi = if u_lobe < self.specular_probability(lifted_wo.z)? {
            let h = sample_ggx_vndf(lifted_wo, self.alpha, u);
            2.0 * lifted_wo.dot(h) * h - lifted_wo
        } else {
            sample_cosine_hemisphere(u)
        };
        let pdf = self.pdf(wo, wi);
        (pdf > 0.0).then(|| Sample { wi, f: self.evaluate(wo, wi), pdf })
    }

    fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        if wi.z <= 0.0 {
            return 0.0;
        }
        let wo = lifted(Vec3::Z, wo);
        let Some(p) = self.specular_probability(wo.z) else { return 0.0 };
        let specular = if p > 0.0 { p * pdf_ggx_vndf(wo, wi, self.alpha) } else { 0.0 };
        specular + (1.0 - p) * wi.z * std::f32::consts::FRAC_1_PI
    }
}
