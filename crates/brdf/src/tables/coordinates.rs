use std::f32::consts::{FRAC_1_PI, FRAC_2_PI};

use glam::Vec3;

use crate::sampling::half_vector;
use crate::torrance_sparrow::angle_from_cosine;

/// What a table is looked up with. Arguments lie in `[0, 1]`; angles against an axis in units of a quarter turn. `TABLE_` constants of the
/// shaders have the same numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Coordinates {
    /// Angle delta from normal to half vector, and the half vector's azimuth, whole.
    Half,
    /// The same of a function that is symmetric about both tangents: the azimuth in the first quadrant, of half vectors whose y is first
    /// multiplied by this number. It brings the azimuths of an ellipse's narrow side apart.
    HalfQuadrant(f32),
    /// delta, and the angle theta between half vector and view.
    HalfAndDifference,
    /// Cosines between normal and light, normal and view.
    Cosines,
    /// theta, and the light's azimuth about the half vector, half a turn of it (Rusinkiewicz 1998): swapping view and light turns it by
    /// the other half.
    Difference,
    /// Cosine and azimuth of the light, in the first quadrant.
    Light,
    /// Cosine and azimuth of the view, in the first quadrant.
    View,
    /// Angles of light and view against the plane across the tangent, from one side to the other.
    Tangent,
    /// Angle whose cosine is `sum of axes * wo * wi` over the greatest such sum (Lafortune et al. 1997): from the mirrored view for
    /// `(-1, -1, 1)`.
    CosineLobe(Vec3),
}

impl Coordinates {
    /// Number for the shaders.
    pub const fn number(self) -> u32 {
        match self {
            Self::Half => 0,
            Self::HalfQuadrant(_) => 1,
            Self::HalfAndDifference => 2,
            Self::Cosines => 3,
            Self::Difference => 4,
            Self::Light => 5,
            Self::View => 6,
            Self::Tangent => 7,
            Self::CosineLobe(_) => 8,
        }
    }

    /// What numbers it has.
    pub fn parameters(self) -> Vec3 {
        match self {
            Self::CosineLobe(axes) => axes,
            Self::HalfQuadrant(stretch) => Vec3::new(stretch, 0.0, 0.0),
            _ => Vec3::ZERO,
        }
    }

    /// Whether the second argument goes round.
    pub fn is_periodic(self) -> bool {
        matches!(self, Self::Half | Self::Difference)
    }

    /// Whether a turn of both directions about the normal changes nothing, whatever the table.
    pub(super) fn is_isotropic(self) -> bool {
        matches!(self, Self::HalfAndDifference | Self::Cosines | Self::Difference)
            || matches!(self, Self::CosineLobe(axes) if axes.x == axes.y)
    }

    /// Whether the first argument depends on the tangent.
    pub(super) fn is_about_tangent(self) -> bool {
        matches!(self, Self::Tangent | Self::CosineLobe(_))
    }

    pub(super) fn is_of_half_vector(self) -> bool {
        matches!(self, Self::Half | Self::HalfQuadrant(_) | Self::HalfAndDifference | Self::CosineLobe(_))
    }

    /// Scales of both arguments: of two cosines it is the same.
    pub(super) fn spread_both(self, scale: f32) -> [f32; 2] {
        [scale, if self == Self::Cosines { scale } else { 0.0 }]
    }

    /// Both arguments of two directions.
    pub fn arguments(self, wo: Vec3, wi: Vec3) -> [f32; 2] {
        let h = half_vector(wo, wi);
        let delta = FRAC_2_PI * (h.x * h.x + h.y * h.y).sqrt().atan2(h.z);
        let theta = || FRAC_2_PI * angle_from_cosine(wo.dot(h).clamp(0.0, 1.0));
        let quadrant = |v: Vec3| FRAC_2_PI * v.y.abs().atan2(v.x.abs());
        match self {
            Self::Half => [delta, 0.5 * FRAC_1_PI * wrapped(h.y.atan2(h.x), 2.0)],
            Self::HalfQuadrant(stretch) => [delta, quadrant(Vec3::new(h.x, stretch * h.y, h.z))],
            Self::HalfAndDifference => [delta, theta()],
            Self::Cosines => [wi.z.clamp(0.0, 1.0), wo.z.clamp(0.0, 1.0)],
            Self::Difference => [theta(), FRAC_1_PI * wrapped(azimuth_about(h, wi), 1.0)],
            Self::Light => [wi.z.clamp(0.0, 1.0), quadrant(wi)],
            Self::View => [wo.z.clamp(0.0, 1.0), quadrant(wo)],
            Self::Tangent => [wi.x, wo.x].map(|x| 0.5 + FRAC_1_PI * x.clamp(-1.0, 1.0).asin()),
            Self::CosineLobe(axes) => {
                let most = axes.abs().max_element().max(1e-6);
                [FRAC_2_PI * angle_from_cosine(((axes * wo).dot(wi) / most).clamp(0.0, 1.0)), 0.0]
            }
        }
    }
}

/// An angle brought to `[0, half_turns pi)`.
fn wrapped(angle: f32, half_turns: f32) -> f32 {
    let turn = half_turns * std::f32::consts::PI;
    angle - turn * (angle / turn).floor()
}

/// Azimuth of a direction in the frame that the rotation of the half vector to the normal, in the plane of both, brings along.
fn azimuth_about(h: Vec3, wi: Vec3) -> f32 {
    let sine2 = h.x * h.x + h.y * h.y;
    let (cos, sin) = if sine2 > 1e-12 { (h.x / sine2.sqrt(), h.y / sine2.sqrt()) } else { (1.0, 0.0) };
    // About the normal until h lies above x, then about y.
    let along = cos * wi.x + sin * wi.y;
    let y = cos * wi.y - sin * wi.x;
    let x = h.z * along - sine2.sqrt() * wi.z;
    y.atan2(x)
}
