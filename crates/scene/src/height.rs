//! Heights over a surface: relief that shades, casts shadows on itself and scatters light, on meshes that stay as they are.

use glam::{Affine2, Mat2, Vec2, Vec3};

use crate::{Scene, Wrap};

/// Index into [`crate::Scene::height_maps`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct HeightMapId(pub usize);

/// Heights of a rectangle, in a unit of the map's own; between the texels' centres they are bilinear.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightMap {
    width: u32,
    height: u32,
    /// Row by row from the top.
    values: Vec<f32>,
    wrap: [Wrap; 2],
    /// Lowest and highest.
    range: [f32; 2],
}

/// Heights as a material uses them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Height {
    /// Which map.
    pub map: HeightMapId,
    /// Coordinates in the map from those of the mesh.
    pub uv_from_mesh: Affine2,
    /// Which of the mesh's two coordinate sets (0 or 1).
    pub set: usize,
    /// Height of the map's unit [m].
    pub scale: f32,
}

impl HeightMap {
    /// Heights row by row from the top.
    ///
    /// # Errors
    /// A line that tells what is wrong: no texels, another number of them, or heights that are not finite.
    pub fn new(width: u32, height: u32, values: Vec<f32>, wrap: [Wrap; 2]) -> Result<Self, String> {
        if width == 0 || height == 0 || values.len() as u64 != u64::from(width) * u64::from(height) {
            return Err(format!("{} heights for {width} x {height} texels", values.len()));
        }
        if let Some(bad) = values.iter().position(|value| !value.is_finite()) {
            let (x, y) = (bad % width as usize, bad / width as usize);
            return Err(format!("the height in column {x} of row {y} is {}", values[bad]));
        }
        // Differences of heights must be finite, too.
        if let Some(bad) = values.iter().find(|value| value.abs() > 1e18) {
            return Err(format!("a height of {bad:e} is out of range"));
        }
        Ok(Self::of(width, height, values, wrap))
    }

    /// Width and height in texels.
    pub fn size(&self) -> [u32; 2] {
        [self.width, self.height]
    }

    /// Addressing along u and v.
    pub fn wrap(&self) -> [Wrap; 2] {
        self.wrap
    }

    /// Lowest and highest.
    pub fn range(&self) -> [f32; 2] {
        self.range
    }

    /// The map in whole blocks of texels, averaged, so that no side is longer than `side`.
    #[must_use]
    pub fn at_most(&self, side: u32) -> Self {
        let blocks = self.size().map(|size| size.div_ceil(side.max(1)));
        let [width, height] = [self.width.div_ceil(blocks[0]), self.height.div_ceil(blocks[1])];
        let mean = |x: u32, y: u32| {
            let (x, y) = (x * blocks[0], y * blocks[1]);
            let (right, bottom) = ((x + blocks[0]).min(self.width), (y + blocks[1]).min(self.height));
            let texels = (y..bottom).flat_map(|y| (x..right).map(move |x| (x, y)));
            let sum: f64 = texels.map(|(x, y)| f64::from(self.values[(y * self.width + x) as usize])).sum();
            (sum / f64::from((right - x) * (bottom - y))) as f32
        };
        let values = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| mean(x, y));
        Self::of(width, height, values.collect(), self.wrap)
    }

    fn of(width: u32, height: u32, values: Vec<f32>, wrap: [Wrap; 2]) -> Self {
        let range = values.iter().fold([f32::MAX, f32::MIN], |[low, high], &v| [low.min(v), high.max(v)]);
        Self { width, height, values, wrap, range }
    }

    /// Height of a texel, which may lie outside the map.
    pub fn texel(&self, x: i64, y: i64) -> f32 {
        let (x, y) = (self.wrap[0].texel(x, self.width), self.wrap[1].texel(y, self.height));
        self.values[y * self.width as usize + x]
    }

    /// Slope at a texel's centre along u and v, per texel: of the bilinear heights the mean of both sides.
    pub fn texel_slope(&self, x: i64, y: i64) -> Vec2 {
        0.5 * Vec2::new(
            self.texel(x + 1, y) - self.texel(x - 1, y),
            self.texel(x, y + 1) - self.texel(x, y - 1),
        )
    }

    /// Height at `uv`, which is (0, 0) at the map's top left corner and (1, 1) at its bottom right; a coordinate that is not finite counts
    /// as 0.
    pub fn at(&self, uv: Vec2) -> f32 {
        let [[x, fx], [y, fy]] = self.place(uv);
        let row = |y: i64| {
            let (left, right) = (self.texel(x as i64, y), self.texel(x as i64 + 1, y));
            left + fx * (right - left)
        };
        let (top, bottom) = (row(y as i64), row(y as i64 + 1));
        top + fy * (bottom - top)
    }

    /// Slope at `uv`, bilinear between those of the texels, in the map's unit over its width and over its height.
    pub fn slope(&self, uv: Vec2) -> Vec2 {
        let [[x, fx], [y, fy]] = self.place(uv);
        let row = |y: i64| self.texel_slope(x as i64, y).lerp(self.texel_slope(x as i64 + 1, y), fx);
        row(y as i64).lerp(row(y as i64 + 1), fy) * Vec2::new(self.width as f32, self.height as f32)
    }

    /// Column and row of the texel above and left of a place, and the place's shares of the next ones.
    fn place(&self, uv: Vec2) -> [[f32; 2]; 2] {
        let along = |value: f32, size: u32| {
            let texels = if value.is_finite() { value * size as f32 - 0.5 } else { -0.5 };
            // Beyond this there are no parts of texels.
            let texels = texels.clamp(-1e9, 1e9);
            [texels.floor(), texels - texels.floor()]
        };
        [along(uv.x, self.width), along(uv.y, self.height)]
    }
}

