use glam::{DVec2, DVec3, Vec2, Vec3};
use gnomon_envmap::{CubeMap, Equirect};
use gnomon_image::{LUMINANCE, RgbImage};
use rayon::prelude::*;

use crate::DistantLight;

/// Flux of an environment on the texels of six cube faces.
pub(super) struct Faces {
    /// Texels along the edge of a face.
    pub(super) size: usize,
    /// Solid angle [sr] of each texel, row by row; the same on every face.
    pub(super) solid_angle: Vec<f64>,
    /// Flux [radiance x sr] of each texel of the six faces, in the order and orientation of [`CubeMap`].
    pub(super) flux: [Vec<DVec3>; 6],
}

/// Texels from `min` up to but without `max`, columns and rows from the top left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct TexelRect {
    pub(super) min: [usize; 2],
    pub(super) max: [usize; 2],
}

impl Faces {
    pub(super) fn new(map: &Equirect, size: usize) -> Self {
        let reduced = reduced(map, 8 * size);
        let cube = CubeMap::from_equirect(reduced.as_ref().unwrap_or(map), size as u32);
        let solid_angle: Vec<f64> =
            (0..size * size).map(|i| cube.texel_solid_angle((i % size) as u32, (i / size) as u32)).collect();
        let flux = cube.faces().each_ref().map(|face| {
            face.texels().iter().zip(&solid_angle).map(|(texel, sr)| texel.as_dvec3() * *sr).collect()
        });
        Self { size, solid_angle, flux }
    }

    /// A copy with the flux of one face; the others hold no texels.
    pub(super) fn one_face(&self, face: usize) -> Self {
        let flux = std::array::from_fn(|i| if i == face { self.flux[i].clone() } else { Vec::new() });
        Self { size: self.size, solid_angle: self.solid_angle.clone(), flux }
    }

    /// Mean radiance of one face.
    pub(super) fn mean_radiance(&self, face: usize) -> DVec3 {
        self.flux[face].iter().sum::<DVec3>() / self.solid_angle.iter().sum::<f64>()
    }

    /// Flux [radiance x sr] of the texels of a rectangle.
    pub(super) fn rect_flux(&self, face: usize, rect: TexelRect) -> DVec3 {
        rect.texels(self.size).map(|texel| self.flux[face][texel]).sum()
    }

    /// A light over exactly these texels.
    pub(super) fn light(&self, face: usize, rect: TexelRect, flux: DVec3) -> DistantLight {
        let point = |x: f32, y: f32| CubeMap::point_on_face(face, Vec2::new(x, y)).as_dvec3();
        let forward = point(0.0, 0.0);
        // Rows run down, the light's second axis runs up.
        let frame = [point(1.0, 0.0) - forward, forward - point(0.0, 1.0), forward];
        let edge = |index: usize| 2.0 * index as f64 / self.size as f64 - 1.0;
        let min = DVec2::new(edge(rect.min[0]), -edge(rect.max[1]));
        let max = DVec2::new(edge(rect.max[0]), -edge(rect.min[1]));
        DistantLight::rectangle(frame, min, max, flux)
    }

    /// Angular width and height [rad] of a rectangle, along the face's axes.
    pub(super) fn extent(&self, rect: TexelRect) -> [f64; 2] {
        let angle = |index: usize| (2.0 * index as f64 / self.size as f64 - 1.0).atan();
        [0, 1].map(|axis| angle(rect.max[axis]) - angle(rect.min[axis]))
    }
}

impl TexelRect {
    /// The whole of a face.
    pub(super) fn face(size: usize) -> Self {
        Self { min: [0, 0], max: [size, size] }
    }

    /// Index of every texel on a face with `size` texels along its edge.
    pub(super) fn texels(self, size: usize) -> impl Iterator<Item = usize> {
        (self.min[1]..self.max[1]).flat_map(move |y| (self.min[0]..self.max[0]).map(move |x| y * size + x))
    }

    /// The parts below and from texel `at` on along an axis.
    pub(super) fn split(self, axis: usize, at: usize) -> [Self; 2] {
        let (mut low, mut high) = (self, self);
        low.max[axis] = at;
        high.min[axis] = at;
        [low, high]
    }
}

/// The map averaged over blocks of whole texels, at least `least_width` wide, where that is smaller: resampling it to a
/// cube takes time for every texel, and twice a face's resolution is enough.
fn reduced(map: &Equirect, least_width: usize) -> Option<Equirect> {
    let (width, height) = (map.width(), map.height());
    let divides = |block: &u32| width.is_multiple_of(*block) && height.is_multiple_of(*block);
    let block = (2..=width / least_width as u32).rev().find(divides)?;
    let solid_angle: Vec<f64> = (0..height).map(|y| map.texel_solid_angle(y)).collect();
    let texels: Vec<Vec3> = (0..height / block)
        .into_par_iter()
        .flat_map_iter(|row| {
            let rows = row * block..(row + 1) * block;
            let weight = f64::from(block) * rows.clone().map(|y| solid_angle[y as usize]).sum::<f64>();
            let solid_angle = &solid_angle;
            (0..width / block).map(move |column| {
                let columns = column * block..(column + 1) * block;
                let flux: DVec3 = rows
                    .clone()
                    .map(|y| {
                        let sum: DVec3 = columns.clone().map(|x| map.radiance().get(x, y).as_dvec3()).sum();
                        sum * solid_angle[y as usize]
                    })
                    .sum();
                (flux / weight).as_vec3()
            })
        })
        .collect();
    RgbImage::from_texels(width / block, height / block, texels).map(Equirect::new)
}

/// Luminance of linear RGB in double precision.
pub(super) fn luminance(rgb: DVec3) -> f64 {
    rgb.dot(LUMINANCE.as_dvec3())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn averaging_blocks_keeps_the_flux() {
        let map = Equirect::new(RgbImage::from_fn(96, 48, |x, y| {
            Vec3::new(x as f32, y as f32, (x * y % 7) as f32)
        }));
        let small = reduced(&map, 20).unwrap();
        assert_eq!((small.width(), small.height()), (24, 12));
        assert!((small.flux() - map.flux()).length() < 1e-6 * map.flux().length());
        assert!(reduced(&map, 60).is_none());
    }

    #[test]
    fn a_texel_light_points_at_its_texel_and_has_its_solid_angle() {
        let map = Equirect::new(RgbImage::filled(16, 8, Vec3::ONE));
        let cube = CubeMap::from_equirect(&map, 8);
        let faces = Faces::new(&map, 8);
        for face in 0..6 {
            for (x, y) in [(0, 0), (7, 2), (3, 5)] {
                let light = faces.light(face, TexelRect { min: [x, y], max: [x + 1, y + 1] }, DVec3::ONE);
                assert!(light.contains(cube.texel_direction(face, x as u32, y as u32)));
                let expected = faces.solid_angle[y * 8 + x];
                assert!((f64::from(light.solid_angle) / expected - 1.0).abs() < 1e-6);
            }
        }
    }
}
