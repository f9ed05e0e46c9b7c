//! Error and time against the number of lights, measured once for the experiments that read them.

use gnomon_picture::{ContactSheet, Panel};

use super::common::{AREAS, Case, Family, POINTS, Subject, cases, frame, settings};
use crate::columns::{TIME_COLUMNS, mebibytes, time_cells};
use crate::drawn::{Drawn, time_in_turns};
use crate::pictures::shown;
use crate::report::{Cell, Table, significant};
use crate::timing::TimingPlan;
use crate::{Lab, LabError};

/// A compositing rule, and how many samples of the picture's side share one of the shadow buffer's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Rule {
    pub name: &'static str,
    pub sampling: u32,
}

impl Rule {
    pub fn label(self) -> String {
        match self.sampling {
            1 => self.name.to_owned(),
            sampling => format!("{}, 1/{} of the samples", self.name, sampling * sampling),
        }
    }
}

const fn rule(name: &'static str, sampling: u32) -> Rule {
    Rule { name, sampling }
}

/// Additive first: the others are held against it.
pub(super) const RULES: [Rule; 5] =
    [rule("additive", 1), rule("subtractive", 1), rule("ratio", 1), rule("subtractive", 4), rule("ratio", 4)];

/// One picture of a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Point {
    /// Found by the fit.
    pub lights: usize,
    /// Median of a frame [ms].
    pub milliseconds: f64,
    /// RMS of displayed values.
    pub displayed: f64,
    /// The same over the pixels of models.
    pub models: f64,
    /// Relative RMSE of radiance.
    pub linear: f64,
}

/// One rule over all numbers of lights, fewest first.
pub(super) struct Curve {
    pub case: &'static Case,
    pub family: Family,
    pub rule: Rule,
    pub points: Vec<Point>,
}

/// Everything that was measured.
pub(super) struct Measured {
    pub curves: Vec<Curve>,
    pub table: Table,
    pub sheets: Vec<ContactSheet>,
    /// Every case in sentences.
    pub cases: Vec<String>,
}

impl Measured {
    /// The curves of one case and family, in the order of [`RULES`].
    pub fn groups(&self) -> impl Iterator<Item = &[Curve]> {
        self.curves.chunk_by(|a, b| std::ptr::eq(a.case, b.case) && a.family == b.family)
    }

    pub fn new(lab: &Lab<'_>) -> Result<Self, LabError> {
        let columns = [
            &[("scene", ""), ("environment", ""), ("fit, shadows", ""), ("compositing", ""), ("lights", "")]
                [..],
            &TIME_COLUMNS,
            &[
                ("shadow memory", "MiB"),
                ("RMS", ""),
                ("RMS, models alone", ""),
                ("relative RMSE", ""),
                ("relative bias", ""),
                ("paper, RMS", ""),
                ("paper, 8800", "ms"),
            ],
        ]
        .concat();
        let caption = "Error and time against the number of lights, rules timed in turns";
        let mut measured = Self {
            curves: Vec::new(),
            table: Table::new("subtractive_lights", caption, &columns),
            sheets: Vec::new(),
            cases: Vec::new(),
        };
        let families: Vec<Family> = [POINTS].into_iter().chain(AREAS).collect();
        let steps = (cases(lab).len() * families.len()) as f32;
        for (index, case) in cases(lab).iter().enumerate() {
            let share = |family: usize| (index * families.len() + family) as f32 / steps;
            lab.tell(&format!("lights: tracing {}", case.view), share(0));
            let subject = Subject::new(lab, case)?;
            measured.cases.extend(subject.described(lab));
            for (place, &family) in families.iter().enumerate() {
                lab.tell(&format!("lights: {}, {}", case.view, family.name()), share(place));
                measured.add(lab, &subject, family)?;
            }
        }
        Ok(measured)
    }

    /// Every rule with every number of lights.
    fn add(&mut self, lab: &Lab<'_>, subject: &Subject, family: Family) -> Result<(), LabError> {
        let counts: &[usize] = if family == POINTS {
            lab.pick(&[6], &[10, 40, 100], &[1, 5, 10, 15, 20, 30, 40, 100, 300, 1000])
        } else {
            lab.pick(&[6], &[20, 60], &[6, 10, 20, 40, 60, 100, 300])
        };
        let first = self.curves.len();
        let curve = |rule| Curve { case: subject.case, family, rule, points: Vec::new() };
        self.curves.extend(RULES.map(curve));
        let title = format!("{}: {}", subject.case.view, family.name());
        let mut sheet = ContactSheet::new(format!("{}_{}", subject.case.view, family.technique), title, 5);
        sheet.enlargement = lab.pick(1, 2, 1);
        for &count in counts {
            let lights = lab.lights(family.fit, Some(count), &subject.view, &subject.environment)?;
            let mut drawn = Vec::new();
            for rule in RULES {
                let settings = settings(&frame(lab), family, rule.name, rule.sampling);
                let setup = subject.setup(&lights);
                drawn.push(Drawn::new(lab, rule.label(), settings, setup, &subject.truth.picture)?);
            }
            let plan = TimingPlan { least_rounds: lab.pick(1, 1, 3), ..lab.timing_plan(5.0) };
            time_in_turns(drawn.iter_mut().flatten(), &plan)?;
            let found = lights.lights.len();
            for (place, drawn) in drawn.iter().enumerate() {
                let (Some(drawn), Some(curve)) = (drawn, self.curves.get_mut(first + place)) else {
                    continue;
                };
                let displayed = subject.displayed_rms(&drawn.picture)?;
                let models = subject.models_rms(&drawn.picture)?;
                let milliseconds = drawn.spread.map_or(f64::NAN, |spread| spread.median);
                let linear = drawn.comparison.relative_rmse;
                curve.points.push(Point { lights: found, milliseconds, displayed, models, linear });
                let row = row(curve, count, drawn);
                self.table.push(row);
                let caption = format!("{found} lights, {}\nRMS {}", drawn.name, significant(displayed, 3));
                let stops = subject.environment.map.suitable_exposure() - 1.0;
                sheet.panels.push(Panel::new(caption, shown(&drawn.picture, stops)));
                sheet.banner.get_or_insert_with(|| shown(&subject.truth.picture, stops));
            }
        }
        self.sheets.push(sheet);
        Ok(())
    }
}

/// The last point of a curve.
fn row(curve: &Curve, asked_for: usize, drawn: &Drawn<'_>) -> Vec<Cell> {
    let Curve { case, family, rule, points } = curve;
    let paper = case.paper.iter().find(|paper| {
        *family == POINTS
            && (paper.rule, paper.sampling, paper.lights) == (rule.name, rule.sampling, asked_for)
    });
    let mut row: Vec<Cell> = vec![
        case.view.into(),
        case.environment.into(),
        family.name().into(),
        rule.label().into(),
        points.last().map(|point| point.lights).into(),
    ];
    row.extend(time_cells(drawn.spread.as_ref()));
    row.push(mebibytes(drawn.renderer.shadow_bytes()).into());
    row.push(points.last().map(|point| point.displayed).into());
    row.push(points.last().map(|point| point.models).into());
    row.push(drawn.comparison.relative_rmse.into());
    row.push(drawn.comparison.relative_bias.into());
    row.push(paper.and_then(|paper| paper.rms).into());
    row.push(paper.map(|paper| 1000.0 / paper.rate).into());
    row
}
