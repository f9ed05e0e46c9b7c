//! Area lights in the scene: exact rays to them, and directions drawn inside them.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3, Vec3};
use gnomon_scene::{AreaLightShape, FLAT_CLEARANCE, PlacedLight};

use crate::environment::IMPORTANCE;
use crate::spherical_rectangle::SphericalRectangle;

/// A [`PlacedLight`] prepared for sampling.
pub(crate) struct NearLight {
    placed: PlacedLight,
    /// Mean of the radiance's channels.
    brightness: f64,
    shape: AreaLightShape,
    center: DVec3,
    normal: DVec3,
    tangent: DVec3,
    bitangent: DVec3,
}

/// A light as one point sees it.
pub(crate) struct Seen<'l> {
    light: &'l NearLight,
    /// That it has towards the point.
    pub(crate) radiance: Vec3,
    /// An estimate of the irradiance, positive wherever there is any: what the choice among lights goes by.
    pub(crate) weight: f64,
    origin: DVec3,
    sampling: Sampling,
}

/// How directions to a light are drawn.
enum Sampling {
    /// Uniform in the sphere's cone, given by `1 - cos` of its half angle.
    Cone { axis: DVec3, one_minus_cos: f64 },
    /// Uniform in solid angle.
    Rectangle(SphericalRectangle),
    /// Uniform over a flat light's area [m^2].
    Area(f64),
}

/// Below this solid angle [sr] a rectangle is as good as flat, and the excess of its angles loses digits.
const SMALL: f64 = 1e-6;

impl NearLight {
    pub(crate) fn new(light: &PlacedLight) -> Self {
        Self {
            placed: *light,
            brightness: f64::from(light.radiance.dot(IMPORTANCE)),
            shape: light.shape,
            center: light.center.into(),
            normal: light.normal.into(),
            tangent: light.tangent.into(),
            bitangent: light.bitangent.into(),
        }
    }

    /// The light from `origin`, for a surface there with the unit normal `n`; `None` where none of it can arrive.
    pub(crate) fn seen_from(&self, origin: Vec3, n: Vec3) -> Option<Seen<'_>> {
        let share = self.placed.share_towards(origin);
        let (origin, n) = (DVec3::from(origin), DVec3::from(n));
        let to_center = self.center - origin;
        let distance = to_center.length();
        let height = -to_center.dot(self.normal);
        let half = self.shape.half_extent().as_dvec2();
        let (sampling, solid_angle, reach) = match self.shape {
            AreaLightShape::Sphere { .. } => {
                let sine = half.x / distance;
                if sine >= 1.0 || distance == 0.0 {
                    return None;
                }
                let one_minus_cos = sine * sine / (1.0 + (1.0 - sine * sine).sqrt());
                (Sampling::Cone { axis: to_center / distance, one_minus_cos }, TAU * one_minus_cos, half.x)
            }
            _ if height <= f64::from(FLAT_CLEARANCE) * half.min_element() => return None,
            AreaLightShape::Rectangle { .. } => {
                let rectangle = self.rectangle(origin);
                let solid_angle = rectangle.solid_angle();
                let area = 4.0 * half.x * half.y;
                let flat = area * height / distance.powi(3);
                let sampling = match solid_angle > SMALL {
                    true => Sampling::Rectangle(rectangle),
                    false => Sampling::Area(area),
                };
                (sampling, solid_angle.max(flat), half.length())
            }
            AreaLightShape::Disk { .. } | AreaLightShape::Sun { .. } => {
                let area = PI * half.x * half.x;
                let aside = (distance * distance - height * height).max(0.0).sqrt() - half.x;
                if height.hypot(aside.max(0.0)) > half.x {
                    (Sampling::Area(area), area * height / distance.powi(3), half.x)
                } else {
                    // So close by, points of equal area differ too much in what they give; the square around the disk does not.
                    let rectangle = self.rectangle(origin);
                    let solid_angle = rectangle.solid_angle();
                    (Sampling::Rectangle(rectangle), solid_angle, half.x)
                }
            }
        };
        // The cosine towards the centre plus the sine of the angle to the farthest point bounds every cosine.
        let cosine = n.dot(to_center) / distance + (reach / distance).min(1.0) + 1e-6;
        let weight = self.brightness * f64::from(share) * solid_angle * cosine;
        let radiance = share * self.placed.radiance;
        (weight > 0.0 && weight.is_finite()).then_some(Seen {
            light: self,
            radiance,
            weight,
            origin,
            sampling,
        })
    }

    /// A rectangle, or the square around a disk, from `origin`.
    fn rectangle(&self, origin: DVec3) -> SphericalRectangle {
        let half = self.shape.half_extent().as_dvec2();
        let corner = self.center - self.tangent * half.x - self.bitangent * half.y;
        SphericalRectangle::new(corner - origin, 2.0 * half, [self.tangent, self.bitangent])
    }
}

