use glam::{DVec2, DVec3, Vec2};
use gnomon_envmap::{CubeMap, Equirect};
use gnomon_picture::LUMINANCE;
use rayon::prelude::*;

use crate::DistantLight;
use crate::light::rectangle_solid_angle;

/// Flux of an environment on the texels of six cube faces.
pub(super) struct Faces {
    /// Texels along the edge of a face.
    pub(super) size: usize,
    /// Solid angle [sr] of each texel, row by row; the same on every face.
    pub(super) solid_angle: Vec<f64>,
    /// Flux [radiance x sr] of each texel of the six faces, in the order and orientation of [`CubeMap`].
    pub(super) flux: [Vec<DVec3>; 6],
    /// How light lies within the same texels.
    pub(super) moments: [Vec<Moments>; 6],
}

/// Moments over directions on a face, at `s` to the right and `t` down from its centre, each in [-1, 1]: the integrals of
/// `[1, s, t, s^2, t^2]`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Moments {
    /// Weighted by luminance.
    pub(super) light: [f64; 5],
    /// Without a weight: the zeroth is the solid angle.
    pub(super) area: [f64; 5],
}

impl Moments {
    /// With so much of the light.
    pub(super) fn lit(&self, weight: f64) -> Self {
        Self { light: self.light.map(|moment| weight * moment), area: self.area }
    }

    /// `a self + b other`.
    pub(super) fn combined(&self, a: f64, other: &Self, b: f64) -> Self {
        Self {
            light: std::array::from_fn(|i| a * self.light[i] + b * other.light[i]),
            area: std::array::from_fn(|i| a * self.area[i] + b * other.area[i]),
        }
    }
}

/// Texels from `min` up to but without `max`, columns and rows from the top left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct TexelRect {
    pub(super) min: [usize; 2],
    pub(super) max: [usize; 2],
}

impl Faces {
    /// The map's flux on faces of `size` x `size` texels, by a dense regular grid of bilinear lookups: a sun keeps its flux wherever it lies
    /// among the texels, and an even map is even. Each channel is then scaled, by next to nothing, to the map's flux. A map turned by a
    /// quarter about +y gives the same texels, turned.
    pub(super) fn new(map: &Equirect, size: usize) -> Self {
        let edge = |index: usize| 2.0 * index as f64 / size as f64 - 1.0;
        let solid_angle: Vec<f64> = (0..size * size)
            .map(|i| {
                let (x, y) = (i % size, i / size);
                rectangle_solid_angle(DVec2::new(edge(x), edge(y)), DVec2::new(edge(x + 1), edge(y + 1)))
            })
            .collect();
        let sums = sampled(map, size);
        let sampled_area = sums.iter().map(|sum| sum.moments.area[0]).sum::<f64>();
        let unit = 4.0 * std::f64::consts::PI / sampled_area;
        let texels =
            |face: usize| sums[face * size * size..(face + 1) * size * size].iter().zip(&solid_angle);
        let mut flux: [Vec<DVec3>; 6] =
            std::array::from_fn(|face| texels(face).map(|(sum, sr)| sum.flux(unit, *sr)).collect());
        let moments =
            std::array::from_fn(|face| texels(face).map(|(sum, sr)| sum.moments(unit, *sr)).collect());
        let (wanted, sampled) = (map.flux(), flux.iter().flatten().sum::<DVec3>());
        let scale = DVec3::select(sampled.cmpgt(DVec3::ZERO), wanted / sampled, DVec3::ONE);
        flux.iter_mut().flatten().for_each(|texel| *texel *= scale);
        Self { size, solid_angle, flux, moments }
    }

    /// A copy with the flux of one face; the others hold no texels, and
    /// none holds moments.
    pub(super) fn one_face(&self, face: usize) -> Self {
        let flux = std::array::from_fn(|i| if i == face { self.flux[i].clone() } else { Vec::new() });
        Self {
            size: self.size,
            solid_angle: self.solid_angle.clone(),
            flux,
            moments: std::array::from_fn(|_| Vec::new()),
        }
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
        let corner = |at: [usize; 2]| DVec2::from(at.map(|index| self.edge(index)));
        Self::light_between(face, corner(rect.min), corner(rect.max), flux)
    }

    /// A light between two corners at `s` to the right and `t` down from the face's centre, the whole face being
    /// `[-1, 1]^2`.
    pub(super) fn light_between(face: usize, min: DVec2, max: DVec2, flux: DVec3) -> DistantLight {
        let point = |x: f32, y: f32| CubeMap::point_on_face(face, Vec2::new(x, y)).as_dvec3();
        let forward = point(0.0, 0.0);
        // Rows run down, the light's second axis runs up.
        let frame = [point(1.0, 0.0) - forward, forward - point(0.0, 1.0), forward];
        DistantLight::rectangle(frame, DVec2::new(min.x, -max.y), DVec2::new(max.x, -min.y), flux)
    }

    /// Place of a texel's low edge along either axis of the face, in [-1, 1].
    pub(super) fn edge(&self, index: usize) -> f64 {
        2.0 * index as f64 / self.size as f64 - 1.0
    }

