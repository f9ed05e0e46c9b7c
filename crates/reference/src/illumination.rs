use glam::{DVec2, DVec3, Vec3};
use gnomon_lights::{DistantLight, LightShape};
use gnomon_scene::{AreaLightShape, PlacedLight};

use crate::environment::{Aim, EnvironmentSampler, IMPORTANCE, choose_weighted};
use crate::near_light::{NearLight, Seen};

/// Everything that shines: a map and area lights at infinity, and area lights in the scene.
pub(crate) struct Illumination<'a> {
    map: Option<EnvironmentSampler<'a>>,
    lights: Vec<AreaLight>,
    /// How many of the lights are not the scene's own suns, which come last.
    of_environment: usize,
    near: Vec<NearLight>,
}

/// The illumination as a surface at a given point with a given normal samples it: every part in proportion to its flux times
/// a bound of the cosine.
pub(crate) struct Aimed<'l, 'a> {
    illumination: &'l Illumination<'a>,
    n: Vec3,
    map: Option<(&'l EnvironmentSampler<'a>, Aim)>,
    near: Vec<Seen<'l>>,
    /// Factor of the scene's own lights.
    own: f32,
    /// Sum of the weights of map and lights.
    total: f64,
}

impl<'a> Illumination<'a> {
    pub(crate) fn new(map: Option<EnvironmentSampler<'a>>, lights: &[DistantLight]) -> Self {
        let lights: Vec<_> = lights.iter().filter_map(AreaLight::new).collect();
        Self { map, of_environment: lights.len(), lights, near: Vec::new() }
    }

    /// The same and lights in the scene.
    pub(crate) fn with_near(mut self, lights: &[PlacedLight]) -> Self {
        for light in lights {
            match light.shape {
                AreaLightShape::Sun { angular_radius } => {
                    let sun =
                        DistantLight::around(-light.normal, light.tangent, angular_radius, light.radiance);
                    self.lights.extend(AreaLight::new(&sun));
                }
                _ => self.near.push(NearLight::new(light)),
            }
        }
        self
    }

    /// Unshadowed irradiance of the environment on a surface with the unit normal `n`.
    pub(crate) fn irradiance(&self, n: Vec3) -> DVec3 {
        let map = self.map.as_ref().map_or(DVec3::ZERO, |sampler| sampler.irradiance(n));
        let light = |light: &AreaLight| (light.radiance * light.source.irradiance(n)).as_dvec3();
        map + self.lights[..self.of_environment].iter().map(light).sum::<DVec3>()
    }

    /// For a surface at `point` [m] with the unit normal `n`.
    pub(crate) fn aim(&self, point: Vec3, n: Vec3) -> Aimed<'_, 'a> {
        let map = self.map.as_ref().map(|map| (map, map.aim(n)));
        let lights: f64 = self.lights.iter().map(|light| f64::from(light.weight(n))).sum();
        let near: Vec<_> = self.near.iter().filter_map(|light| light.seen_from(point, n)).collect();
        let total = map.as_ref().map_or(0.0, |(_, aim)| aim.total)
            + lights
            + near.iter().map(|seen| seen.weight).sum::<f64>();
        Aimed { illumination: self, n, map, near, own: 1.0, total }
    }
}

impl Aimed<'_, '_> {
    /// The same with so much of the scene's own lights.
    pub(crate) fn with_own(self, own: f32) -> Self {
        Self { own, ..self }
    }

    /// A direction drawn by `u` and `u_choice`, each in `[0, 1)`; `None` where nothing shines on the surface.
    pub(crate) fn sample(&self, u: DVec2, u_choice: f64) -> Option<Vec3> {
        let lights = &self.illumination.lights;
        let map_weight = self.map.as_ref().map_or(0.0, |(_, aim)| aim.total);
        let choice = u_choice * self.total;
        match &self.map {
            Some((map, aim)) if choice < map_weight || (lights.is_empty() && self.near.is_empty()) => {
                map.sample(aim, u)
            }
            _ => {
                let u_light = (choice - map_weight) / (self.total - map_weight);
                let distant = lights.iter().map(|light| light.weight(self.n));
                let weights = distant.chain(self.near.iter().map(|seen| seen.weight as f32));
                let (index, _) = choose_weighted(weights, u_light)?;
                Some(match lights.get(index) {
                    Some(light) => light.sample(u),
                    None => self.near.get(index - lights.len())?.sample(u),
                })
            }
        }
    }

