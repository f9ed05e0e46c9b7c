use std::cmp::Ordering;
use std::collections::BinaryHeap;

use glam::{DVec2, DVec3};
use gnomon_envmap::Equirect;

use super::error::check_map;
use super::faces::{Faces, Moments, TexelRect};
use super::{FitError, FitOptions};
use crate::DistantLight;

/// Texels along a face's edge.
pub(super) const FACE_SIZE: usize = 64;
/// From this number of lights on, the division starts from four cells a face instead of one: with 30 lights the pictures'
/// error falls by a fifth, with 60 by half, and no cell is wider than an eighth of a turn.
const QUARTERS_FROM: usize = 30;
/// A cell below this share of the whole flux is black: the sums round at about 10^-16 of it.
const BLACK: f64 = 1e-12;
/// Least half width of a light in texels: the sun's.
pub(super) const LEAST_HALF_WIDTH: f64 = 0.125;
/// Weight of a light's extent in its [`Face::cost`]: shadows of wide lights are the least exact.
const EXTENT_WEIGHT: f64 = 0.03;
/// Numbers of lights with which a ground counts: with 20 it takes a sixth off the pictures' error, with 40 a twentieth, with 50
/// it adds a fiftieth.
const GROUND_BELOW: usize = 48;
/// Least number of lights from which a ground's horizon divides the faces that it crosses.
const HORIZON_FROM: usize = 10;
/// Above a ground, what lies below its horizon costs so much of what it would cost elsewhere: some of it shines past the ground's edge.
const BELOW_GROUND: f64 = 0.2;
/// The cube face that looks down; the horizon halves the four between it and its opposite.
const DOWN: usize = 3;
const UP: usize = 2;

/// Number of lights unless told otherwise.
pub(super) const LIGHT_COUNT: usize = 60;

/// Divides a map, as the residual of a fit, into `light_count` lights (6 to [`super::MAX_LIGHTS`], 60 where the options have none)
/// that together hold exactly its flux: fewer only where the map has too few texels that are not black.
///
/// A cell is a rectangle on a cube face; its light has its flux and colour, and the centre and spread of its light:
/// within the cell, it is as far from the cell's middle and as wide, along each axis, as makes mean and variance of its
/// directions those of the cell's luminance. The cell whose light misplaces most flux is cut next, by the straight cut
/// that leaves least of it. From 30 lights on, none is wider or higher than an eighth of a turn, but for those below a ground, which
/// counts up to 47 lights.
/// `max_extent` \[rad\] bounds the angular length of every light's sides, if need be with more lights than asked for.
///
/// # Errors
/// A count or an extent out of range, a threshold or sampler, a map without texels or with some that are no radiance.
pub fn cells(map: &Equirect, options: &FitOptions) -> Result<Vec<DistantLight>, FitError> {
    check("partition", options)?;
    check_map(map)?;
    let divided = divided(&Faces::new(map, FACE_SIZE), options);
    Ok(divided.iter().map(Part::light).collect())
}

/// What stands for a cell: opposite corners on its face, from -1 to 1, and flux.
pub(super) struct Part {
    pub(super) face: usize,
    pub(super) min: DVec2,
    pub(super) max: DVec2,
    pub(super) flux: DVec3,
    /// Of the cell.
    pub(super) rect: TexelRect,
}

impl Part {
    pub(super) fn light(&self) -> DistantLight {
        Faces::light_between(self.face, self.min, self.max, self.flux)
    }
}

