//! A [`LightSet`] as JSON that people edit.

use glam::{DVec3, Vec2, Vec3};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use thiserror::Error;

use crate::{DistantLight, LightSet, LightShape};

/// The JSON form of a [`LightSet`]: its lights, and which files hold its maps. Directions are in world axes, angles radians, radiance and
/// flux linear Rec. 709. What follows from other fields is written for whoever reads it, and not read back: the sums of flux, and
/// [`LightEntry::derived`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LightDocument {
    /// Name of the fit.
    #[serde(default)]
    pub method: String,
    /// The fit's settings.
    #[serde(default)]
    pub parameters: Map<String, Value>,
    /// File of the map that the lights leave, seen from the document; none where they leave nothing.
    #[serde(default)]
    pub residual: Option<String>,
    /// File of the map behind the scene, which lights nothing; none for the residual.
    #[serde(default)]
    pub background: Option<String>,
    /// Flux of lights and residual together.
    #[serde(default)]
    pub total_flux: [f64; 3],
    /// Flux of the lights.
    #[serde(default)]
    pub lights_flux: [f64; 3],
    /// Flux of the residual.
    #[serde(default)]
    pub residual_flux: [f64; 3],
    /// Every light, in the order found.
    pub lights: Vec<LightEntry>,
}

/// One light of a [`LightDocument`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LightEntry {
    /// Whether it shines.
    #[serde(default = "shines")]
    pub enabled: bool,
    /// Towards the light's centre, of any length.
    pub direction: [f32; 3],
    /// First axis of the light's plane, but for its part along `direction`; the second is `direction x tangent`. Horizontal where it is left
    /// out.
    #[serde(default)]
    pub tangent: Option<[f32; 3]>,
    /// Outline.
    pub shape: ShapeEntry,
    /// Radiance.
    pub radiance: [f32; 3],
    /// What follows from the above.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub derived: Option<DerivedEntry>,
}

/// What a [`LightEntry`] comes to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DerivedEntry {
    /// Full angular width and height along tangent and bitangent [rad].
    pub extent: [f32; 2],
    /// Exact solid angle of the outline [sr].
    pub solid_angle: f32,
    /// Radiance times solid angle.
    pub flux: [f64; 3],
}

/// Outline of a [`LightEntry`], around its direction.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
pub enum ShapeEntry {
    /// All directions within a half angle of the centre.
    Disk {
        /// Half the apex angle [rad], in (0, pi/2).
        angular_radius: f32,
    },
    /// A convex quadrilateral.
    Rectangle {
        /// Corners in turn, along tangent and bitangent on the plane at distance 1: tangents of angles from the centre.
        corners: [[f32; 2]; 4],
    },
}

/// Why text is no light document.
#[derive(Debug, Error)]
pub enum DocumentError {
    /// The text is not JSON of this form.
    #[error("not a light document: {0}")]
    Json(#[from] serde_json::Error),
    /// A light with impossible numbers.
    #[error("light {index} of the document has an invalid {field}: {reason}")]
    Light {
        /// Which light, from 0.
        index: usize,
        /// Which of its fields.
        field: &'static str,
        /// What it has to be.
        reason: &'static str,
    },
}

fn shines() -> bool {
    true
}

impl LightSet {
    /// The set as a serialisable document that names no maps.
    pub fn document(&self) -> LightDocument {
        LightDocument {
            method: self.method.to_owned(),
            parameters: self.parameters.clone(),
            residual: None,
            background: None,
            total_flux: self.total_flux().to_array(),
            lights_flux: self.lights_flux().to_array(),
            residual_flux: self.residual_flux().to_array(),
            lights: self.lights.iter().map(LightEntry::from).collect(),
        }
    }
}

impl LightDocument {
    /// As indented JSON.
    pub fn to_json(&self) -> String {
        // `json!`-made values and finite numbers always serialise; `{:#}` cannot fail.
        let document = serde_json::to_value(self).unwrap_or(Value::Null);
        format!("{document:#}\n")
    }

