//! Axes, unit and origin of files that do not say how their coordinates are meant.

use glam::{DVec3, Vec3};
use gnomon_options::choices;
use gnomon_scene::{LARGEST_COORDINATE, origin_around};

choices! {
    /// The axis that points up.
    pub enum UpAxis {
        /// y, as in CONVENTIONS.md.
        Y = "y",
        /// z, as surveys, printers and CAD programs have it.
        Z = "z",
    }
}

/// Names of units and their lengths [m].
pub const UNITS: [(&str, f32); 5] = [("m", 1.0), ("cm", 0.01), ("mm", 0.001), ("in", 0.0254), ("ft", 0.3048)];

/// How the coordinates of files that do not say so are meant: OBJ, PLY and STL. What is `None` nobody has said yet.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Axes {
    /// The axis that points up; [`UpAxis::Y`] where nobody says. From z up, y goes back.
    pub up: Option<UpAxis>,
    /// Length of the unit [m], above 0; a metre where nobody says.
    pub unit: Option<f32>,
}

impl Axes {
    /// These, and what they do not say as `others` do.
    #[must_use]
    pub fn or(self, others: Self) -> Self {
        Self { up: self.up.or(others.up), unit: self.unit.or(others.unit) }
    }

    /// Whether they are those of Gnomon.
    pub(crate) fn are_own(self) -> bool {
        self.up.unwrap_or_default() == UpAxis::Y && self.unit.unwrap_or(1.0) == 1.0
    }

    /// Points of the file in place: turned, in metres, and near the origin. Returns the origin that was subtracted, which is that of the scene
    /// ([`gnomon_scene::Scene::origin`]): the one that is right for the points that are `used`, by their indices.
    pub(crate) fn settle(self, points: &mut [DVec3], used: impl Iterator<Item = u32>) -> DVec3 {
        if !self.are_own() {
            let unit = self.unit.unwrap_or(1.0);
            // The number that was written: 0.001 is more than single precision keeps of it.
            let unit = unit.to_string().parse().unwrap_or(f64::from(unit));
            points.iter_mut().for_each(|point| *point = self.turned(*point) * unit);
        }
        let usable =
            |point: &DVec3| point.abs().max_element() <= f64::from(LARGEST_COORDINATE) && point.is_finite();
        let ends = used.map(|index| points[index as usize]).filter(usable).map(|point| (point, point));
        let ends = ends.reduce(|(min, max), (point, _)| (min.min(point), max.max(point)));
        let origin = ends.map_or(DVec3::ZERO, |(min, max)| origin_around(min, max));
        if origin != DVec3::ZERO {
            points.iter_mut().for_each(|point| *point -= origin);
        }
        origin
    }

    /// Directions of the file in place.
    pub(crate) fn turn(self, directions: &mut [Vec3]) {
        if self.up == Some(UpAxis::Z) {
            directions.iter_mut().for_each(|d| *d = Vec3::new(d.x, d.z, -d.y));
        }
    }

    fn turned(self, point: DVec3) -> DVec3 {
        match self.up.unwrap_or_default() {
            UpAxis::Y => point,
            UpAxis::Z => DVec3::new(point.x, point.z, -point.y),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn z_goes_up_and_feet_become_metres() {
        let axes = Axes { up: Some(UpAxis::Z), unit: Some(0.3048) };
        let mut points = [DVec3::new(1.0, 2.0, 3.0), DVec3::ZERO];
        assert_eq!(axes.settle(&mut points, 0..2), DVec3::ZERO);
        assert!(points[0].distance(0.3048 * DVec3::new(1.0, 3.0, -2.0)) < 1e-12);
        let mut up = [Vec3::Z];
        axes.turn(&mut up);
        assert_eq!(up, [Vec3::Y]);
    }

    #[test]
    fn far_points_keep_their_digits() {
        let far = DVec3::new(5e8, 1e5, 4.5e9);
        // The last one is nobody's.
        let mut points = [far, far + DVec3::splat(0.25), DVec3::NAN, DVec3::ZERO];
        let origin = Axes { unit: Some(0.001), ..Axes::default() }.settle(&mut points, 0..3);
        assert!((origin - 0.001 * far).length() < 1.0, "{origin}");
        assert!((points[1] - points[0]).distance(DVec3::splat(0.00025)) < 1e-9);
    }
}
