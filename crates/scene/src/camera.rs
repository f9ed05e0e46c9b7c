use glam::{Affine3A, DVec3, Mat3, Mat3A, Mat4, Vec3, Vec3A};
use gnomon_messages::quoted;
use serde::{Deserialize, Serialize};

use crate::SceneError;
use crate::pose::LARGEST;

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

/// A view of the scene: right-handed, looking along its own -z with +y up. As a document it is a `[camera]` of a scene file, without its
/// name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "CameraSettings", into = "CameraSettings")]
pub struct Camera {
    /// Name in the file, empty where it has none.
    pub name: String,
    /// Rigid transform from camera space to world space.
    pub world_from_camera: Mat4,
    /// Where the origin of that world space lies in file coordinates [m]: that of the scene which it sees ([`crate::Scene::origin`]), or of its own
    /// where it was written for any.
    pub origin: DVec3,
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
        let projection = Projection::Perspective { fov_x };
        Self { name: String::new(), world_from_camera, origin: DVec3::ZERO, projection }
    }

    /// The same view in the world space of a scene with this origin.
    #[must_use]
    pub fn relative_to(&self, origin: DVec3) -> Self {
        let mut camera = self.clone();
        if self.origin != origin {
            let eye = self.eye().as_dvec3() + (self.origin - origin);
            camera.world_from_camera.w_axis = eye.as_vec3().extend(1.0);
            camera.origin = origin;
        }
        camera
    }

    /// Position in world space [m].
    pub fn eye(&self) -> Vec3 {
        self.world_from_camera.w_axis.truncate()
    }
}

impl std::str::FromStr for Camera {
    type Err = SceneError;

    /// Parses `eye=x,y,z;target=x,y,z;fov=degrees`, in any order, blanks allowed.
    fn from_str(text: &str) -> Result<Self, SceneError> {
        let bad = |what: &str| {
            let text = quoted(text);
            SceneError::Request(format!(
                "camera '{text}': {what} (eye=x,y,z;target=x,y,z;fov=degrees is expected)"
            ))
        };
        let number = |text: &str| {
            text.trim().parse::<f64>().map_err(|_| bad(&format!("'{}' is no number", quoted(text))))
        };
        let (mut eye, mut target, mut fov) = (None, None, None);
        for part in text.split(';').filter(|part| !part.trim().is_empty()) {
            let (key, value) = part.split_once('=').ok_or_else(|| bad("a part has no '='"))?;
            let numbers = value.split(',').map(number).collect::<Result<Vec<f64>, _>>()?;
            let place = |slot: &mut Option<[f64; 3]>| -> Result<(), SceneError> {
                let value = numbers.as_slice().try_into().map_err(|_| bad("a point has three numbers"))?;
                if slot.replace(value).is_some() { Err(bad("a part is given twice")) } else { Ok(()) }
            };
            match key.trim() {
                "eye" => place(&mut eye)?,
                "target" => place(&mut target)?,
                "fov" => match numbers.as_slice() {
                    [value] if fov.is_none() => fov = Some(*value as f32),
                    _ => return Err(bad("fov is one number")),
                },
                key => return Err(bad(&format!("'{}' is unknown", quoted(key)))),
            }
        }
        let missing = |name: &str| bad(&format!("{name} is missing"));
        let settings = CameraSettings {
            eye: Some(eye.ok_or_else(|| missing("eye"))?),
            target: Some(target.ok_or_else(|| missing("target"))?),
            fov: Some(fov.ok_or_else(|| missing("fov"))?),
            ..CameraSettings::default()
        };
        settings.camera().map_err(|message| bad(&message))
    }
}

/// A camera as people write it, `eye`, `target` and `fov`; or as programs do, to the last bit: `matrix` and `fov_radians` or
/// `half_width`.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct CameraSettings {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub eye: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub target: Option<[f64; 3]>,
    /// Horizontal [degrees].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fov: Option<f32>,
    /// `world_from_camera`: right, up and back as columns, and the eye.
    #[serde(skip_serializing_if = "Option::is_none")]
    matrix: Option<[[f64; 3]; 4]>,
    /// Horizontal [rad].
    #[serde(skip_serializing_if = "Option::is_none")]
    fov_radians: Option<f32>,
    /// Of a parallel view [m].
    #[serde(skip_serializing_if = "Option::is_none")]
    half_width: Option<f32>,
}

