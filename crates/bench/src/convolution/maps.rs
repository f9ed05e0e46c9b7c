use std::collections::BTreeMap;

use gnomon_image::RgbImage;
use gnomon_metrics::Comparison;
use gnomon_report::{Axis, Cell, ContactSheet, Panel, Plot, Section, Series, Table, significant};

use super::common::{fits, stand_ins};
use super::variant::{Drawn, Variant};
use crate::pictures::{difference, shown};
use crate::{BenchError, Environment, Experiment, Lab, Setup, Stage, Truth};

/// Error under every environment map with every light fit.
pub(super) struct Maps;

/// Environments at full effort.
const ENVIRONMENTS: [&str; 7] = ["grace", "stpeters", "galileo", "kitchen", "rnl", "studio", "sunny"];

/// Relative RMSE that a picture may have with 60 to 80 lights, and with any number.
const GOALS: [f64; 2] = [0.05, 0.035];

/// Errors of one scene under one environment, by fit and number of lights asked for.
struct Subject {
    scene: &'static str,
    environment: &'static str,
    truth: String,
    noise: Option<f64>,
    unshadowed: f64,
    errors: BTreeMap<(usize, &'static str), f64>,
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
        let counts: &[usize] = lab.pick(&[6], &[60], &[60, 80, 240]);
        let size = lab.pick([32, 24], [128, 96], [128, 96]);
        let columns = [
            ("scene", ""),
            ("environment", ""),
            ("fit", ""),
            ("lights asked for", ""),
            ("lights", ""),
            ("relative RMSE", ""),
            ("relative bias", ""),
            ("FLIP, weighted median", ""),
        ];
        let caption = "Every picture: convolution, mip maps, M = 4, ratio compositing";
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
                let scenery = Scenery { lab, stage, environment, truth: &truth, size };
                subjects.push(scenery.subject(counts, &mut all, &mut sheet)?);
            }
            sheets.push(sheet);
        }
        let mut tables: Vec<Table> = counts.iter().map(|&count| summary(&subjects, count)).collect();
        tables.push(all);
        let (stages, environments): (Vec<&Stage>, Vec<&Environment>) =
            (stages.iter().map(AsRef::as_ref).collect(), environments.iter().map(AsRef::as_ref).collect());
        let mut paragraphs = vec![format!(
            "{} x {} pixels of 2 x 2 samples, Lambert, shadow maps of {} texels a side; the goals are {} with 60 to 80 lights and {} \
             with any number.",
            size[0],
            size[1],
            resolution(lab),
            GOALS[0],
            GOALS[1]
        )];
        paragraphs.push(verdict(&subjects, counts));
        paragraphs.extend(stand_ins(&stages, &environments));
        Ok(Section { paragraphs, tables, plots: vec![plot(&subjects, counts)], sheets, ..Section::default() })
    }
}

fn resolution(lab: &Lab<'_>) -> u32 {
    lab.pick(32, 128, 256)
}

struct Scenery<'s, 'gpu> {
    lab: &'s Lab<'gpu>,
    stage: &'s Stage,
    environment: &'s Environment,
    truth: &'s Truth,
    size: [u32; 2],
}

