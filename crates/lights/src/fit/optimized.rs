//! Lights of least error behind edges, near to those of a partition.

use glam::{DQuat, DVec2, DVec3, Vec2};
use gnomon_envmap::CubeMap;
use rayon::prelude::*;

use super::cells::{FACE_SIZE, LEAST_HALF_WIDTH, Part};
use super::edge_error::Points;
use super::faces::{Faces, luminance};
use crate::DistantLight;

/// Numbers of lights up to which lights are optimised: time grows with the square, and what there is to gain falls.
pub(super) const MOST_LIGHTS: usize = 128;
/// Steps downhill. With 100 of them, shorter ones, the error is 7 % less.
pub(super) const STEPS: usize = 60;
/// The first of these integrate over lights with fewer points.
const COARSE_STEPS: usize = 40;
/// Length of the first step [rad]; they shorten evenly to nothing.
const FIRST_STEP: f64 = 0.015;
/// How much larger steps of a light's widths are: relative.
const WIDTH_STEP: f64 = 3.0;
/// Steps from one solution for the colours to the next, and steps of each.
const STEPS_PER_SOLUTION: usize = 5;
const COLOR_STEPS: usize = 50;
/// How fast the running means of the gradient and of its square forget (Kingma and Ba 2015, "Adam").
const MEMORY: [f64; 2] = [0.9, 0.99];
/// A slope much below this share of a light's squared flux is rounding, and moves nothing.
const NO_SLOPE: f64 = 3e-3;
/// No light loses more than this share of the flux that it starts with.
const MOST_LOST: f64 = 0.9;
/// Places along a light's side, within [-1, 1], and their weights.
type Quadrature = [[f64; 2]];
/// Gauss and Legendre's, of two and three places.
const TWO_PLACES: &Quadrature = &[[-0.577_350_269_189_625_8, 0.5], [0.577_350_269_189_625_8, 0.5]];
const THREE_PLACES: &Quadrature =
    &[[-0.774_596_669_241_483_4, 5.0 / 18.0], [0.0, 8.0 / 18.0], [0.774_596_669_241_483_4, 5.0 / 18.0]];
/// Texels along the side of the largest part of a face that one point stands for.
const COARSEST: usize = 8;
/// Largest share of the whole flux that one point stands for, unless it is a single texel, as a share of a light's mean flux.
pub(super) const LARGEST_SHARE: f64 = 0.15;
/// Weight of lights' widths: shadows of wide lights are the least exact. Without it pictures with 30 lights are off by a twelfth more,
/// and twice the weight changes little; the smaller it is, the less are edges of exact shadows wrong.
pub(super) const WIDTH_WEIGHT: f64 = 1.0;

/// A light while it changes.
#[derive(Clone, Copy, Debug)]
struct Patch {
    /// Unit axes `[right, up, forward]`, `right = forward x up`, `forward` towards the middle.
    frame: [DVec3; 3],
    /// Half widths along `right` and `up`: tangents of half angles.
    half: DVec2,
    /// As a share of the map's luminous flux.
    flux: DVec3,
    /// The least that may be left of it.
    least_flux: DVec3,
}

/// A point of a [`Patch`].
struct PatchPoint {
    /// Not normalised: on the plane at distance 1.
    place: DVec3,
    /// Offset from the middle in half widths, within [-1, 1].
    at: DVec2,
    /// Share of the patch's flux.
    share: f64,
}

/// What of a patch changes: its place along `right` and `up` [rad], and both half widths (relative).
const VARIABLES: usize = 4;