/// How far the axes of a camera's matrix may be from unit length and right angles.
const RIGID: f32 = 1e-3;

impl CameraSettings {
    /// The camera, or what is wrong with it.
    pub fn camera(&self) -> Result<Camera, String> {
        let camera = match (self.eye, self.target, self.matrix) {
            (Some(eye), Some(target), None) => looking(eye.into(), target.into())?,
            (None, None, Some(matrix)) => with_columns(matrix.map(DVec3::from_array))?,
            (_, _, Some(_)) => return Err("a camera has either 'matrix' or 'eye' and 'target'".to_owned()),
            (None, ..) => return Err("missing field `eye`".to_owned()),
            (_, None, _) => return Err("missing field `target`".to_owned()),
        };
        let projection = match (self.fov, self.fov_radians, self.half_width) {
            (Some(fov), None, None) if fov > 0.0 && fov < 180.0 => {
                Projection::Perspective { fov_x: fov.to_radians() }
            }
            (Some(fov), None, None) => {
                return Err(format!("fov is {fov} degrees, but must lie between 0 and 180"));
            }
            (None, Some(fov_x), None) if fov_x > 0.0 && fov_x < std::f32::consts::PI => {
                Projection::Perspective { fov_x }
            }
            (None, Some(fov_x), None) => {
                return Err(format!("fov_radians is {fov_x}, but must lie between 0 and pi"));
            }
            (None, None, Some(half_width)) if half_width > 0.0 && half_width.is_finite() => {
                Projection::Orthographic { half_width }
            }
            (None, None, Some(half_width)) => {
                return Err(format!("half_width is {half_width} m, but must be above 0"));
            }
            (None, None, None) => return Err("missing field `fov`".to_owned()),
            _ => return Err("a camera has one of 'fov', 'fov_radians' and 'half_width'".to_owned()),
        };
        Ok(Camera { projection, ..camera })
    }
}

/// Beyond this distance [m] single precision keeps less than half a millimetre of an eye's place: it then has an origin of its own.
const FAR_EYE: f64 = 4096.0;

/// The origin for a camera at this place.
fn origin_of(eye: DVec3) -> DVec3 {
    if eye.abs().max_element() > FAR_EYE { eye.round() } else { DVec3::ZERO }
}

/// Whether squares of its coordinates stay finite; false for NaN, which a maximum would skip.
fn is_near(place: DVec3) -> bool {
    place.to_array().into_iter().all(|coordinate| coordinate.abs() <= f64::from(LARGEST))
}

fn looking(eye: DVec3, target: DVec3) -> Result<Camera, String> {
    if !(is_near(eye) && is_near(target)) {
        return Err(format!("eye and target must be finite, and within {LARGEST:.0e} m of the origin"));
    }
    let origin = origin_of(eye);
    let (eye, target) = ((eye - origin).as_vec3(), (target - origin).as_vec3());
    if (eye - target).try_normalize().is_none() {
        return Err("eye and target are the same point".to_owned());
    }
    Ok(Camera { origin, ..Camera::look_at(eye, target, 1.0) })
}

fn with_columns(columns: [DVec3; 4]) -> Result<Camera, String> {
    let eye = columns[3];
    let [x, y, z, _] = columns.map(|column| column.as_vec3());
    let gram = [x.dot(x) - 1.0, y.dot(y) - 1.0, z.dot(z) - 1.0, x.dot(y), y.dot(z), z.dot(x)];
    if !gram.iter().all(|value| value.abs() < RIGID) || x.cross(y).dot(z) < 0.0 {
        return Err(
            "the first three columns of matrix must be right, up and back: unit length, right angles"
                .to_owned(),
        );
    }
    if !is_near(eye) {
        return Err(format!(
            "the last column of matrix, the eye, must be finite, and within {LARGEST:.0e} m of the origin"
        ));
    }
    let origin = origin_of(eye);
    let columns = [x.extend(0.0), y.extend(0.0), z.extend(0.0), (eye - origin).as_vec3().extend(1.0)];
    let [x, y, z, eye] = columns;
    let world_from_camera = Mat4::from_cols(x, y, z, eye);
    Ok(Camera { world_from_camera, origin, ..Camera::look_at(Vec3::ZERO, Vec3::NEG_Z, 1.0) })
}

