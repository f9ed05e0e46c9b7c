//! What lies on the base of a surface, whatever model the base has: a clear coat (`KHR_materials_clearcoat`) over sheen
//! (`KHR_materials_sheen`).
//!
//! Of the light from a view, the coat reflects the share that Schlick's Fresnel gives for the cosine to the view, and the base gets the rest:
//! `base (1 - c F(n_c . v)) + coat c F(n_c . v)` (the extension's section "Layering"). Sheen lies under
//! the coat, and leaves the base what it does not reflect of uniform light, its strongest colour's albedo ("Albedo-scaling technique", in the
//! form for the view alone). Where smooth fibres at grazing views would reflect more than they get, they reflect all. The shares depend on the view alone, so that a scene's
//! light is summed without them.

use std::f32::consts::FRAC_1_PI;

use glam::{Vec2, Vec3};

use crate::fresnel::schlick_share;
use crate::layers::LUMINANCE;
use crate::{Frame, LightPatch, Lobe, Model, sheen_albedo, sheen_light, sheen_sample, sheen_value};

/// Reflectance of a coat along its normal: an index of refraction of 1.5.
const COAT_F0: f32 = 0.04;

/// A surface's finish.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Finish {
    /// `clearcoatFactor`, 0..1; 0 is no coat.
    pub clearcoat: f32,
    /// Perceptual roughness of the coat.
    pub clearcoat_roughness: f32,
    /// Normal of the coat, unit, in the tangent frame of the base: its own where a normal map bends one of them.
    pub clearcoat_normal: Vec3,
    /// `sheenColorFactor`, 0..1; black is no sheen.
    pub sheen_color: Vec3,
    /// Perceptual roughness of the sheen.
    pub sheen_roughness: f32,
}

/// A finish as a view sees it. `Finish` of `finish.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeenFinish {
    /// Share of the light that the base gets.
    pub base: f32,
    /// Share of the light that the coat reflects.
    pub coat: f32,
    /// Its perceptual roughness.
    pub coat_roughness: f32,
    /// Its normal in the tangent frame of the base.
    pub coat_normal: Vec3,
    /// Factor of white sheen.
    pub sheen: Vec3,
    /// Its perceptual roughness.
    pub sheen_roughness: f32,
}

impl Finish {
    /// Whether there is any.
    pub fn is_present(&self) -> bool {
        self.clearcoat > 0.0 || self.sheen_color.max_element() > 0.0
    }

    /// As it is seen from `wo`, a direction in the tangent frame of the base.
    pub fn seen_from(&self, wo: Vec3) -> SeenFinish {
        let coat = coat_share(self.clearcoat, self.clearcoat_normal.dot(wo));
        let albedo = match self.sheen_color.max_element() > 0.0 {
            true => sheen_albedo(wo.z, self.sheen_roughness),
            false => 0.0,
        };
        SeenFinish {
            base: (1.0 - coat) * (1.0 - self.sheen_color.max_element() * albedo.min(1.0)),
            coat,
            coat_roughness: self.clearcoat_roughness,
            coat_normal: self.clearcoat_normal,
            sheen: (1.0 - coat) / albedo.max(1.0) * self.sheen_color,
            sheen_roughness: self.sheen_roughness,
        }
    }

    /// Share of the emission of the base that leaves it towards `wo`.
    pub fn emission_weight(&self, wo: Vec3) -> f32 {
        1.0 - coat_share(self.clearcoat, self.clearcoat_normal.dot(wo))
    }
}

/// Share of the light that a coat of this strength reflects.
pub fn coat_share(clearcoat: f32, n_dot_v: f32) -> f32 {
    clearcoat * (COAT_F0 + (1.0 - COAT_F0) * schlick_share(n_dot_v))
}

/// Its lobe is GGX without a Fresnel factor of its own: the share has it.
fn coat_lobe(finish: &SeenFinish) -> Lobe<'static> {
    let tint = Vec3::splat(finish.coat).extend(finish.coat);
    Lobe { model: Model::MetallicRoughness, shape: finish.coat_roughness, tint, tables: None }
}

/// The coat's own frame, in that of the base.
fn coat_frame(finish: &SeenFinish) -> Frame {
    Frame::from_normal(finish.coat_normal)
}

/// Value of the finish [1/sr], without the cosine, which is that of the base; zero for a `wi` under either surface.
pub fn finish_value(finish: &SeenFinish, wo: Vec3, wi: Vec3) -> Vec3 {
    if wi.z <= 0.0 {
        return Vec3::ZERO;
    }
    let frame = coat_frame(finish);
    let wi_coat = frame.local_from_world(wi);
    // The cosine of the coat in the place of the base's.
    let coat = coat_lobe(finish).value(frame.local_from_world(wo), wi_coat) * (wi_coat.z.max(0.0) / wi.z);
    if has_sheen(finish) { coat + sheen_value(finish.sheen_roughness, wo, wi) * finish.sheen } else { coat }
}

/// A direction about in proportion to that; it may lie under the surface.
pub fn finish_sample(finish: &SeenFinish, wo: Vec3, u: Vec2) -> Vec3 {
    // One number both chooses and, stretched again, samples.
    let of_coat = coat_chance(finish);
    if u.x >= of_coat {
        return sheen_sample(Vec2::new((u.x - of_coat) / (1.0 - of_coat), u.y));
    }
    let frame = coat_frame(finish);
    let u = Vec2::new(u.x / of_coat, u.y);
    let wi = coat_lobe(finish).sample(frame.local_from_world(wo), u);
    // What is under the coat is lost, though it may be above the base.
    if wi.z > 0.0 { frame.world_from_local(wi) } else { Vec3::NEG_Z }
}

/// Density of [`finish_sample`] [1/sr of `wi`].
pub fn finish_pdf(finish: &SeenFinish, wo: Vec3, wi: Vec3) -> f32 {
    if wi.z <= 0.0 {
        return 0.0;
    }
    let frame = coat_frame(finish);
    let of_coat = coat_chance(finish);
    let coat = coat_lobe(finish).pdf(frame.local_from_world(wo), frame.local_from_world(wi));
    of_coat * coat + (1.0 - of_coat) * (0.5 * FRAC_1_PI)
}

/// Integral of [`finish_value`] times the cosine over an area light.
pub fn finish_light(finish: &SeenFinish, wo: Vec3, light: &LightPatch) -> Vec3 {
    let frame = coat_frame(finish);
    let seen = LightPatch {
        direction: frame.local_from_world(light.direction),
        half_width: frame.local_from_world(light.half_width),
        half_height: frame.local_from_world(light.half_height),
        is_disk: light.is_disk,
    };
    let coat = coat_lobe(finish).over_light(frame.local_from_world(wo), &seen);
    if has_sheen(finish) {
        coat + sheen_light(finish.sheen_roughness, wo, light) * finish.sheen
    } else {
        coat
    }
}

/// Luminance of the light that the finish reflects, about: how often it is sampled.
pub fn finish_strength(finish: &SeenFinish) -> f32 {
    finish.coat + finish.sheen.dot(LUMINANCE)
}

fn has_sheen(finish: &SeenFinish) -> bool {
    finish.sheen.max_element() > 0.0
}

/// Chance of sampling the coat among both.
fn coat_chance(finish: &SeenFinish) -> f32 {
    match (finish.coat > 0.0, has_sheen(finish)) {
        (true, true) => 0.5,
        (false, true) => 0.0,
        _ => 1.0,
    }
}
