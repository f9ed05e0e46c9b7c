use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use thiserror::Error;

use crate::{DistantLight, LightSet, LightShape};

/// The JSON form of a [`LightSet`], without the residual's texels. Directions are unit vectors in world axes, angles
/// radians, solid angles steradians, radiance and flux linear Rec. 709.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LightDocument {
    /// Name of the fit.
    pub method: String,
    /// The fit's settings.
    pub parameters: Map<String, Value>,
    /// Flux of lights and residual together.
    pub total_flux: [f64; 3],
    /// Flux of the lights.
    pub lights_flux: [f64; 3],
    /// Flux of the residual.
    pub residual_flux: [f64; 3],
    /// Every light, in the order found.
    pub lights: Vec<LightEntry>,
}

/// One light of a [`LightDocument`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LightEntry {
    /// Towards the light's centre.
    pub direction: [f32; 3],
    /// First axis of the light's plane.
    pub tangent: [f32; 3],
    /// Outline.
    pub shape: ShapeEntry,
    /// Full angular width and height along tangent and bitangent [rad].
    pub extent: [f32; 2],
    /// Exact solid angle of the outline [sr].
    pub solid_angle: f32,
    /// Radiance.
    pub radiance: [f32; 3],
    /// Radiance times solid angle.
    pub flux: [f64; 3],
}

/// Outline of a [`LightEntry`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum ShapeEntry {
    /// All directions within a half angle of the centre.
    Disk {
        /// Half the apex angle [rad].
        angular_radius: f32,
    },
    /// A quadrilateral on the sphere.
    Rectangle {
        /// Unit directions, counter-clockwise seen from the scene.
        corners: [[f32; 3]; 4],
    },
}

/// Why text is no light document.
#[derive(Debug, Error)]
pub enum DocumentError {
    /// The text is not JSON of this form.
    #[error("not a light document: {0}")]
    Json(#[from] serde_json::Error),
    /// A light with impossible numbers.
    #[error("light {index} of the document has an invalid {field}")]
    Light {
        /// Which light, from 0.
        index: usize,
        /// Which of its fields.
        field: &'static str,
    },
}

impl LightSet {
    /// The set as a serialisable document.
    pub fn document(&self) -> LightDocument {
        LightDocument {
            method: self.method.to_owned(),
            parameters: self.parameters.clone(),
            total_flux: self.total_flux().to_array(),
            lights_flux: self.lights_flux().to_array(),
            residual_flux: self.residual_flux().to_array(),
            lights: self.lights.iter().map(LightEntry::from).collect(),
        }
    }

    /// The set as indented JSON: method, parameters, every light, and the flux of lights, residual and both.
    pub fn to_json(&self) -> String {
        // `json!`-made values and finite numbers always serialise; `{:#}` cannot fail.
        let document = serde_json::to_value(self.document()).unwrap_or(Value::Null);
        format!("{document:#}\n")
    }
}

impl LightDocument {
    /// Reads a document back, checking every light.
    pub fn from_json(text: &str) -> Result<Self, DocumentError> {
        let document: Self = serde_json::from_str(text)?;
        for (index, light) in document.lights.iter().enumerate() {
            light.check().map_err(|field| DocumentError::Light { index, field })?;
        }
        Ok(document)
    }
}

impl From<&DistantLight> for LightEntry {
    fn from(light: &DistantLight) -> Self {
        Self {
            direction: light.direction.to_array(),
            tangent: light.tangent.to_array(),
            shape: match light.shape {
                LightShape::Disk { angular_radius } => ShapeEntry::Disk { angular_radius },
                LightShape::Rectangle { corners } => {
                    ShapeEntry::Rectangle { corners: corners.map(|corner| corner.to_array()) }
                }
            },
            extent: light.extent().to_array(),
            solid_angle: light.solid_angle,
            radiance: light.radiance.to_array(),
            flux: light.flux().to_array(),
        }
    }
}

impl LightEntry {
    /// The light described.
    pub fn light(&self) -> DistantLight {
        let (direction, tangent) = (Vec3::from(self.direction), Vec3::from(self.tangent));
        DistantLight {
            direction,
            tangent,
            bitangent: direction.cross(tangent),
            shape: match self.shape {
                ShapeEntry::Disk { angular_radius } => LightShape::Disk { angular_radius },
                ShapeEntry::Rectangle { corners } => {
                    LightShape::Rectangle { corners: corners.map(Vec3::from) }
                }
            },
            solid_angle: self.solid_angle,
            radiance: Vec3::from(self.radiance),
        }
    }

    /// The first field that no light can have.
    fn check(&self) -> Result<(), &'static str> {
        let unit = |v: [f32; 3]| (Vec3::from(v).length() - 1.0).abs() < 1e-3;
        let shape = match self.shape {
            ShapeEntry::Disk { angular_radius } => {
                angular_radius > 0.0 && angular_radius < std::f32::consts::FRAC_PI_2
            }
            ShapeEntry::Rectangle { corners } => corners.into_iter().all(unit),
        };
        let radiance = Vec3::from(self.radiance);
        let flux = DVec3::from(self.flux);
        [
            ("direction", unit(self.direction)),
            (
                "tangent",
                unit(self.tangent) && Vec3::from(self.tangent).dot(self.direction.into()).abs() < 1e-3,
            ),
            ("shape", shape),
            (
                "solid_angle",
                self.solid_angle > 0.0 && f64::from(self.solid_angle) < 4.0 * std::f64::consts::PI,
            ),
            ("radiance", radiance.is_finite() && radiance.min_element() >= 0.0),
            ("flux", flux.is_finite() && flux.min_element() >= 0.0),
        ]
        .into_iter()
        .find(|(_, valid)| !valid)
        .map_or(Ok(()), |(field, _)| Err(field))
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec2;
    use gnomon_envmap::Equirect;
    use gnomon_picture::RgbImage;

    use super::*;

    fn set() -> LightSet {
        let frame = [DVec3::X, DVec3::Y, DVec3::NEG_Z];
        let lights = vec![
            DistantLight::disk(DVec3::new(0.6, 0.8, 0.0), 0.3, DVec3::new(1.0, 2.0, 3.0)),
            DistantLight::rectangle(frame, DVec2::new(-0.5, 0.0), DVec2::new(0.5, 0.25), DVec3::ONE),
        ];
        LightSet::new("disks", lights, Equirect::new(RgbImage::filled(4, 2, Vec3::ONE)))
    }

    #[test]
    fn lights_survive_a_round_trip_through_text() {
        let set = set();
        let document = LightDocument::from_json(&set.to_json()).unwrap();
        assert_eq!((document.method.as_str(), document.lights.len()), (set.method, set.lights.len()));
        for (entry, light) in document.lights.iter().zip(&set.lights) {
            let back = entry.light();
            assert!((back.bitangent - light.bitangent).length() < 1e-6);
            assert_eq!(
                (back.shape, back.radiance, back.direction),
                (light.shape, light.radiance, light.direction)
            );
        }
    }

    #[test]
    fn impossible_lights_and_other_text_are_refused() {
        assert!(LightDocument::from_json("{}").is_err());
        assert!(LightDocument::from_json("not json").is_err());
        for (field, value) in [("direction", "[0, 0, 0]"), ("radiance", "[-1, 0, 0]"), ("solid_angle", "0")] {
            let mut json: Value = serde_json::from_str(&set().to_json()).unwrap();
            json["lights"][1][field] = serde_json::from_str(value).unwrap();
            let error = LightDocument::from_json(&json.to_string()).unwrap_err().to_string();
            assert!(error.contains("light 1") && error.contains(field), "{error}");
        }
    }
}
