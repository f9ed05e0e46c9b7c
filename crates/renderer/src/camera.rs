use std::ops::Range;

use glam::{Mat4, Vec2, Vec3, Vec4};
use gnomon_scene::{Bounds, Camera, Film, Projection};

/// A camera as the shaders see it: reversed depth, 1 at the near plane and 0 at (or towards) infinity.
pub(crate) struct CameraMatrices {
    pub clip_from_world: Mat4,
    pub world_from_clip: Mat4,
    /// Eye position and 1, or direction to the viewer and 0.
    pub eye_world: Vec4,
    /// Width of what is seen [m], in perspective at a distance of 1 m.
    pub view_width: f32,
}

impl CameraMatrices {
    pub fn new(camera: &Camera, aspect: f32, bounds: Option<Bounds>) -> Self {
        let camera_from_world = camera.world_from_camera.inverse();
        let (center, radius) = bounds.map_or((Vec3::ZERO, 1.0), |b| (b.center(), b.radius()));
        let distance = (camera.eye() - center).length() + radius;
        let Film { shift, pixel_aspect } = camera.film;
        // Half a width up in half heights, and the picture's middle in half widths and half heights.
        let vertical = aspect / pixel_aspect;
        let middle = 2.0 * shift * Vec2::new(1.0, vertical);
        let (clip_from_camera, eye_world, view_width) = match camera.projection {
            Projection::Perspective { fov_x } => {
                let focal = 1.0 / (0.5 * fov_x).tan();
                let near = (1e-3 * distance).max(1e-6);
                let matrix = Mat4::from_cols(
                    Vec4::new(focal, 0.0, 0.0, 0.0),
                    Vec4::new(0.0, focal * vertical, 0.0, 0.0),
                    Vec4::new(middle.x, middle.y, 0.0, -1.0),
                    Vec4::new(0.0, 0.0, near, 0.0),
                );
                (matrix, camera.eye().extend(1.0), 2.0 / focal)
            }
            Projection::Orthographic { half_width } => {
                // Far is depth 0, which stands for the background: keep the scene nearer than that.
                let range = 4.0 * distance.max(1e-6);
                let matrix = Mat4::from_cols(
                    Vec4::new(1.0 / half_width, 0.0, 0.0, 0.0),
                    Vec4::new(0.0, vertical / half_width, 0.0, 0.0),
                    Vec4::new(0.0, 0.0, 1.0 / range, 0.0),
                    Vec4::new(-middle.x, -middle.y, 1.0, 1.0),
                );
                let to_viewer = camera.world_from_camera.z_axis.truncate().normalize();
                (matrix, to_viewer.extend(0.0), 2.0 * half_width)
            }
        };
        let clip_from_world = clip_from_camera * camera_from_world;
        Self { clip_from_world, world_from_clip: clip_from_world.inverse(), eye_world, view_width }
    }

    /// The same for some rows of the picture's `height`, top row first: they fill the view.
    pub fn cropped(self, height: u32, rows: Range<u32>) -> Self {
        if rows == (0..height) {
            return self;
        }
        let scale = height as f32 / rows.len().max(1) as f32;
        let top = 1.0 - 2.0 * rows.start as f32 / height as f32;
        let mut crop = Mat4::IDENTITY;
        (crop.y_axis.y, crop.w_axis.y) = (scale, 1.0 - scale * top);
        let clip_from_world = crop * self.clip_from_world;
        Self { clip_from_world, world_from_clip: clip_from_world.inverse(), ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_horizontal_field_of_view_fills_the_width() {
        let camera = Camera::look_at(Vec3::new(0.0, 0.0, 2.0), Vec3::ZERO, 90_f32.to_radians());
        let m = CameraMatrices::new(&camera, 2.0, None);
        let edge = m.clip_from_world.project_point3(Vec3::new(2.0, 1.0, 0.0));
        assert!((edge.x - 1.0).abs() < 1e-5 && (edge.y - 1.0).abs() < 1e-5 && edge.z > 0.0 && edge.z < 1.0);
    }

    /// What [`gnomon_scene::Film::plane_from_picture`] says of the picture's corners.
    #[test]
    fn a_moved_picture_shows_what_lies_there() {
        let mut camera = Camera::look_at(Vec3::ZERO, Vec3::NEG_Z, 90_f32.to_radians());
        camera.film = Film { shift: Vec2::new(0.25, -0.125), pixel_aspect: 2.0 };
        for projection in [camera.projection, Projection::Orthographic { half_width: 1.0 }] {
            camera.projection = projection;
            let m = CameraMatrices::new(&camera, 2.0, None);
            for corner in [Vec2::new(1.0, 0.5), Vec2::new(-1.0, -0.5)] {
                let seen = camera.film.plane_from_picture(corner).extend(-1.0);
                let clip = m.clip_from_world.project_point3(seen).truncate();
                assert!((clip - corner * Vec2::new(1.0, 2.0)).length() < 1e-5, "{clip} {corner}");
            }
        }
    }

    #[test]
    fn cropped_rows_fill_the_view() {
        let camera = Camera::look_at(Vec3::new(0.0, 0.0, 2.0), Vec3::ZERO, 90_f32.to_radians());
        let at = |rows: Range<u32>, y: f32| {
            let m = CameraMatrices::new(&camera, 1.0, None).cropped(100, rows);
            m.clip_from_world.project_point3(Vec3::new(0.5, y, 0.0)).truncate()
        };
        // Rows 25 to 75 are the middle half of a view that is 4 m high.
        assert!((at(25..75, 1.0) - Vec2::new(0.25, 1.0)).length() < 1e-5);
        assert!((at(25..75, -1.0) - Vec2::new(0.25, -1.0)).length() < 1e-5);
        assert!((at(0..100, 1.0) - Vec2::new(0.25, 0.5)).length() < 1e-5);
        assert!((at(0..50, 2.0) - Vec2::new(0.25, 1.0)).length() < 1e-5);
    }

    #[test]
    fn clip_and_world_are_inverses_far_from_the_origin() {
        let camera = Camera::look_at(Vec3::new(300.0, 20.0, -80.0), Vec3::new(298.0, 19.5, -81.0), 0.7);
        let m = CameraMatrices::new(&camera, 1.3, None);
        let p = Vec3::new(290.0, 18.0, -84.0);
        let back = m.world_from_clip.project_point3(m.clip_from_world.project_point3(p));
        assert!((back - p).length() < 0.02, "{back}");
    }
}
