//! Reflectance as sums of products of small tables (Heidrich 2001, section 1.1; Kautz and McCool 1999): what analytic models, elliptical
//! lobes and measurements become alike, here and in `brdf_tables.wgsl`.

mod coordinates;
mod proposal;
mod table;

use std::f32::consts::{FRAC_1_PI, FRAC_PI_2, PI, TAU};

use glam::{Vec2, Vec3, Vec4};

pub use coordinates::Coordinates;
pub use proposal::Proposal;
pub use table::{Table, spread_place, unspread_place};

use crate::sampling::{half_vector, hammersley, reflect};
use crate::{LightPatch, MIN_N_DOT_V, sample_cosine_hemisphere};

/// What of [`crate::Lobe::tint`] a term is multiplied by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Tint {
    /// Its colour: of models with Schlick's Fresnel the reflectance along the normal.
    Color = 1,
    /// Its w: that at grazing incidence.
    Grazing = 2,
}

/// A table and what it is looked up with.
#[derive(Clone, Debug, PartialEq)]
pub struct Factor {
    /// Arguments.
    pub coordinates: Coordinates,
    /// Where the first argument's columns lie, see [`spread_place`].
    pub scale: f32,
    /// Values.
    pub table: Table,
}

/// A product of tables.
#[derive(Clone, Debug, PartialEq)]
pub struct Term {
    /// What tints it.
    pub tint: Tint,
    /// Factors, at least one.
    pub factors: Vec<Factor>,
}

/// A glossy part of a surface as tables [1/sr, without the cosine]: a sum of terms, 0 where that is negative.
#[derive(Clone, Debug, PartialEq)]
pub struct Tables {
    terms: Vec<Term>,
    /// Angle from the surface's tangent to the tables' x axis, counter-clockwise [rad].
    turn: f32,
    /// Share of uniform light that terms of either tint reflect, by the cosine to the viewer.
    albedo: Table,
    /// Most of it, towards any view and of any channel.
    most: f32,
    proposal: Proposal,
    /// That of a GGX lobe about as wide.
    roughness: f32,
}

/// Chance of a sample about a half vector; the others are distributed as the cosine, so that what a table holds far from its lobe is
/// found, too.
pub const PROPOSAL_SHARE: f32 = 0.85;
/// Columns of the albedo's table.
const ALBEDO_COLUMNS: usize = 16;
/// Where they lie: closest at grazing views.
const ALBEDO_SCALE: f32 = 0.3;
/// Points on a light, and of the lobe, that its highlight is summed over.
pub const LIGHT_POINTS: u32 = 16;
/// Half the width of the border over which a light fades out, in its half sides: without it a highlight would jump as points cross.
pub const LIGHT_BORDER: f32 = 0.15;

impl Tables {
    /// Tables of these terms, whose x axis is the tangent turned by `turn` [rad].
    pub fn new(terms: Vec<Term>, turn: f32) -> Self {
        let value = |wo: Vec3, wi: Vec3| sum(&terms, Vec4::ONE, wo, wi);
        let is_isotropic = terms.iter().flat_map(|term| &term.factors).all(Factor::is_isotropic);
        let proposal = Proposal::new(is_isotropic, narrowest(&terms), &value);
        let roughness = proposal.equivalent_roughness();
        let tints = [Vec4::new(1.0, 1.0, 1.0, 0.0), Vec4::new(0.0, 0.0, 0.0, 1.0)];
        let (mut albedo, mut most) = (Vec::new(), 0.0f32);
        for tint in tints {
            for column in 0..ALBEDO_COLUMNS {
                let place = column as f32 / (ALBEDO_COLUMNS - 1) as f32;
                let n_dot_v = unspread_place(place, ALBEDO_SCALE).max(MIN_N_DOT_V);
                let views = proposal.reflected(n_dot_v, |wo, wi| sum(&terms, tint, wo, wi));
                albedo.push(views.iter().sum::<Vec3>() / views.len() as f32);
                most = views.iter().map(|view| view.max_element()).fold(most, f32::max);
            }
        }
        let albedo = Table { columns: ALBEDO_COLUMNS, values: albedo };
        Self { terms, turn, albedo, most, proposal, roughness }
    }