/// How coordinates lie on a surface: how a point's u and v change along the surface [1/m].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gradients {
    /// Of u.
    pub u: Vec3,
    /// Of v.
    pub v: Vec3,
}

impl Gradients {
    /// On a triangle with these corners [m] and coordinates, in the plane of the unit normal `n`, which may be a smooth one (Mikkelsen,
    /// "Bump Mapping Unparametrized Surfaces on the GPU", 2010). `None` where the triangle has no area in that plane.
    pub fn new(corners: [Vec3; 3], uvs: [Vec2; 3], n: Vec3) -> Option<Self> {
        let [a, b, c] = corners;
        let (e1, e2) = (b - a, c - a);
        let (across, along) = (e2.cross(n), n.cross(e1));
        let determinant = e1.dot(across);
        let (d1, d2) = (uvs[1] - uvs[0], uvs[2] - uvs[0]);
        let gradient = |d1: f32, d2: f32| (d1 * across + d2 * along) / determinant;
        let gradients = Self { u: gradient(d1.x, d2.x), v: gradient(d1.y, d2.y) };
        (determinant != 0.0 && gradients.u.is_finite() && gradients.v.is_finite()).then_some(gradients)
    }

    /// How something rises along the surface that changes so along u and v: metres a metre for heights in metres.
    pub fn rise(&self, slope: Vec2) -> Vec3 {
        slope.x * self.u + slope.y * self.v
    }
}

impl Height {
    /// Coordinates in the map for those of the mesh.
    pub fn transform(&self, mesh_uv: Vec2) -> Vec2 {
        self.uv_from_mesh.transform_point2(mesh_uv)
    }
}

/// Least share of a normal along the smooth one: a normal map cannot tilt further where heights bend it, too.
const LEAST_COSINE: f32 = 0.05;

/// A unit normal, which a normal map may have bent away from the smooth one, bent further by heights that rise so along the surface
/// ([`Gradients::rise`]): slopes add (Blinn 1978).
pub fn bent_by_heights(normal: Vec3, smooth: Vec3, rise: Vec3) -> Vec3 {
    (normal / normal.dot(smooth).max(LEAST_COSINE) - rise).try_normalize().unwrap_or(normal)
}

