//! Cameras as people and files describe them.

use glam::{DVec3, Mat4, Vec2, Vec3};
use gnomon_messages::quoted;
use serde::{Deserialize, Serialize};

use crate::camera::{MOST_ASPECT, MOST_SHIFT};
use crate::pose::LARGEST;
use crate::{Camera, Film, Projection, SceneError};

impl std::str::FromStr for Camera {
    type Err = SceneError;

    /// Parses `eye=x,y,z;target=x,y,z;fov=degrees`, in any order, blanks allowed; in place of `fov` a calibrated lens as
    /// `fx=pixels;fy=pixels;cx=pixels;cy=pixels;size=WxH`, and with either `shift=x,y`.
    fn from_str(text: &str) -> Result<Self, SceneError> {
        let bad = |what: &str| {
            let text = quoted(text);
            SceneError::Request(format!(
                "camera '{text}': {what} (eye=x,y,z;target=x,y,z;fov=degrees is expected, or fx, fy, cx, cy in pixels and size=WxH in place of fov)"
            ))
        };
        let number = |text: &str| {
            text.trim().parse::<f64>().map_err(|_| bad(&format!("'{}' is no number", quoted(text))))
        };
        let mut settings = CameraSettings::default();
        for part in text.split(';').filter(|part| !part.trim().is_empty()) {
            let (key, value) = part.split_once('=').ok_or_else(|| bad("a part has no '='"))?;
            let key = key.trim();
            let between = if key == "size" { ['x', 'X'] } else { [',', ','] };
            let numbers = value.split(between).map(number).collect::<Result<Vec<f64>, _>>()?;
            let twice = match key {
                "eye" => fill(&mut settings.eye, &numbers, |number| number),
                "target" => fill(&mut settings.target, &numbers, |number| number),
                "shift" => fill(&mut settings.shift, &numbers, |number| number as f32),
                "size" => fill(&mut settings.size, &numbers, |number| number as f32),
                "fov" => fill_one(&mut settings.fov, &numbers),
                "fx" => fill_one(&mut settings.fx, &numbers),
                "fy" => fill_one(&mut settings.fy, &numbers),
                "cx" => fill_one(&mut settings.cx, &numbers),
                "cy" => fill_one(&mut settings.cy, &numbers),
                key => return Err(bad(&format!("'{}' is unknown", quoted(key)))),
            };
            twice.map_err(|what| bad(&format!("{key} {what}")))?;
        }
        for (name, is_missing) in [
            ("eye", settings.eye.is_none()),
            ("target", settings.target.is_none()),
            ("fov", settings.fov.is_none() && settings.fx.is_none()),
        ] {
            if is_missing {
                return Err(bad(&format!("{name} is missing")));
            }
        }
        settings.camera().map_err(|message| bad(&message))
    }
}

/// Puts numbers where there are none yet, or says what is wrong with them.
fn fill<T, const N: usize>(
    slot: &mut Option<[T; N]>,
    numbers: &[f64],
    kept: impl Fn(f64) -> T,
) -> Result<(), &'static str> {
    let wanted = if N == 3 { "is three numbers" } else { "is two numbers" };
    let value = <[f64; N]>::try_from(numbers).map_err(|_| wanted)?.map(kept);
    if slot.replace(value).is_some() { Err("is given twice") } else { Ok(()) }
}

fn fill_one(slot: &mut Option<f32>, numbers: &[f64]) -> Result<(), &'static str> {
    let [value] = numbers else { return Err("is one number") };
    if slot.replace(*value as f32).is_some() { Err("is given twice") } else { Ok(()) }
}