    /// The same, scaled so that under uniform light it reflects `most` of it in the brightest direction and channel.
    #[must_use]
    pub fn normalized(mut self, most: f32) -> Self {
        if self.most > 0.0 {
            self.scale(most / self.most);
        }
        self
    }

    /// Most that is reflected of uniform light, towards any view and of any channel.
    pub fn most(&self) -> f32 {
        self.most
    }

    /// Multiplies all of it.
    pub fn scale(&mut self, by: f32) {
        for term in &mut self.terms {
            if let Some(first) = term.factors.first_mut() {
                first.table.scale(by);
            }
        }
        self.albedo.scale(by);
        self.most *= by;
    }

    /// Its terms.
    pub fn terms(&self) -> &[Term] {
        &self.terms
    }

    /// Angle from the surface's tangent to the tables' x axis [rad].
    pub fn turn(&self) -> f32 {
        self.turn
    }

    /// Share of uniform light that is reflected: rows for either tint, columns as [`Tables::ALBEDO_SCALE`] spreads the cosine.
    pub fn albedo_table(&self) -> &Table {
        &self.albedo
    }

    /// See [`Tables::albedo_table`].
    pub const ALBEDO_SCALE: f32 = ALBEDO_SCALE;

    /// What samples are drawn from.
    pub fn proposal(&self) -> &Proposal {
        &self.proposal
    }

    /// Roughness of a GGX lobe about as wide.
    pub fn roughness(&self) -> f32 {
        self.roughness
    }

    /// Bytes on the GPU, four floats a value.
    pub fn bytes(&self) -> usize {
        let factors = self.terms.iter().flat_map(|term| &term.factors).map(|factor| &factor.table);
        let tables = factors.chain([&self.albedo, self.proposal.table()]);
        16 * tables.map(|table| table.values().len()).sum::<usize>()
    }

    /// Value under a tint [1/sr]; `wi` lies above the surface.
    pub(crate) fn value(&self, tint: Vec4, wo: Vec3, wi: Vec3) -> Vec3 {
        sum(&self.terms, tint, self.turned(wo), self.turned(wi))
    }

    /// A direction about in proportion to the value times the cosine.
    pub(crate) fn sample(&self, wo: Vec3, u: Vec2) -> Vec3 {
        if u.x >= PROPOSAL_SHARE {
            let rest = (u.x - PROPOSAL_SHARE) / (1.0 - PROPOSAL_SHARE);
            return sample_cosine_hemisphere(Vec2::new(rest.min(1.0 - f32::EPSILON), u.y));
        }
        let h = self.proposal.sample(Vec2::new(u.x / PROPOSAL_SHARE, u.y));
        reflect(turned(h, self.turn), wo)
    }