    /// Angular width and height [rad] of a rectangle, along the face's axes.
    pub(super) fn extent(&self, rect: TexelRect) -> [f64; 2] {
        let angle = |index: usize| self.edge(index).atan();
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

/// Sums over the samples of one texel, up to a factor common to all.
#[derive(Clone, Copy)]
struct TexelSum {
    /// Radiance times solid angle.
    radiance: DVec3,
    moments: Moments,
    /// The least radiance of any sample.
    least: DVec3,
}

impl TexelSum {
    const EMPTY: Self = Self {
        radiance: DVec3::ZERO,
        moments: Moments { light: [0.0; 5], area: [0.0; 5] },
        least: DVec3::INFINITY,
    };

    fn combined(&self, other: &Self) -> Self {
        Self {
            radiance: self.radiance + other.radiance,
            moments: self.moments.combined(1.0, &other.moments, 1.0),
            least: self.least.min(other.least),
        }
    }

    /// The factor that makes the area of the samples the texel's solid angle `sr`.
    fn area_scale(&self, sr: f64) -> f64 {
        if self.moments.area[0] > 0.0 { sr / self.moments.area[0] } else { 0.0 }
    }

    /// Flux [radiance x sr], `unit` being the solid angle of a sample of weight 1. What all samples have in common counts by the texel's
    /// own solid angle `sr`, since a few samples more or less fall within it; what some have more counts by theirs, so that no part of a
    /// sun is lost or counted twice.
    fn flux(&self, unit: f64, sr: f64) -> DVec3 {
        let area = self.moments.area[0];
        if area > 0.0 { unit * self.radiance + self.least * (sr - unit * area) } else { DVec3::ZERO }
    }

    /// The same for the moments.
    fn moments(&self, unit: f64, sr: f64) -> Moments {
        let scale = self.area_scale(sr);
        let least = if scale > 0.0 { luminance(self.least) } else { 0.0 };
        Moments {
            light: std::array::from_fn(|i| {
                unit * self.moments.light[i] + least * (scale - unit) * self.moments.area[i]
            }),
            area: self.moments.area.map(|moment| scale * moment),
        }
    }
}

/// Samples of the map in every texel of six faces, one face after the other.
fn sampled(map: &Equirect, size: usize) -> Vec<TexelSum> {
    let (width, height) = (map.width() as usize, map.height() as usize);
    // Samples a texel, each way: at least three across the smallest texel of a face, at its corners. Their number around
    // the horizon is a multiple of 8 where the width is one of 4, so that no sample falls on the edge of two side faces.
    let density = |texels: usize| {
        let needed = (24 * size).div_ceil(texels);
        if needed == 1 && texels.is_multiple_of(8) { 1 } else { needed.next_multiple_of(2) }
    };
    let (per_column, per_row) = (density(width), density(2 * height));
    let azimuths = azimuths(width * per_column);
    let axes: [[DVec3; 3]; 6] = std::array::from_fn(|face| {
        let point = |x: f32, y: f32| CubeMap::point_on_face(face, Vec2::new(x, y)).as_dvec3();
        let forward = point(0.0, 0.0);
        [point(1.0, 0.0) - forward, point(0.0, 1.0) - forward, forward]
    });
    let polar = |row: usize| std::f64::consts::PI * row as f64 / (height * per_row) as f64;
    let band = |rows: std::ops::Range<usize>| -> Vec<TexelSum> {
        let mut sums = vec![TexelSum::EMPTY; 6 * size * size];
        for row in rows {
            let (sin, cos) = polar(row).midpoint(polar(row + 1)).sin_cos();
            let (above, down) = between_texels(row, per_row);
            for (column, [sin_phi, cos_phi]) in azimuths.iter().enumerate() {
                let (left, right) = between_texels(column, per_column);
                let radiance = map.between(left, above, Vec2::new(right, down)).as_dvec3();
                // Solid angle of the sample, up to a factor common to all.
                let weighted = radiance * sin;
                let light = luminance(weighted);
                let d = DVec3::new(sin * sin_phi, cos, -sin * cos_phi);
                let a = d.abs();
                let face = if a.y >= a.x.max(a.z) {
                    2 + usize::from(d.y < 0.0)
                } else if a.x >= a.z {
                    usize::from(d.x < 0.0)
                } else {
                    4 + usize::from(d.z < 0.0)
                };
                let [right, down, forward] = &axes[face];
                let depth = d.dot(*forward).recip();
                let (s, t) = (d.dot(*right) * depth, d.dot(*down) * depth);
                let cell = |at: f64| ((0.5 * (at + 1.0) * size as f64) as usize).min(size - 1);
                let sum = &mut sums[(face * size + cell(t)) * size + cell(s)];
                sum.radiance += weighted;
                sum.least = sum.least.min(radiance);
                for (i, power) in [1.0, s, t, s * s, t * t].into_iter().enumerate() {
                    sum.moments.light[i] += light * power;
                    sum.moments.area[i] += sin * power;
                }
            }
        }
        sums
    };
    // A fixed number of bands, so that the sums do not depend on the number of threads.
    let rows = height * per_row;
    let edge = |index: usize| index * rows / BANDS;
    let bands: Vec<Vec<TexelSum>> = (0..BANDS).into_par_iter().map(|i| band(edge(i)..edge(i + 1))).collect();
    (0..6 * size * size)
        .map(|texel| bands.iter().fold(TexelSum::EMPTY, |sum, band| sum.combined(&band[texel])))
        .collect()
}

/// Of a sample, `per_texel` of which lie along a texel: the texel whose middle comes before it, and the part of the way to the next one.
fn between_texels(sample: usize, per_texel: usize) -> (i64, f32) {
    let place = (2 * (sample % per_texel) + 1) as f32 / (2 * per_texel) as f32 - 0.5;
    let before = place < 0.0;
    ((sample / per_texel) as i64 - i64::from(before), place + f32::from(before))
}

/// Bands of rows that are sampled side by side.
const BANDS: usize = 8;

/// Sine and cosine of `count` azimuths at the middles of equal steps; where they come in quarters, each quarter repeats
/// the first one's numbers exactly.
fn azimuths(count: usize) -> Vec<[f64; 2]> {
    let at = |i: usize| {
        let (sin, cos) = (std::f64::consts::TAU * (i as f64 + 0.5) / count as f64).sin_cos();
        [sin, cos]
    };
    if !count.is_multiple_of(4) {
        return (0..count).map(at).collect();
    }
    let quarter = count / 4;
    (0..count)
        .map(|i| {
            let [sin, cos] = at(i % quarter);
            [[sin, cos], [cos, -sin], [-sin, -cos], [-cos, sin]][i / quarter]
        })
        .collect()
}

/// Luminance of linear RGB in double precision.
pub(super) fn luminance(rgb: DVec3) -> f64 {
    rgb.dot(LUMINANCE.as_dvec3())
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use gnomon_picture::RgbImage;

    use super::*;

    #[test]
    fn texels_have_the_radiance_of_their_directions_and_all_of_the_flux() {
        for (width, height) in [(1, 1), (3, 2), (64, 32), (1024, 512), (1200, 600)] {
            // Radiance that is linear in the direction's y, so that a texel's mean is known at its centre.
            let map = Equirect::new(RgbImage::from_fn(width, height, |_, y| {
                let theta = |y: u32| std::f32::consts::PI * y as f32 / height as f32;
                Vec3::new(1.0, 2.0 + 0.5 * (theta(y).cos() + theta(y + 1).cos()), 0.0)
            }));
            let faces = Faces::new(&map, 32);
            let sum: DVec3 = faces.flux.iter().flatten().sum();
            assert!((sum - map.flux()).length() < 1e-9, "{width} x {height}");
            if height < 100 {
                continue;
            }
            let cube = CubeMap::new(std::array::from_fn(|_| RgbImage::filled(32, 32, Vec3::ZERO))).unwrap();
            for (face, texel) in (0..6).flat_map(|face| (0..32 * 32).map(move |texel| (face, texel))) {
                let radiance = faces.flux[face][texel] / faces.solid_angle[texel];
                let direction = cube.texel_direction(face, texel as u32 % 32, texel as u32 / 32);
                let expected = DVec3::new(1.0, 2.0 + f64::from(direction.y), 0.0);
                assert!(
                    (radiance - expected).length() < 5e-3,
                    "{width} {face} {texel}: {radiance} {expected}"
                );
            }
        }
    }

    #[test]
    fn a_sun_keeps_its_flux_and_its_place() {
        for column in [70, 201, 299, 615] {
            let sun = |x: u32, y: u32| (x == column || x == column + 1) && y == 84;
            let map = Equirect::new(RgbImage::from_fn(1024, 512, |x, y| {
                Vec3::splat(if sun(x, y) { 5e4 } else { 0.5 })
            }));
            let faces = Faces::new(&map, 64);
            let wanted = 2.0 * (5e4 - 0.5) * map.texel_solid_angle(84);
            let mut sum = (0.0, 0.0);
            for (flux, (sr, moments)) in
                (0..6).flat_map(|i| faces.flux[i].iter().zip(faces.solid_angle.iter().zip(&faces.moments[i])))
            {
                if flux.x > 0.6 * sr {
                    sum = (sum.0 + flux.x - 0.5 * sr, sum.1 + moments.light[0] - 0.5 * sr);
                }
            }
            assert!((sum.0 / wanted - 1.0).abs() < 1e-4, "{column}: {}", sum.0 / wanted);
            assert!((sum.1 / wanted - 1.0).abs() < 2e-4, "{column}: {}", sum.1 / wanted);
        }
    }

    #[test]
    fn a_texel_light_points_at_its_texel_and_has_its_solid_angle() {
        let map = Equirect::new(RgbImage::filled(16, 8, Vec3::ONE));
        let cube = CubeMap::new(std::array::from_fn(|_| RgbImage::filled(8, 8, Vec3::ZERO))).unwrap();
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
