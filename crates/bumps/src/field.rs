use glam::{Vec2, Vec3};
use gnomon_scene::{HeightMap, Wrap};

/// A height map at its size in the world.
#[derive(Clone, Copy, Debug)]
pub struct Field<'a> {
    /// The heights.
    pub map: &'a HeightMap,
    /// Height of the map's unit [m].
    pub scale: f32,
    /// Distance between the centres of neighbouring texels of a row, and of a column [m].
    pub spacing: Vec2,
}

impl<'a> Field<'a> {
    /// A map that lies on a surface with so many metres along its width and its height.
    pub fn new(map: &'a HeightMap, scale: f32, extent: Vec2) -> Self {
        let [width, height] = map.size();
        Self { map, scale, spacing: extent / Vec2::new(width as f32, height as f32) }
    }

    /// Width and height in texels.
    pub fn size(&self) -> [usize; 2] {
        self.map.size().map(|side| side as usize)
    }

    /// Height of a texel [m].
    pub fn texel(&self, x: i64, y: i64) -> f32 {
        self.scale * self.map.texel(x, y)
    }

    /// Height [m] at a place in texels, whose centres lie at whole numbers; `None` outside of a map that ends at its edges.
    pub fn at(&self, place: Vec2) -> Option<f32> {
        let [width, height] = self.map.size();
        let ends = self.map.wrap().map(|wrap| wrap == Wrap::ClampToEdge);
        let size = Vec2::new(width as f32, height as f32);
        let outside = |value: f32, size: f32| value < -0.5 || value > size - 0.5;
        if (ends[0] && outside(place.x, size.x)) || (ends[1] && outside(place.y, size.y)) {
            return None;
        }
        Some(self.scale * self.map.at((place + 0.5) / size))
    }

    /// Unit normal at a texel.
    pub fn normal(&self, x: i64, y: i64) -> Vec3 {
        let slope = self.scale * self.map.texel_slope(x, y) / self.spacing;
        (-slope).extend(1.0).normalize()
    }
}