impl Scenery<'_, '_> {
    fn subject(
        &self,
        counts: &[usize],
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
            errors: BTreeMap::new(),
        };
        let mut best: Option<(String, RgbImage, Comparison)> = None;
        for &count in counts {
            for method in fits() {
                let lights = self.lab.lights(method, count, self.environment)?;
                let setup =
                    Setup { stage: self.stage, map: &self.environment.map, lights: &lights, size: self.size };
                if subject.unshadowed.is_nan() {
                    let none = Variant::technique("none");
                    if let Some(none) = Drawn::new(self.lab, &none, setup, 16, "ratio", truth)? {
                        subject.unshadowed = none.comparison.relative_rmse;
                        all.push(self.row("no shadows", None, 0, &none.comparison));
                    }
                }
                let drawn =
                    Drawn::new(self.lab, &Variant::mip(4), setup, resolution(self.lab), "ratio", truth)?;
                let Some(drawn) = drawn else { continue };
                all.push(self.row(method, Some(count), lights.lights.len(), &drawn.comparison));
                subject.errors.insert((count, method), drawn.comparison.relative_rmse);
                let Drawn { picture, comparison, .. } = drawn;
                let least = best.as_ref().map_or(f64::INFINITY, |(_, _, best)| best.relative_rmse);
                if comparison.relative_rmse < least {
                    best = Some((format!("{} {method}", lights.lights.len()), picture, comparison));
                }
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

    fn row(&self, method: &str, asked: Option<usize>, found: usize, comparison: &Comparison) -> [Cell; 8] {
        [
            self.stage.name.into(),
            self.environment.name.into(),
            method.into(),
            asked.into(),
            found.into(),
            comparison.relative_rmse.into(),
            comparison.relative_bias.into(),
            f64::from(comparison.flip.weighted_median).into(),
        ]
    }
}

/// One row a scene and environment, one column a fit.
fn summary(subjects: &[Subject], count: usize) -> Table {
    let mut columns = vec![("scene", ""), ("environment", ""), ("no shadows", "")];
    columns.extend(fits().into_iter().map(|fit| (fit, "")));
    columns.extend([("noise of the truth", ""), ("truth", "")]);
    let caption = format!("Relative RMSE with {count} lights asked for");
    let mut table = Table::new(format!("maps_{count}"), caption, &columns);
    for subject in subjects {
        let mut row: Vec<Cell> =
            vec![subject.scene.into(), subject.environment.into(), subject.unshadowed.into()];
        row.extend(fits().into_iter().map(|fit| subject.errors.get(&(count, fit)).copied().into()));
        row.extend([subject.noise.into(), subject.truth.as_str().into()]);
        table.push(row);
    }
    table
}

/// How many subjects reach the goals, and with which fit.
fn verdict(subjects: &[Subject], counts: &[usize]) -> String {
    let reached = |limit: f64, fit: &str, counts: &[usize]| {
        let error = |subject: &&Subject| {
            let errors = counts.iter().filter_map(|count| subject.errors.get(&(*count, fit)));
            errors.copied().fold(f64::INFINITY, f64::min) <= limit
        };
        subjects.iter().filter(error).count()
    };
    let few: Vec<usize> = counts.iter().copied().filter(|count| (60..=80).contains(count)).collect();
    let words: Vec<String> = fits()
        .into_iter()
        .map(|fit| format!("{fit} {} and {}", reached(GOALS[0], fit, &few), reached(GOALS[1], fit, counts)))
        .collect();
    format!(
        "Of {} pairs of scene and environment, so many reach the first and the second goal: {}.",
        subjects.len(),
        words.join("; ")
    )
}

/// Geometric mean of the error over all subjects against the number of lights.
fn plot(subjects: &[Subject], counts: &[usize]) -> Plot {
    let mut plot = Plot::new(
        "maps",
        "Error against lights, geometric mean over scenes and maps",
        Axis::logarithmic("lights asked for", "")
            .with_ticks(counts.iter().map(|&count| count as f64).collect()),
        Axis::logarithmic("relative RMSE", ""),
    );
    for fit in fits() {
        let mean = |count: usize| {
            let logarithms =
                subjects.iter().filter_map(|subject| Some(subject.errors.get(&(count, fit))?.ln()));
            let logarithms: Vec<f64> = logarithms.collect();
            (logarithms.iter().sum::<f64>() / logarithms.len() as f64).exp()
        };
        let points = counts.iter().map(|&count| (count as f64, mean(count))).collect();
        plot.series.push(Series::new(fit, points));
    }
    plot
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn goals_are_counted_by_fit() {
        let subject = |error: f64| Subject {
            scene: "s",
            environment: "e",
            truth: String::new(),
            noise: None,
            unshadowed: 0.2,
            errors: BTreeMap::from([((60, "disks"), error), ((200, "disks"), 0.5 * error)]),
        };
        let subjects = [subject(0.06), subject(0.04), subject(0.2)];
        // With 60 lights one is under 0.05; with any number two are under 0.035.
        assert!(verdict(&subjects, &[60, 200]).contains("disks 1 and 2"));
        let table = summary(&subjects, 60);
        assert_eq!(table.rows()[1][3], Cell::Number(0.04));
        let points = &plot(&subjects, &[60]).series[0].points;
        assert!((points[0].1 - (0.06 * 0.04 * 0.2_f64).cbrt()).abs() < 1e-12);
    }
}
