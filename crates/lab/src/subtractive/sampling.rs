use gnomon_picture::{ContactSheet, Panel};

use super::common::{AREAS, Family, POINTS, Subject, cases, frame, reading, settings};
use crate::drawn::{Drawn, time_in_turns};
use crate::pictures::shown;
use crate::report::{Axis, Cell, Plot, Section, Series, Table, significant};
use crate::timing::TimingPlan;
use crate::{Experiment, Lab, LabError, TimedRenderer};

/// Fig. 3, right: shadow buffers of fewer samples than the picture.
pub(super) struct Sampling;

/// Samples of the picture's side for one of the shadow buffer's.
const SAMPLINGS: [u32; 6] = [1, 2, 4, 8, 16, 32];

/// Passes whose work is the shadow buffer's: finding where it is sampled, and summing lights there.
const PASSES: [&str; 2] = ["points", "light"];

/// The sampling that is held to the requirements, and these: share of the time, share of error added, at most.
const SIXTEENTH: u32 = 4;
const MOST_TIME: f64 = 1.0 / 3.0;
const MOST_ADDED: f64 = 0.2;

/// What one sampling gave.
#[derive(Clone, Copy)]
struct Row {
    sampling: u32,
    /// Of [`PASSES`], each submitted alone [ms].
    pass: f64,
    /// Median of a whole frame [ms].
    frame: f64,
    displayed: f64,
    linear: f64,
}

/// All samplings of one scene and family, the finest first.
struct Subsampled {
    scene: &'static str,
    family: Family,
    rule: &'static str,
    lights: usize,
    rows: Vec<Row>,
}

impl Experiment for Sampling {
    fn name(&self) -> &'static str {
        "sampling"
    }

    fn title(&self) -> &'static str {
        "Shadow buffers of fewer samples (Fig. 3, right)"
    }

    fn run(&self, lab: &Lab<'_>) -> Result<Section, LabError> {
        let samplings: &[u32] = lab.pick(&SAMPLINGS[..2], &SAMPLINGS, &SAMPLINGS);
        // The paper's 30 lights; soft shadows with the number of lights that is the renderer's default.
        let families =
            [(POINTS, "subtractive", lab.pick(6, 30, 30)), (AREAS[1], "ratio", lab.pick(6, 60, 60))];
        let mut paragraphs = vec![reading()];
        let (mut found, mut sheets) = (Vec::new(), Vec::new());
        for (index, case) in cases(lab).iter().enumerate() {
            lab.tell(&format!("sampling: {}", case.view), index as f32 / cases(lab).len() as f32);
            let subject = Subject::new(lab, case)?;
            paragraphs.extend(subject.described(lab));
            for (family, rule, count) in families {
                let title = format!("{}: {}, {rule}", case.view, family.name());
                let mut sheet =
                    ContactSheet::new(format!("sampling_{}_{}", case.view, family.technique), title, 3);
                sheet.enlargement = lab.pick(1, 2, 1);
                found.push(measure(lab, &subject, (family, rule, count), samplings, &mut sheet)?);
                sheets.push(sheet);
            }
        }
        paragraphs.push(format!(
            "The passes of the shadow buffer are {}; shadow maps are drawn beside them, and do not depend on it.",
            PASSES.map(|name| format!("'{name}'")).join(" and ")
        ));
        let tables = vec![table(&found), requirements(&found)];
        Ok(Section { paragraphs, tables, plots: plots(&found), sheets, ..Section::default() })
    }
}

