use glam::{DVec3, Vec3};
use gnomon_envmap::Equirect;
use gnomon_picture::{LUMINANCE, RgbImage};
use serde_json::{Map, Value};

use crate::DistantLight;

/// What a fit makes of an environment map. Flux of all `lights` plus flux of `residual` equals the map's flux.
#[derive(Clone, Debug)]
pub struct LightSet {
    /// Name of the fit that made it.
    pub method: &'static str,
    /// The fit's parameters, by name, as they appear in the JSON.
    pub parameters: Map<String, Value>,
    /// Lights, in the order they were found.
    pub lights: Vec<DistantLight>,
    /// What is left of the map: the ambient part. As large as the input map.
    pub residual: Equirect,
    /// Whether light is left out that arrives nowhere in the scene that the set was made for ([`crate::FitOptions::arrival`]): then lights
    /// and residual hold less than the map, and unshadowed light is theirs.
    pub omits_hidden: bool,
    /// Whether they are no fit's, so that lights and residual are what lights: unshadowed light and reflections are theirs, too.
    pub stands_alone: bool,
    /// So many of the lights, the last ones, hold light that was taken out of the map before ([`crate::clamped`]): mirrors do not find them in
    /// there.
    pub taken_out: usize,
}

/// Shares of the map's luminous flux, each in `[0, 1]`; all zero for a black map.
#[derive(Clone, Debug, PartialEq)]
pub struct FluxShares {
    /// One share a light, in the set's order.
    pub lights: Vec<f64>,
    /// Share of the residual.
    pub residual: f64,
}

impl LightSet {
    /// A set without recorded parameters, for lights that no fit made.
    pub fn new(method: &'static str, lights: Vec<DistantLight>, residual: Equirect) -> Self {
        Self {
            method,
            parameters: Map::new(),
            lights,
            residual,
            omits_hidden: false,
            stands_alone: false,
            taken_out: 0,
        }
    }

    /// Lights that hold all of `map`'s flux, so that what is left of it is black.
    pub(crate) fn without_residual(
        method: &'static str,
        parameters: Map<String, Value>,
        lights: Vec<DistantLight>,
        map: &Equirect,
    ) -> Self {
        let residual = Equirect::new(RgbImage::filled(map.width(), map.height(), Vec3::ZERO));
        Self { method, parameters, lights, residual, omits_hidden: false, stands_alone: false, taken_out: 0 }
    }

    /// Flux [radiance x sr] of all lights together, channel by channel.
    pub fn lights_flux(&self) -> DVec3 {
        self.lights.iter().map(DistantLight::flux).sum()
    }

    /// Flux [radiance x sr] of the residual, channel by channel.
    pub fn residual_flux(&self) -> DVec3 {
        self.residual.flux()
    }

    /// Flux [radiance x sr] of lights and residual: the map's own, up to rounding.
    pub fn total_flux(&self) -> DVec3 {
        self.lights_flux() + self.residual_flux()
    }

    /// How the luminous flux divides among the lights and the residual.
    pub fn flux_shares(&self) -> FluxShares {
        let luminous = |flux: DVec3| flux.dot(LUMINANCE.as_dvec3());
        let total = luminous(self.total_flux());
        let share = |flux: DVec3| if total > 0.0 { luminous(flux) / total } else { 0.0 };
        FluxShares {
            lights: self.lights.iter().map(|light| share(light.flux())).collect(),
            residual: share(self.residual_flux()),
        }
    }

    /// The set with all light multiplied, channel by channel.
    #[must_use]
    pub fn times(&self, factor: Vec3) -> Self {
        Self {
            lights: self.lights.iter().map(|light| light.times(factor)).collect(),
            residual: self.residual.times(factor),
            ..self.clone()
        }
    }

    /// The set turned about +y by `yaw` [rad], right-hand rule. The residual's rows shift by linear interpolation, which
    /// keeps each row's flux.
    pub fn rotated(&self, yaw: f32) -> Self {
        Self {
            method: self.method,
            parameters: self.parameters.clone(),
            lights: self.lights.iter().map(|light| light.rotated(yaw)).collect(),
            residual: self.residual.rotated(yaw),
            omits_hidden: self.omits_hidden,
            stands_alone: self.stands_alone,
            taken_out: self.taken_out,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f32::consts::FRAC_PI_2;

    use super::*;

    fn ramp() -> Equirect {
        Equirect::new(RgbImage::from_fn(8, 4, |x, y| Vec3::new(x as f32, y as f32, 1.0)))
    }

    #[test]
    fn a_turned_map_shows_the_same_radiance_towards_turned_directions() {
        let map = ramp();
        let turned = LightSet::new("none", Vec::new(), map.clone()).rotated(FRAC_PI_2).residual;
        for d in [Vec3::X, Vec3::new(0.3, 0.4, -0.7).normalize(), Vec3::new(-0.6, -0.2, 0.5).normalize()] {
            let to = glam::Quat::from_rotation_y(FRAC_PI_2) * d;
            assert!((turned.lookup(to) - map.lookup(d)).length() < 1e-5);
        }
    }

    #[test]
    fn any_turn_keeps_the_flux() {
        let set = LightSet::new("none", vec![DistantLight::disk(DVec3::Z, 0.2, DVec3::ONE)], ramp());
        for yaw in [0.1, -7.0, 100.0] {
            let turned = set.rotated(yaw);
            assert!((turned.total_flux() - set.total_flux()).length() < 1e-5 * set.total_flux().length());
        }
    }

    #[test]
    fn shares_sum_to_one_and_a_black_set_has_none() {
        let set = LightSet::new("none", vec![DistantLight::disk(DVec3::Z, 0.2, DVec3::ONE)], ramp());
        let shares = set.flux_shares();
        assert!((shares.lights[0] + shares.residual - 1.0).abs() < 1e-9);
        let black = LightSet::new("none", Vec::new(), Equirect::new(RgbImage::filled(2, 1, Vec3::ZERO)));
        assert_eq!(black.flux_shares(), FluxShares { lights: Vec::new(), residual: 0.0 });
    }
}
