//! `[[light]]` of a scene file.

use std::f32::consts::PI;

use glam::{Affine3A, DVec3, Mat3, Vec2, Vec3};
use gnomon_messages::quoted;
use gnomon_scene::{AreaLight, AreaLightShape, Node, NodeId, Scene, Spread};
use serde::Deserialize;

use crate::ies::IesFile;

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Shape {
    Disk,
    Square,
    Rectangle,
    Sphere,
    Spot,
    Sun,
}

/// Side of a square, or width and height.
#[derive(Clone, Copy, Deserialize)]
#[serde(untagged, expecting = "size is one number or two")]
enum Size {
    Side(f32),
    Sides([f32; 2]),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LightEntry {
    shape: Shape,
    name: Option<String>,
    node: Option<String>,
    #[serde(default)]
    position: [f64; 3],
    target: Option<[f64; 3]>,
    direction: Option<[f32; 3]>,
    roll: Option<f32>,
    radius: Option<f32>,
    size: Option<Size>,
    /// Of a spot: between the axis and the rims of what is lit as much as the axis, and of what is lit at all [degrees].
    cone: Option<[f32; 2]>,
    /// Of a spot, in place of the cone: an LM-63 file.
    profile: Option<String>,
    /// Of a sun: its angular diameter [degrees].
    angle: Option<f32>,
    radiance: Option<[f32; 3]>,
    power: Option<[f32; 3]>,
    /// Of a sphere or spot, towards its front.
    intensity: Option<[f32; 3]>,
    /// Of a sun, on a surface that faces it.
    irradiance: Option<[f32; 3]>,
}

/// Smallest and largest length of an outline [m]: squares of both are far from the ends of `f32`.
const LENGTHS: std::ops::RangeInclusive<f32> = 1e-6..=1e6;

/// Largest radiance: sums over many lights stay finite.
const MOST_RADIANCE: f32 = 1e30;

/// Angular diameters of suns, and that of the Earth's [degrees].
const SUN_ANGLES: std::ops::RangeInclusive<f32> = 0.01..=170.0;
const SUN_ANGLE: f32 = 0.53;

impl LightEntry {
    /// Adds the light and a node that places it, which it returns with its translation, or says what is wrong.
    /// `profile` is what the file of [`LightEntry::profile_file`] says.
    pub fn add_to(&self, scene: &mut Scene, profile: Option<&IesFile>) -> Result<(NodeId, DVec3), String> {
        let shape = self.outline()?;
        let spread = self.spread(profile)?;
        let radiance = self.radiance(&shape, profile)?;
        let parent = self.node.as_deref().map(|name| node_called(scene, name)).transpose()?;
        let position = DVec3::from_array(self.position);
        if !position.as_vec3().is_finite() {
            return Err("position must be finite".to_owned());
        }
        scene.nodes.push(Node {
            name: self.name.as_deref().map_or_else(|| "light".to_owned(), quoted),
            parent,
            parent_from_node: Affine3A::from_mat3(self.orientation(position)?),
            ..Node::default()
        });
        let node = NodeId(scene.nodes.len() - 1);
        scene.place(node, position);
        scene.lights.push(AreaLight { node, shape, radiance, spread });
        Ok((node, position))
    }

    fn outline(&self) -> Result<AreaLightShape, String> {
        let check = |what: &str, lengths: &[f32]| match lengths.iter().all(|length| LENGTHS.contains(length))
        {
            true => Ok(()),
            false => Err(format!("{what} must be {} to {} m", LENGTHS.start(), LENGTHS.end())),
        };
        let round = |kind: &str| match (self.radius, self.size) {
            (Some(radius), None) => check("radius", &[radius]).map(|()| radius),
            _ => Err(format!("a {kind} has 'radius' and no 'size'")),
        };
        if self.angle.is_some() && !matches!(self.shape, Shape::Sun) {
            return Err("only a sun has an 'angle'".to_owned());
        }
        match (self.shape, self.radius, self.size) {
            (Shape::Sun, None, None) => match self.angle.unwrap_or(SUN_ANGLE) {
                angle if SUN_ANGLES.contains(&angle) => {
                    Ok(AreaLightShape::Sun { angular_radius: 0.5 * angle.to_radians() })
                }
                _ => Err(format!("angle must be {} to {} degrees", SUN_ANGLES.start(), SUN_ANGLES.end())),
            },
            (Shape::Sun, ..) => Err("a sun has 'angle' and no 'radius' or 'size'".to_owned()),
            (Shape::Spot, ..) => Ok(AreaLightShape::Sphere { radius: round("spot")? }),
            (Shape::Disk, ..) => Ok(AreaLightShape::Disk { radius: round("disk")? }),
            (Shape::Sphere, ..) => Ok(AreaLightShape::Sphere { radius: round("sphere")? }),
            (Shape::Square, None, Some(Size::Side(side))) => {
                check("size", &[side])?;
                Ok(AreaLightShape::Rectangle { size: Vec2::splat(side) })
            }
            (Shape::Rectangle, None, Some(Size::Sides(sides))) => {
                check("size", &sides)?;
                Ok(AreaLightShape::Rectangle { size: Vec2::from_array(sides) })
            }
            (Shape::Square, ..) => Err("a square has 'size', one number, and no 'radius'".to_owned()),
            (Shape::Rectangle, ..) => Err("a rectangle has 'size', two numbers, and no 'radius'".to_owned()),
        }
    }