    /// Reads a document back, checking every light.
    ///
    /// # Errors
    /// [`DocumentError`] for text of another form, and for lights that cannot be.
    pub fn from_json(text: &str) -> Result<Self, DocumentError> {
        let document: Self = serde_json::from_str(text)?;
        document.check()?;
        Ok(document)
    }

    /// Whether every light can be.
    ///
    /// # Errors
    /// [`DocumentError::Light`] for the first that cannot.
    pub fn check(&self) -> Result<(), DocumentError> {
        for (index, light) in self.lights.iter().enumerate() {
            light.light().map_err(|(field, reason)| DocumentError::Light { index, field, reason })?;
        }
        Ok(())
    }

    /// Works out anew what follows from the lights: [`LightEntry::derived`], and the flux of those that shine.
    pub fn derive(&mut self) {
        for entry in &mut self.lights {
            entry.derived = entry.light().ok().map(|light| DerivedEntry::from(&light));
        }
        let flux: DVec3 = self.shining().iter().map(DistantLight::flux).sum();
        self.lights_flux = flux.to_array();
        self.total_flux = (flux + DVec3::from(self.residual_flux)).to_array();
    }

    /// The lights that shine.
    pub fn shining(&self) -> Vec<DistantLight> {
        self.lights.iter().filter(|entry| entry.enabled).filter_map(|entry| entry.light().ok()).collect()
    }
}

impl From<&DistantLight> for LightEntry {
    fn from(light: &DistantLight) -> Self {
        Self {
            enabled: true,
            direction: light.direction.to_array(),
            tangent: Some(light.tangent.to_array()),
            shape: match light.shape {
                LightShape::Disk { angular_radius } => ShapeEntry::Disk { angular_radius },
                LightShape::Rectangle { .. } => ShapeEntry::Rectangle {
                    corners: light.plane_corners().unwrap_or_default().map(|corner| corner.to_array()),
                },
            },
            radiance: light.radiance.to_array(),
            derived: Some(DerivedEntry::from(light)),
        }
    }
}

impl From<&DistantLight> for DerivedEntry {
    fn from(light: &DistantLight) -> Self {
        Self {
            extent: light.extent().to_array(),
            solid_angle: light.solid_angle,
            flux: light.flux().to_array(),
        }
    }
}

/// A field, and what it has to be.
type Invalid = (&'static str, &'static str);

impl LightEntry {
    /// The light described, or the first field that no light can have.
    fn light(&self) -> Result<DistantLight, Invalid> {
        let direction = Vec3::from(self.direction)
            .try_normalize()
            .ok_or(("direction", "it needs three finite numbers, not all 0"))?;
        let tangent = self.tangent.map(Vec3::from).unwrap_or_default();
        if !tangent.is_finite() {
            return Err(("tangent", "it needs three finite numbers"));
        }
        let radiance = Vec3::from(self.radiance);
        if !(radiance.is_finite() && radiance.min_element() >= 0.0) {
            return Err(("radiance", "it needs three finite numbers, none below 0"));
        }
        match self.shape {
            ShapeEntry::Disk { angular_radius }
                if angular_radius > 0.0 && angular_radius < std::f32::consts::FRAC_PI_2 =>
            {
                Ok(DistantLight::around(direction, tangent, angular_radius, radiance))
            }
            ShapeEntry::Disk { .. } => Err(("shape", "the angular radius lies between 0 and pi/2")),
            ShapeEntry::Rectangle { corners } => {
                DistantLight::quadrilateral(direction, tangent, corners.map(Vec2::from), radiance)
                    .ok_or(("shape", "the corners must be those of a convex quadrilateral, in turn"))
            }
        }
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

    fn edited(change: impl Fn(&mut Value)) -> Result<LightDocument, DocumentError> {
        let mut json: Value = serde_json::from_str(&set().document().to_json()).unwrap();
        change(&mut json["lights"][1]);
        LightDocument::from_json(&json.to_string())
    }

    #[test]
    fn lights_survive_a_round_trip_through_text() {
        let set = set();
        let document = LightDocument::from_json(&set.document().to_json()).unwrap();
        assert_eq!((document.method.as_str(), document.lights.len()), (set.method, set.lights.len()));
        for (back, light) in document.shining().iter().zip(&set.lights) {
            assert!((back.tangent - light.tangent).length() < 1e-6);
            assert!((back.bitangent - light.bitangent).length() < 1e-6);
            assert!((back.solid_angle / light.solid_angle - 1.0).abs() < 1e-6);
            assert_eq!((back.radiance, back.direction), (light.radiance, light.direction));
            match (back.shape, light.shape) {
                (LightShape::Rectangle { corners: found }, LightShape::Rectangle { corners }) => {
                    assert!(found.iter().zip(corners).all(|(a, b)| a.distance(b) < 1e-6));
                }
                (found, expected) => assert_eq!(found, expected),
            }
        }
    }

    #[test]
    fn a_moved_light_takes_its_outline_along_and_one_that_is_off_does_not_shine() {
        let moved = edited(|light| light["direction"] = serde_json::json!([0, 0, 2])).unwrap().shining();
        let (moved, before) = (&moved[1], &set().lights[1]);
        assert_eq!(moved.direction, Vec3::Z);
        assert!((moved.solid_angle / before.solid_angle - 1.0).abs() < 1e-5);
        assert!((moved.tan_half_extent() - before.tan_half_extent()).length() < 1e-5);
        assert!((moved.irradiance(Vec3::Z) / before.irradiance(before.direction) - 1.0).abs() < 1e-5);
        let mut off = edited(|light| light["enabled"] = false.into()).unwrap();
        assert_eq!((off.lights.len(), off.shining().len()), (2, 1));
        off.lights[0].radiance = off.lights[0].radiance.map(|channel| 2.0 * channel);
        off.derive();
        let flux = DVec3::new(2.0, 4.0, 6.0);
        assert!((DVec3::from(off.lights_flux) - flux).length() < 1e-5, "{:?}", off.lights_flux);
        let derived = off.lights[0].derived.as_ref().map_or(DVec3::ZERO, |derived| derived.flux.into());
        assert!((derived - flux).length() < 1e-5, "{derived}");
        let added = r#"{"lights": [{"direction": [0, 1, 0], "shape": {"type": "disk", "angular_radius": 0.1},
            "radiance": [1, 2, 3]}]}"#;
        assert_eq!(LightDocument::from_json(added).unwrap().shining()[0].radiance, Vec3::new(1.0, 2.0, 3.0));
    }

    #[test]
    fn impossible_lights_and_other_text_are_refused() {
        assert!(LightDocument::from_json("{}").is_err());
        assert!(LightDocument::from_json("not json").is_err());
        for (field, value) in [
            ("direction", "[0, 0, 0]"),
            ("radiance", "[-1, 0, 0]"),
            ("shape", r#"{"type": "disk", "angular_radius": 1.6}"#),
            ("shape", r#"{"type": "rectangle", "corners": [[0, 0], [1, 0], [0.1, 0.1], [0, 1]]}"#),
            ("shape", r#"{"type": "rectangle", "corners": [[0, 0], [1, 0], [2, 0], [3, 0]]}"#),
        ] {
            let error = edited(|light| light[field] = serde_json::from_str(value).unwrap());
            let error = error.unwrap_err().to_string();
            assert!(error.contains("light 1") && error.contains(field), "{error}");
        }
        let unknown = edited(|light| light["colour"] = Value::from(1)).unwrap_err().to_string();
        assert!(unknown.contains("colour") && !unknown.contains('\n'), "{unknown}");
    }
}
