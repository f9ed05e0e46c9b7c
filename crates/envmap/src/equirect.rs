use std::f32::consts::{PI, TAU};
use std::sync::Arc;

use glam::{DVec3, Vec2, Vec3};
use gnomon_picture::{LUMINANCE, RgbImage};
use rayon::prelude::*;

use crate::Backdrop;

/// An equirectangular (latitude-longitude) map of incoming radiance, finite and not negative.
///
/// Texel `(x, y)` covers `phi` in `[x, x + 1] * 2 pi / width` and `theta` in `[y, y + 1] * pi / height`, and stands for
/// the mean radiance over that patch. See [`Equirect::direction_from_uv`] for the axes.
#[derive(Clone, Debug, PartialEq)]
pub struct Equirect {
    radiance: RgbImage,
    backdrop: Option<Arc<Backdrop>>,
}

impl Equirect {
    /// Takes linear radiance as an equirect map. The caller has cleaned it of NaN, infinite and negative texels.
    pub fn new(radiance: RgbImage) -> Self {
        Self { radiance, backdrop: None }
    }

    /// The same map, with a finer picture of it for what the camera sees.
    #[must_use]
    pub fn with_backdrop(self, backdrop: Arc<Backdrop>) -> Self {
        Self { backdrop: Some(backdrop), ..self }
    }

    /// The finer picture of it, where its file was larger than light needs.
    pub fn backdrop(&self) -> Option<&Arc<Backdrop>> {
        self.backdrop.as_ref()
    }

    /// The radiance of every texel, north pole (+y) row first.
    pub fn radiance(&self) -> &RgbImage {
        &self.radiance
    }

    /// Gives the radiance picture back.
    pub fn into_radiance(self) -> RgbImage {
        self.radiance
    }

    /// Width in texels.
    pub fn width(&self) -> u32 {
        self.radiance.width()
    }

    /// Height in texels.
    pub fn height(&self) -> u32 {
        self.radiance.height()
    }

    /// Unit world direction at `(u, v)` in `[0, 1]^2`, `v = 0` the +y pole: the centre looks along +z, `u = 0.25` is +x.
    pub fn direction_from_uv(uv: Vec2) -> Vec3 {
        let (sin_phi, cos_phi) = (TAU * uv.x).sin_cos();
        let (sin_theta, cos_theta) = (PI * uv.y).sin_cos();
        Vec3::new(sin_theta * sin_phi, cos_theta, -sin_theta * cos_phi)
    }

    /// Inverse of [`Equirect::direction_from_uv`] for a unit direction; `u` in `[0, 1)`, `v` in `[0, 1]`.
    pub fn uv_from_direction(direction: Vec3) -> Vec2 {
        let u = direction.x.atan2(-direction.z) / TAU;
        let u = if u < 0.0 { u + 1.0 } else { u };
        // Not acos: it loses half the digits near the poles.
        let theta = Vec2::new(direction.x, direction.z).length().atan2(direction.y);
        Vec2::new(if u >= 1.0 { 0.0 } else { u }, theta / PI)
    }

    /// Solid angle [sr] of each texel in row `y`: `(2 pi / width) (cos theta_top - cos theta_bottom)`.
    pub fn texel_solid_angle(&self, y: u32) -> f64 {
        let theta = |row: u32| std::f64::consts::PI * f64::from(row) / f64::from(self.height());
        // cos a - cos b = 2 sin((a+b)/2) sin((b-a)/2) keeps its digits at the poles.
        let (top, bottom) = (theta(y), theta(y + 1));
        std::f64::consts::TAU / f64::from(self.width())
            * 2.0
            * (0.5 * (top + bottom)).sin()
            * (0.5 * (bottom - top)).sin()
    }

    /// Unit direction through the centre of texel `(x, y)`.
    pub fn texel_direction(&self, x: u32, y: u32) -> Vec3 {
        let uv = Vec2::new((x as f32 + 0.5) / self.width() as f32, (y as f32 + 0.5) / self.height() as f32);
        Self::direction_from_uv(uv)
    }

    /// Bilinear radiance towards a unit direction, without a seam: columns wrap, and a row past a pole continues half
    /// a turn away.
    pub fn lookup(&self, direction: Vec3) -> Vec3 {
        interpolate(direction, [self.width(), self.height()], |x, y| self.radiance.get(x, y))
    }

