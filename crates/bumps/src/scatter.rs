use glam::{Quat, Vec2, Vec3};
use rayon::prelude::*;

use crate::{Field, Horizons};

/// Directions in which every texel looks for others that it sees: the paper's S_i, each of which also starts a path.
const PATHS: usize = 64;
/// Directions of light.
const LIGHTS: usize = 32;
/// Azimuths of the horizons that light is blocked by.
const AZIMUTHS: usize = 16;
/// No texel.
const NONE: u32 = u32::MAX;
/// Greatest growth from bounce to bounce: whatever a texel sees, some of it leaves.
const GREATEST_GAIN: f32 = 0.95;

/// What a texel gets from others, prepared: for light from the unit direction l that gives the irradiance E to an unblocked surface that faces
/// up, the first bounce is `E rho (even + (x, y) . l)` where the albedo is rho, and each further one is `rho gain` times the one before.
///
/// It loses what of the first bounce does not vary linearly with the direction, and that further bounces are more even than it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Scattering {
    /// Share that does not depend on the direction. Under a uniform sky it alone counts, and is exact.
    pub even: f32,
    /// How it changes with the direction's x and y.
    pub slope: Vec2,
    /// From one bounce to the next.
    pub gain: f32,
}

impl Scattering {
    /// Irradiance by scattered light, in that of an unblocked surface that faces up, for light from the unit direction `l`.
    pub fn irradiance(&self, l: Vec3, albedo: f32) -> f32 {
        (self.even + self.slope.dot(l.truncate())).max(0.0) * albedo / (1.0 - albedo * self.gain)
    }
}

/// Scattered irradiance of every texel from one light, bounce by bounce: the paper's chain of dependent lookups.
pub struct Bounces {
    /// What each texel sees, [`PATHS`] a texel.
    seen: Vec<u32>,
}

impl Bounces {
    /// Looks around every texel of a field.
    pub fn new(field: &Field<'_>, horizons: &Horizons) -> Self {
        let [width, height] = field.size();
        let [one, other] = field.map.range().map(|value| field.scale * value);
        let highest = one.max(other);
        let local = cosine_directions();
        let seen = (0..width * height)
            .into_par_iter()
            .flat_map_iter(|texel| {
                let (x, y) = ((texel % width) as i64, (texel / width) as i64);
                let turn = Quat::from_rotation_arc(Vec3::Z, field.normal(x, y));
                let local = &local;
                (0..PATHS).map(move |i| {
                    let d = turn * local[i];
                    let rises_above = d.z > horizons.towards(texel, d.truncate()) * d.truncate().length();
                    if rises_above && d.z > 0.0 {
                        NONE
                    } else {
                        first_hit(field, [x, y], d, highest).unwrap_or(NONE)
                    }
                })
            })
            .collect();
        Self { seen }
    }

    /// Irradiance that light which leaves the texels with these radiosities brings to each.
    pub fn gathered<const N: usize>(&self, radiosity: &[[f32; N]]) -> Vec<[f32; N]> {
        let of_texel = |seen: &[u32]| {
            let mut sum = [0.0; N];
            for &texel in seen.iter().filter(|&&texel| texel != NONE) {
                for (sum, value) in sum.iter_mut().zip(&radiosity[texel as usize]) {
                    *sum += value;
                }
            }
            sum.map(|sum| sum / PATHS as f32)
        };
        self.seen.par_chunks(PATHS).map(of_texel).collect()
    }

    /// Share of what each texel looks at that is other texels.
    pub fn closed(&self) -> impl Iterator<Item = f32> {
        self.seen
            .chunks(PATHS)
            .map(|seen| seen.iter().filter(|&&texel| texel != NONE).count() as f32 / PATHS as f32)
    }
}

/// Every texel's prepared scattering.
pub(crate) fn scattering(field: &Field<'_>) -> Vec<Scattering> {
    let [width, height] = field.size();
    let horizons = Horizons::new(field, AZIMUTHS);
    let bounces = Bounces::new(field, &horizons);
    let lights = light_directions();
    let direct: Vec<[f32; LIGHTS]> = (0..width * height)
        .into_par_iter()
        .map(|texel| {
            let n = field.normal((texel % width) as i64, (texel / width) as i64);
            lights.map(|l| {
                let open = l.z > horizons.towards(texel, l.truncate()) * l.truncate().length();
                if open { n.dot(l).max(0.0) } else { 0.0 }
            })
        })
        .collect();
    let first = bounces.gathered(&direct);
    // Under a uniform sky.
    let mean: Vec<[f32; 1]> = first.iter().map(|first| [first.iter().sum::<f32>() / LIGHTS as f32]).collect();
    let second = bounces.gathered(&mean);
    let squares: Vec2 = lights.iter().map(|l| l.z * l.z * l.truncate() * l.truncate()).sum();
    let of_texel = |((first, [mean]), [second]): ((&[f32; LIGHTS], &[f32; 1]), &[f32; 1])| {
        // Directions are even over the hemisphere, where the mean of z is a half.
        let even = 2.0 * mean;
        let rest = first.iter().zip(&lights).map(|(first, l)| (first - even * l.z) * l.z * l.truncate());
        let gain = if *mean > 1e-6 { (second / mean).min(GREATEST_GAIN) } else { 0.0 };
        Scattering { even, slope: rest.sum::<Vec2>() / squares, gain }
    };
    first.iter().zip(&mean).zip(&second).map(of_texel).collect()
}

/// The texel where a ray from a texel's centre first goes below the field.
fn first_hit(field: &Field<'_>, [x, y]: [i64; 2], d: Vec3, highest: f32) -> Option<u32> {
    let [width, height] = field.size();
    let start = Vec2::new(x as f32, y as f32);
    let from = field.texel(x, y);
    let per_metre = d.truncate() / field.spacing;
    let step = 0.5 / per_metre.abs().max_element().max(1e-9);
    let longest = 2 * (width + height);
    let mut above = 0.0;
    for i in 1..=longest {
        let t = i as f32 * step;
        let z = from + t * d.z;
        if z > highest && d.z > 0.0 {
            return None;
        }
        let gap = z - field.at(start + t * per_metre)?;
        if gap < 0.0 {
            // Where the gap closes between the last step and this one.
            let share = if above > 0.0 { above / (above - gap) } else { 1.0 };
            let hit = start + (t - step + share * step) * per_metre;
            let wraps = field.map.wrap();
            let place =
                |value: f32, axis: usize, size: usize| wraps[axis].texel(value.round() as i64, size as u32);
            return Some((place(hit.y, 1, height) * width + place(hit.x, 0, width)) as u32);
        }
        above = gap;
    }
    None
}

/// Directions about z with the density of their cosine, spread evenly (Vogel 1979).
fn cosine_directions() -> [Vec3; PATHS] {
    const GOLDEN_ANGLE: f32 = 2.399_963_2;
    std::array::from_fn(|i| {
        let squared = (i as f32 + 0.5) / PATHS as f32;
        (squared.sqrt() * Vec2::from_angle(GOLDEN_ANGLE * i as f32)).extend((1.0 - squared).sqrt())
    })
}

/// Directions spread evenly over the upper hemisphere.
fn light_directions() -> [Vec3; LIGHTS] {
    const GOLDEN_ANGLE: f32 = 2.399_963_2;
    std::array::from_fn(|i| {
        let z = (i as f32 + 0.5) / LIGHTS as f32;
        ((1.0 - z * z).sqrt() * Vec2::from_angle(GOLDEN_ANGLE * i as f32)).extend(z)
    })
}
