use glam::{UVec2, Vec2, Vec3};
use gnomon_scene::{Camera, Projection};

use crate::ReferenceError;

/// A half line in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it starts [m].
    pub origin: Vec3,
    /// Where it goes; unit length.
    pub direction: Vec3,
}

/// The camera's ray through `pixel` of a picture of `size` pixels: `(0, 0)` is the top left corner of the picture, and
/// `(x + 0.5, y + 0.5)` the centre of pixel `(x, y)`. The lens sets the width; the height follows from the pixels' aspect.
///
/// A pinhole's rays start at the eye, a parallel camera's on its own plane.
pub fn camera_ray(camera: &Camera, size: UVec2, pixel: Vec2) -> Ray {
    let size = size.as_vec2();
    // -1..1 across the width, the same scale downwards.
    let screen = Vec2::new(2.0 * pixel.x - size.x, size.y - 2.0 * pixel.y) / size.x;
    let screen = camera.film.plane_from_picture(screen);
    let (origin, direction) = match camera.projection {
        Projection::Perspective { fov_x } => {
            (Vec3::ZERO, (screen * (0.5 * fov_x).tan()).extend(-1.0).normalize())
        }
        Projection::Orthographic { half_width } => ((screen * half_width).extend(0.0), Vec3::NEG_Z),
    };
    let world = camera.world_from_camera;
    Ray { origin: world.transform_point3(origin), direction: world.transform_vector3(direction).normalize() }
}

/// Refuses cameras whose rays would not be numbers.
pub(crate) fn check_camera(camera: &Camera) -> Result<(), ReferenceError> {
    let bad = |reason| Err(ReferenceError::BadCamera { name: camera.name.clone(), reason });
    let matrix = camera.world_from_camera;
    if !matrix.is_finite() {
        return bad("its matrix has entries that are not finite");
    }
    if matrix.determinant().abs() < 1e-12 || !matrix.determinant().is_finite() {
        return bad("its matrix cannot be inverted");
    }
    if !camera.film.is_usable() {
        return bad("its picture is moved or stretched too far");
    }
    match camera.projection {
        Projection::Perspective { fov_x } if !(fov_x > 0.0 && fov_x < std::f32::consts::PI) => {
            bad("its field of view is not between 0 and 180 degrees")
        }
        Projection::Orthographic { half_width } if !(half_width > 0.0 && half_width.is_finite()) => {
            bad("its width is not a positive number")
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use gnomon_scene::Film;

    use super::*;

    #[test]
    fn pinhole_rays() {
        let camera = Camera::look_at(Vec3::new(1.0, 2.0, 3.0), Vec3::new(1.0, 2.0, 0.0), 90f32.to_radians());
        let size = UVec2::new(200, 100);
        let centre = camera_ray(&camera, size, Vec2::new(100.0, 50.0));
        assert_eq!(centre.origin, Vec3::new(1.0, 2.0, 3.0));
        assert!(centre.direction.distance(Vec3::NEG_Z) < 1e-6);
        // Half of 90 degrees to the right edge; the top edge is half as far on the film.
        let right = camera_ray(&camera, size, Vec2::new(200.0, 50.0)).direction;
        assert!(right.distance(Vec3::new(1.0, 0.0, -1.0).normalize()) < 1e-6);
        let top = camera_ray(&camera, size, Vec2::new(100.0, 0.0)).direction;
        assert!(top.distance(Vec3::new(0.0, 0.5, -1.0).normalize()) < 1e-6);
    }

    #[test]
    fn parallel_rays() {
        let mut camera = Camera::look_at(Vec3::ZERO, Vec3::NEG_Z, 1.0);
        camera.projection = Projection::Orthographic { half_width: 3.0 };
        let ray = camera_ray(&camera, UVec2::new(60, 20), Vec2::new(60.0, 20.0));
        assert!(ray.origin.distance(Vec3::new(3.0, -1.0, 0.0)) < 1e-6);
        assert_eq!(ray.direction, Vec3::NEG_Z);
    }

    #[test]
    fn a_moved_picture_shows_what_is_beside_the_axis() {
        let mut camera = Camera::look_at(Vec3::ZERO, Vec3::NEG_Z, 90f32.to_radians());
        camera.film = Film { shift: Vec2::new(0.25, -0.125), pixel_aspect: 2.0 };
        // A quarter of a width of 2 to the right, an eighth down; pixels are twice as high.
        let size = UVec2::new(200, 100);
        let centre = camera_ray(&camera, size, Vec2::new(100.0, 50.0)).direction;
        assert!(centre.distance(Vec3::new(0.5, -0.25, -1.0).normalize()) < 1e-6, "{centre}");
        let top = camera_ray(&camera, size, Vec2::new(100.0, 0.0)).direction;
        assert!(top.distance(Vec3::new(0.5, 0.75, -1.0).normalize()) < 1e-6, "{top}");
        camera.projection = Projection::Orthographic { half_width: 3.0 };
        assert_eq!(camera_ray(&camera, size, Vec2::new(100.0, 50.0)).origin, Vec3::new(1.5, -0.75, 0.0));
    }

    #[test]
    fn unusable_cameras_are_refused() {
        let good = Camera::look_at(Vec3::ZERO, Vec3::NEG_Z, 1.0);
        assert!(check_camera(&good).is_ok());
        for projection in [
            Projection::Perspective { fov_x: 0.0 },
            Projection::Perspective { fov_x: f32::NAN },
            Projection::Perspective { fov_x: 3.2 },
            Projection::Orthographic { half_width: -1.0 },
            Projection::Orthographic { half_width: f32::INFINITY },
        ] {
            assert!(check_camera(&Camera { projection, ..good.clone() }).is_err(), "{projection:?}");
        }
        for scale in [0.0, f32::NAN] {
            let world_from_camera = good.world_from_camera * scale;
            assert!(check_camera(&Camera { world_from_camera, ..good.clone() }).is_err());
        }
    }
}
