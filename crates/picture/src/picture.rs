use glam::Vec3;

/// Rec. 709 luminance weights of linear RGB (ITU-R BT.709-6, section 3).
pub const LUMINANCE: Vec3 = Vec3::new(0.2126, 0.7152, 0.0722);

/// CIE XYZ to linear Rec. 709 (D65): the inverse of IEC 61966-2-1, equation 7. Colours out of gamut come out negative.
pub fn rec709_from_xyz(xyz: Vec3) -> Vec3 {
    Vec3::new(3.240_97, -0.969_243_6, 0.055_630_08) * xyz.x
        + Vec3::new(-1.537_383_2, 1.875_967_5, -0.203_976_96) * xyz.y
        + Vec3::new(-0.498_610_76, 0.041_555_06, 1.056_971_5) * xyz.z
}

/// A picture of linear Rec. 709 radiance: row-major, top row first.
#[derive(Clone, Debug, PartialEq)]
pub struct RgbImage {
    width: u32,
    height: u32,
    texels: Vec<Vec3>,
}

impl RgbImage {
    /// A `width` x `height` picture with every texel equal to `value`.
    pub fn filled(width: u32, height: u32, value: Vec3) -> Self {
        Self { width, height, texels: vec![value; width as usize * height as usize] }
    }

    /// A picture whose texel at column `x`, row `y` is `f(x, y)`.
    pub fn from_fn(width: u32, height: u32, mut f: impl FnMut(u32, u32) -> Vec3) -> Self {
        let mut texels = Vec::with_capacity(width as usize * height as usize);
        for y in 0..height {
            for x in 0..width {
                texels.push(f(x, y));
            }
        }
        Self { width, height, texels }
    }

    /// A picture over existing texels; `None` unless there are exactly `width * height` of them.
    pub fn from_texels(width: u32, height: u32, texels: Vec<Vec3>) -> Option<Self> {
        (texels.len() == width as usize * height as usize).then_some(Self { width, height, texels })
    }

    /// Width in texels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Height in texels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Texel at column `x`, row `y`, counted from the top left.
    pub fn get(&self, x: u32, y: u32) -> Vec3 {
        self.texels[self.index(x, y)]
    }

    /// The same texel, to change it.
    pub fn get_mut(&mut self, x: u32, y: u32) -> &mut Vec3 {
        let index = self.index(x, y);
        &mut self.texels[index]
    }

    /// All texels, row by row from the top.
    pub fn texels(&self) -> &[Vec3] {
        &self.texels
    }

    /// The same texels, to change them.
    pub fn texels_mut(&mut self) -> &mut [Vec3] {
        &mut self.texels
    }

    /// The texels of row `y`.
    pub fn row(&self, y: u32) -> &[Vec3] {
        let width = self.width as usize;
        &self.texels[y as usize * width..][..width]
    }

    /// The same, to change them.
    pub fn row_mut(&mut self, y: u32) -> &mut [Vec3] {
        let width = self.width as usize;
        &mut self.texels[y as usize * width..][..width]
    }

    fn index(&self, x: u32, y: u32) -> usize {
        debug_assert!(x < self.width && y < self.height);
        y as usize * self.width as usize + x as usize
    }
}