impl Patch {
    /// The rectangle most like a part of a face. Both axes count alike, so that a map turned by a quarter gives the same, turned.
    fn new(part: &Part, scale: f64) -> Self {
        let point =
            |s: f64, t: f64| CubeMap::point_on_face(part.face, Vec2::new(s as f32, t as f32)).as_dvec3();
        // Rows run down, `up` runs up.
        let corners = [
            point(part.min.x, part.max.y),
            point(part.max.x, part.max.y),
            point(part.max.x, part.min.y),
            point(part.min.x, part.min.y),
        ];
        let forward = corners.map(DVec3::normalize).iter().sum::<DVec3>().normalize();
        let [a, b, c, d] = corners.map(|corner| corner / corner.dot(forward));
        let axes = [b - a + c - d, d - a + c - b];
        let right = (axes[0].normalize() + forward.cross(axes[1].normalize())).normalize();
        let up = right.cross(forward);
        let flux = part.flux * scale;
        Self {
            frame: [right, up, forward],
            half: DVec2::new(axes[0].dot(right), axes[1].dot(up)) * 0.25,
            flux,
            least_flux: flux * (1.0 - MOST_LOST),
        }
    }

    /// Points with their shares of the solid angle.
    fn points(&self, quadrature: &Quadrature) -> Vec<PatchPoint> {
        let [right, up, forward] = self.frame;
        let mut points: Vec<_> = (quadrature.iter())
            .flat_map(|[y, row]| quadrature.iter().map(move |[x, column]| (DVec2::new(*x, *y), row * column)))
            .map(|(at, weight)| {
                let place = forward + right * (at.x * self.half.x) + up * (at.y * self.half.y);
                PatchPoint { place, at, share: weight * place.length().powi(-3) }
            })
            .collect();
        let sum: f64 = points.iter().map(|point| point.share).sum();
        points.iter_mut().for_each(|point| point.share /= sum);
        points
    }

    /// Mean over the patch of what these points are to it.
    fn potential(&self, of: &Points, quadrature: &Quadrature) -> DVec3 {
        self.points(quadrature).iter().map(|point| point.share * of.potential(point.place.normalize())).sum()
    }

    /// Derivatives of the error, of which `wrong` is what lights have too much.
    fn gradient(&self, wrong: &Points, quadrature: &Quadrature, width_weight: f64) -> [f64; VARIABLES] {
        let [right, up, _] = self.frame;
        let mut gradient = [0.0; VARIABLES];
        for point in self.points(quadrature) {
            let towards = point.place.normalize();
            let by_direction = 2.0 * point.share * wrong.gradient(towards, self.flux);
            let by_place = by_direction.reject_from_normalized(towards) / point.place.length();
            let along = DVec2::new(by_place.dot(right), by_place.dot(up));
            let [width, height] = (along * point.at * self.half).to_array();
            let part = [along.x, along.y, width, height];
            gradient.iter_mut().zip(part).for_each(|(sum, part)| *sum += part);
        }
        for axis in 0..2 {
            gradient[2 + axis] += 3.0 * width_weight * self.flux.length_squared() * self.half[axis].powi(3);
        }
        gradient
    }

    fn stepped(&self, step: [f64; VARIABLES], max_half: f64) -> Self {
        let [right, up, forward] = self.frame;
        let moved = (forward + right * step[0] + up * step[1]).normalize();
        let turn = DQuat::from_rotation_arc(forward, moved);
        let [right, forward] = [turn * right, moved].map(DVec3::normalize);
        let growth = DVec2::new(step[2], step[3]) * WIDTH_STEP;
        let least = LEAST_HALF_WIDTH * 2.0 / FACE_SIZE as f64;
        let half = self.half * DVec2::new(growth.x.exp(), growth.y.exp());
        Self {
            frame: [right, right.cross(forward), forward],
            half: half.clamp(DVec2::splat(least), DVec2::splat(max_half.max(least))),
            ..*self
        }
    }
}