fn measure(
    lab: &Lab<'_>,
    subject: &Subject,
    (family, rule, count): (Family, &'static str, usize),
    samplings: &[u32],
    sheet: &mut ContactSheet,
) -> Result<Subsampled, LabError> {
    let lights = lab.lights(family.fit, Some(count), &subject.view, &subject.environment)?;
    let setup = subject.setup(&lights);
    let stops = subject.environment.map.suitable_exposure() - 1.0;
    sheet.banner = Some(shown(&subject.truth.picture, stops));
    let of = |sampling: u32| settings(&frame(lab), family, rule, sampling);
    let mut drawn = Vec::new();
    for &sampling in samplings {
        let name = format!("1/{} of the samples", sampling * sampling);
        let new = Drawn::new(lab, name, of(sampling), setup, &subject.truth.picture)?;
        drawn.extend(new.map(|drawn| (sampling, drawn)));
    }
    let plan = TimingPlan { least_rounds: lab.pick(1, 3, 5), ..lab.timing_plan(8.0) };
    time_in_turns(drawn.iter_mut().map(|(_, drawn)| drawn), &plan)?;
    let mut rows = Vec::new();
    for (sampling, drawn) in &drawn {
        let profiled = of(*sampling).with(|s| s.measure.profile = true);
        let passes = TimedRenderer::new(lab, profiled, setup)?.pass_times(&plan)?;
        let pass = passes.iter().filter(|(name, _)| PASSES.contains(name)).map(|(_, time)| time).sum();
        let displayed = subject.displayed_rms(&drawn.picture)?;
        let caption = format!("{}\nRMS {}", drawn.name, significant(displayed, 3));
        sheet.panels.push(Panel::new(caption, shown(&drawn.picture, stops)));
        rows.push(Row {
            sampling: *sampling,
            pass,
            frame: drawn.spread.map_or(f64::NAN, |spread| spread.median),
            displayed,
            linear: drawn.comparison.relative_rmse,
        });
    }
    Ok(Subsampled { scene: subject.case.view, family, rule, lights: lights.lights.len(), rows })
}

impl Subsampled {
    fn name(&self) -> String {
        format!("{}: {}, {}", self.scene, self.family.name(), self.rule)
    }

    /// Time of the passes and errors over those of the finest sampling: pass, RMS, relative RMSE.
    fn relative(&self, row: &Row) -> Option<[f64; 3]> {
        let full = self.rows.iter().find(|row| row.sampling == 1)?;
        Some([row.pass / full.pass, row.displayed / full.displayed, row.linear / full.linear])
    }
}

fn table(found: &[Subsampled]) -> Table {
    let columns = [
        ("scene", ""),
        ("fit, shadows", ""),
        ("compositing", ""),
        ("lights", ""),
        ("samples a side", ""),
        ("samples", ""),
        ("shadow buffer", "ms"),
        ("over all samples'", ""),
        ("frame, median", "ms"),
        ("RMS", ""),
        ("added RMS", ""),
        ("relative RMSE", ""),
        ("added relative RMSE", ""),
    ];
    let mut table =
        Table::new("sampling", "Time and error against the samples of the shadow buffer", &columns);
    for series in found {
        for row in &series.rows {
            let relative = series.relative(row);
            table.push([
                series.scene.into(),
                series.family.name().into(),
                series.rule.into(),
                series.lights.into(),
                format!("1/{}", row.sampling).into(),
                format!("1/{}", row.sampling * row.sampling).into(),
                row.pass.into(),
                relative.map(|[pass, ..]| pass).into(),
                row.frame.into(),
                row.displayed.into(),
                relative.map(|[_, displayed, _]| displayed - 1.0).into(),
                row.linear.into(),
                relative.map(|[.., linear]| linear - 1.0).into(),
            ]);
        }
    }
    table
}

/// A sixteenth of the samples against what is asked of it.
fn requirements(found: &[Subsampled]) -> Table {
    let columns = [
        ("scene", ""),
        ("fit, shadows", ""),
        ("share of the time", ""),
        ("at most", ""),
        ("added RMS", ""),
        ("added relative RMSE", ""),
        ("each at most", ""),
        ("met", ""),
    ];
    let caption = "What is asked of a sixteenth of the samples";
    let mut table = Table::new("sampling_requirements", caption, &columns);
    for series in found {
        let sixteenth = series.rows.iter().find(|row| row.sampling == SIXTEENTH);
        let relative = sixteenth.and_then(|row| series.relative(row));
        let met = relative
            .map(|[pass, displayed, linear]| pass <= MOST_TIME && displayed.max(linear) <= 1.0 + MOST_ADDED);
        let cell = |place: usize, less: f64| Cell::from(relative.map(|relative| relative[place] - less));
        table.push([
            series.scene.into(),
            series.family.name().into(),
            cell(0, 0.0),
            MOST_TIME.into(),
            cell(1, 1.0),
            cell(2, 1.0),
            MOST_ADDED.into(),
            met.map(|met| if met { "yes" } else { "no" }).into(),
        ]);
    }
    table
}

/// Time and error against the samples.
fn plots(found: &[Subsampled]) -> Vec<Plot> {
    let ticks: Vec<f64> = SAMPLINGS.iter().rev().map(|side| f64::from(side * side).recip()).collect();
    let plot = |name: &str, title: &str, y: Axis, of: &dyn Fn(&Subsampled, &Row) -> f64| {
        let x = Axis::logarithmic("samples of the shadow buffer over those of the picture", "");
        let mut plot = Plot::new(name, title, x.with_ticks(ticks.clone()), y);
        for series in found {
            let point = |row: &Row| (f64::from(row.sampling * row.sampling).recip(), of(series, row));
            plot.series.push(Series::new(series.name(), series.rows.iter().map(point).collect()));
        }
        plot
    };
    vec![
        plot(
            "sampling_time",
            "Time of the shadow buffer against its samples",
            Axis::logarithmic("time", "ms"),
            &|_, row| row.pass,
        ),
        plot(
            "sampling_error",
            "Error against the samples of the shadow buffer",
            Axis::linear("RMS over that with all samples", ""),
            &|series, row| series.relative(row).map_or(f64::NAN, |[_, displayed, _]| displayed),
        ),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sixteenth_is_held_to_its_time_and_its_error() {
        let row = |sampling: u32, pass: f64, displayed: f64| Row {
            sampling,
            pass,
            frame: 2.0 * pass,
            displayed,
            linear: displayed,
        };
        let series = |pass: f64, displayed: f64| Subsampled {
            scene: "s",
            family: POINTS,
            rule: "subtractive",
            lights: 30,
            rows: vec![row(1, 9.0, 0.02), row(SIXTEENTH, pass, displayed)],
        };
        let incomplete = Subsampled { rows: vec![row(1, 9.0, 0.02)], ..series(1.0, 1.0) };
        let table = requirements(&[series(3.0, 0.023), series(3.1, 0.023), series(3.0, 0.025), incomplete]);
        let met: Vec<Cell> = table.rows().iter().filter_map(|row| row.last().cloned()).collect();
        assert_eq!(met, ["yes".into(), "no".into(), "no".into(), Cell::Missing]);
    }
}
