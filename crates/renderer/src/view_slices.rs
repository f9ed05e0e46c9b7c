//! Parts of what a camera sees, by their distance: each has shadow maps of its own where the scene is large for what is near.

use glam::{Vec2, Vec3};
use gnomon_scene::{Bounds, Camera, Projection};

use crate::casters::PlacedBoxes;

/// Most of them.
pub(crate) const MOST_SLICES: usize = 3;
/// A map of the whole scene is fine enough where its texels are no wider than so many pixels of the nearest thing.
const PIXELS_OF_TEXEL: f32 = 2.0;
/// Every slice may be so many times as far as the one before without texels that are coarse for its near end.
const GROWTH: f32 = 6.0;
/// Nothing counts as nearer than this share of the distance of the farthest thing.
const NEAREST: f32 = 1e-3;

/// What a camera sees in slices of distance from the eye (parallel split shadow maps, Zhang et al. 2006).
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct ViewSlices {
    eye: Vec3,
    /// To the corners of the picture, at a depth of 1.
    rays: [Vec3; 4],
    /// Where each but the last ends [m].
    ends: Vec<f32>,
}

/// One of them.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ViewSlice {
    /// Distance from the eye at which it begins and ends [m].
    pub distance: [f32; 2],
    /// Corners of a pyramid around what is nearer than its end; `None` for all there is.
    pub around: Option<[Vec3; 5]>,
}

impl ViewSlice {
    /// All that is seen.
    pub const WHOLE: Self = Self { distance: [0.0, f32::MAX], around: None };
}

impl ViewSlices {
    /// As few as make texels of maps of `resolution` texels a side as fine as a picture of `width` pixels asks for.
    pub fn new(camera: &Camera, [width, height]: [u32; 2], resolution: u32, scene: &PlacedBoxes) -> Self {
        let (Projection::Perspective { fov_x }, Some(around)) = (camera.projection, scene.around) else {
            return Self::default();
        };
        let tan = (0.5 * fov_x).tan();
        // Edges of the picture at distance 1.
        let corner = Vec2::new(1.0, height as f32 / width as f32);
        let [min, max] = [-corner, corner].map(|corner| camera.film.plane_from_picture(corner) * tan);
        let world_from_camera = camera.world_from_camera;
        let ray = |x: f32, y: f32| world_from_camera.transform_vector3(Vec3::new(x, y, -1.0));
        let eye = camera.eye();
        let camera_from_world = world_from_camera.inverse();
        let is_seen = |corners: &[Vec3; 8]| {
            let corners = corners.map(|corner| camera_from_world.transform_point3(corner));
            let outside = |plane: Vec3| corners.iter().all(|corner| plane.dot(*corner) > 0.0);
            let sides = [(1.0, 0.0, max.x), (-1.0, 0.0, -min.x), (0.0, 1.0, max.y), (0.0, -1.0, -min.y)];
            !outside(Vec3::Z) && !sides.into_iter().any(|(x, y, edge)| outside(Vec3::new(x, y, edge)))
        };
        let (mut near, mut far) = (f32::INFINITY, 0.0_f32);
        for place in scene.boxes.iter().filter(|place| is_seen(&place.corners)) {
            let Some(Bounds { min, max }) = Bounds::around(place.corners) else { continue };
            near = near.min(eye.distance(eye.clamp(min, max)));
            far = place.corners.iter().map(|corner| eye.distance(*corner)).fold(far, f32::max);
        }
        let near = near.max(NEAREST * far);
        let texel = 2.0 * around.radius() / resolution as f32;
        let pixel = near * 2.0 * tan / width as f32;
        let coarseness = texel / (PIXELS_OF_TEXEL * pixel);
        if !(coarseness.is_finite() && coarseness > 1.0 && near < far) {
            return Self::default();
        }
        let count = if coarseness <= GROWTH { 2 } else { MOST_SLICES };
        let end = |slice: usize| near * (far / near).powf(slice as f32 / count as f32);
        let rays = [ray(min.x, min.y), ray(max.x, min.y), ray(max.x, max.y), ray(min.x, max.y)];
        Self { eye, rays, ends: (1..count).map(end).collect() }
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.ends.len() + 1
    }

    /// The slice of a number; `None` past the last.
    pub fn get(&self, number: usize) -> Option<ViewSlice> {
        if number >= self.count() {
            return None;
        }
        let begin = number.checked_sub(1).map_or(0.0, |before| self.ends[before]);
        let around = |end: f32| {
            let [a, b, c, d] = self.rays.map(|ray| self.eye + end * ray);
            [self.eye, a, b, c, d]
        };
        let end = self.ends.get(number).copied();
        Some(ViewSlice { distance: [begin, end.unwrap_or(f32::MAX)], around: end.map(around) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::casters::tests::placed;

    #[test]
    fn a_small_scene_is_seen_whole_and_a_large_one_in_slices_that_hold_what_is_nearer() {
        let camera = Camera::look_at(Vec3::new(0.0, 2.0, 8.0), Vec3::ZERO, 0.7);
        let slices = |size: f32| {
            let boxes = [
                placed(Vec3::new(-1.0, 0.0, -1.0), Vec3::new(1.0, 1.0, 1.0)),
                placed(Vec3::new(-size, -0.1, -size), Vec3::new(size, 0.0, size)),
            ];
            ViewSlices::new(&camera, [320, 240], 2048, &PlacedBoxes::new(&boxes))
        };
        assert_eq!(slices(5.0).count(), 1);
        assert_eq!(slices(5.0).get(0), Some(ViewSlice::WHOLE));
        let large = slices(2000.0);
        assert_eq!(large.count(), MOST_SLICES);
        let all: Vec<_> = (0..MOST_SLICES).map(|number| large.get(number).unwrap()).collect();
        assert!(all.windows(2).all(|pair| pair[0].distance[1] == pair[1].distance[0]));
        assert_eq!((all[0].distance[0], all[2].distance[1]), (0.0, f32::MAX));
        // What a ray through a corner of the picture meets just before the end lies within the pyramid's box.
        let [_, a, ..] = all[0].around.unwrap();
        let towards = (a - camera.eye()).normalize();
        let met = camera.eye() + 0.999 * all[0].distance[1] * towards;
        let around = Bounds::around(all[0].around.unwrap()).unwrap();
        assert!(met.cmpge(around.min).all() && met.cmple(around.max).all());
        assert!(large.get(MOST_SLICES).is_none());
    }
}
