use gnomon_picture::{ContactSheet, Panel};

use super::common::{FITS, maps_by_footprint};
use super::variant::Variant;
use crate::columns::{mean_and_worst, mebibytes, stand_ins};
use crate::drawn::Drawn;
use crate::pictures::{difference, shown};
use crate::report::{Axis, Cell, Plot, Section, Series, Table};
use crate::{Environment, Experiment, Lab, LabError, Setup, Truth, View};

/// Error under every environment map.
pub(super) struct Maps;

/// Environments at full effort.
const ENVIRONMENTS: [&str; 7] = ["grace", "stpeters", "galileo", "kitchen", "rnl", "studio", "sunny"];

/// How many lights there are in all, how large their maps may be, and how far off a picture may be.
#[derive(Clone, Copy)]
struct Size {
    lights: usize,
    /// Texels along the side of the largest map.
    resolution: u32,
    /// Relative RMSE.
    limit: f64,
}

const SIZES: [Size; 3] = [
    Size { lights: 60, resolution: 256, limit: 0.05 },
    Size { lights: 80, resolution: 256, limit: 0.05 },
    Size { lights: 200, resolution: 512, limit: 0.035 },
];

const TECHNIQUES: [&str; 2] = ["convolution", "pcss"];

/// Of the lights of disks, at least so many are kept for the ambient rest that they leave.
const CELLS: usize = 32;

/// How an environment becomes lights, and how they cast shadows.
#[derive(Clone, Copy)]
struct Way {
    fit: &'static str,
    size: Size,
    technique: &'static str,
}

impl Way {
    /// Every way, those of one fit side by side.
    fn all(fits: &[&'static str], sizes: &[Size]) -> Vec<Self> {
        let of_size = |fit, size| TECHNIQUES.map(|technique| Self { fit, size, technique });
        let of_fit = |&fit| sizes.iter().flat_map(move |&size| of_size(fit, size));
        fits.iter().flat_map(of_fit).collect()
    }

    /// Lights that the fit is asked for.
    fn asked_for(&self) -> usize {
        if self.fit == "disks" { self.size.lights - CELLS } else { self.size.lights }
    }

    fn column(&self) -> String {
        format!("{} lights, {}", self.size.lights, self.technique)
    }

    fn name(&self) -> String {
        format!("{} {}, {}", self.size.lights, self.fit, self.technique)
    }

    fn variant(&self) -> Variant {
        if self.technique == "convolution" { Variant::mip(4) } else { Variant::technique(self.technique) }
    }
}

/// Errors of one scene under one environment.
struct Subject {
    scene: &'static str,
    environment: &'static str,
    truth: String,
    noise: Option<f64>,
    unshadowed: f64,
    /// One for each way; none where the adapter cannot hold it.
    errors: Vec<Option<f64>>,
}

impl Experiment for Maps {
    fn name(&self) -> &'static str {
        "maps"
    }

    fn title(&self) -> &'static str {
        "Error under every environment map"
    }

    fn run(&self, lab: &Lab<'_>) -> Result<Section, LabError> {
        let environments = lab.environments(lab.pick(&["grace"], &["grace", "rnl"], &ENVIRONMENTS))?;
        let views =
            lab.views(lab.pick(&["three_boxes"], &["three_boxes", "bunny"], &["three_boxes", "bunny"]))?;
        let fits: &[&str] = lab.pick(&["disks", "partition"], &["disks", "partition"], &FITS);
        let ways = Way::all(fits, lab.pick(&SIZES[..1], &SIZES[..2], &SIZES));
        let size = lab.pick([32, 24], [128, 96], [128, 96]);
        // Truth pictures of such a size are larger ones made smaller: their edges are smoother than 2 x 2 samples make them.
        let samples = lab.pick(2, 2, 4);
        let columns = [
            ("scene", ""),
            ("environment", ""),
            ("lights and shadows", ""),
            ("lights of the fit", ""),
            ("shadow memory", "MiB"),
            ("relative RMSE", ""),
            ("relative bias", ""),
            ("FLIP, weighted median", ""),
        ];
        let mut all = Table::new("maps_all", "Every picture", &columns);
        let mut subjects = Vec::new();
        let mut sheets = Vec::new();
        let steps = (views.len() * environments.len()).max(1) as f32;
        for view in &views {
            let mut sheet =
                ContactSheet::new(format!("maps_{}", view.name), format!("Least error: {}", view.name), 3);
            sheet.enlargement = 2;
            for environment in &environments {
                let share = subjects.len() as f32 / steps;
                lab.tell(&format!("maps: {}, {}", view.name, environment.name), share);
                let truth = lab.truth(view, environment, size, lab.pick(2, 256, 1024))?;
                let scenery = Scenery { lab, view, environment, truth: &truth, size, samples };
                subjects.push(scenery.subject(&ways, &mut all, &mut sheet)?);
            }
            sheets.push(sheet);
        }
        let mut paragraphs = vec![format!(
            "{} x {} pixels of {samples} x {samples} samples, Lambert, ratio compositing; convolution with mip maps and M = 4. Lights are \
             counted in all: {CELLS} or more of them tile what disks leave over, the other fits leave nothing. \
             Shadow maps are coarser for wider lights and have at most 256 texels a side, 512 with 200 lights.",
            size[0], size[1],
        )];
        paragraphs.extend(stand_ins(&views, &environments));
        let tables = vec![errors_table(&subjects, &ways), all, limits_table(&subjects, &ways)];
        Ok(Section { paragraphs, tables, plots: vec![plot(&subjects, &ways)], sheets, ..Section::default() })
    }
}