    /// Radiance that arrives from a direction, and the density with which [`Aimed::sample`] draws it [1/sr]. `arrives` is asked,
    /// for each part that shines, what share of the light from that distance [m] reaches the surface.
    pub(crate) fn evaluate(&self, wi: Vec3, arrives: impl Fn(f32) -> f32) -> (Vec3, f64) {
        let mut distant = Vec3::ZERO;
        let mut density = 0.0;
        if let Some((map, aim)) = &self.map {
            distant = map.radiance(wi);
            density = aim.total * map.pdf(aim, wi, distant);
        }
        for (place, light) in self.illumination.lights.iter().enumerate() {
            if let Some(light_pdf) = light.pdf(wi) {
                let is_own = place >= self.illumination.of_environment;
                distant += light.radiance * if is_own { self.own } else { 1.0 };
                density += f64::from(light.weight(self.n)) * light_pdf;
            }
        }
        let mut radiance = Vec3::ZERO;
        if distant != Vec3::ZERO {
            radiance = distant * arrives(f32::INFINITY);
        }
        for seen in &self.near {
            if let Some((distance, light_pdf)) = seen.hit(wi) {
                density += seen.weight * light_pdf;
                radiance += self.own * seen.radiance * arrives(distance as f32);
            }
        }
        (radiance, if self.total > 0.0 { density / self.total } else { 0.0 })
    }
}

/// A [`DistantLight`] prepared for sampling.
struct AreaLight {
    source: DistantLight,
    radiance: Vec3,
    flux: f32,
    /// Sine of the angle from `direction` to the farthest point of the outline, a little more.
    sine: f32,
    direction: Vec3,
    tangent: Vec3,
    bitangent: Vec3,
    outline: Outline,
}

enum Outline {
    /// Cone, by `1 - cos` of its half angle.
    Disk { one_minus_cos: f64 },
    /// Convex quadrilateral on the plane that touches the sphere at `direction`, counter-clockwise in `(tangent, bitangent)`.
    Quadrilateral {
        corners: [DVec2; 4],
        area: f64,
        /// Share of the first of the triangles `012` and `023`.
        first: f64,
    },
}

impl AreaLight {
    /// `None` for a light that is black, has no extent, or reaches behind the plane of its own centre.
    fn new(light: &DistantLight) -> Option<Self> {
        let outline = match light.shape {
            LightShape::Disk { angular_radius } => {
                let half_sine = f64::from(0.5 * angular_radius).sin();
                Outline::Disk { one_minus_cos: 2.0 * half_sine * half_sine }
            }
            LightShape::Rectangle { corners } => {
                if corners.iter().any(|corner| corner.dot(light.direction) <= 0.0) {
                    return None;
                }
                let mut corners = corners.map(|corner| {
                    let depth = f64::from(corner.dot(light.direction));
                    DVec2::new(corner.dot(light.tangent).into(), corner.dot(light.bitangent).into()) / depth
                });
                let half = |a: DVec2, b: DVec2, c: DVec2| 0.5 * (b - a).perp_dot(c - a);
                if half(corners[0], corners[1], corners[2]) < 0.0 {
                    corners.reverse();
                }
                let [a, b, c, d] = corners;
                let area = half(a, b, c) + half(a, c, d);
                Outline::Quadrilateral { corners, area, first: half(a, b, c) / area }
            }
        };
        let flux = light.radiance.dot(IMPORTANCE) * light.solid_angle;
        let tangent = light.tan_half_extent().length();
        let extent = match outline {
            Outline::Disk { one_minus_cos } => one_minus_cos,
            Outline::Quadrilateral { area, .. } => area,
        };
        (flux > 0.0 && extent > 0.0).then_some(Self {
            source: light.clone(),
            radiance: light.radiance,
            flux,
            sine: tangent / (1.0 + tangent * tangent).sqrt() + 1e-3,
            direction: light.direction,
            tangent: light.tangent,
            bitangent: light.bitangent,
            outline,
        })
    }

    /// Flux times a bound of the cosine at a surface; 0 only where the whole light is under the horizon.
    fn weight(&self, n: Vec3) -> f32 {
        self.flux * (n.dot(self.direction) + self.sine).max(0.0)
    }

