use gnomon_picture::ContactSheet;

use super::common::maps_by_footprint;
use super::variant::Variant;
use crate::columns::{mean_and_worst, mebibytes, stand_ins};
use crate::drawn::time_in_turns;
use crate::pictures::shown;
use crate::report::{Cell, Section, Table};
use crate::{Environment, Experiment, Lab, LabError, Setup, View};

/// The ambient part gets shadows too: ways to shadow what disks leave over, their error and cost.
pub(super) struct AmbientPart;

/// Environments at full effort.
const ENVIRONMENTS: [&str; 7] = ["grace", "stpeters", "galileo", "kitchen", "rnl", "studio", "sunny"];

/// Name in tables, name in the renderer's settings, lights or probes.
const WAYS: [(&str, &str, usize); 5] = [
    ("unshadowed", "unshadowed", 32),
    ("occlusion, 32 probes", "occlusion", 32),
    ("24 cells", "cells", 24),
    ("32 cells", "cells", 32),
    ("48 cells", "cells", 48),
];

/// What one scene and environment gave, way by way: error, median time [ms], shadow memory [MiB].
struct Subject {
    labels: [&'static str; 2],
    measured: Vec<Option<[f64; 3]>>,
}

impl Experiment for AmbientPart {
    fn name(&self) -> &'static str {
        "ambient"
    }

    fn title(&self) -> &'static str {
        "The ambient part gets shadows too"
    }

    fn run(&self, lab: &Lab<'_>) -> Result<Section, LabError> {
        let environments = lab.environments(lab.pick(&["grace"], &["stpeters", "rnl"], &ENVIRONMENTS))?;
        let views = lab.views(lab.pick(&["three_boxes"], &["bunny"], &["three_boxes", "bunny"]))?;
        let size = lab.pick([32, 24], [128, 96], [128, 96]);
        let resolution = lab.pick(32, 256, 256);
        let mut subjects = Vec::new();
        let mut sheets = Vec::new();
        let steps = (views.len() * environments.len()).max(1) as f32;
        for view in &views {
            let title = format!("Picture - truth: {}", view.name);
            let columns = WAYS.len() as u32;
            let mut sheet = ContactSheet::new(format!("ambient_{}", view.name), title, columns);
            for environment in &environments {
                let share = subjects.len() as f32 / steps;
                lab.tell(&format!("ambient: {}, {}", view.name, environment.name), share);
                subjects.push(subject(lab, view, environment, size, resolution, &mut sheet)?);
            }
            sheets.push(sheet);
        }
        let mut paragraphs = vec![format!(
            "Disks as many as the fit chooses, {} x {} pixels of 2 x 2 samples, convolution with mip maps and M = 4, shadow maps of \
             at most {resolution} texels a side and coarser for wider lights. Occlusion multiplies the rest by the share of the sky \
             that is open; cells are lights that tile the rest, each with its own shadow.",
            size[0], size[1]
        )];
        paragraphs.extend(stand_ins(&views, &environments));
        let tables = vec![errors(&subjects), costs(&subjects)];
        Ok(Section { paragraphs, tables, sheets, ..Section::default() })
    }
}

/// Every way for one scene under one environment, timed in turns.
fn subject(
    lab: &Lab<'_>,
    view: &View,
    environment: &Environment,
    size: [u32; 2],
    resolution: u32,
    sheet: &mut ContactSheet,
) -> Result<Subject, LabError> {
    let truth = lab.truth(view, environment, size, lab.pick(2, 256, 1024))?;
    let lights = lab.lights("disks", None, view, environment)?;
    let setup = Setup { view, map: &environment.map, lights: &lights, size };
    let mut drawn = Vec::new();
    for (_, ambient, cells) in WAYS {
        let frame = maps_by_footprint(resolution).with(|s| {
            s.lighting.ambient = ambient.to_owned();
            s.lighting.ambient_cells = cells;
        });
        drawn.push(Variant::mip(4).drawn(lab, setup, &frame, &truth.picture)?);
    }
    time_in_turns(drawn.iter_mut().flatten(), &lab.timing_plan(5.0))?;
    let mut measured = Vec::new();
    for ((way, ..), drawn) in WAYS.iter().zip(&drawn) {
        let Some(drawn) = drawn else {
            measured.push(None);
            continue;
        };
        let time = drawn.spread.map_or(f64::NAN, |spread| spread.median);
        let memory = mebibytes(drawn.renderer.shadow_bytes());
        measured.push(Some([drawn.comparison.relative_rmse, time, memory]));
        let label = format!("{}, {way}", environment.name);
        sheet.panels.push(drawn.difference_panel(&label, &truth.picture)?);
    }
    if let Some(Some(first)) = drawn.first() {
        sheet.banner.get_or_insert_with(|| shown(&truth.picture, first.comparison.exposure));
    }
    Ok(Subject { labels: [view.name, environment.name], measured })
}

/// One row a scene and environment, one column a way.
fn errors(subjects: &[Subject]) -> Table {
    let mut columns = vec![("scene", ""), ("environment", "")];
    columns.extend(WAYS.map(|(name, ..)| (name, "")));
    let mut table = Table::new("ambient", "Relative RMSE of disks with the ambient rest", &columns);
    for subject in subjects {
        let mut row: Vec<Cell> = subject.labels.map(Cell::from).into();
        row.extend(subject.measured.iter().map(|way| Cell::from(way.map(|[error, ..]| error))));
        table.push(row);
    }
    table
}

/// One row a way: errors, time and memory over all subjects.
fn costs(subjects: &[Subject]) -> Table {
    let columns = [
        ("ambient", ""),
        ("relative RMSE, mean", ""),
        ("relative RMSE, worst", ""),
        ("frame, mean of medians", "ms"),
        ("times the unshadowed", ""),
        ("shadow memory, mean", "MiB"),
    ];
    let mut table = Table::new("ambient_cost", "Error and cost over all scenes and environments", &columns);
    let of = |way: usize, what: usize| -> Vec<f64> {
        subjects.iter().filter_map(|subject| Some(subject.measured.get(way).copied()??[what])).collect()
    };
    let over_all = |way: usize, what: usize| mean_and_worst(&of(way, what));
    let mean = |way: usize, what: usize| over_all(way, what).map(|[mean, _]| mean);
    for (way, (name, ..)) in WAYS.iter().enumerate() {
        let time = mean(way, 1);
        table.push([
            Cell::from(*name),
            mean(way, 0).into(),
            over_all(way, 0).map(|[_, worst]| worst).into(),
            time.into(),
            time.zip(mean(0, 1)).map(|(time, unshadowed)| time / unshadowed).into(),
            mean(way, 2).into(),
        ]);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_and_ratios_of_known_figures() {
        let subject = |scale: f64| Subject {
            labels: ["scene", "map"],
            measured: vec![Some([0.1 * scale, 2.0, 3.0]), Some([0.05, 6.0, 9.0]), None, None, None],
        };
        let table = costs(&[subject(1.0), subject(3.0)]);
        let number = |row: usize, column: usize| match table.rows()[row][column] {
            Cell::Number(number) => number,
            _ => f64::NAN,
        };
        assert!((number(0, 1) - 0.2).abs() < 1e-12 && (number(0, 2) - 0.3).abs() < 1e-12);
        assert!((number(1, 4) - 3.0).abs() < 1e-12 && (number(1, 5) - 9.0).abs() < 1e-12);
        // Where nothing fitted, nothing is claimed.
        assert_eq!(table.rows()[2][2], Cell::Missing);
        assert_eq!(errors(&[subject(1.0)]).rows()[0][4], Cell::Missing);
    }
}