struct Scenery<'s, 'gpu> {
    lab: &'s Lab<'gpu>,
    view: &'s View,
    environment: &'s Environment,
    truth: &'s Truth,
    size: [u32; 2],
    /// Along a pixel's side.
    samples: u32,
}

impl Scenery<'_, '_> {
    fn subject(&self, ways: &[Way], all: &mut Table, sheet: &mut ContactSheet) -> Result<Subject, LabError> {
        let truth = &self.truth.picture;
        let mut subject = Subject {
            scene: self.view.name,
            environment: self.environment.name,
            truth: self.truth.source.clone(),
            noise: self.truth.noise,
            unshadowed: f64::NAN,
            errors: Vec::new(),
        };
        let mut sheet_row = None;
        let mut least = f64::INFINITY;
        for way in ways {
            let lights = self.lab.lights(way.fit, Some(way.asked_for()), self.view, self.environment)?;
            let found = lights.lights.len();
            let setup =
                Setup { view: self.view, map: &self.environment.map, lights: &lights, size: self.size };
            let resolution = self.lab.pick(32, way.size.resolution, way.size.resolution);
            let frame = maps_by_footprint(resolution).with(|s| {
                s.techniques.supersample = self.samples;
                s.lighting.ambient_cells = way.size.lights.saturating_sub(found).max(CELLS);
            });
            if subject.unshadowed.is_nan()
                && let Some(none) = Variant::technique("none").drawn(self.lab, setup, &frame, truth)?
            {
                subject.unshadowed = none.comparison.relative_rmse;
                all.push(self.row("no shadows", found, &none));
            }
            let drawn = way.variant().drawn(self.lab, setup, &frame, truth)?;
            subject.errors.push(drawn.as_ref().map(|drawn| drawn.comparison.relative_rmse));
            let Some(drawn) = drawn else { continue };
            all.push(self.row(&way.name(), found, &drawn));
            if drawn.comparison.relative_rmse < least {
                least = drawn.comparison.relative_rmse;
                sheet_row = Some(self.sheet_row(&way.name(), &drawn)?);
            }
        }
        sheet.panels.extend(sheet_row.into_iter().flatten());
        Ok(subject)
    }

    fn sheet_row(&self, name: &str, drawn: &Drawn<'_>) -> Result<[Panel; 3], LabError> {
        let truth = &self.truth.picture;
        let stops = drawn.comparison.exposure;
        let title = format!("{}\ntruth: {}", self.environment.name, self.truth.source);
        Ok([
            Panel::new(title, shown(truth, stops)),
            Panel::new(drawn.caption(name), shown(&drawn.picture, stops)),
            Panel::new("picture - truth", difference(&drawn.picture, truth)?),
        ])
    }

    fn row(&self, way: &str, lights: usize, drawn: &Drawn<'_>) -> [Cell; 8] {
        [
            self.view.name.into(),
            self.environment.name.into(),
            way.into(),
            lights.into(),
            mebibytes(drawn.renderer.shadow_bytes()).into(),
            drawn.comparison.relative_rmse.into(),
            drawn.comparison.relative_bias.into(),
            f64::from(drawn.comparison.flip.weighted_median).into(),
        ]
    }
}

