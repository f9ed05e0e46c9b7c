//! What the experiments of this suite share.

use glam::{DVec2, DVec3, Vec3};
use gnomon_envmap::Equirect;
use gnomon_image::RgbImage;
use gnomon_lights::{DistantLight, LightSet, fit};
use gnomon_report::Cell;

use crate::timing::{Spread, TimingPlan};
use crate::{Environment, Lab, Stage};

/// The light fits that are compared, in the order of tables, as far as they exist.
pub(super) fn fits() -> Vec<&'static str> {
    let wanted = ["disks", "squares", "rectangles", "partition"];
    wanted.into_iter().filter(|name| fit_exists(name)).collect()
}

/// Whether a light fit is registered.
pub(super) fn fit_exists(name: &str) -> bool {
    fit::methods().iter().any(|method| method.name == name)
}

/// One lamp in the dark: a distant square, ten degrees wide, high on the left of a default camera. Irradiance across the beam is pi, so that a white surface there has radiance 1.
pub(super) struct Lamp {
    pub lights: LightSet,
    pub map: Equirect,
}

/// Half the lamp's side on the plane at distance 1: tan 5 degrees.
const HALF_SIDE: f64 = 0.087_488_66;

impl Lamp {
    pub fn new() -> Self {
        let map = Equirect::new(RgbImage::filled(64, 32, Vec3::ZERO));
        let forward = DVec3::new(-0.5, 1.1, 0.5).normalize();
        let right = forward.cross(DVec3::Y).normalize();
        let up = right.cross(forward);
        let half = DVec2::splat(HALF_SIDE);
        let flux = DVec3::splat(std::f64::consts::PI);
        let light = DistantLight::rectangle([right, up, forward], -half, half, flux);
        Self { lights: LightSet::new("one lamp", vec![light], map.clone()), map }
    }
}

/// How long rivals are timed; `seconds` is for the full effort.
pub(super) fn plan(lab: &Lab<'_>, seconds: f64) -> TimingPlan {
    TimingPlan {
        rounds: lab.pick(1, 7, 15),
        seconds: lab.pick(0.0, 0.3 * seconds, seconds),
        least_rounds: lab.pick(1, 2, 5),
    }
}

/// Median, minimum and quartiles, for four columns [ms].
pub(super) fn time_cells(spread: Option<&Spread>) -> [Cell; 4] {
    let cell = |value: fn(&Spread) -> f64| Cell::from(spread.map(value));
    [
        cell(|spread| spread.median),
        cell(|spread| spread.minimum),
        cell(|spread| spread.first_quartile),
        cell(|spread| spread.third_quartile),
    ]
}

/// Headings of [`time_cells`].
pub(super) const TIME_COLUMNS: [(&str, &str); 4] =
    [("frame, median", "ms"), ("minimum", "ms"), ("first quartile", "ms"), ("third quartile", "ms")];

/// Mebibytes.
pub(super) fn mebibytes(bytes: u64) -> f64 {
    bytes as f64 / f64::from(1 << 20)
}

/// One sentence for each scene or environment for which a built-in stands in.
pub(super) fn stand_ins(stages: &[&Stage], environments: &[&Environment]) -> Vec<String> {
    let sentence = |what: &str, name: &str, stand_in: &str| {
        format!("The {what} '{name}' is not in the data folder; the built-in '{stand_in}' stands in for it.")
    };
    let stages = stages.iter().filter_map(|stage| Some(sentence("scene", stage.name, stage.stand_in?)));
    let environments = environments
        .iter()
        .filter_map(|environment| Some(sentence("environment", environment.name, environment.stand_in?)));
    stages.chain(environments).collect()
}
