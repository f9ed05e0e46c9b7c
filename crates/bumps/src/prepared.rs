use glam::Vec2;
use rayon::prelude::*;

use crate::ellipse::Star;
use crate::scatter::scattering;
use crate::{Ellipse, Field, Horizons, Scattering};
use gnomon_scene::HeightMap;

/// Azimuths by which ellipses are fitted.
const FITTED_AZIMUTHS: usize = 32;
/// Azimuths of horizon maps.
const HORIZON_AZIMUTHS: usize = 8;
/// Largest sides of the maps of what is hidden and of what is scattered: heights are averaged to them.
const LARGEST_SIDES: [u32; 2] = [1024, 256];

/// How the lit directions of a texel are kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Shape {
    /// An ellipse: six numbers.
    Ellipses,
    /// Horizons in eight azimuths, each as t / (1 + t) of the tangent t of its elevation: tangents interpolate best.
    Horizons,
}

/// What is known of a height field, texel by texel.
#[derive(Clone, Debug)]
pub struct Prepared {
    /// Width and height of [`Prepared::lit`].
    pub size: [u32; 2],
    /// Of an ellipse: centre x and y, shape x x, x y and y y, and the share of the hemisphere that is lit; two more zeros. Or eight horizons.
    pub lit: Vec<[f32; 8]>,
    /// Width and height of [`Prepared::scattered`].
    pub scattered_size: [u32; 2],
    /// Empty where it was not asked for.
    pub scattered: Vec<Scattering>,
}

impl Prepared {
    /// Of a map that lies on a surface with so many metres along its width and height, its unit `scale` metres high.
    pub fn new(map: &HeightMap, scale: f32, extent: Vec2, shape: Shape, scatters: bool) -> Self {
        let hidden = map.at_most(LARGEST_SIDES[0]);
        let field = Field::new(&hidden, scale, extent);
        let lit = match shape {
            Shape::Ellipses => ellipses(&field)
                .into_iter()
                .map(|(ellipse, area)| {
                    let [xx, xy, yy] = ellipse.shape();
                    [ellipse.center.x, ellipse.center.y, xx, xy, yy, area, 0.0, 0.0]
                })
                .collect(),
            Shape::Horizons => {
                let horizons = Horizons::new(&field, HORIZON_AZIMUTHS);
                let texels = 0..(hidden.size()[0] * hidden.size()[1]) as usize;
                texels
                    .map(|texel| std::array::from_fn(|i| horizons.of(texel)[i]).map(|t: f32| t / (1.0 + t)))
                    .collect()
            }
        };
        let coarse = map.at_most(LARGEST_SIDES[1]);
        let scattered = if scatters { scattering(&Field::new(&coarse, scale, extent)) } else { Vec::new() };
        Self { size: hidden.size(), lit, scattered_size: coarse.size(), scattered }
    }
}

/// The ellipse of every texel, and the share of the hemisphere that is lit.
pub(crate) fn ellipses(field: &Field<'_>) -> Vec<(Ellipse, f32)> {
    let [width, height] = field.size();
    let horizons = Horizons::new(field, FITTED_AZIMUTHS);
    let azimuths: Vec<Vec2> = (0..FITTED_AZIMUTHS)
        .map(|i| Vec2::from_angle(std::f32::consts::TAU * i as f32 / FITTED_AZIMUTHS as f32))
        .collect();
    let fitted = |texel: usize| {
        let mut radii = [0.0; FITTED_AZIMUTHS];
        for (radius, slope) in radii.iter_mut().zip(horizons.of(texel)) {
            *radius = 1.0 / (1.0 + slope * slope).sqrt();
        }
        let star = Star { azimuths: &azimuths, radii: &radii };
        (star.fitted(), star.area())
    };
    (0..width * height).into_par_iter().map(fitted).collect()
}
