//! Equirect to equirect, where rows and columns separate and overlaps are exact; and equirect from a cube map.

use std::f64::consts::{PI, TAU};

use glam::{DVec3, Vec3};
use gnomon_picture::RgbImage;
use rayon::prelude::*;

use crate::grid::{CubeGrid, EquirectGrid, Sampling};
use crate::transfer::Transfer;
use crate::{CubeMap, Equirect};

/// Distance from a whole number of texels below which a rotation moves texels without blending them.
const WHOLE_TEXEL: f64 = 1e-3;

/// Texels of a picture in row-major order as an equirect map.
fn map(width: u32, height: u32, texels: &[Vec3]) -> Equirect {
    Equirect::new(RgbImage::from_fn(width, height, |x, y| texels[y as usize * width as usize + x as usize]))
}

/// Resamples the texels of a cube's faces.
pub(crate) fn equirect_from_faces(cube: &CubeGrid, texels: &[Vec3], width: u32, height: u32) -> Equirect {
    let transfer = Transfer::new(&EquirectGrid::new(width, height), cube);
    map(width, height, &transfer.to_map(texels))
}

/// For each of `count` equal cells the source cells that it overlaps, with the shares of its measure; `measure` grows
/// from the first edge, 0, to the last, 1.
fn shares(source: u32, sampling: Sampling, count: u32, measure: impl Fn(f64) -> f64) -> Vec<Vec<(u32, f64)>> {
    let one = |cell: u32| {
        let edge = |index: u32| f64::from(index) / f64::from(count);
        let (low, high) = (edge(cell), edge(cell + 1));
        let whole = measure(high) - measure(low);
        let (first, last) = sampling.range(source);
        let at = |edge: f64| first + edge * (last - first);
        (at(low).floor() as u32..(at(high).ceil() as u32).min(source))
            .map(|index| {
                let (a, b) = (sampling.edge(index, source), sampling.edge(index + 1, source));
                let (a, b) = (a.max(low), b.min(high));
                (index, if b > a { (measure(b) - measure(a)) / whole } else { 0.0 })
            })
            .collect()
    };
    (0..count).map(one).collect()
}

/// For each column and row of `width` x `height` texels what they overlap of a latitude-longitude picture, with the shares of it.
pub(crate) fn shares_of_equirect(
    picture: [u32; 2],
    sampling: Sampling,
    [width, height]: [u32; 2],
) -> [Vec<Vec<(u32, f64)>>; 2] {
    let columns = shares(picture[0], sampling, width, |u| u);
    // (1 - cos(theta)) / 2, without its loss of digits near 0.
    let rows = shares(picture[1], sampling, height, |v| (0.5 * PI * v).sin().powi(2));
    [columns, rows]
}

/// Resamples a latitude-longitude picture to `width` x `height` texels by exact overlap.
pub(crate) fn equirect_from_picture(
    picture: &RgbImage,
    sampling: Sampling,
    width: u32,
    height: u32,
) -> Equirect {
    let [columns, rows] = shares_of_equirect([picture.width(), picture.height()], sampling, [width, height]);
    let row = |sources: &Vec<(u32, f64)>| {
        let mut sum = vec![DVec3::ZERO; picture.width() as usize];
        for &(y, share) in sources {
            for (x, sum) in (0..).zip(&mut sum) {
                *sum += picture.get(x, y).as_dvec3() * share;
            }
        }
        let texel = |shares: &Vec<(u32, f64)>| {
            shares.iter().map(|&(x, share)| sum[x as usize] * share).sum::<DVec3>().as_vec3()
        };
        columns.iter().map(texel).collect::<Vec<Vec3>>()
    };
    let texels: Vec<Vec3> = rows.par_iter().map(row).collect::<Vec<_>>().concat();
    map(width, height, &texels)
}

impl Equirect {
    /// Resamples a cube map to `width` x `height` texels (at least 1). Each channel's flux is kept.
    pub fn from_cube(cube: &CubeMap, width: u32, height: u32) -> Self {
        let grid = CubeGrid::new(cube.size(), Sampling::Areas);
        equirect_from_faces(&grid, &cube.texels(), width.max(1), height.max(1))
    }

    /// The same map with `width` x `height` texels (at least 1): each is the mean of what it covers, by exact solid angle.
    /// Flux is kept, a constant stays constant.
    pub fn resized(&self, width: u32, height: u32) -> Self {
        let (width, height) = (width.max(1), height.max(1));
        if (width, height) == (self.width(), self.height()) {
            return self.clone();
        }
        equirect_from_picture(self.radiance(), Sampling::Areas, width, height)
    }

    /// The environment turned about +y by `yaw` [rad], right-hand rule: what was seen towards `d` is then seen towards
    /// `rotate_y(yaw) * d`. Whole texels move exactly; otherwise each texel becomes the mean of what it covers. Flux is kept.
    pub fn rotated(&self, yaw: f32) -> Self {
        let width = i64::from(self.width());
        // phi of rotate_y(yaw) * d is phi - yaw: the picture moves to the left.
        let shift = f64::from(yaw).rem_euclid(TAU) / TAU * width as f64;
        let nearest = shift.round();
        let (whole, fraction) = if (shift - nearest).abs() < WHOLE_TEXEL {
            (nearest as i64, 0.0)
        } else {
            (shift.floor() as i64, shift - shift.floor())
        };
        let texel = |x: i64, y: u32| self.radiance().get(x.rem_euclid(width) as u32, y);
        let turned = RgbImage::from_fn(self.width(), self.height(), |x, y| {
            let x = i64::from(x) + whole;
            let near = texel(x, y);
            if fraction == 0.0 {
                return near;
            }
            (near.as_dvec3() * (1.0 - fraction) + texel(x + 1, y).as_dvec3() * fraction).as_vec3()
        });
        Self::new(turned)
    }
}