impl Seen<'_> {
    /// A direction towards the light's front, or a little past the rim of a disk close by.
    pub(crate) fn sample(&self, u: DVec2) -> Vec3 {
        let light = self.light;
        let to = match &self.sampling {
            &Sampling::Cone { axis, one_minus_cos } => {
                let h = u.x * one_minus_cos;
                let r = (h * (2.0 - h)).sqrt();
                let (sin_phi, cos_phi) = (TAU * u.y).sin_cos();
                let (x, y) = axis.any_orthonormal_pair();
                x * (r * cos_phi) + y * (r * sin_phi) + axis * (1.0 - h)
            }
            Sampling::Rectangle(rectangle) => rectangle.sample(u),
            Sampling::Area(_) => {
                let half = light.shape.half_extent().as_dvec2();
                let place = match light.shape {
                    AreaLightShape::Disk { .. } => half.x * concentric(u),
                    _ => half * (2.0 * u - 1.0),
                };
                light.center + light.tangent * place.x + light.bitangent * place.y - self.origin
            }
        };
        to.normalize().as_vec3()
    }

    /// Where a ray from the origin meets the light's front: its distance [m], and the density of [`Seen::sample`] there [1/sr].
    pub(crate) fn hit(&self, wi: Vec3) -> Option<(f64, f64)> {
        let (light, wi) = (self.light, DVec3::from(wi));
        let to_center = light.center - self.origin;
        if let Sampling::Cone { one_minus_cos, .. } = self.sampling {
            let along = to_center.dot(wi);
            let radius = light.shape.half_extent().x;
            // By the cross product, which keeps its digits for a small sphere far away.
            let half_chord2 = f64::from(radius * radius) - to_center.cross(wi).length_squared();
            let hit = along > 0.0 && half_chord2 >= 0.0;
            return hit.then(|| (along - half_chord2.sqrt(), 1.0 / (TAU * one_minus_cos)));
        }
        let cosine = -wi.dot(light.normal);
        if cosine <= 0.0 {
            return None;
        }
        let distance = -to_center.dot(light.normal) / cosine;
        let place = wi * distance - to_center;
        let place = DVec2::new(place.dot(light.tangent), place.dot(light.bitangent));
        let half = light.shape.half_extent().as_dvec2();
        let inside = match light.shape {
            AreaLightShape::Disk { .. } => place.length_squared() <= half.x * half.x,
            _ => place.abs().cmple(half).all(),
        };
        inside.then(|| {
            let density = match &self.sampling {
                Sampling::Rectangle(rectangle) => 1.0 / rectangle.solid_angle(),
                Sampling::Area(area) => distance * distance / (area * cosine),
                Sampling::Cone { one_minus_cos, .. } => 1.0 / (TAU * one_minus_cos),
            };
            (distance, density)
        })
    }
}

/// The unit square onto the unit disk, areas in proportion, neighbours staying neighbours (Shirley and Chiu 1997).
fn concentric(u: DVec2) -> DVec2 {
    let p = 2.0 * u - 1.0;
    if p == DVec2::ZERO {
        return p;
    }
    let (r, phi) = match p.x.abs() > p.y.abs() {
        true => (p.x, PI / 4.0 * (p.y / p.x)),
        false => (p.y, PI / 2.0 - PI / 4.0 * (p.x / p.y)),
    };
    r * DVec2::from_angle(phi)
}

#[cfg(test)]
mod tests {
    use glam::Vec2;

    use super::*;
    use crate::sampler::{Decision, Sequence};