    /// A direction inside the outline.
    fn sample(&self, u: DVec2) -> Vec3 {
        let (x, y, z) = match self.outline {
            Outline::Disk { one_minus_cos } => {
                let h = u.x * one_minus_cos;
                let r = (h * (2.0 - h)).sqrt();
                let (sin_phi, cos_phi) = (std::f64::consts::TAU * u.y).sin_cos();
                (r * cos_phi, r * sin_phi, 1.0 - h)
            }
            Outline::Quadrilateral { corners: [a, b, c, d], first, .. } => {
                let (u_x, [b, c]) =
                    if u.x < first { (u.x / first, [b, c]) } else { ((u.x - first) / (1.0 - first), [c, d]) };
                // Uniform in a triangle: the square root spreads the points evenly away from `a`.
                let s = u_x.clamp(0.0, 1.0).sqrt();
                let p = a + s * ((b - a) + u.y * (c - b));
                (p.x, p.y, 1.0)
            }
        };
        let local = DVec3::new(x, y, z).normalize().as_vec3();
        (self.tangent * local.x + self.bitangent * local.y + self.direction * local.z).normalize()
    }

    /// Density of [`AreaLight::sample`] [1/sr]; `None` outside the outline.
    fn pdf(&self, wi: Vec3) -> Option<f64> {
        match self.outline {
            Outline::Disk { one_minus_cos } => {
                // The squared chord is 2 (1 - cos) and keeps its digits for a small disk.
                let inside = f64::from(wi.distance_squared(self.direction)) <= 2.0 * one_minus_cos;
                inside.then(|| 1.0 / (std::f64::consts::TAU * one_minus_cos))
            }
            Outline::Quadrilateral { corners, area, .. } => {
                let depth = f64::from(wi.dot(self.direction));
                if depth <= 0.0 {
                    return None;
                }
                let p = DVec2::new(wi.dot(self.tangent).into(), wi.dot(self.bitangent).into()) / depth;
                let inside =
                    (0..4).all(|i| (corners[(i + 1) % 4] - corners[i]).perp_dot(p - corners[i]) >= 0.0);
                // An area element of the plane subtends depth^3 of itself.
                inside.then(|| 1.0 / (area * depth * depth * depth))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::sampler::{Decision, Sequence};

    fn lights() -> Vec<DistantLight> {
        let frame = [DVec3::X, DVec3::Y, DVec3::NEG_Z];
        vec![
            DistantLight::disk(DVec3::new(1.0, 2.0, 0.5).normalize(), 0.3, DVec3::new(1.0, 2.0, 3.0)),
            DistantLight::disk(DVec3::new(1.0, 2.0, 0.7).normalize(), 0.2, DVec3::ONE),
            DistantLight::rectangle(frame, DVec2::new(-0.9, 0.2), DVec2::new(0.4, 0.8), DVec3::splat(4.0)),
        ]
    }

    /// The mean of radiance over pdf is the flux of all lights, overlaps included.
    #[test]
    fn samples_carry_the_whole_flux() {
        let lights = lights();
        let expected: DVec3 = lights.iter().map(DistantLight::flux).sum();
        let illumination = Illumination::new(None, &lights);
        // Every light is above this surface.
        let aimed = illumination.aim(Vec3::ZERO, Vec3::new(0.3, 0.8, -0.5).normalize());
        let sequence = Sequence::new(1, 2, 3);
        let count = 1 << 14;
        let mut sum = DVec3::ZERO;
        for index in 0..count {
            let u = sequence.pair(index, Decision::Direction);
            let choice = sequence.pair(index, Decision::Choice).x;
            let (radiance, pdf) = aimed.evaluate(aimed.sample(u, choice).unwrap(), |_| 1.0);
            if pdf > 0.0 {
                sum += radiance.as_dvec3() / pdf;
            }
        }
        let flux = sum / f64::from(count);
        assert!((flux / expected - 1.0).abs().max_element() < 5e-3, "{flux} against {expected}");
    }

    #[test]
    fn outlines_agree_with_the_lights_own() {
        let lights = lights();
        let sequence = Sequence::new(4, 0, 0);
        for light in &lights {
            let area = AreaLight::new(light).unwrap();
            for index in 0..2000 {
                let u = sequence.pair(index, Decision::Direction);
                let d = gnomon_envmap::Equirect::direction_from_uv(u.as_vec2());
                assert_eq!(area.pdf(d).is_some(), light.contains(d), "{light:?} {d}");
                assert!(area.pdf(area.sample(0.001 + 0.998 * u)).is_some(), "{light:?} {u}");
            }
        }
    }

    #[test]
    fn darkness_has_no_samples() {
        let nothing = Illumination::new(None, &[]);
        let dark = nothing.aim(Vec3::ZERO, Vec3::Y);
        assert!(dark.sample(DVec2::splat(0.3), 0.2).is_none());
        assert_eq!(dark.evaluate(Vec3::X, |_| 1.0), (Vec3::ZERO, 0.0));
    }
}