/// The lights of [`cells`], for faces of [`FACE_SIZE`] texels and options that [`check`] lets pass.
pub(super) fn divided(faces: &Faces, options: &FitOptions) -> Vec<Part> {
    let count = options.light_count.unwrap_or(LIGHT_COUNT);
    let ground = heeds_ground(options);
    let tables: Vec<Face> = (0..6).map(|face| Face::new(faces, face)).collect();
    let black =
        BLACK * tables.iter().map(|face| face.moments(TexelRect::face(FACE_SIZE)).light[0]).sum::<f64>();
    let max_extent = options.max_extent.map_or(f64::INFINITY, f64::from);
    let planned = |face: usize, rect: TexelRect| {
        let is_lit = tables[face].moments(rect).light[0] > black;
        is_lit.then(|| {
            let is_wide = faces.extent(rect).into_iter().any(|angle| angle > max_extent);
            let weight = if ground && is_below_horizon(face, rect) { BELOW_GROUND } else { 1.0 };
            let cost = if is_wide { f64::INFINITY } else { weight * tables[face].cost(rect) };
            Cell { cost, face, rect }
        })
    };
    let mut open: BinaryHeap<Cell> = first_cells(count, ground, options.arrival.is_some())
        .into_iter()
        .filter_map(|(face, rect)| planned(face, rect))
        .collect();
    let mut done = Vec::new();
    while let Some(cell) = open.pop() {
        if done.len() + open.len() + 1 >= count && cell.cost.is_finite() {
            done.push(cell);
            break;
        }
        let table = &tables[cell.face];
        let cut = if cell.cost.is_finite() { table.best_cut(cell.rect) } else { halves(faces, cell.rect) };
        match cut {
            Some(parts) => open.extend(parts.into_iter().filter_map(|rect| planned(cell.face, rect))),
            None => done.push(cell),
        }
    }
    done.extend(open);
    let part = |&Cell { face, rect, .. }: &Cell| {
        let (min, max) = tables[face].matched(rect);
        Part { face, min, max, flux: faces.rect_flux(face, rect), rect }
    };
    done.iter().map(part).collect()
}

/// Whether a map can be divided so, for the fit called `method`.
pub(super) fn check(method: &'static str, options: &FitOptions) -> Result<(), FitError> {
    options.validate()?;
    options.validate_tiling(method)?;
    options.refuse_threshold(method)?;
    options.refuse_sampler(method)
}

/// Whether the cells are others above a ground.
pub(super) fn heeds_ground(options: &FitOptions) -> bool {
    options.ground && options.light_count.unwrap_or(LIGHT_COUNT) < GROUND_BELOW
}

/// Whether all of a cell lies below the horizon.
fn is_below_horizon(face: usize, rect: TexelRect) -> bool {
    face == DOWN || (face != UP && rect.min[1] >= FACE_SIZE / 2)
}

/// What the division starts from, and which face it is on.
fn first_cells(count: usize, ground: bool, is_interior: bool) -> Vec<(usize, TexelRect)> {
    // What does not arrive in an interior may be as wide as it likes.
    let parts = if count < QUARTERS_FROM || is_interior { 1 } else { 2 };
    let divided = |face: usize, whole: TexelRect, [columns, rows]: [usize; 2]| {
        let edge = |axis: usize, part: usize, parts: usize| {
            whole.min[axis] + part * (whole.max[axis] - whole.min[axis]) / parts
        };
        (0..columns * rows)
            .map(|i| {
                let (x, y) = (i % columns, i / columns);
                let rect = TexelRect {
                    min: [edge(0, x, columns), edge(1, y, rows)],
                    max: [edge(0, x + 1, columns), edge(1, y + 1, rows)],
                };
                (face, rect)
            })
            .collect::<Vec<_>>()
    };
    let whole = TexelRect::face(FACE_SIZE);
    (0..6)
        .flat_map(|face| {
            if !ground || count < HORIZON_FROM || face == UP {
                return divided(face, whole, [parts, parts]);
            }
            if face == DOWN {
                return divided(face, whole, [1, 1]);
            }
            let [above, below] = whole.split(1, FACE_SIZE / 2);
            [divided(face, above, [parts, 1]), divided(face, below, [1, 1])].concat()
        })
        .collect()
}

/// A part of a face that becomes one light. Cells are ordered by cost, equal ones by place: the first comes first.
#[derive(Clone, Copy, Debug)]
struct Cell {
    /// Infinite where the cell is too wide.
    cost: f64,
    face: usize,
    rect: TexelRect,
}

