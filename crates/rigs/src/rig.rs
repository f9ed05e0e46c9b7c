//! What targets write, in units that none of them owns.

use glam::{DVec3, Vec2, Vec3};
use gnomon_envmap::Equirect;
use gnomon_lights::{DistantLight, LightSet, LightShape};

/// Lights, and the files of their maps.
#[derive(Clone, Debug)]
pub struct Rig<'a> {
    /// What it is of, a line each, for a comment.
    pub about: Vec<String>,
    /// Lights and residual.
    pub set: &'a LightSet,
    /// The whole map.
    pub map: &'a Equirect,
    /// File of the residual, beside the rig; none where it is black.
    pub residual: Option<String>,
    /// File of the whole map, where mirrors or the camera show it instead of lights and residual.
    pub whole: Option<String>,
}

/// A light as one without size: what [`gnomon_lights::DistantLight::vector_irradiance`] says of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sun {
    /// Unit direction towards it.
    pub towards: DVec3,
    /// Irradiance of a surface that faces it, linear Rec. 709.
    pub irradiance: DVec3,
    /// Angle across the disk of the same solid angle [rad].
    pub diameter: f64,
}

impl Sun {
    /// Of a light.
    pub fn of(light: &DistantLight) -> Self {
        let vector = light.vector_irradiance().as_dvec3();
        let solid_angle = f64::from(light.solid_angle);
        Self {
            towards: vector.normalize_or(light.direction.as_dvec3()),
            irradiance: light.radiance.as_dvec3() * vector.length(),
            // From `solid angle = 4 pi sin^2(diameter / 4)`.
            diameter: 4.0 * (solid_angle / (4.0 * std::f64::consts::PI)).sqrt().min(1.0).asin(),
        }
    }

    /// The irradiance as a colour whose largest channel is 1, and its factor.
    pub fn color_and_intensity(&self) -> (DVec3, f64) {
        split(self.irradiance)
    }
}

/// A colour whose largest channel is 1, and the factor that brings the value back; black for black.
pub(crate) fn split(value: DVec3) -> (DVec3, f64) {
    let intensity = value.max_element();
    if intensity > 0.0 { (value / intensity, intensity) } else { (DVec3::ZERO, 0.0) }
}

/// A light as a flat one far away, across its direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FarShape {
    /// Unit direction towards it.
    pub towards: Vec3,
    /// Unit axis of its width.
    pub across: Vec3,
    /// Unit axis of its height: `towards x across`.
    pub along: Vec3,
    /// Outline at distance 1.
    pub outline: Outline,
    /// Radiance, linear Rec. 709.
    pub radiance: Vec3,
    /// Whether outline and radiance are the light's own. Else it is the rectangle around its middle of the same shape along both axes, with
    /// the light's irradiance.
    pub is_exact: bool,
}

/// Outline of a [`FarShape`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outline {
    /// A disk's radius.
    Disk(f32),
    /// Half a rectangle's width and height.
    Rectangle(Vec2),
}

/// How far corners may lie from those of a rectangle, as a share of its sides.
const RECTANGULAR: f32 = 1e-3;

impl FarShape {
    /// Of a light.
    pub fn of(light: &DistantLight) -> Self {
        let shape = Self {
            towards: light.direction,
            across: light.tangent,
            along: light.bitangent,
            outline: Outline::Rectangle(Vec2::ZERO),
            radiance: light.radiance,
            is_exact: true,
        };
        match (light.shape, light.plane_corners()) {
            (LightShape::Disk { angular_radius }, _) => {
                Self { outline: Outline::Disk(angular_radius.tan()), ..shape }
            }
            (_, corners) => {
                let corners = corners.unwrap_or_default();
                let half = light.tan_half_extent();
                let is_exact = corners
                    .iter()
                    .all(|corner| ((corner.abs() - half) / half).abs().max_element() < RECTANGULAR);
                match is_exact {
                    true => Self { outline: Outline::Rectangle(half), ..shape },
                    false => shape.like(light, corners, half),
                }
            }
        }
    }

    /// A rectangle of the quadrilateral's own area, with the light's irradiance.
    fn like(self, light: &DistantLight, corners: [Vec2; 4], half: Vec2) -> Self {
        let area = |a: Vec2, b: Vec2, c: Vec2| 0.5 * (b - a).perp_dot(c - a).abs();
        let [a, b, c, d] = corners;
        let share = (area(a, b, c) + area(a, c, d)) / (4.0 * half.x * half.y);
        let half = half * share.sqrt();
        let corners = [-half, Vec2::new(half.x, -half.y), half, Vec2::new(-half.x, half.y)];
        let stands_in = DistantLight::quadrilateral(self.towards, self.across, corners, Vec3::ONE);
        let ratio = stands_in.map_or(1.0, |it| {
            light.irradiance(self.towards) / it.irradiance(self.towards).max(f32::MIN_POSITIVE)
        });
        Self { outline: Outline::Rectangle(half), radiance: self.radiance * ratio, is_exact: false, ..self }
    }
}

/// A place or direction of Gnomon's y-up world in a z-up one, as importers of glTF turn scenes: `(x, -z, y)`.
pub(crate) fn z_up(v: DVec3) -> DVec3 {
    DVec3::new(v.x, -v.z, v.y)
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;

    const FRONT: [DVec3; 3] = [DVec3::X, DVec3::Y, DVec3::NEG_Z];

    #[test]
    fn a_sun_lights_a_plane_as_its_disk_does() {
        let radius = 0.2_f64;
        let disk = DistantLight::disk(DVec3::Y, radius, DVec3::ONE);
        let sun = Sun::of(&disk);
        let radiance = 1.0 / (2.0 * std::f64::consts::PI * (1.0 - radius.cos()));
        let expected = std::f64::consts::PI * radius.sin().powi(2) * radiance;
        assert!((sun.irradiance.x / expected - 1.0).abs() < 1e-6, "{} {expected}", sun.irradiance);
        assert!((sun.diameter - 2.0 * radius).abs() < 1e-6 && (sun.towards - DVec3::Y).length() < 1e-6);
        let (color, intensity) = Sun { irradiance: DVec3::new(2.0, 4.0, 1.0), ..sun }.color_and_intensity();
        assert_eq!((color, intensity), (DVec3::new(0.5, 1.0, 0.25), 4.0));
    }

    #[test]
    fn a_far_shape_lights_a_plane_as_the_light_does() {
        let corners = (DVec2::new(-0.4, -0.1), DVec2::new(0.4, 0.1));
        let rectangle = DistantLight::rectangle(FRONT, corners.0, corners.1, DVec3::ONE);
        let shape = FarShape::of(&rectangle);
        let Outline::Rectangle(half) = shape.outline else { panic!("{shape:?}") };
        assert!(shape.is_exact && (half - Vec2::new(0.4, 0.1)).length() < 1e-6);
        // Seen from the side it is none.
        let slanted = DistantLight::rectangle(FRONT, DVec2::new(0.1, 0.5), DVec2::new(0.5, 0.9), DVec3::ONE);
        let shape = FarShape::of(&slanted);
        let Outline::Rectangle(half) = shape.outline else { panic!("{shape:?}") };
        let corners = [-half, Vec2::new(half.x, -half.y), half, Vec2::new(-half.x, half.y)];
        let drawn =
            DistantLight::quadrilateral(shape.towards, shape.across, corners, shape.radiance).unwrap();
        let irradiance = |light: &DistantLight| light.radiance * light.irradiance(slanted.direction);
        assert!(!shape.is_exact);
        assert!((irradiance(&drawn) / irradiance(&slanted) - 1.0).abs().max_element() < 1e-5);
    }
}