    fn light(shape: AreaLightShape) -> NearLight {
        let normal = Vec3::new(0.2, -1.0, 0.3).normalize();
        let tangent = normal.cross(Vec3::Z).normalize();
        NearLight::new(&PlacedLight {
            shape,
            center: Vec3::new(0.3, 2.0, -0.4),
            normal,
            tangent,
            bitangent: tangent.cross(normal),
            radiance: Vec3::ONE,
            spread: Default::default(),
        })
    }

    const SHAPES: [AreaLightShape; 4] = [
        AreaLightShape::Disk { radius: 0.7 },
        AreaLightShape::Rectangle { size: Vec2::new(1.5, 0.6) },
        AreaLightShape::Rectangle { size: Vec2::new(0.001, 0.0006) },
        AreaLightShape::Sphere { radius: 0.5 },
    ];

    /// The mean of cosine over density is the irradiance: sampling and density belong together, and so do sample and hit.
    #[test]
    fn samples_hit_and_agree_with_a_sum_over_directions() {
        let sequence = Sequence::new(8, 1, 0);
        for shape in SHAPES {
            for origin in [Vec3::ZERO, Vec3::new(0.5, 1.4, -0.2), Vec3::new(-1.5, 0.6, 0.8)] {
                let light = light(shape);
                let n = Vec3::new(0.1, 1.0, 0.2).normalize();
                let seen = light.seen_from(origin, n).unwrap();
                let (count, mut sum, mut hits) = (1 << 13, 0.0, 0);
                for index in 0..count {
                    let wi = seen.sample(sequence.pair(index, Decision::Direction));
                    if let Some((_, density)) = seen.hit(wi) {
                        sum += f64::from(n.dot(wi).max(0.0)) / density;
                        hits += 1;
                    }
                }
                // A direction is rounded to 6e-8: of the smallest light, 6e-4 m across, that much may fall off its edge. A
                // disk close by is drawn from the square around it.
                let least = if matches!(shape, AreaLightShape::Disk { .. }) { 0.75 } else { 0.99 };
                assert!(f64::from(hits) > least * f64::from(count), "{shape:?} {origin}: {hits} of {count}");
                if shape.area() < 1e-3 {
                    continue;
                }
                let (columns, rows, mut expected) = (900, 450, 0.0);
                for row in 0..rows {
                    let y = 1.0 - 2.0 * (f64::from(row) + 0.5) / f64::from(rows);
                    for column in 0..columns {
                        let (sin, cos) = (TAU * (f64::from(column) + 0.5) / f64::from(columns)).sin_cos();
                        let ring = (1.0 - y * y).sqrt();
                        let wi = DVec3::new(ring * cos, y, ring * sin).as_vec3();
                        if seen.hit(wi).is_some() {
                            expected += f64::from(n.dot(wi).max(0.0));
                        }
                    }
                }
                expected *= 4.0 * PI / f64::from(columns * rows);
                let found = sum / f64::from(count);
                // Edge cells of the sum: 1e-2 of the small solid angles seen from afar.
                assert!((found / expected - 1.0).abs() < 1e-2, "{shape:?} {origin}: {found} {expected}");
            }
        }
    }

    #[test]
    fn nothing_arrives_behind_a_flat_light_inside_a_sphere_or_under_the_horizon() {
        let disk = light(SHAPES[0]);
        assert!(disk.seen_from(Vec3::new(0.3, 4.0, -0.4), Vec3::NEG_Y).is_none());
        assert!(disk.seen_from(Vec3::new(0.3, 2.0, -0.4), Vec3::NEG_Y).is_none(), "in its plane");
        let sphere = light(SHAPES[3]);
        assert!(sphere.seen_from(Vec3::new(0.3, 2.1, -0.4), Vec3::Y).is_none());
        assert!(sphere.seen_from(Vec3::ZERO, Vec3::NEG_Y).is_none());
        assert!(sphere.seen_from(Vec3::ZERO, Vec3::Y).is_some());
    }

    #[test]
    fn rays_meet_the_near_side() {
        let sphere = light(SHAPES[3]);
        let seen = sphere.seen_from(Vec3::new(0.3, 0.0, -0.4), Vec3::Y).unwrap();
        let (distance, _) = seen.hit(Vec3::Y).unwrap();
        assert!((distance - 1.5).abs() < 1e-6);
        assert!(seen.hit(Vec3::NEG_Y).is_none());
    }
}