impl Ord for Cell {
    fn cmp(&self, other: &Self) -> Ordering {
        let place = |cell: &Self| (cell.face, cell.rect.min[1], cell.rect.min[0]);
        self.cost.total_cmp(&other.cost).then_with(|| place(other).cmp(&place(self)))
    }
}

impl PartialOrd for Cell {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Cell {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Cell {}

/// Both halves, by angle, of a cell that is too wide, across its wider axis.
fn halves(faces: &Faces, rect: TexelRect) -> Option<[TexelRect; 2]> {
    let [width, height] = faces.extent(rect);
    let axis = usize::from(height > width);
    let angle = |index: usize| faces.edge(index).atan();
    let middle = angle(rect.min[axis]).midpoint(angle(rect.max[axis])).tan();
    let at = (0.5 * (middle + 1.0) * faces.size as f64).round() as usize;
    (at > rect.min[axis] && at < rect.max[axis]).then(|| rect.split(axis, at))
}

/// Moments of any rectangle of a face, by a summed-area table.
struct Face {
    size: usize,
    /// `(size + 1)^2` sums over all texels above and to the left.
    table: Vec<Moments>,
    /// Share of a great circle's light below each texel edge, see [`ramp`].
    ramp: Vec<f64>,
}

impl Face {
    fn new(faces: &Faces, face: usize) -> Self {
        let (size, stride) = (faces.size, faces.size + 1);
        let mut table = vec![Moments::default(); stride * stride];
        for y in 0..size {
            let mut row = Moments::default();
            for x in 0..size {
                row = row.combined(1.0, &faces.moments[face][y * size + x], 1.0);
                table[(y + 1) * stride + x + 1] = table[y * stride + x + 1].combined(1.0, &row, 1.0);
            }
        }
        Self { size, table, ramp: (0..stride).map(|index| ramp(faces.edge(index))).collect() }
    }

    fn moments(&self, rect: TexelRect) -> Moments {
        let at = |x: usize, y: usize| &self.table[y * (self.size + 1) + x];
        let ([x0, y0], [x1, y1]) = (rect.min, rect.max);
        at(x1, y1).combined(1.0, at(x0, y1), -1.0).combined(
            1.0,
            &at(x1, y0).combined(1.0, at(x0, y0), -1.0),
            -1.0,
        )
    }

    /// Luminous flux of a rectangle.
    fn flux(&self, rect: TexelRect) -> f64 {
        let at = |x: usize, y: usize| self.table[y * (self.size + 1) + x].light[0];
        let ([x0, y0], [x1, y1]) = (rect.min, rect.max);
        at(x1, y1) - at(x0, y1) - (at(x1, y0) - at(x0, y0))
    }

    /// Opposite corners, on the face from -1 to 1, of the light that stands for a cell.
    fn matched(&self, rect: TexelRect) -> (DVec2, DVec2) {
        let moments = self.moments(rect);
        let edge = |index: usize| 2.0 * index as f64 / self.size as f64 - 1.0;
        let (mut min, mut max) = (DVec2::ZERO, DVec2::ZERO);
        for axis in 0..2 {
            let mean_and_variance = |moments: [f64; 5]| {
                let mean = moments[1 + axis] / moments[0];
                (mean, (moments[3 + axis] / moments[0] - mean * mean).max(0.0))
            };
            let (mean, variance) = mean_and_variance(moments.light);
            let (even_mean, even_variance) = mean_and_variance(moments.area);
            let (low, high) = (edge(rect.min[axis]), edge(rect.max[axis]));
            let half = 0.5 * (high - low);
            let least = LEAST_HALF_WIDTH * 2.0 / self.size as f64;
            // A uniform cell gets back exactly its own place and width.
            let spread = (variance / even_variance.max(f64::MIN_POSITIVE)).sqrt().min(1.0);
            // Directions are denser towards the face's centre, so that a rectangle's mean is not its middle: by less the narrower it is.
            let skew = (even_mean - low.midpoint(high)) * spread * spread;
            let offset = (mean - skew - low.midpoint(high)).clamp(least - half, half - least);
            let width = (half * spread).min(half - offset.abs()).max(least);
            min[axis] = low.midpoint(high) + offset - width;
            max[axis] = low.midpoint(high) + offset + width;
        }
        (min, max)
    }

