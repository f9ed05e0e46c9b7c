use gnomon_image::RgbImage;
use gnomon_metrics::Comparison;
use gnomon_report::{Axis, Cell, ContactSheet, Panel, Plot, Section, Series, Table, significant};

use super::common::{maps_by_footprint, mebibytes, stand_ins};
use super::variant::{Drawn, Variant};
use crate::pictures::{difference, shown};
use crate::{BenchError, Environment, Experiment, Lab, Setup, Stage, Truth};

/// Error under every environment map.
pub(super) struct Maps;

/// Environments at full effort.
const ENVIRONMENTS: [&str; 7] = ["grace", "stpeters", "galileo", "kitchen", "rnl", "studio", "sunny"];

/// Relative RMSE that a picture may have with 60 to 80 lights, and with any number.
const GOALS: [f64; 2] = [0.05, 0.035];

/// How an environment becomes lights, and how they cast shadows.
#[derive(Clone, Copy)]
struct Way {
    name: &'static str,
    fit: &'static str,
    /// Lights asked for; the fit's own choice for none.
    count: Option<usize>,
    technique: &'static str,
}

const fn way(name: &'static str, fit: &'static str, count: Option<usize>, technique: &'static str) -> Way {
    Way { name, fit, count, technique }
}

/// The columns of the table.
const WAYS: [Way; 7] = [
    way("disks + cells", "disks", None, "convolution"),
    way("partition 60", "partition", Some(60), "convolution"),
    way("partition 60, pcss", "partition", Some(60), "pcss"),
    way("partition 80", "partition", Some(80), "convolution"),
    way("partition 200", "partition", Some(200), "convolution"),
    way("squares 60 + cells", "squares", Some(60), "convolution"),
    way("rectangles 60 + cells", "rectangles", Some(60), "convolution"),
];

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

    fn run(&self, lab: &Lab<'_>) -> Result<Section, BenchError> {
        let names: &[&str] = lab.pick(&["grace"], &["grace", "rnl"], &ENVIRONMENTS);
        let environments = lab.environments(names)?;
        let stages =
            lab.stages(lab.pick(&["three_boxes"], &["three_boxes", "bunny"], &["three_boxes", "bunny"]))?;
        let ways = lab.pick(&WAYS[..2], &WAYS[..5], &WAYS);
        let size = lab.pick([32, 24], [128, 96], [128, 96]);
        let resolution = lab.pick(32, 256, 256);
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
        let caption = "Every picture: ratio compositing; convolution with mip maps and M = 4";
        let mut all = Table::new("maps_all", caption, &columns);
        let mut subjects = Vec::new();
        let mut sheets = Vec::new();
        let steps = (stages.len() * environments.len()).max(1) as f32;
        for stage in &stages {
            let mut sheet =
                ContactSheet::new(format!("maps_{}", stage.name), format!("Least error: {}", stage.name), 3);
            sheet.enlargement = 2;
            for environment in &environments {
                let share = subjects.len() as f32 / steps;
                lab.tell(&format!("maps: {}, {}", stage.name, environment.name), share);
                let truth = lab.truth(stage, environment, size, lab.pick(2, 256, 1024))?;
                let scenery = Scenery { lab, stage, environment, truth: &truth, size, resolution };
                subjects.push(scenery.subject(ways, &mut all, &mut sheet)?);
            }
            sheets.push(sheet);
        }
        let (stages, environments): (Vec<&Stage>, Vec<&Environment>) =
            (stages.iter().map(AsRef::as_ref).collect(), environments.iter().map(AsRef::as_ref).collect());
        let mut paragraphs = vec![
            format!(
                "{} x {} pixels of 2 x 2 samples, Lambert. Shadow maps of at most {resolution} texels a side, coarser for wider \
                 lights. 'Cells' are at most {} further lights that tile what a fit leaves over; a partition leaves nothing. The \
                 goals are {} with 60 to 80 lights and {} with any number.",
                size[0],
                size[1],
                maps_by_footprint(resolution).ambient_cells,
                GOALS[0],
                GOALS[1]
            ),
            verdict(&subjects, ways),
        ];
        paragraphs.extend(stand_ins(&stages, &environments));
        let (tables, plots) = (vec![summary(&subjects, ways), all], vec![plot(&subjects, ways)]);
        Ok(Section { paragraphs, tables, plots, sheets, ..Section::default() })
    }
}

struct Scenery<'s, 'gpu> {
    lab: &'s Lab<'gpu>,
    stage: &'s Stage,
    environment: &'s Environment,
    truth: &'s Truth,
    size: [u32; 2],
    resolution: u32,
}

