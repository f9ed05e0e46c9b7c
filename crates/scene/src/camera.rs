use glam::{Affine3A, DVec2, DVec3, Mat3, Mat3A, Mat4, Vec2, Vec3, Vec3A};
use serde::{Deserialize, Serialize};

use crate::camera_settings::CameraSettings;

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

/// Where the picture lies on the plane behind a lens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Film {
    /// From the lens' axis to the picture's middle, to the right and up, in widths of the picture: what is seen moves the other way.
    pub shift: Vec2,
    /// Height of a pixel over its width.
    pub pixel_aspect: f32,
}

impl Default for Film {
    fn default() -> Self {
        Self { shift: Vec2::ZERO, pixel_aspect: 1.0 }
    }
}

impl Film {
    /// Place on the plane of a place in the picture, both in half widths of the picture, to the right and up: of the picture from its
    /// middle, of the plane from the lens' axis.
    pub fn plane_from_picture(&self, place: Vec2) -> Vec2 {
        place * Vec2::new(1.0, self.pixel_aspect) + 2.0 * self.shift
    }

    /// Whether shift and aspect are those of a picture.
    pub fn is_usable(&self) -> bool {
        let aspect = self.pixel_aspect;
        self.shift.is_finite()
            && self.shift.abs().max_element() <= MOST_SHIFT
            && (1.0 / MOST_ASPECT..=MOST_ASPECT).contains(&aspect)
    }
}

/// Farthest shift [widths of the picture], and most that a pixel is higher than wide or wider than high.
pub(crate) const MOST_SHIFT: f32 = 100.0;
pub(crate) const MOST_ASPECT: f32 = 100.0;

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
    /// Where the picture lies behind it.
    pub film: Film,
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
        Self {
            name: String::new(),
            world_from_camera,
            origin: DVec3::ZERO,
            projection,
            film: Film::default(),
        }
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

    /// `fx`, `fy`, `cx` and `cy` [pixels] of a pinhole for a picture of this size, as OpenCV has them; `None` for a parallel view.
    pub fn intrinsics(&self, size: [u32; 2]) -> Option<[f64; 4]> {
        let Projection::Perspective { fov_x } = self.projection else { return None };
        let [width, height] = size.map(f64::from);
        let aspect = f64::from(self.film.pixel_aspect);
        let shift = self.film.shift.as_dvec2();
        let fx = 0.5 * width / (0.5 * f64::from(fov_x)).tan();
        let cx = 0.5 * width - 0.5 - shift.x * width;
        let cy = 0.5 * height - 0.5 + shift.y * width / aspect;
        Some([fx, fx / aspect, cx, cy])
    }

    /// Where a place in world space is seen: the pixel, counted as OpenCV does, and the distance along the viewing axis [m], which is not above 0
    /// for what lies behind.
    pub fn project(&self, place: Vec3, size: [u32; 2]) -> Vec3 {
        let in_camera = self.world_from_camera.as_dmat4().inverse().transform_point3(place.as_dvec3());
        let [width, height] = size.map(f64::from);
        let depth = -in_camera.z;
        // On the film, in half widths of the picture.
        let film = match self.projection {
            Projection::Perspective { fov_x } => {
                in_camera.truncate() / (depth * (0.5 * f64::from(fov_x)).tan())
            }
            Projection::Orthographic { half_width } => in_camera.truncate() / f64::from(half_width),
        };
        let at =
            (film - 2.0 * self.film.shift.as_dvec2()) / DVec2::new(1.0, f64::from(self.film.pixel_aspect));
        let pixel = DVec2::new(0.5 * width * (1.0 + at.x) - 0.5, 0.5 * (height - width * at.y) - 0.5);
        pixel.extend(depth).as_vec3()
    }

    /// Position in world space [m].
    pub fn eye(&self) -> Vec3 {
        self.world_from_camera.w_axis.truncate()
    }
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
