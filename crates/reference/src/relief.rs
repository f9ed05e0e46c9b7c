//! The heights around a hit: a height field that rays are traced through in the space of its texture. The mesh stays flat there, as bump maps
//! have it: the camera's ray and what the scene blocks end on the surface under the bumps.

use glam::{Vec2, Vec3};
use gnomon_scene::{Gradients, HeightMap, Wrap};

/// Heights as they lie around a point of a surface, which counts as flat as far as they reach.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Relief<'a> {
    pub map: &'a HeightMap,
    /// Height of the map's unit [m].
    pub scale: f32,
    /// Of the map's coordinates, in world space.
    pub gradients: Gradients,
    /// Unit normal of the surface under the bumps.
    pub n: Vec3,
}

/// Parts of a texel that a step along a ray crosses: the field is bilinear within a texel.
const STEPS_PER_TEXEL: f32 = 4.0;

/// Most steps of a ray: beyond so many texels, however often a map repeats, nothing rises higher than what was passed.
const MOST_STEPS: u32 = 1 << 15;

impl Relief<'_> {
    /// Unit normal of the bumps at a place of the map.
    pub fn normal(&self, uv: Vec2) -> Vec3 {
        let rise = self.gradients.rise(self.scale * self.map.slope(uv));
        (self.n - rise).try_normalize().unwrap_or(self.n)
    }

    /// Where a ray from the bumps at `uv` towards the unit vector `direction` first meets them again.
    pub fn hit(&self, uv: Vec2, direction: Vec3) -> Option<Vec2> {
        let size = Vec2::from(self.map.size().map(|side| side as f32));
        let per_metre = Vec2::new(self.gradients.u.dot(direction), self.gradients.v.dot(direction));
        let rises = self.n.dot(direction);
        let texels = (per_metre * size).abs().max_element();
        if texels <= 0.0 {
            return None;
        }
        let step = 1.0 / (STEPS_PER_TEXEL * texels);
        let [low, high] = self.map.range().map(|height| self.scale * height);
        let highest = low.max(high);
        let start = self.scale * self.map.at(uv);
        let longest = (STEPS_PER_TEXEL * 2.0 * size.element_sum()).min(MOST_STEPS as f32) as u32;
        let ends = self.map.wrap().map(|wrap| wrap == Wrap::ClampToEdge);
        // The first step leaves the texel's own patch: rounding does not count as a hit.
        let tolerance = 1e-5 * (highest - low.min(high)).max(step);
        let mut above = 0.0;
        for i in 1..=longest {
            let t = i as f32 * step;
            let z = start + t * rises;
            if z > highest {
                return None;
            }
            let place = uv + t * per_metre;
            let outside = |value: f32| !(0.0..=1.0).contains(&value);
            if (ends[0] && outside(place.x)) || (ends[1] && outside(place.y)) {
                return None;
            }
            let gap = z - self.scale * self.map.at(place);
            if gap < -tolerance {
                let share = if above > 0.0 { above / (above - gap) } else { 0.0 };
                return Some(place - (1.0 - share) * step * per_metre);
            }
            above = gap;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wall 1 m high and 0.1 m wide every metre of a repeating square, whose coordinates are metres.
    fn walls() -> HeightMap {
        let values = (0..100).map(|i| if i < 10 { 1.0 } else { 0.0 }).collect();
        HeightMap::new(100, 1, values, [Wrap::Repeat; 2]).unwrap()
    }

    #[test]
    fn a_wall_hides_what_is_below_its_edge() {
        let map = walls();
        let relief =
            Relief { map: &map, scale: 1.0, gradients: Gradients { u: Vec3::X, v: Vec3::Y }, n: Vec3::Z };
        // From half-way, 0.45 m before the next wall's face and 0.4 m behind the last one's.
        let from = Vec2::new(0.55, 0.5);
        for (elevation, is_hidden) in [(0.5f32, true), (1.1, true), (1.2, false)] {
            let (sine, cosine) = elevation.sin_cos();
            let hit = relief.hit(from, Vec3::new(cosine, 0.0, sine));
            assert_eq!(hit.is_some(), is_hidden, "{elevation}");
            if let Some(hit) = hit {
                assert!((hit.x - 1.0).abs() < 0.02, "{hit}");
            }
        }
        // Along the walls, and into the ground.
        assert_eq!(relief.hit(from, Vec3::new(0.0, 0.8, 0.6)), None);
        assert!(relief.hit(from, Vec3::new(0.6, 0.0, -0.8)).is_some_and(|hit| hit.distance(from) < 0.01));
        // Twice as long on the surface: half as steep.
        let long = Relief { gradients: Gradients { u: 0.5 * Vec3::X, v: Vec3::Y }, ..relief };
        assert!(long.hit(from, Vec3::new(0.8f32.cos(), 0.0, 0.8f32.sin())).is_some());
        assert_eq!(long.hit(from, Vec3::new(1.0f32.cos(), 0.0, 1.0f32.sin())), None);
    }
}