/// As many lights of least error near to those that parts of faces give. `max_half` is the tangent of the largest half angle.
pub(super) fn optimized(
    faces: &Faces,
    parts: &[Part],
    max_half: f64,
    width_weight: f64,
) -> Vec<DistantLight> {
    let whole: DVec3 = faces.flux.iter().flatten().sum();
    let scale = luminance(whole).recip();
    let sky = sky(faces, scale, LARGEST_SHARE / parts.len() as f64);
    let mut patches: Vec<Patch> = parts.iter().map(|part| Patch::new(part, scale)).collect();
    let mut means = vec![[[0.0; 2]; VARIABLES]; patches.len()];
    for step in 0..STEPS {
        let quadrature = if step < COARSE_STEPS { TWO_PLACES } else { THREE_PLACES };
        if step % STEPS_PER_SOLUTION == 0 {
            solve_colors(&mut patches, &sky, quadrature);
        }
        let wrong = wrong(&patches, &sky, quadrature);
        let gradients: Vec<_> =
            patches.par_iter().map(|patch| patch.gradient(&wrong, quadrature, width_weight)).collect();
        let length = FIRST_STEP * (1.0 - step as f64 / STEPS as f64);
        let bias = MEMORY.map(|memory| 1.0 - memory.powi(step as i32 + 1));
        for ((patch, means), gradient) in patches.iter_mut().zip(&mut means).zip(gradients) {
            let mut by = [0.0; VARIABLES];
            for ((by, [mean, square]), slope) in by.iter_mut().zip(means).zip(gradient) {
                *mean = MEMORY[0] * *mean + (1.0 - MEMORY[0]) * slope;
                *square = MEMORY[1] * *square + (1.0 - MEMORY[1]) * slope * slope;
                let spread = (*square / bias[1]).sqrt() + NO_SLOPE * patch.flux.length_squared();
                *by = -length * (*mean / bias[0]) / spread;
            }
            *patch = patch.stepped(by, max_half);
        }
    }
    solve_colors(&mut patches, &sky, THREE_PLACES);
    let found: DVec3 = patches.iter().map(|patch| patch.flux).sum();
    let to_map = DVec3::select(found.cmpgt(DVec3::ZERO), whole / found, DVec3::ZERO);
    let light =
        |patch: &Patch| DistantLight::rectangle(patch.frame, -patch.half, patch.half, patch.flux * to_map);
    patches.iter().map(light).collect()
}

/// The map as points, the denser the brighter it is: none stands for more than `largest` of the whole flux or is wider than
/// [`COARSEST`] texels, unless it is one texel. Each lies at the centre of its light. Fluxes are the map's times `scale`.
pub(super) fn sky(faces: &Faces, scale: f64, largest: f64) -> Points {
    let mut points = Points::default();
    for face in 0..6 {
        let texel_point = |texel: usize| {
            let moments = faces.moments[face][texel].light;
            let at = |axis: usize| (moments[1 + axis] / moments[0]) as f32;
            let towards = || CubeMap::point_on_face(face, Vec2::new(at(0), at(1))).as_dvec3().normalize();
            let flux = faces.flux[face][texel] * scale;
            if moments[0] > 0.0 { (luminance(flux) * towards(), flux) } else { (DVec3::ZERO, flux) }
        };
        let mut open = vec![([0, 0], FACE_SIZE)];
        while let Some(([left, top], size)) = open.pop() {
            let texels = (top..top + size).flat_map(|y| (left..left + size).map(move |x| y * FACE_SIZE + x));
            let (centre, flux) =
                texels.map(texel_point).fold((DVec3::ZERO, DVec3::ZERO), |(a, b), (c, d)| (a + c, b + d));
            if size > 1 && (size > COARSEST || luminance(flux) > largest) {
                let half = size / 2;
                open.extend(
                    [[0, 0], [half, 0], [0, half], [half, half]].map(|[x, y]| ([left + x, top + y], half)),
                );
            } else if let Some(towards) = centre.try_normalize() {
                points.push(towards, flux);
            }
        }
    }
    points
}

/// What the lights have and the map has not.
fn wrong(patches: &[Patch], sky: &Points, quadrature: &Quadrature) -> Points {
    let mut wrong = sky.negated();
    for patch in patches {
        for point in patch.points(quadrature) {
            wrong.push(point.place.normalize(), patch.flux * point.share);
        }
    }
    wrong
}

