use glam::{Mat4, Vec3};

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
}