impl TryFrom<CameraSettings> for Camera {
    type Error = String;

    fn try_from(settings: CameraSettings) -> Result<Self, String> {
        settings.camera()
    }
}

impl From<Camera> for CameraSettings {
    fn from(camera: Camera) -> Self {
        let column = |index| camera.world_from_camera.col(index).truncate().to_array().map(as_written);
        let eye = DVec3::from_array(column(3)) + camera.origin;
        let (fov_radians, half_width) = match camera.projection {
            Projection::Perspective { fov_x } => (Some(fov_x), None),
            Projection::Orthographic { half_width } => (None, Some(half_width)),
        };
        let matrix = Some([column(0), column(1), column(2), eye.to_array()]);
        Self { matrix, fov_radians, half_width, ..Self::default() }
    }
}

/// The number of fewest digits that is the same in single precision.
fn as_written(value: f32) -> f64 {
    value.to_string().parse().unwrap_or(f64::from(value))
}

/// The transform without scale and shear, as a camera has it: the viewing axis keeps its direction, +y is kept as near
/// as can be. `None` where it is collapsed or not finite.
pub fn rigid(affine: Affine3A) -> Option<Mat4> {
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
    fn documents_keep_every_bit_of_a_camera() {
        let mut camera = Camera::look_at(Vec3::new(0.1, 2.3, -4.7), Vec3::new(0.3, 0.2, 0.1), 0.7123);
        for projection in [camera.projection, Projection::Orthographic { half_width: 1.7 }] {
            camera.projection = projection;
            let text = toml::to_string(&camera).unwrap();
            assert_eq!(toml::from_str::<Camera>(&text).unwrap(), camera, "{text}");
        }
        let far = "eye = [500000.125, 12.0, -4500000.875]\ntarget = [500000.0, 10.0, -4500003.25]\nfov = 40";
        let far: Camera = toml::from_str(far).unwrap();
        let again: Camera = toml::from_str(&toml::to_string(&far).unwrap()).unwrap();
        assert_eq!(again, far);
        let from_here = far.relative_to(DVec3::new(5e5, 0.0, -4.5e6));
        assert_eq!(from_here.eye(), Vec3::new(0.125, 12.0, -0.875));
        let towards = Vec3::new(0.125, 2.0, 2.375).normalize();
        assert!((from_here.world_from_camera.z_axis.truncate() - towards).length() < 1e-6);
        for (text, why) in [
            ("eye = [1, 2, 3]\ntarget = [0, 0, 0]", "missing field `fov`"),
            ("target = [0, 0, 0]\nfov = 40", "missing field `eye`"),
            ("eye = [1, 2, 3]\nmatrix = [[1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, 0]]\nfov = 40", "either"),
            ("matrix = [[1, 0, 0], [0, 1, 0], [0, 0, 2], [0, 0, 0]]\nfov = 40", "unit length"),
            ("matrix = [[1, 0, 0], [0, 1, 0], [0, 0, -1], [0, 0, 0]]\nfov = 40", "right angles"),
            ("matrix = [[1, 0, 0], [0, 1, 0], [0, 0, 1], [0, nan, 0]]\nfov = 40", "finite"),
            ("eye = [1, 2, 3]\ntarget = [0, 0, 0]\nfov = 40\nhalf_width = 2", "one of"),
            ("eye = [1, 2, 3]\ntarget = [0, 0, 0]\nhalf_width = -2", "above 0"),
        ] {
            let error = toml::from_str::<Camera>(text).unwrap_err().to_string();
            assert!(error.contains(why), "{text}: {error}");
        }
    }

    #[test]
    fn looking_straight_down_is_defined() {
        let camera = Camera::look_at(Vec3::new(0.0, 5.0, 0.0), Vec3::ZERO, 1.0);
        assert!(camera.world_from_camera.is_finite());
        assert!((camera.world_from_camera.determinant() - 1.0).abs() < 1e-6);
    }
}
