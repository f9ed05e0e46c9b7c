use glam::{DVec3, Vec2, Vec3};
use gnomon_picture::RgbImage;
use rayon::prelude::*;

use crate::Equirect;
use crate::grid::{CubeGrid, EquirectGrid, Patches, Sampling};
use crate::transfer::Transfer;

/// A cube map of incoming radiance around the origin: faces `+x -x +y -y +z -z`, each as seen from inside, in OpenEXR's
/// orientation (`ImfEnvmap`). Texels stand for the mean radiance over their area.
#[derive(Clone, Debug, PartialEq)]
pub struct CubeMap {
    size: u32,
    faces: [RgbImage; 6],
}

impl CubeMap {
    /// Name of each face: the axis through its centre.
    pub const FACE_NAMES: [&str; 6] = ["+x", "-x", "+y", "-y", "+z", "-z"];

    /// A cube map over six square pictures of one size; `None` if they are not that.
    pub fn new(faces: [RgbImage; 6]) -> Option<Self> {
        let size = faces[0].width();
        let fits = size > 0 && faces.iter().all(|face| face.width() == size && face.height() == size);
        fits.then_some(Self { size, faces })
    }

    /// Resamples an equirect map to `size` x `size` texels a face (at least 1). Each channel's flux is kept.
    pub fn from_equirect(map: &Equirect, size: u32) -> Self {
        let size = size.max(1);
        let grid = EquirectGrid::new(map.width(), map.height());
        Self::resampled(&grid, map.radiance().texels(), size)
    }

    /// Resamples the texels of any map.
    pub(crate) fn resampled(map: &impl Patches, texels: &[Vec3], size: u32) -> Self {
        let texels = Transfer::new(map, &CubeGrid::new(size, Sampling::Areas)).to_cube(texels);
        let start = |face: usize, y: u32| (face * size as usize + y as usize) * size as usize;
        let face = |face: usize| RgbImage::from_fn(size, size, |x, y| texels[start(face, y) + x as usize]);
        Self { size, faces: std::array::from_fn(face) }
    }

    /// Texels along the edge of a face.
    pub fn size(&self) -> u32 {
        self.size
    }

    /// The faces, in the order of [`CubeMap::FACE_NAMES`].
    pub fn faces(&self) -> &[RgbImage; 6] {
        &self.faces
    }

    /// Point on the cube [-1, 1]^3 at `position` on a face: x to the right, y down, both in [-1, 1]. Its length is not 1.
    pub fn point_on_face(face: usize, position: Vec2) -> Vec3 {
        let Vec2 { x: s, y: t } = position;
        match face {
            0 => Vec3::new(1.0, -t, s),
            1 => Vec3::new(-1.0, -t, -s),
            2 => Vec3::new(s, 1.0, -t),
            3 => Vec3::new(s, -1.0, t),
            4 => Vec3::new(-s, -t, 1.0),
            _ => Vec3::new(s, -t, -1.0),
        }
    }

    /// Face that a direction (any length but 0) passes through, and where: the inverse of [`CubeMap::point_on_face`].
    pub fn face_and_position(direction: Vec3) -> (usize, Vec2) {
        let (d, a) = (direction, direction.abs());
        if a.x >= a.y && a.x >= a.z {
            let scale = 1.0 / a.x;
            if d.x >= 0.0 { (0, Vec2::new(d.z, -d.y) * scale) } else { (1, Vec2::new(-d.z, -d.y) * scale) }
        } else if a.y >= a.z {
            let scale = 1.0 / a.y;
            if d.y >= 0.0 { (2, Vec2::new(d.x, -d.z) * scale) } else { (3, Vec2::new(d.x, d.z) * scale) }
        } else {
            let scale = 1.0 / a.z;
            if d.z >= 0.0 { (4, Vec2::new(-d.x, -d.y) * scale) } else { (5, Vec2::new(d.x, -d.y) * scale) }
        }
    }

