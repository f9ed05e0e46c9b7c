//! What lies on the base of a surface, whatever model the base has: a clear coat (`KHR_materials_clearcoat`).
//!
//! Of the light from a view, the coat reflects the share that Schlick's Fresnel gives for the cosine to the view, and the base gets the rest:
//! `base (1 - c F(n_c . v)) + coat c F(n_c . v)` (the extension's section "Layering"). The shares depend on the view alone, so that a scene's
//! light is summed without them.

use glam::{Vec2, Vec3};

use crate::fresnel::schlick_share;
use crate::{Frame, LightPatch, Lobe, Model};

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
}

impl Finish {
    /// Whether there is any.
    pub fn is_present(&self) -> bool {
        self.clearcoat > 0.0
    }

    /// As it is seen from `wo`, a direction in the tangent frame of the base.
    pub fn seen_from(&self, wo: Vec3) -> SeenFinish {
        let coat = coat_share(self.clearcoat, self.clearcoat_normal.dot(wo));
        SeenFinish {
            base: 1.0 - coat,
            coat,
            coat_roughness: self.clearcoat_roughness,
            coat_normal: self.clearcoat_normal,
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
    coat_lobe(finish).value(frame.local_from_world(wo), wi_coat) * (wi_coat.z.max(0.0) / wi.z)
}

/// A direction about in proportion to that; it may lie under the surface.
pub fn finish_sample(finish: &SeenFinish, wo: Vec3, u: Vec2) -> Vec3 {
    let frame = coat_frame(finish);
    frame.world_from_local(coat_lobe(finish).sample(frame.local_from_world(wo), u))
}

/// Density of [`finish_sample`] [1/sr of `wi`].
pub fn finish_pdf(finish: &SeenFinish, wo: Vec3, wi: Vec3) -> f32 {
    if wi.z <= 0.0 {
        return 0.0;
    }
    let frame = coat_frame(finish);
    coat_lobe(finish).pdf(frame.local_from_world(wo), frame.local_from_world(wi))
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
    coat_lobe(finish).over_light(frame.local_from_world(wo), &seen)
}

/// Luminance of the light that the finish reflects, about: how often it is sampled.
pub fn finish_strength(finish: &SeenFinish) -> f32 {
    finish.coat
}