    /// What the camera sees towards a unit direction: the backdrop, or else [`Equirect::lookup`].
    pub fn seen(&self, direction: Vec3) -> Vec3 {
        match &self.backdrop {
            Some(backdrop) => backdrop.lookup(direction),
            None => self.lookup(direction),
        }
    }

    /// The same at `fraction` of the way from the middle of a texel to that of the next one to the right and below; columns and rows may
    /// lie past the edges by less than the map's size.
    pub fn between(&self, column: i64, row: i64, fraction: Vec2) -> Vec3 {
        between([self.width(), self.height()], [column, row], fraction, &|x, y| self.radiance.get(x, y))
    }

    /// Irradiance of a surface with the unit normal `n` by all of the map as [`Equirect::lookup`] has it, unshadowed: by 3 x 3 places a texel, which
    /// leaves an error of some 1e-4.
    pub fn irradiance(&self, n: Vec3) -> DVec3 {
        const PLACES: u32 = 3;
        let [width, height] = [PLACES * self.width(), PLACES * self.height()];
        let rows = (0..height).into_par_iter().map(|y| {
            let v = (f64::from(y) + 0.5) / f64::from(height);
            let sine = (std::f64::consts::PI * v).sin();
            let row: DVec3 = (0..width)
                .map(|x| {
                    let u = (f64::from(x) + 0.5) / f64::from(width);
                    let direction = Self::direction_from_uv(Vec2::new(u as f32, v as f32));
                    let cosine = n.dot(direction);
                    if cosine > 0.0 { (self.lookup(direction) * cosine).as_dvec3() } else { DVec3::ZERO }
                })
                .sum();
            row * sine
        });
        let sum: DVec3 = rows.sum();
        sum * (2.0 * std::f64::consts::PI * std::f64::consts::PI / (f64::from(width) * f64::from(height)))
    }

    /// Flux [radiance x sr] of the whole map, channel by channel: the sum of radiance times solid angle.
    pub fn flux(&self) -> DVec3 {
        (0..self.height())
            .map(|y| {
                let row = (0..self.width()).map(|x| self.radiance.get(x, y).as_dvec3()).sum::<DVec3>();
                row * self.texel_solid_angle(y)
            })
            .sum()
    }

    /// Stops that bring the mean luminance to 0.5, so that a matte white surface is bright but not clipped. 0 for a black map.
    pub fn suitable_exposure(&self) -> f32 {
        let mean = (self.flux() / (4.0 * std::f64::consts::PI)).as_vec3().dot(LUMINANCE);
        let stops = (0.5 / mean).log2();
        if stops.is_finite() { stops.clamp(-60.0, 60.0) } else { 0.0 }
    }
}

/// Bilinear interpolation of the texels of an equirect picture towards a unit direction.
pub(crate) fn interpolate(direction: Vec3, size: [u32; 2], texel: impl Fn(u32, u32) -> Vec3) -> Vec3 {
    let at = Equirect::uv_from_direction(direction) * Vec2::new(size[0] as f32, size[1] as f32) - 0.5;
    let first = at.floor();
    between(size, [first.x as i64, first.y as i64], at - first, &texel)
}

fn between(
    [width, height]: [u32; 2],
    [column, row]: [i64; 2],
    fraction: Vec2,
    texel: &impl Fn(u32, u32) -> Vec3,
) -> Vec3 {
    let (width, height) = (i64::from(width), i64::from(height));
    let wrapped = |x: i64, y: i64| {
        let (x, y) = if y < 0 {
            (x + width / 2, -1 - y)
        } else if y >= height {
            (x + width / 2, 2 * height - 1 - y)
        } else {
            (x, y)
        };
        texel(x.rem_euclid(width) as u32, y.clamp(0, height - 1) as u32)
    };
    let along = |y: i64| wrapped(column, y).lerp(wrapped(column + 1, y), fraction.x);
    along(row).lerp(along(row + 1), fraction.y)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_luminance_is_shown_as_a_half() {
        let map = |luminance: f32| Equirect::new(RgbImage::filled(8, 4, Vec3::splat(luminance)));
        assert!((map(0.125).suitable_exposure() - 2.0).abs() < 1e-5);
        assert_eq!(map(0.0).suitable_exposure(), 0.0);
    }
}