    /// How badly its light stands for a cell: over all straight cuts along its two axes, the integral of the squared error
    /// of the flux on one side, which is what an occluder's edge across the light does to irradiance. The light's extents
    /// add a little.
    fn cost(&self, rect: TexelRect) -> f64 {
        let flux = self.flux(rect);
        let (min, max) = self.matched(rect);
        let mut cost = 0.0;
        for axis in 0..2 {
            let (from, to) = (ramp(min[axis]), ramp(max[axis]));
            for at in rect.min[axis] + 1..rect.max[axis] {
                let share = ((self.ramp[at] - from) / (to - from)).clamp(0.0, 1.0);
                cost += (self.flux(rect.split(axis, at)[0]) - share * flux).powi(2) * 2.0 / self.size as f64;
            }
            let extent = max[axis].atan() - min[axis].atan();
            cost += EXTENT_WEIGHT * (flux * flux) * extent.powi(3);
        }
        cost
    }

    /// Both parts after the straight cut that leaves the least cost; `None` for a single texel.
    fn best_cut(&self, rect: TexelRect) -> Option<[TexelRect; 2]> {
        (0..2)
            .flat_map(|axis| (rect.min[axis] + 1..rect.max[axis]).map(move |at| rect.split(axis, at)))
            .map(|parts| (parts.map(|part| self.cost(part)).iter().sum::<f64>(), parts))
            .reduce(|best, next| if next.0 < best.0 { next } else { best })
            .map(|(_, parts)| parts)
    }
}

/// Solid angle of a thin strip along a face's axis up to `s`, per width: the integral of `(1 + s^2)^(-3/2)`.
fn ramp(s: f64) -> f64 {
    s / (1.0 + s * s).sqrt()
}

#[cfg(test)]
mod tests {
    use std::f32::consts::{FRAC_PI_4, PI, TAU};

    use glam::Vec3;
    use gnomon_picture::RgbImage;

    use super::*;
    use crate::LightShape;

    fn map(f: impl FnMut(u32, u32) -> Vec3) -> Equirect {
        Equirect::new(RgbImage::from_fn(256, 128, f))
    }

    fn asked(count: usize) -> FitOptions {
        FitOptions { light_count: Some(count), ..FitOptions::default() }
    }

    #[test]
    fn few_of_few_lights_are_below_a_ground_s_horizon() {
        let map = map(|x, y| Vec3::new(1.0, 0.5 + 0.4 * (x % 7) as f32, 0.3 + 0.2 * (y % 5) as f32));
        for count in [6, 9, 10, 17, 30, 40, 48, 200] {
            let below = |ground: bool| {
                let lights = cells(&map, &FitOptions { ground, ..asked(count) }).unwrap();
                assert_eq!(lights.len(), count);
                let flux: DVec3 = lights.iter().map(DistantLight::flux).sum();
                assert!((flux - map.flux()).abs().max_element() < 1e-4 * map.flux().max_element());
                lights.iter().filter(|light| light.direction.y < -1e-3).count()
            };
            let (without, with) = (below(false), below(true));
            let counts = count < GROUND_BELOW;
            assert!(count < 17 || (with < without) == counts, "{count}: {with} instead of {without}");
            assert!(with > 0, "{count}");
        }
    }

    /// Longest side [rad].
    fn widest(lights: &[DistantLight]) -> f32 {
        let side = |light: &DistantLight| match light.shape {
            LightShape::Rectangle { corners } => {
                (0..4).map(|i| corners[i].angle_between(corners[(i + 1) % 4])).fold(0.0, f32::max)
            }
            LightShape::Disk { .. } => f32::INFINITY,
        };
        lights.iter().map(side).fold(0.0, f32::max)
    }