/// Gives the patches the colours of least error, as far as they keep what they must: a quadratic form, by accelerated projected
/// gradients (Beck and Teboulle 2009). The order of the patches does not matter.
fn solve_colors(patches: &mut [Patch], sky: &Points, quadrature: &Quadrature) {
    let wanted: Vec<DVec3> = patches.par_iter().map(|patch| patch.potential(sky, quadrature)).collect();
    let lit: Vec<Points> = patches
        .iter()
        .map(|patch| {
            let mut points = Points::default();
            for point in patch.points(quadrature) {
                points.push(point.place.normalize(), DVec3::splat(point.share));
            }
            points
        })
        .collect();
    let pairs: Vec<Vec<f64>> = patches
        .par_iter()
        .map(|patch| lit.iter().map(|points| patch.potential(points, quadrature).x).collect())
        .collect();
    // No eigenvalue is larger than the largest sum of a row.
    let step = pairs.iter().map(|row| row.iter().sum::<f64>()).fold(1.0, f64::max).recip();
    let mut ahead: Vec<DVec3> = patches.iter().map(|patch| patch.flux).collect();
    let mut momentum = 1.0_f64;
    for _ in 0..COLOR_STEPS {
        let next_momentum = 0.5 * (1.0 + (1.0 + 4.0 * momentum * momentum).sqrt());
        let onwards = (momentum - 1.0) / next_momentum;
        momentum = next_momentum;
        let given =
            pairs.iter().map(|row| row.iter().zip(&ahead).map(|(pair, flux)| *pair * *flux).sum::<DVec3>());
        let missing: Vec<DVec3> = given.zip(&wanted).map(|(given, wanted)| wanted - given).collect();
        for ((patch, ahead), missing) in patches.iter_mut().zip(&mut ahead).zip(missing) {
            let flux = (*ahead + step * missing).max(patch.least_flux);
            *ahead = flux + onwards * (flux - patch.flux);
            patch.flux = flux;
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use glam::Vec3;
    use gnomon_envmap::Equirect;
    use gnomon_picture::RgbImage;

    use super::super::cells::divided;
    use super::super::{FitOptions, by_name};
    use super::*;
    use crate::{LightSet, LightShape};

    fn map(f: impl FnMut(u32, u32) -> Vec3) -> Equirect {
        Equirect::new(RgbImage::from_fn(128, 64, f))
    }

    /// A room with two windows and a lamp.
    fn room() -> Equirect {
        map(|x, y| match (x, y) {
            (10..18, 20..34) => Vec3::new(20.0, 22.0, 30.0),
            (70..90, 24..30) => Vec3::new(9.0, 8.0, 6.0),
            (50..52, 12..14) => Vec3::new(300.0, 200.0, 90.0),
            _ => Vec3::new(0.4, 0.3 + 0.004 * y as f32, 0.3),
        })
    }

    fn fitted(method: &str, map: &Equirect, options: &FitOptions) -> LightSet {
        by_name(method, options).unwrap().fit(map).unwrap()
    }

    /// Directions that a light covers evenly, with their share of its flux.
    fn within(light: &DistantLight) -> Vec<(DVec3, DVec3)> {
        let LightShape::Rectangle { corners } = light.shape else { panic!("not a rectangle") };
        let [a, b, c, d] = corners.map(|corner| (corner / corner.dot(light.direction)).as_dvec3());
        let place = |i: usize| (i as f64 + 0.5) / 16.0;
        let points: Vec<DVec3> = (0..256)
            .map(|i| a.lerp(b, place(i % 16)).lerp(d.lerp(c, place(i % 16)), place(i / 16)))
            .collect();
        let sum: f64 = points.iter().map(|point| point.length().powi(-3)).sum();
        points
            .iter()
            .map(|point| (point.normalize(), light.flux() * (point.length().powi(-3) / sum)))
            .collect()
    }

    /// Root mean square error of irradiance over surfaces of any orientation of which a straight edge hides one half.
    fn error_behind_edges(map: &Equirect, lights: &[DistantLight]) -> f64 {
        let texels = (0..map.height()).flat_map(|y| (0..map.width()).map(move |x| (x, y)));
        let mut wrong: Vec<(DVec3, DVec3)> = texels
            .map(|(x, y)| {
                let flux = map.radiance().get(x, y).as_dvec3() * map.texel_solid_angle(y);
                (map.texel_direction(x, y).as_dvec3(), -flux)
            })
            .collect();
        wrong.extend(lights.iter().flat_map(within));
        let direction = |i: usize| {
            let z = 1.0 - (2.0 * i as f64 + 1.0) / 1000.0;
            let (sin, cos) = (i as f64 * PI * (3.0 - 5.0_f64.sqrt())).sin_cos();
            DVec3::new((1.0 - z * z).sqrt() * cos, (1.0 - z * z).sqrt() * sin, z)
        };
        let square = |i: usize| {
            let (normal, open) = (direction(i), direction((401 * i + 17) % 1000));
            let seen = wrong.iter().filter(|(towards, _)| towards.dot(open) > 0.0);
            seen.map(|(towards, flux)| *flux * towards.dot(normal).max(0.0)).sum::<DVec3>().length_squared()
        };
        ((0..1000).into_par_iter().map(square).sum::<f64>() / 1000.0).sqrt()
    }

    #[test]
    fn edges_show_less_error_than_with_a_partition() {
        let map = room();
        let faces = Faces::new(&map, FACE_SIZE);
        for (count, gain) in [(12, 0.4), (30, 0.5), (60, 0.8)] {
            let options = FitOptions { light_count: Some(count), ..FitOptions::default() };
            let before = error_behind_edges(&map, &fitted("partition", &map, &options).lights);
            let error = |width_weight: f64| {
                error_behind_edges(&map, &optimized(&faces, &divided(&faces, &options), 1.0, width_weight))
            };
            let after = error(0.0);
            assert!(after < gain * before, "{count}: {after} instead of {before}");
            // The checker notices lights that are too narrow.
            assert!(error(30.0) > 1.5 * after);
        }
    }

    #[test]
    fn a_small_sun_stays_where_it_is_and_as_small() {
        let (column, row) = (70, 17);
        let map = map(|x, y| Vec3::splat(if (x, y) == (column, row) { 1e5 } else { 1.0 }));
        let towards = map.texel_direction(column, row);
        let lights = fitted("optimized", &map, &FitOptions::default()).lights;
        let texel = (TAU / 128.0) as f32;
        let expected = 1e5 * map.texel_solid_angle(row);
        let of_sun = |light: &&DistantLight| light.direction.angle_between(towards) < 2.0 * texel;
        let sun: Vec<_> = lights.iter().filter(of_sun).collect();
        let flux: f64 = sun.iter().map(|light| light.flux().x).sum();
        assert!((0.99..1.01).contains(&(flux / expected)), "{}", flux / expected);
        let centre: DVec3 = sun.iter().map(|light| light.flux().x * light.direction.as_dvec3()).sum();
        let off = centre.as_vec3().angle_between(towards) / texel;
        assert!(off < 0.1, "{off} of a texel");
        // Slivers of sky beside it may hold a little of its edge.
        for light in sun.iter().filter(|light| light.flux().x > 1e-2 * expected) {
            assert!(light.extent().max_element() < 2.0 * texel, "{}", light.extent());
        }
    }

    #[test]
    fn so_many_lights_stay_a_partition_s() {
        let options = FitOptions { light_count: Some(MOST_LIGHTS + 1), ..FitOptions::default() };
        let (as_they_start, as_ever) =
            (fitted("optimized", &room(), &options), fitted("partition", &room(), &options));
        assert_eq!(as_they_start.lights, as_ever.lights);
    }
}