    /// Unit direction through the centre of texel `(x, y)` of a face.
    pub fn texel_direction(&self, face: usize, x: u32, y: u32) -> Vec3 {
        let position = (Vec2::new(x as f32, y as f32) + 0.5) * (2.0 / self.size as f32) - 1.0;
        Self::point_on_face(face, position).normalize()
    }

    /// Solid angle [sr] of the texel at `(x, y)`, the same on every face; all texels together have 4 pi.
    pub fn texel_solid_angle(&self, x: u32, y: u32) -> f64 {
        let edge = |index: u32| 2.0 * f64::from(index) / f64::from(self.size) - 1.0;
        face_solid_angle([edge(x), edge(x + 1)], [edge(y), edge(y + 1)])
    }

    /// Bilinear radiance towards a direction (any length but 0), without a seam: beyond an edge come the texels of the
    /// next face, and at a corner the missing fourth texel is the mean of the other three.
    pub fn lookup(&self, direction: Vec3) -> Vec3 {
        let (face, position) = Self::face_and_position(direction);
        let at = (position + 1.0) * (0.5 * self.size as f32) - 0.5;
        let base = at.floor();
        let fraction = at - base;
        let (x, y) = (base.x as i64, base.y as i64);
        let texels = [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)].map(|(x, y)| self.beyond(face, x, y));
        let known = texels.iter().flatten().count().max(1) as f32;
        let mean = texels.iter().flatten().sum::<Vec3>() / known;
        let [a, b, c, d] = texels.map(|texel| texel.unwrap_or(mean));
        a.lerp(b, fraction.x).lerp(c.lerp(d, fraction.x), fraction.y)
    }

    /// Texel of a face or, one step outside, of its neighbour; `None` past a corner.
    fn beyond(&self, face: usize, x: i64, y: i64) -> Option<Vec3> {
        let inside = 0..i64::from(self.size);
        match (inside.contains(&x), inside.contains(&y)) {
            (true, true) => Some(self.faces[face].get(x as u32, y as u32)),
            (false, false) => None,
            _ => {
                // The centre of the texel that would continue the face's plane, seen on the face next to it.
                let position = (Vec2::new(x as f32, y as f32) + 0.5) * (2.0 / self.size as f32) - 1.0;
                let (face, position) = Self::face_and_position(Self::point_on_face(face, position));
                let texel = (position + 1.0) * (0.5 * self.size as f32);
                let last = self.size - 1;
                Some(self.faces[face].get((texel.x as u32).min(last), (texel.y as u32).min(last)))
            }
        }
    }

    /// Flux [radiance x sr] of the whole map, channel by channel.
    pub fn flux(&self) -> DVec3 {
        (0..self.size)
            .into_par_iter()
            .map(|y| {
                let texel = |x: u32| {
                    let sum: DVec3 = self.faces.iter().map(|face| face.get(x, y).as_dvec3()).sum();
                    sum * self.texel_solid_angle(x, y)
                };
                (0..self.size).map(texel).sum::<DVec3>()
            })
            .collect::<Vec<_>>()
            .into_iter()
            .sum()
    }

    /// All texels, face by face, row by row.
    pub(crate) fn texels(&self) -> Vec<Vec3> {
        self.faces.iter().flat_map(|face| face.texels().iter().copied()).collect()
    }
}

/// Solid angle of the rectangle `x` times `y` on a face of the cube [-1, 1]^3: the corners' signed
/// `atan(x y / sqrt(x^2 + y^2 + 1))`, in closed form.
pub(crate) fn face_solid_angle(x: [f64; 2], y: [f64; 2]) -> f64 {
    let corner = |x: f64, y: f64| (x * y).atan2((x * x + y * y + 1.0).sqrt());
    corner(x[1], y[1]) - corner(x[0], y[1]) - corner(x[1], y[0]) + corner(x[0], y[0])
}
