use super::common::{POINTS, reading};
use super::curves::{Curve, Measured, Point};
use crate::report::{Axis, Plot, Section, Series, Style, Table};
use crate::{Experiment, Lab, LabError};

/// Figs 3 and 5: error and time against the number of lights.
pub(super) struct Lights;

/// What the project holds itself to: scene, lights, RMS of subtractive shadows at most.
const REQUIREMENTS: [(&str, usize, f64); 2] =
    [("glossy_bunny", 40, 0.026), ("glossy_triceratops", 100, 0.039)];

/// Of the bunny: subtractive's RMS over additive's, at most.
const MOST_OF_ADDITIVE: f64 = 0.5;

impl Experiment for Lights {
    fn name(&self) -> &'static str {
        "lights"
    }

    fn title(&self) -> &'static str {
        "Error and time against the number of lights (Figs 3 and 5)"
    }

    fn run(&self, lab: &Lab<'_>) -> Result<Section, LabError> {
        let measured = lab.once("subtractive curves", || Measured::new(lab))?;
        let mut paragraphs = vec![reading()];
        paragraphs.extend_from_slice(&measured.cases);
        Ok(Section {
            paragraphs,
            tables: vec![measured.table.clone(), requirements(&measured.curves)],
            plots: measured.groups().flat_map(plots).collect(),
            sheets: measured.sheets.clone(),
            ..Section::default()
        })
    }
}

/// Subtractive shadows of points against what is asked of them.
fn requirements(curves: &[Curve]) -> Table {
    let columns =
        [("scene", ""), ("lights", ""), ("what", ""), ("measured", ""), ("at most", ""), ("met", "")];
    let caption = "What is asked of subtractive shadows with hard shadows of points";
    let mut table = Table::new("subtractive_requirements", caption, &columns);
    let point = |scene: &str, rule: &str, lights: usize| {
        let curve = curves.iter().find(|curve| {
            curve.family == POINTS
                && curve.case.view == scene
                && (curve.rule.name, curve.rule.sampling) == (rule, 1)
        });
        curve?.points.iter().find(|point| point.lights == lights)
    };
    let mut push = |scene: &str, lights: usize, what: &str, measured: Option<f64>, most: f64| {
        let met = measured.map(|measured| if measured <= most { "yes" } else { "no" });
        table.push([scene.into(), lights.into(), what.into(), measured.into(), most.into(), met.into()]);
    };
    for (scene, lights, most) in REQUIREMENTS {
        let measured = point(scene, "subtractive", lights).map(|point| point.displayed);
        push(scene, lights, "RMS", measured, most);
    }
    let (scene, lights, _) = REQUIREMENTS[0];
    let pair = point(scene, "subtractive", lights).zip(point(scene, "additive", lights));
    let all = pair.map(|(subtractive, additive)| subtractive.displayed / additive.displayed);
    let models = pair.map(|(subtractive, additive)| subtractive.models / additive.models);
    push(scene, lights, "RMS over additive's", all, MOST_OF_ADDITIVE);
    push(scene, lights, "the same of the models alone", models, MOST_OF_ADDITIVE);
    table
}

/// Error against lights and against time; of the paper's family time against lights too.
fn plots(curves: &[Curve]) -> Vec<Plot> {
    let Some(Curve { case, family, .. }) = curves.first() else { return Vec::new() };
    let lights = |point: &Point| point.lights as f64;
    let milliseconds = |point: &Point| point.milliseconds;
    let displayed = |point: &Point| point.displayed;
    let mut ticks: Vec<f64> = curves.iter().flat_map(|curve| curve.points.iter().map(lights)).collect();
    ticks.sort_by(f64::total_cmp);
    ticks.dedup();
    let lights_axis = || Axis::logarithmic("lights", "").with_ticks(ticks.clone());
    let time_axis = || Axis::logarithmic("frame time", "ms");
    let rms_axis = || Axis::logarithmic("RMS of displayed values", "");
    let plot = |what: &str, x: Axis, y: Axis, of: &dyn Fn(&Point) -> (f64, f64)| {
        let name = format!("{}_{}_{what}", case.view, family.technique);
        let title = format!("{} under {}: {}", case.view, case.environment, family.name());
        let mut plot = Plot::new(name, title, x, y);
        let series = |curve: &Curve| Series::new(curve.rule.label(), curve.points.iter().map(of).collect());
        plot.series = curves.iter().map(series).collect();
        plot
    };
    let mut by_lights = plot("lights", lights_axis(), rms_axis(), &|point| (lights(point), displayed(point)));
    if *family != POINTS {
        let by_time = plot("time", time_axis(), rms_axis(), &|point| (milliseconds(point), displayed(point)));
        return vec![by_lights, by_time];
    }
    for rule in ["additive", "subtractive"] {
        let of_rule = case.paper.iter().filter(|paper| paper.rule == rule);
        let points: Vec<_> = of_rule.filter_map(|paper| Some((paper.lights as f64, paper.rms?))).collect();
        if !points.is_empty() {
            by_lights.series.push(Series::new(format!("paper, {rule}"), points).styled(Style::Points));
        }
    }
    vec![
        by_lights,
        plot("time", time_axis(), rms_axis(), &|point| (milliseconds(point), displayed(point))),
        plot("cost", lights_axis(), time_axis(), &|point| (lights(point), milliseconds(point))),
    ]
}

#[cfg(test)]
mod tests {
    use crate::report::Cell;

    use super::super::common::CASES;
    use super::super::curves::RULES;
    use super::*;

    #[test]
    fn requirements_are_read_off_the_right_curve() {
        let case = &CASES[0];
        let curve = |place: usize, displayed: f64| Curve {
            case,
            family: POINTS,
            rule: RULES[place],
            points: vec![Point {
                lights: 40,
                milliseconds: 1.0,
                displayed,
                models: 2.0 * displayed,
                linear: 0.1,
            }],
        };
        // Additive, subtractive, and subtractive at fewer samples, which does not count.
        let table = requirements(&[curve(3, 0.001), curve(0, 0.05), curve(1, 0.026)]);
        let cells = |row: usize| table.rows()[row][3..].to_vec();
        assert_eq!(cells(0), [0.026.into(), 0.026.into(), "yes".into()]);
        assert_eq!(cells(1)[0], Cell::Missing);
        assert_eq!(cells(1)[2], Cell::Missing);
        assert_eq!(cells(2), [(0.026 / 0.05).into(), 0.5.into(), "no".into()]);
        assert_eq!(plots(&[curve(0, 0.05)]).len(), 3);
    }
}
