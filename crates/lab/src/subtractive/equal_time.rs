use super::common::reading;
use super::curves::{Curve, Measured, Point, RULES};
use crate::report::{Cell, Section, Table};
use crate::{Experiment, Lab, LabError};

/// Additive against the other rules at equal time.
pub(super) struct EqualTime;

/// Times so near to the least of a curve are taken for it: rules that do the same work differ by as much from run to run.
const TOLERANCE: f64 = 0.1;

/// Name in tables, figure of a point.
type Measure = (&'static str, fn(&Point) -> f64);

const MEASURES: [Measure; 2] = [("RMS", |point| point.displayed), ("relative RMSE", |point| point.linear)];

impl Experiment for EqualTime {
    fn name(&self) -> &'static str {
        "equal-time"
    }

    fn title(&self) -> &'static str {
        "Compositing rules at equal time"
    }

    fn run(&self, lab: &Lab<'_>) -> Result<Section, LabError> {
        let measured = lab.once("subtractive curves", || Measured::new(lab))?;
        let mut paragraphs = vec![
            "For every number of lights of additive compositing: its error, and those of the other rules in the same frame time, \
             interpolated along their curves of error against time (both logarithmic; beyond the longest time measured, the error \
             there). A missing error: the rule needs more time for its fewest lights."
                .to_owned(),
            reading(),
        ];
        let mut tables = Vec::new();
        for (place, measure) in MEASURES.into_iter().enumerate() {
            let (table, words) = compared(measured.groups(), measure, &format!("equal_time_{place}"));
            tables.push(table);
            paragraphs.push(words);
        }
        Ok(Section { paragraphs, tables, ..Section::default() })
    }
}

/// A table of one measure, and in words where additive wins.
fn compared<'a>(
    groups: impl Iterator<Item = &'a [Curve]>,
    (name, of): Measure,
    file: &str,
) -> (Table, String) {
    let labels = RULES.map(|rule| rule.label());
    let mut columns = vec![("scene", ""), ("fit, shadows", ""), ("lights, additive", ""), ("frame", "ms")];
    columns.extend(labels.iter().map(|label| (label.as_str(), "")));
    columns.push(("least", ""));
    let mut table = Table::new(file, format!("{name} at equal time"), &columns);
    let (mut places, mut lost) = (0, Vec::new());
    for group in groups {
        let Some((additive, others)) = group.split_first() else { continue };
        for point in &additive.points {
            let time = point.milliseconds;
            let mut errors = vec![Some(of(point))];
            errors.extend(others.iter().map(|curve| error_at(&curve.points, time, of)));
            errors.resize(labels.len(), None);
            let mut least = (0, f64::INFINITY);
            for (place, error) in errors.iter().enumerate() {
                if let Some(error) = error.filter(|error| *error < least.1) {
                    least = (place, error);
                }
            }
            places += 1;
            if least.0 == 0 {
                let family = additive.family.name();
                lost.push(format!("{} ({family}, {} lights)", additive.case.view, point.lights));
            }
            let mut row: Vec<Cell> = vec![
                additive.case.view.into(),
                additive.family.name().into(),
                point.lights.into(),
                time.into(),
            ];
            row.extend(errors.into_iter().map(Cell::from));
            row.push(labels.get(least.0).map(String::as_str).into());
            table.push(row);
        }
    }
    let words = if lost.is_empty() {
        format!("{name}: subtractive or ratio compositing is better than additive in all {places} places.")
    } else {
        format!(
            "{name}: additive compositing wins in {} of {places} places: {}.",
            lost.len(),
            lost.join("; ")
        )
    };
    (table, words)
}

/// The error of a curve in a given time, interpolated in logarithms; that of its longest time beyond it, none before its shortest.
fn error_at(points: &[Point], milliseconds: f64, of: fn(&Point) -> f64) -> Option<f64> {
    let mut sorted: Vec<(f64, f64)> = points.iter().map(|point| (point.milliseconds, of(point))).collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (&(shortest, first), &(longest, last)) = (sorted.first()?, sorted.last()?);
    if milliseconds >= longest {
        return Some(last);
    }
    if milliseconds <= shortest {
        return (milliseconds >= (1.0 - TOLERANCE) * shortest).then_some(first);
    }
    let next = sorted.iter().position(|point| point.0 > milliseconds)?;
    let ((t0, e0), (t1, e1)) = (*sorted.get(next.checked_sub(1)?)?, *sorted.get(next)?);
    let share = (milliseconds / t0).ln() / (t1 / t0).ln();
    Some((e0.ln() + share * (e1 / e0).ln()).exp())
}

#[cfg(test)]
mod tests {
    use super::super::common::{CASES, POINTS};
    use super::*;

    fn point(lights: usize, milliseconds: f64, displayed: f64) -> Point {
        Point { lights, milliseconds, displayed, models: displayed, linear: 2.0 * displayed }
    }

    #[test]
    fn errors_are_interpolated_in_logarithms_and_not_extrapolated() {
        // In no order, as fits may find fewer lights than asked for.
        let points = [point(9, 40.0, 0.01), point(1, 10.0, 0.04)];
        let at = |time: f64| error_at(&points, time, |point| point.displayed);
        assert!((at(20.0).unwrap() - 0.02).abs() < 1e-12);
        assert_eq!((at(10.0), at(9.5), at(5.0), at(80.0)), (Some(0.04), Some(0.04), None, Some(0.01)));
        assert_eq!(error_at(&[], 1.0, |point| point.displayed), None);
    }

    #[test]
    fn the_winner_is_named_and_so_is_where_additive_wins() {
        let curve = |place: usize, points: Vec<Point>| Curve {
            case: &CASES[0],
            family: POINTS,
            rule: RULES[place],
            points,
        };
        let curves = [
            curve(0, vec![point(1, 10.0, 0.03), point(9, 40.0, 0.02)]),
            curve(1, vec![point(1, 10.0, 0.04), point(9, 40.0, 0.01)]),
        ];
        let (table, words) = compared(std::iter::once(&curves[..]), MEASURES[0], "x");
        assert!(
            words.contains("wins in 1 of 2 places: glossy_bunny (samples:structured, hard, 1 lights)"),
            "{words}"
        );
        let last = |row: usize| table.rows()[row].last().cloned().unwrap();
        assert_eq!((last(0), last(1)), ("additive".into(), "subtractive".into()));
        let (_, words) = compared(std::iter::once(&curves[1..]), MEASURES[1], "x");
        // A curve held against nothing loses nothing to others.
        assert!(words.contains("wins in 2 of 2"), "{words}");
    }
}