impl Scenery<'_, '_> {
    fn subject(
        &self,
        ways: &[Way],
        all: &mut Table,
        sheet: &mut ContactSheet,
    ) -> Result<Subject, BenchError> {
        let truth = &self.truth.picture;
        let mut subject = Subject {
            scene: self.stage.name,
            environment: self.environment.name,
            truth: self.truth.source.clone(),
            noise: self.truth.noise,
            unshadowed: f64::NAN,
            errors: Vec::new(),
        };
        let frame = maps_by_footprint(self.resolution);
        let mut best: Option<(String, RgbImage, Comparison)> = None;
        for way in ways {
            let lights = self.lab.lights(way.fit, way.count, self.environment)?;
            let setup =
                Setup { stage: self.stage, map: &self.environment.map, lights: &lights, size: self.size };
            if subject.unshadowed.is_nan()
                && let Some(none) = Drawn::new(self.lab, &Variant::technique("none"), setup, &frame, truth)?
            {
                subject.unshadowed = none.comparison.relative_rmse;
                all.push(self.row("no shadows", lights.lights.len(), &none));
            }
            let variant = if way.technique == "convolution" {
                Variant::mip(4)
            } else {
                Variant::technique(way.technique)
            };
            let drawn = Drawn::new(self.lab, &variant, setup, &frame, truth)?;
            subject.errors.push(drawn.as_ref().map(|drawn| drawn.comparison.relative_rmse));
            let Some(drawn) = drawn else { continue };
            all.push(self.row(way.name, lights.lights.len(), &drawn));
            let Drawn { picture, comparison, .. } = drawn;
            let least = best.as_ref().map_or(f64::INFINITY, |(_, _, best)| best.relative_rmse);
            if comparison.relative_rmse < least {
                best = Some((way.name.to_owned(), picture, comparison));
            }
        }
        if let Some((name, picture, comparison)) = best {
            let environment = self.environment.name;
            let stops = comparison.exposure;
            let error = significant(comparison.relative_rmse, 3);
            sheet.panels.extend([
                Panel::new(format!("{environment}\ntruth: {}", self.truth.source), shown(truth, stops)),
                Panel::new(format!("{name}\nRMSE {error}"), shown(&picture, stops)),
                Panel::new("picture - truth", difference(&picture, truth)?),
            ]);
        }
        Ok(subject)
    }

    fn row(&self, way: &str, lights: usize, drawn: &Drawn<'_>) -> [Cell; 8] {
        [
            self.stage.name.into(),
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

/// One row a scene and environment, one column a way, and the worst of every column.
fn summary(subjects: &[Subject], ways: &[Way]) -> Table {
    let mut columns = vec![("scene", ""), ("environment", ""), ("no shadows", "")];
    columns.extend(ways.iter().map(|way| (way.name, "")));
    columns.extend([("noise of the truth", ""), ("truth", "")]);
    let mut table = Table::new("maps", "Relative RMSE", &columns);
    for subject in subjects {
        let mut row: Vec<Cell> =
            vec![subject.scene.into(), subject.environment.into(), subject.unshadowed.into()];
        row.extend(subject.errors.iter().map(|error| Cell::from(*error)));
        row.extend([subject.noise.into(), subject.truth.as_str().into()]);
        table.push(row);
    }
    let mut row: Vec<Cell> = vec!["worst".into(), Cell::Missing];
    row.push(subjects.iter().map(|subject| subject.unshadowed).reduce(f64::max).into());
    row.extend((0..ways.len()).map(|way| Cell::from(errors(subjects, way).reduce(f64::max))));
    table.push(row);
    table
}

/// The errors of one way, subject by subject, as far as there are any.
fn errors(subjects: &[Subject], way: usize) -> impl Iterator<Item = f64> {
    subjects.iter().filter_map(move |subject| subject.errors.get(way).copied().flatten())
}

/// How many subjects reach the goals, way by way.
fn verdict(subjects: &[Subject], ways: &[Way]) -> String {
    let words: Vec<String> = ways
        .iter()
        .enumerate()
        .map(|(place, way)| {
            let [few, any] = GOALS.map(|goal| errors(subjects, place).filter(|error| *error <= goal).count());
            format!("{} {few} and {any}", way.name)
        })
        .collect();
    format!(
        "Of {} pairs of scene and environment, so many are off by at most {} and by at most {}: {}.",
        subjects.len(),
        GOALS[0],
        GOALS[1],
        words.join("; ")
    )
}

/// Error of partitions by convolution against the number of lights: geometric mean over all subjects, and the worst.
fn plot(subjects: &[Subject], ways: &[Way]) -> Plot {
    let chosen =
        ways.iter().enumerate().filter(|(_, way)| (way.fit, way.technique) == ("partition", "convolution"));
    let chosen: Vec<(f64, usize)> =
        chosen.filter_map(|(place, way)| Some((way.count? as f64, place))).collect();
    let mut plot = Plot::new(
        "maps",
        "Error against lights: partition, convolution, over scenes and maps",
        Axis::logarithmic("lights", "").with_ticks(chosen.iter().map(|(count, _)| *count).collect()),
        Axis::logarithmic("relative RMSE", ""),
    );
    let mean = |way: usize| {
        let logarithms: Vec<f64> = errors(subjects, way).map(f64::ln).collect();
        (logarithms.iter().sum::<f64>() / logarithms.len() as f64).exp()
    };
    let worst = |way: usize| errors(subjects, way).fold(f64::NAN, f64::max);
    let points = |of: &dyn Fn(usize) -> f64| chosen.iter().map(|(count, way)| (*count, of(*way))).collect();
    plot.series.push(Series::new("geometric mean", points(&mean)));
    plot.series.push(Series::new("worst", points(&worst)));
    plot
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn goals_are_counted_by_way() {
        let subject = |error: f64| Subject {
            scene: "s",
            environment: "e",
            truth: String::new(),
            noise: None,
            unshadowed: 0.2,
            errors: vec![None, Some(error)],
        };
        let subjects = [subject(0.06), subject(0.04), subject(0.03)];
        let verdict = verdict(&subjects, &WAYS[..2]);
        assert!(verdict.contains("disks + cells 0 and 0; partition 60 2 and 1"), "{verdict}");
        let table = summary(&subjects, &WAYS[..2]);
        assert_eq!(table.rows()[1][3..5], [Cell::Missing, Cell::Number(0.04)]);
        assert_eq!(table.rows()[3][3..5], [Cell::Missing, Cell::Number(0.06)]);
        let series = &plot(&subjects, &WAYS[..2]).series;
        assert!((series[0].points[0].1 - (0.06 * 0.04 * 0.03_f64).cbrt()).abs() < 1e-12);
        assert_eq!(series[1].points, [(60.0, 0.06)]);
    }
}