    #[test]
    fn lights_of_a_uniform_map_tile_the_sphere_at_any_count() {
        let map = map(|_, _| Vec3::new(1.0, 0.5, 2.0));
        for count in [6, 17, 30, 60, 200] {
            let lights = cells(&map, &asked(count)).unwrap();
            assert_eq!(lights.len(), count);
            let covered: f32 = lights.iter().map(|light| light.solid_angle).sum();
            assert!((covered - 4.0 * PI).abs() < 1e-3, "{count}: {covered}");
            assert!(count < QUARTERS_FROM || widest(&lights) < FRAC_PI_4 + 1e-3);
            for light in &lights {
                assert!((light.radiance - Vec3::new(1.0, 0.5, 2.0)).length() < 1e-3, "{}", light.radiance);
            }
        }
    }

    #[test]
    fn a_small_sun_becomes_lights_of_its_own_size_and_place() {
        // One texel of a 256 x 128 map is 1.4 degrees wide, and lies across the texels of the face.
        let (column, row) = (70, 37);
        let map = map(|x, y| Vec3::splat(if (x, y) == (column, row) { 1e5 } else { 1.0 }));
        let towards = map.texel_direction(column, row);
        let lights = cells(&map, &asked(60)).unwrap();
        let sun: Vec<_> =
            lights.iter().filter(|light| light.direction.angle_between(towards) < TAU / 128.0).collect();
        let flux: f64 = sun.iter().map(|light| light.flux().x).sum();
        let solid_angle: f64 = sun.iter().map(|light| f64::from(light.solid_angle)).sum();
        let centre: DVec3 = sun.iter().map(|light| light.flux().x * light.direction.as_dvec3()).sum();
        let texel = map.texel_solid_angle(row);
        assert!((0.99..1.01).contains(&(flux / (1e5 * texel))), "{}", flux / texel);
        // Between texels radiance is bilinear: what one texel has spreads over its neighbours.
        assert!((1.4..2.8).contains(&(solid_angle / texel)), "{}", solid_angle / texel);
        let off = centre.as_vec3().angle_between(towards) / (TAU / 256.0);
        assert!(off < 0.1, "{off} of a texel");
        assert!(sun.len() <= 6, "{}", sun.len());
    }

    /// Flux-weighted mean direction of what a light stands for and of the light itself.
    #[test]
    fn the_centre_of_all_light_stays_where_it_is() {
        let map =
            map(|x, y| Vec3::splat(0.1 + ((x * 7 + y * 13) % 11) as f32 + if y < 30 { 20.0 } else { 0.0 }));
        let lights = cells(&map, &asked(60)).unwrap();
        let mut expected = DVec3::ZERO;
        for (x, y) in (0..128).flat_map(|y| (0..256).map(move |x| (x, y))) {
            let texel = f64::from(map.radiance().get(x, y).x) * map.texel_solid_angle(y);
            expected += texel * map.texel_direction(x, y).as_dvec3();
        }
        let found: DVec3 = lights.iter().map(|light| light.flux().x * light.direction.as_dvec3()).sum();
        assert!((found - expected).length() < 0.01 * map.flux().x, "{found} {expected}");
    }

    #[test]
    fn a_largest_extent_overrules_the_count() {
        let map = map(|x, _| Vec3::splat(1.0 + (x % 5) as f32));
        for extent in [0.9_f32, 0.4] {
            let lights = cells(&map, &FitOptions { max_extent: Some(extent), ..asked(6) }).unwrap();
            assert!(widest(&lights) <= extent + 1e-5, "{}", widest(&lights));
            assert!(lights.len() > 6);
        }
    }

    #[test]
    fn black_parts_get_no_light_and_counts_are_met_without_them() {
        let half = map(|x, _| Vec3::splat(if x < 128 { 1.0 } else { 0.0 }));
        let lights = cells(&half, &asked(40)).unwrap();
        assert_eq!(lights.len(), 40);
        assert!(lights.iter().all(|light| light.direction.x > -0.1));
        assert!(cells(&map(|_, _| Vec3::ZERO), &asked(40)).unwrap().is_empty());
        for wrong in [0, 5, super::super::MAX_LIGHTS + 1] {
            assert!(cells(&half, &asked(wrong)).is_err(), "{wrong}");
        }
    }
}
