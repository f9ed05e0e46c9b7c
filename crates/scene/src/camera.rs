use std::path::Path;

use glam::{Affine3A, Mat3, Mat3A, Mat4, Vec3, Vec3A};
use serde::Deserialize;

use crate::SceneError;
use crate::error::one_line;

/// How a camera maps directions to the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Pinhole.
    Perspective {
        /// Horizontal field of view [rad], in (0, pi).
        fov_x: f32,
    },
    /// Parallel.
    Orthographic {
        /// Half the width of the view [m].
        half_width: f32,
    },
}

/// A view of the scene: right-handed, looking along its own -z with +y up.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Name in the file, empty where it has none.
    pub name: String,
    /// Rigid transform from camera space to world space.
    pub world_from_camera: Mat4,
    /// Lens.
    pub projection: Projection,
}

impl Camera {
    /// A pinhole camera at `eye` that looks at `target` with +y up (or +z where it looks along y); `fov_x` [rad].
    pub fn look_at(eye: Vec3, target: Vec3, fov_x: f32) -> Self {
        let back = (eye - target).try_normalize().unwrap_or(Vec3::Z);
        let up = if back.y.abs() > 0.9999 { Vec3::Z } else { Vec3::Y };
        let right = up.cross(back).normalize();
        let world_from_camera = Mat4::from_cols(
            right.extend(0.0),
            back.cross(right).extend(0.0),
            back.extend(0.0),
            eye.extend(1.0),
        );
        Self { name: String::new(), world_from_camera, projection: Projection::Perspective { fov_x } }
    }

    /// Position in world space [m].
    pub fn eye(&self) -> Vec3 {
        self.world_from_camera.w_axis.truncate()
    }

    /// The camera that a user describes on the command line: `eye=x,y,z;target=x,y,z;fov=degrees` (horizontal), or else
    /// the path of a camera file, see [`Camera::from_file`].
    ///
    /// # Errors
    /// [`SceneError::Request`] for a description that makes no sense, and those of [`Camera::from_file`].
    pub fn from_argument(argument: &str) -> Result<Self, SceneError> {
        if argument.contains('=') && !Path::new(argument).exists() {
            return argument.parse();
        }
        Self::from_file(Path::new(argument))
    }

    /// Reads a camera file: TOML, or JSON where it starts with `{`, with the members `eye` and `target` (three numbers each
    /// [m]) and `fov` (horizontal [degrees]).
    ///
    /// # Errors
    /// [`SceneError::Io`], or [`SceneError::Invalid`] naming what is wrong.
    pub fn from_file(path: &Path) -> Result<Self, SceneError> {
        const LARGEST: u64 = 1 << 20;
        let io = |source| SceneError::Io { path: path.to_owned(), source };
        let invalid =
            |message: &str| SceneError::Invalid { path: path.to_owned(), message: one_line(message) };
        let metadata = std::fs::metadata(path).map_err(io)?;
        if !metadata.is_file() || metadata.len() > LARGEST {
            return Err(invalid("a camera file is a small text file"));
        }
        let text = std::fs::read_to_string(path).map_err(io)?;
        let text = text.trim_start_matches('\u{feff}');
        let settings: CameraSettings = if text.trim_start().starts_with('{') {
            serde_json::from_str(text).map_err(|error| invalid(&error.to_string()))?
        } else {
            toml::from_str(text).map_err(|error| invalid(error.message()))?
        };
        settings.camera().map_err(|message| invalid(&message))
    }
}

impl std::str::FromStr for Camera {
    type Err = SceneError;

    /// Parses `eye=x,y,z;target=x,y,z;fov=degrees`, in any order, blanks allowed.
    fn from_str(text: &str) -> Result<Self, SceneError> {
        let bad = |what: &str| {
            let text = one_line(text);
            SceneError::Request(format!(
                "camera '{text}': {what} (eye=x,y,z;target=x,y,z;fov=degrees is expected)"
            ))
        };
        let number = |text: &str| {
            text.trim().parse::<f32>().map_err(|_| bad(&format!("'{}' is no number", one_line(text))))
        };
        let (mut eye, mut target, mut fov) = (None, None, None);
        for part in text.split(';').filter(|part| !part.trim().is_empty()) {
            let (key, value) = part.split_once('=').ok_or_else(|| bad("a part has no '='"))?;
            let numbers = value.split(',').map(number).collect::<Result<Vec<f32>, _>>()?;
            let place = |slot: &mut Option<[f32; 3]>| -> Result<(), SceneError> {
                let value = numbers.as_slice().try_into().map_err(|_| bad("a point has three numbers"))?;
                if slot.replace(value).is_some() { Err(bad("a part is given twice")) } else { Ok(()) }
            };
            match key.trim() {
                "eye" => place(&mut eye)?,
                "target" => place(&mut target)?,
                "fov" => match numbers.as_slice() {
                    [value] if fov.is_none() => fov = Some(*value),
                    _ => return Err(bad("fov is one number")),
                },
                key => return Err(bad(&format!("'{}' is unknown", one_line(key)))),
            }
        }
        let missing = |name: &str| bad(&format!("{name} is missing"));
        let settings = CameraSettings {
            eye: eye.ok_or_else(|| missing("eye"))?,
            target: target.ok_or_else(|| missing("target"))?,
            fov: fov.ok_or_else(|| missing("fov"))?,
        };
        settings.camera().map_err(|message| bad(&message))
    }
}