impl Scene {
    /// Metres along u and along v of the map of a material's heights, as its meshes lie in the current pose: means over their area. `None`
    /// where no mesh has such coordinates.
    pub fn height_extent(&self, material: usize) -> Option<Vec2> {
        let height = self.materials.get(material)?.height?;
        let mut sums = [Vec2::ZERO, Vec2::ZERO];
        for placed in self.instances() {
            let mesh = &self.meshes[placed.mesh.0];
            if mesh.material.is_none_or(|id| id.0 != material) || mesh.uvs[height.set].is_empty() {
                continue;
            }
            for triangle in &mesh.triangles {
                let indices = triangle.map(|index| index as usize);
                let corners = indices.map(|i| placed.world_from_mesh.transform_point3(mesh.positions[i]));
                let uvs = indices.map(|i| height.transform(mesh.uvs[height.set][i]));
                // dP/duv is the inverse of duv/dP.
                let (e1, e2) = (corners[1] - corners[0], corners[2] - corners[0]);
                let area = 0.5 * e1.cross(e2).length();
                let per_uv = Mat2::from_cols(uvs[1] - uvs[0], uvs[2] - uvs[0]).inverse();
                let [u, v] =
                    [per_uv.x_axis, per_uv.y_axis].map(|weights| (weights.x * e1 + weights.y * e2).length());
                if area > 0.0 && (u + v + area).is_finite() {
                    sums[0] += area * Vec2::new(u, v);
                    sums[1] += Vec2::splat(area);
                }
            }
        }
        let extent = sums[0] / sums[1];
        (extent.is_finite() && extent.min_element() > 0.0).then_some(extent)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn odd_heights_are_refused_with_their_place() {
        let wrap = [Wrap::Repeat; 2];
        let nan = HeightMap::new(2, 2, vec![0.0, 1.0, 2.0, f32::NAN], wrap).unwrap_err();
        assert_eq!(nan, "the height in column 1 of row 1 is NaN");
        assert!(HeightMap::new(2, 2, vec![0.0; 3], wrap).is_err());
        assert!(HeightMap::new(0, 0, Vec::new(), wrap).is_err());
        assert!(HeightMap::new(1, 1, vec![f32::MAX], wrap).is_err());
    }

    #[test]
    fn slopes_of_a_ramp_and_of_a_single_texel() {
        let values = (0..16).map(|i| (i % 4) as f32).collect();
        let ramp = HeightMap::new(4, 4, values, [Wrap::ClampToEdge; 2]).unwrap();
        // One a texel, four over the map.
        assert_eq!(ramp.slope(Vec2::splat(0.5)), Vec2::new(4.0, 0.0));
        assert_eq!(ramp.at(Vec2::new(0.5, 0.3)), 1.5);
        let one = HeightMap::new(1, 1, vec![3.0], [Wrap::Repeat; 2]).unwrap();
        assert_eq!((one.slope(Vec2::new(0.3, 7.0)), one.at(Vec2::NAN)), (Vec2::ZERO, 3.0));
    }

    #[test]
    fn blocks_are_averaged() {
        let values = (0..10).map(|i| i as f32).collect();
        let map = HeightMap::new(5, 2, values, [Wrap::Repeat; 2]).unwrap();
        let small = map.at_most(3);
        assert_eq!(small.size(), [3, 2]);
        assert_eq!((small.texel(0, 0), small.texel(2, 1)), (0.5, 9.0));
    }

    #[test]
    fn gradients_of_stretched_and_mirrored_coordinates() {
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let uvs = [Vec2::ZERO, Vec2::new(-0.5, 0.0), Vec2::new(0.0, 4.0)];
        let gradients = Gradients::new(corners, uvs, Vec3::Z).unwrap();
        assert_eq!((gradients.u, gradients.v), (Vec3::new(-0.5, 0.0, 0.0), Vec3::new(0.0, 4.0, 0.0)));
        assert_eq!(Gradients::new([Vec3::ZERO; 3], uvs, Vec3::Z), None);
        // A metre up over the map's width of 2 m, seen from the other side.
        let bent = bent_by_heights(Vec3::Z, Vec3::Z, gradients.rise(Vec2::X));
        assert!((bent - Vec3::new(0.5, 0.0, 1.0).normalize()).length() < 1e-6);
    }
}