    /// The photometric file that it names.
    pub fn profile_file(&self) -> Option<&str> {
        self.profile.as_deref()
    }

    fn spread(&self, profile: Option<&IesFile>) -> Result<Spread, String> {
        if let Some(file) = profile {
            return match (self.shape, self.cone) {
                (Shape::Spot, None) => Ok(Spread::Profile(file.profile)),
                (Shape::Spot, Some(_)) => Err("a spot has either 'cone' or 'profile'".to_owned()),
                _ => Err("only a spot has a 'profile'".to_owned()),
            };
        }
        match (self.shape, self.cone) {
            (Shape::Spot, Some([inner, outer])) if 0.0 <= inner && inner < outer && outer <= 90.0 => {
                Ok(Spread::Cone { inner: inner.to_radians(), outer: outer.to_radians() })
            }
            (Shape::Spot, Some(_)) => {
                Err("cone must be two angles from 0 to 90 degrees, the first smaller".to_owned())
            }
            (Shape::Spot, None) => Err("a spot needs a 'cone' or a 'profile'".to_owned()),
            (_, Some(_)) => Err("only a spot has a 'cone'".to_owned()),
            (_, None) => Ok(Spread::Even),
        }
    }

    fn radiance(&self, shape: &AreaLightShape, profile: Option<&IesFile>) -> Result<Vec3, String> {
        let divided = |given: [f32; 3], by: f32| Vec3::from_array(given) / by;
        let (what, given, radiance) = match (self.radiance, self.power, self.intensity, self.irradiance) {
            (Some(radiance), None, None, None) => ("radiance", radiance, Vec3::from_array(radiance)),
            (None, Some(power), None, None) if !matches!(self.shape, Shape::Sun | Shape::Spot) => {
                ("power", power, divided(power, PI * shape.area()))
            }
            (None, None, Some(intensity), None) if matches!(shape, AreaLightShape::Sphere { .. }) => {
                ("intensity", intensity, divided(intensity, shape.facing_irradiance()))
            }
            (None, None, None, Some(irradiance)) if matches!(self.shape, Shape::Sun) => {
                ("irradiance", irradiance, divided(irradiance, shape.facing_irradiance()))
            }
            (None, None, None, None) if profile.is_some() => {
                let intensity = [profile.map_or(0.0, |file| file.most); 3];
                ("intensity", intensity, divided(intensity, shape.facing_irradiance()))
            }
            _ => {
                return Err(match self.shape {
                    Shape::Sun => "a sun has either 'radiance' or 'irradiance'",
                    Shape::Spot => "a spot has either 'radiance' or 'intensity'",
                    Shape::Sphere => "a sphere has either 'radiance' or 'power' or 'intensity'",
                    _ => "a light has either 'radiance' or 'power'",
                }
                .to_owned());
            }
        };
        if !given.iter().all(|value| (0.0..f32::INFINITY).contains(value)) {
            return Err(format!("{what} must be three finite numbers of at least 0"));
        }
        if radiance.max_element() > MOST_RADIANCE {
            return Err(format!("{what} gives a radiance above {MOST_RADIANCE:e}"));
        }
        Ok(radiance)
    }

    /// Axes of the node: like a camera, the light looks along its -z, with +y (or +z where it looks along y) upwards.
    fn orientation(&self, position: DVec3) -> Result<Mat3, String> {
        let towards = match (self.shape, self.target, self.direction) {
            (Shape::Sphere, None, None) if self.roll.is_none() => return Ok(Mat3::IDENTITY),
            (Shape::Sphere, ..) => return Err("a sphere has no 'target', 'direction' or 'roll'".to_owned()),
            (_, Some(target), None) => (DVec3::from_array(target) - position).as_vec3(),
            (_, None, Some(direction)) => Vec3::from_array(direction),
            _ => {
                return Err("a flat light, a spot or a sun has either 'target' or 'direction'".to_owned());
            }
        };
        // In two steps: the square of a long vector overflows.
        let scale = towards.abs().max_element();
        let Some(back) = (-towards / scale).try_normalize().filter(|_| scale.is_finite()) else {
            return Err("'target' or 'direction' gives no direction".to_owned());
        };
        let roll = self.roll.unwrap_or(0.0).to_radians();
        if !roll.is_finite() {
            return Err("roll must be finite".to_owned());
        }
        let up = if back.y.abs() > 0.9999 { Vec3::Z } else { Vec3::Y };
        let right = up.cross(back).normalize();
        Ok(Mat3::from_cols(right, back.cross(right), back) * Mat3::from_rotation_z(-roll))
    }
}

/// The only node of that name.
fn node_called(scene: &Scene, name: &str) -> Result<NodeId, String> {
    let mut found = (0..scene.nodes.len()).filter(|&node| scene.nodes[node].name == name);
    match (found.next(), found.next()) {
        (Some(node), None) => Ok(NodeId(node)),
        (None, _) => Err(format!("there is no node '{}'", quoted(name))),
        (Some(_), Some(_)) => Err(format!("several nodes are called '{}'", quoted(name))),
    }
}