/// A camera as people write it, `eye`, `target` and `fov`; as calibrations have its lens, `fx`, `fy`, `cx`, `cy` and `size`; or as programs
/// do, to the last bit: `matrix` and `fov_radians` or `half_width`.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct CameraSettings {
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
    /// Focal lengths in widths and heights of a pixel, for pictures of `size`; `fy` is `fx` where it is left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    fx: Option<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    fy: Option<f32>,
    /// The pixel that the axis meets, from 0 in the middle of the upper left one, as OpenCV counts; the picture's middle where it is left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    cx: Option<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    cy: Option<f32>,
    /// Width and height of the picture that these are for [pixels].
    #[serde(skip_serializing_if = "Option::is_none")]
    size: Option<[f32; 2]>,
    /// [`Film::shift`].
    #[serde(skip_serializing_if = "Option::is_none")]
    shift: Option<[f32; 2]>,
    /// [`Film::pixel_aspect`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pixel_aspect: Option<f32>,
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
        let (projection, film) = self.lens()?;
        if !film.is_usable() {
            return Err(format!(
                "the picture is moved or stretched too far: shift to {MOST_SHIFT} widths, pixels to {MOST_ASPECT} times as high as wide"
            ));
        }
        Ok(Camera { projection, film, ..camera })
    }

    fn lens(&self) -> Result<(Projection, Film), String> {
        let film = Film {
            shift: self.shift.map_or(Vec2::ZERO, Vec2::from),
            pixel_aspect: self.pixel_aspect.unwrap_or(1.0),
        };
        let perspective = |fov_x: f32| Ok((Projection::Perspective { fov_x }, film));
        let is_calibrated = [self.fy, self.cx, self.cy].iter().any(Option::is_some) || self.size.is_some();
        match (self.fov, self.fov_radians, self.half_width, self.fx) {
            (None, None, None, Some(fx)) => self.calibrated(fx),
            (.., None) if is_calibrated => Err("fy, cx, cy and size are for a lens that fx gives".to_owned()),
            (Some(fov), None, None, None) if fov > 0.0 && fov < 180.0 => perspective(fov.to_radians()),
            (Some(fov), None, None, None) => {
                Err(format!("fov is {fov} degrees, but must lie between 0 and 180"))
            }
            (None, Some(fov_x), None, None) if fov_x > 0.0 && fov_x < std::f32::consts::PI => {
                perspective(fov_x)
            }
            (None, Some(fov_x), None, None) => {
                Err(format!("fov_radians is {fov_x}, but must lie between 0 and pi"))
            }
            (None, None, Some(half_width), None) if half_width > 0.0 && half_width.is_finite() => {
                Ok((Projection::Orthographic { half_width }, film))
            }
            (None, None, Some(half_width), None) => {
                Err(format!("half_width is {half_width} m, but must be above 0"))
            }
            (None, None, None, None) => Err("missing field `fov`".to_owned()),
            _ => Err("a camera has one of 'fov', 'fx', 'fov_radians' and 'half_width'".to_owned()),
        }
    }

    fn calibrated(&self, fx: f32) -> Result<(Projection, Film), String> {
        let Some([width, height]) = self.size else {
            return Err("fx is in pixels of a picture whose size is missing".to_owned());
        };
        if self.shift.is_some() || self.pixel_aspect.is_some() {
            return Err(
                "a lens with fx has its shift from cx and cy, and its pixels' aspect from fy".to_owned()
            );
        }
        let fy = self.fy.unwrap_or(fx);
        if ![fx, fy, width, height].iter().all(|value| value.is_finite() && *value > 0.0) {
            return Err("fx, fy and size must be above 0".to_owned());
        }
        let [cx, cy] =
            [(self.cx, width), (self.cy, height)].map(|(c, side)| c.map_or(0.5 * side, |c| c + 0.5));
        let fov_x = 2.0 * (0.5 * width / fx).atan();
        let pixel_aspect = fx / fy;
        let shift = Vec2::new(0.5 * width - cx, (cy - 0.5 * height) * pixel_aspect) / width;
        Ok((Projection::Perspective { fov_x }, Film { shift, pixel_aspect }))
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
        let Film { shift, pixel_aspect } = camera.film;
        Self {
            matrix: Some([column(0), column(1), column(2), eye.to_array()]),
            fov_radians,
            half_width,
            shift: (shift != Vec2::ZERO).then(|| shift.to_array()),
            pixel_aspect: (pixel_aspect != 1.0).then_some(pixel_aspect),
            ..Self::default()
        }
    }
}

/// The number of fewest digits that is the same in single precision.
fn as_written(value: f32) -> f64 {
    value.to_string().parse().unwrap_or(f64::from(value))
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

    /// OpenCV's `x = fx X / Z + cx`, whose first pixel has its middle at 0.
    #[test]
    fn a_calibrated_lens_projects_as_opencv_does() {
        let camera: Camera =
            "eye=0,0,0; target=0,0,-1; fx=900; fy=800; cx=310.5; cy=200.25; size=640x480".parse().unwrap();
        let Projection::Perspective { fov_x } = camera.projection else { panic!("{camera:?}") };
        let (width, height) = (640.0, 480.0);
        for pixel in [Vec2::ZERO, Vec2::new(310.5, 200.25), Vec2::new(600.0, 470.0)] {
            // Its middle, from the picture's middle in half widths.
            let place = Vec2::new(pixel.x + 0.5 - 0.5 * width, 0.5 * height - pixel.y - 0.5) / (0.5 * width);
            let seen = camera.film.plane_from_picture(place) * (0.5 * fov_x).tan();
            let expected = Vec2::new((pixel.x - 310.5) / 900.0, -(pixel.y - 200.25) / 800.0);
            assert!((seen - expected).length() < 1e-6, "{pixel}: {seen} {expected}");
            // At a depth of 3 m.
            let place = Vec3::new(3.0 * expected.x, 3.0 * expected.y, -3.0);
            let projected = camera.project(place, [640, 480]);
            assert!((projected - pixel.extend(3.0)).length() < 1e-3, "{pixel}: {projected}");
        }
        let lens = camera.intrinsics([640, 480]).unwrap();
        for (number, expected) in lens.iter().zip([900.0, 800.0, 310.5, 200.25]) {
            assert!((number - expected).abs() < 1e-3, "{lens:?}");
        }
        let plain: Camera = "eye=0,0,0; target=0,0,-1; fx=900; size=640x480".parse().unwrap();
        assert_eq!(plain.film, Film::default());
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
            ("eye=1,2,3;target=0,0,0;fx=40;size=30", "size is two numbers"),
            ("eye=1,2,3;target=0,0,0;fov=40;fx=40;size=30x20", "one of"),
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
        let moved = Film { shift: Vec2::new(0.123_456_7, -0.3), pixel_aspect: 1.01 };
        for (projection, film) in
            [(camera.projection, Film::default()), (Projection::Orthographic { half_width: 1.7 }, moved)]
        {
            (camera.projection, camera.film) = (projection, film);
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
            ("eye = [1, 2, 3]\ntarget = [0, 0, 0]\nfov = 40\ncx = 3", "that fx gives"),
            ("eye = [1, 2, 3]\ntarget = [0, 0, 0]\nfx = 40", "size is missing"),
            ("eye = [1, 2, 3]\ntarget = [0, 0, 0]\nfx = 40\nsize = [0, 3]", "above 0"),
            ("eye = [1, 2, 3]\ntarget = [0, 0, 0]\nfov = 40\nshift = [nan, 3]", "too far"),
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