    /// Density of `sample` [1/sr of `wi`].
    pub(crate) fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        let h = half_vector(wo, wi);
        let v_dot_h = wo.dot(h);
        let about = if h.z > 0.0 && v_dot_h > 0.0 {
            self.proposal.density(self.turned(h)) / (4.0 * v_dot_h)
        } else {
            0.0
        };
        PROPOSAL_SHARE * about + (1.0 - PROPOSAL_SHARE) * FRAC_1_PI * wi.z
    }

    /// Share of uniform light that is reflected under a tint.
    pub(crate) fn albedo(&self, tint: Vec4, n_dot_v: f32) -> Vec3 {
        let x = spread_place(n_dot_v, ALBEDO_SCALE);
        tint.truncate() * self.albedo.at(x, 0.0, false) + tint.w * self.albedo.at(x, 1.0, false)
    }

    /// Integral of the value times the cosine over an area light: points on the light and of the lobe, each weighed by what the other
    /// would have found (Veach 1997, balance heuristic), so that neither has to be the narrower one.
    pub(crate) fn light_lobe(&self, tint: Vec4, wo: Vec3, light: &LightPatch) -> Vec3 {
        let (aa, bb) = (light.half_width.length_squared(), light.half_height.length_squared());
        let ab = light.half_width.dot(light.half_height);
        let area2 = (aa * bb - ab * ab).max(1e-30);
        let light_pdf = 1.0 / (area2.sqrt() * if light.is_disk { PI } else { 4.0 });
        let reflected = |wi: Vec3| {
            let both = self.pdf(wo, wi) + light_pdf;
            self.value(tint, wo, wi) * (wi.z / both)
        };
        let mut sum = Vec3::ZERO;
        for i in 0..LIGHT_POINTS {
            let u = hammersley(i, LIGHT_POINTS);
            let [x, y] = match light.is_disk {
                true => {
                    let (sin, cos) = (TAU * u.y).sin_cos();
                    [u.x.sqrt() * cos, u.x.sqrt() * sin]
                }
                false => [2.0 * u.x - 1.0, 2.0 * u.y - 1.0],
            };
            let wi = (light.direction + light.half_width * x + light.half_height * y).normalize();
            if wi.z > 0.0 {
                sum += reflected(wi);
            }
            let wi = self.sample(wo, u);
            let towards = wi.dot(light.direction);
            if wi.z > 0.0 && towards > 0.0 {
                let at = wi / towards;
                let (a, b) = (at.dot(light.half_width), at.dot(light.half_height));
                let place = Vec2::new(a * bb - b * ab, b * aa - a * ab) / area2;
                let out = if light.is_disk { place.length() } else { place.abs().max_element() };
                let inside = ((1.0 + LIGHT_BORDER - out) / (2.0 * LIGHT_BORDER)).clamp(0.0, 1.0);
                if inside > 0.0 {
                    sum += inside * reflected(wi);
                }
            }
        }
        sum / LIGHT_POINTS as f32
    }

    /// A direction in the tables' own frame.
    fn turned(&self, direction: Vec3) -> Vec3 {
        turned(direction, -self.turn)
    }
}

fn turned(direction: Vec3, angle: f32) -> Vec3 {
    let (sin, cos) = angle.sin_cos();
    Vec3::new(cos * direction.x - sin * direction.y, sin * direction.x + cos * direction.y, direction.z)
}

fn sum(terms: &[Term], tint: Vec4, wo: Vec3, wi: Vec3) -> Vec3 {
    let of_term = |term: &Term| {
        let product = term.factors.iter().fold(Vec3::ONE, |product, f| product * f.value(wo, wi));
        product * if term.tint == Tint::Color { tint.truncate() } else { Vec3::splat(tint.w) }
    };
    terms.iter().map(of_term).sum::<Vec3>().max(Vec3::ZERO)
}

/// Least scale of a table of half vectors: about as wide as the lobe.
fn narrowest(terms: &[Term]) -> f32 {
    let of_half = terms.iter().flat_map(|term| &term.factors).filter(|f| f.coordinates.is_of_half_vector());
    of_half.map(|factor| factor.scale).fold(1.0, f32::min)
}

impl Factor {
    /// A table of what `value` is at the arguments: both in `[0, 1]` as [`Coordinates`] has them.
    pub fn new(
        coordinates: Coordinates,
        scale: f32,
        [columns, rows]: [usize; 2],
        value: impl Fn(f32, f32) -> Vec3,
    ) -> Self {
        let table = Table::from_fn(columns, rows, |x, y| {
            let y = if coordinates.is_periodic() { y * (rows - 1) as f32 / rows as f32 } else { y };
            let [first, second] = coordinates.spread_both(scale);
            value(unspread_place(x, first), unspread_place(y, second))
        });
        Self { coordinates, scale, table }
    }

    /// Whether a turn of both directions about the normal changes nothing.
    fn is_isotropic(&self) -> bool {
        self.coordinates.is_isotropic() || (self.table.rows() == 1 && !self.coordinates.is_about_tangent())
    }

    /// Its value between two directions.
    pub fn value(&self, wo: Vec3, wi: Vec3) -> Vec3 {
        let [x, y] = self.coordinates.arguments(wo, wi);
        let [first, second] = self.coordinates.spread_both(self.scale);
        self.table.at(spread_place(x, first), spread_place(y, second), self.coordinates.is_periodic())
    }
}

/// Angle that is this part of a quarter turn [rad].
pub(crate) fn quarter_angle(argument: f32) -> f32 {
    argument * FRAC_PI_2
}