/// One row a scene, environment and fit; one column a number of lights and technique.
fn errors_table(subjects: &[Subject], ways: &[Way]) -> Table {
    let fits: Vec<&[Way]> = ways.chunk_by(|a, b| a.fit == b.fit).collect();
    let names: Vec<String> = fits.first().into_iter().flat_map(|ways| ways.iter().map(Way::column)).collect();
    let mut columns = vec![("scene", ""), ("environment", ""), ("fit", "")];
    columns.extend(names.iter().map(|name| (name.as_str(), "")));
    columns.extend([("no shadows", ""), ("noise of the truth", ""), ("truth", "")]);
    let mut table = Table::new("maps", "Relative RMSE", &columns);
    for subject in subjects {
        let mut errors = subject.errors.iter();
        for ways in &fits {
            let fit = ways.first().map(|way| way.fit);
            let mut row: Vec<Cell> = vec![subject.scene.into(), subject.environment.into(), fit.into()];
            row.extend(errors.by_ref().take(ways.len()).map(|error| Cell::from(*error)));
            row.extend([subject.unshadowed.into(), subject.noise.into(), subject.truth.as_str().into()]);
            table.push(row);
        }
    }
    table
}

/// Mean and worst of every way against the limit.
fn limits_table(subjects: &[Subject], ways: &[Way]) -> Table {
    let columns = [
        ("fit", ""),
        ("lights", ""),
        ("technique", ""),
        ("relative RMSE, mean", ""),
        ("relative RMSE, worst", ""),
        ("limit", ""),
        ("within the limit", ""),
        ("pictures", ""),
    ];
    let mut table =
        Table::new("maps_limits", "Over all scenes and environments, against the limits", &columns);
    for (place, way) in ways.iter().enumerate() {
        let errors: Vec<f64> = errors(subjects, place).collect();
        let over_all = mean_and_worst(&errors);
        table.push([
            way.fit.into(),
            way.size.lights.into(),
            way.technique.into(),
            over_all.map(|[mean, _]| mean).into(),
            over_all.map(|[_, worst]| worst).into(),
            way.size.limit.into(),
            errors.iter().filter(|error| **error <= way.size.limit).count().into(),
            errors.len().into(),
        ]);
    }
    table
}

/// The errors of one way, subject by subject, as far as there are any.
fn errors(subjects: &[Subject], way: usize) -> impl Iterator<Item = f64> {
    subjects.iter().filter_map(move |subject| subject.errors.get(way).copied().flatten())
}

/// Error of every fit and technique against the number of lights: mean over all subjects.
fn plot(subjects: &[Subject], ways: &[Way]) -> Plot {
    let mut ticks: Vec<f64> = ways.iter().map(|way| way.size.lights as f64).collect();
    ticks.sort_by(f64::total_cmp);
    ticks.dedup();
    let mut plot = Plot::new(
        "maps",
        "Error against lights: mean over scenes and maps",
        Axis::logarithmic("lights", "").with_ticks(ticks),
        Axis::logarithmic("relative RMSE", ""),
    );
    for (place, way) in ways.iter().enumerate() {
        let over_all = mean_and_worst(&errors(subjects, place).collect::<Vec<_>>());
        let mean = over_all.map_or(f64::NAN, |[mean, _]| mean);
        let (name, point) = (format!("{}, {}", way.fit, way.technique), (way.size.lights as f64, mean));
        match plot.series.iter_mut().find(|series| series.name == name) {
            Some(series) => series.points.push(point),
            None => plot.series.push(Series::new(name, vec![point])),
        }
    }
    plot
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_counted_by_way() {
        let ways = Way::all(&["disks", "partition"], &SIZES[1..]);
        assert_eq!(ways.len(), 8);
        assert_eq!([ways[0].asked_for(), ways[4].asked_for()], [48, 80]);
        let subject = |error: f64| Subject {
            scene: "s",
            environment: "e",
            truth: String::new(),
            noise: None,
            unshadowed: 0.2,
            errors: [vec![None, Some(error)], vec![Some(0.01); 5], vec![Some(0.5 * error)]].concat(),
        };
        let subjects = [subject(0.06), subject(0.04), subject(0.03)];
        let limits = limits_table(&subjects, &ways);
        // Disks, 80 lights, convolution: nothing was drawn.
        assert_eq!(limits.rows()[0][6..], [Cell::Count(0), Cell::Count(0)]);
        assert_eq!(limits.rows()[1][4..], [0.06.into(), 0.05.into(), Cell::Count(2), Cell::Count(3)]);
        // Partition, 200 lights, pcss.
        assert_eq!(limits.rows()[7][4..], [0.03.into(), 0.035.into(), Cell::Count(3), Cell::Count(3)]);
        let errors = errors_table(&subjects, &ways);
        assert_eq!(errors.rows().len(), 6);
        assert_eq!(errors.rows()[2][2..5], ["disks".into(), Cell::Missing, Cell::Number(0.04)]);
        assert_eq!(errors.rows()[3][6], Cell::Number(0.02));
        let series = &plot(&subjects, &ways).series;
        assert_eq!(series.len(), 4);
        assert!((series[3].points[1].1 - 0.065 / 3.0).abs() < 1e-12, "{:?}", series[3]);
    }
}