/// A pinhole camera as people write it.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct CameraSettings {
    pub eye: [f32; 3],
    pub target: [f32; 3],
    /// Horizontal [degrees].
    pub fov: f32,
}

impl CameraSettings {
    /// The camera, or what is wrong with it.
    pub fn camera(&self) -> Result<Camera, String> {
        let (eye, target) = (Vec3::from_array(self.eye), Vec3::from_array(self.target));
        // Beyond 1e15 squares of coordinates overflow.
        if !(eye.abs().max(target.abs()).max_element() < 1e15 && eye.is_finite() && target.is_finite()) {
            return Err("eye and target must be finite".to_owned());
        }
        if (eye - target).try_normalize().is_none() {
            return Err("eye and target are the same point".to_owned());
        }
        if !(self.fov > 0.0 && self.fov < 180.0) {
            return Err(format!("fov is {} degrees, but must lie between 0 and 180", self.fov));
        }
        Ok(Camera::look_at(eye, target, self.fov.to_radians()))
    }
}

/// The transform without scale and shear, as a camera has it: the viewing axis keeps its direction, +y is kept as near
/// as can be. `None` where it is collapsed or not finite.
pub(crate) fn rigid(affine: Affine3A) -> Option<Mat4> {
    let back = affine.matrix3.z_axis.try_normalize()?;
    let up = affine.matrix3.y_axis;
    let up = (up - back * back.dot(up)).try_normalize()?;
    let right: Vec3A = up.cross(back);
    let rotation = Mat3::from(Mat3A::from_cols(right, up, back));
    affine.translation.is_finite().then(|| Mat4::from_mat3_translation(rotation, affine.translation.into()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_described_camera_looks_at_its_target() {
        let camera: Camera = "eye=3.2,2.6,4.2; target = 0,.5,0;fov=40".parse().unwrap();
        assert_eq!(camera.eye(), Vec3::new(3.2, 2.6, 4.2));
        let target = camera.world_from_camera.inverse().transform_point3(Vec3::new(0.0, 0.5, 0.0));
        assert!(target.x.abs() < 1e-5 && target.y.abs() < 1e-5 && target.z < 0.0, "{target}");
        assert_eq!(camera.projection, Projection::Perspective { fov_x: 40_f32.to_radians() });
    }

    #[test]
    fn descriptions_that_make_no_sense_say_why() {
        for (text, why) in [
            ("eye=1,2,3;target=0,0,0", "fov is missing"),
            ("eye=1,2;target=0,0,0;fov=40", "three numbers"),
            ("eye=1,2,x;target=0,0,0;fov=40", "'x' is no number"),
            ("eye=1,2,nan;target=0,0,0;fov=40", "finite"),
            ("eye=1,2,3;target=1,2,3;fov=40", "same point"),
            ("eye=1,2,3;target=0,0,0;fov=180", "between 0 and 180"),
            ("eye=1,2,3;target=0,0,0;fov=40;up=0,1,0", "'up' is unknown"),
            ("eye=1,2,3;eye=1,2,3;target=0,0,0;fov=40", "twice"),
            ("", "eye is missing"),
        ] {
            let error = text.parse::<Camera>().unwrap_err().to_string();
            assert!(error.contains(why), "{text}: {error}");
            assert!(!error.contains('\n'));
        }
    }

    #[test]
    fn camera_files_are_toml_or_json() {
        let folder = tempfile::tempdir().unwrap();
        let expected: Camera = "eye=1,2,3;target=0,0,0;fov=50".parse().unwrap();
        for (name, text) in [
            ("a.toml", "# a view\neye = [1, 2, 3]\ntarget = [0, 0, 0]\nfov = 50\n"),
            ("a.json", r#"{"eye": [1, 2, 3], "target": [0, 0, 0], "fov": 50}"#),
        ] {
            let path = folder.path().join(name);
            std::fs::write(&path, text).unwrap();
            assert_eq!(Camera::from_file(&path).unwrap(), expected);
            assert_eq!(Camera::from_argument(path.to_str().unwrap()).unwrap(), expected);
        }
        let path = folder.path().join("bad.toml");
        std::fs::write(&path, "eye = [1, 2, 3]\ntarget = [0, 0, 0]\nfov = 50\nroll = 3").unwrap();
        let error = Camera::from_file(&path).unwrap_err().to_string();
        assert!(error.contains("roll") && !error.contains('\n'), "{error}");
        assert!(matches!(Camera::from_file(folder.path()), Err(SceneError::Invalid { .. })));
    }

    #[test]
    fn looking_straight_down_is_defined() {
        let camera = Camera::look_at(Vec3::new(0.0, 5.0, 0.0), Vec3::ZERO, 1.0);
        assert!(camera.world_from_camera.is_finite());
        assert!((camera.world_from_camera.determinant() - 1.0).abs() < 1e-6);
    }
}
