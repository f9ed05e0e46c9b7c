use std::rc::Rc;

use gnomon_picture::{ContactSheet, Panel};
use gnomon_renderer::RenderSettings;

use crate::columns::{mean_and_worst, stand_ins};
use crate::drawn::{Drawn, time_in_turns};
use crate::pictures::{difference, shown};
use crate::report::{Axis, Cell, Plot, Section, Series, Style, Table, significant};
use crate::timing::TimingPlan;
use crate::{Environment, Experiment, Lab, LabError, Setup, Truth, View};

/// The best of all settings with few lights.
pub(super) struct Best;

const ENVIRONMENTS: [&str; 10] =
    ["grace", "stpeters", "galileo", "kitchen", "rnl", "uffizi", "studio", "sunny", "dawn", "park"];

/// Lights in all, those of the ambient rest included.
const LIGHTS: usize = 64;

/// Of the lights of a fit that leaves an ambient rest, at least so many are kept for that rest.
const CELLS: usize = 32;

/// After so many pictures, settings whose mean error is more than so many times the least of all are not drawn again.
const SCREENING: usize = 4;
const WORTHWHILE: f64 = 1.5;

/// Relative RMSE: in the worst picture, and on average.
const LIMITS: [f64; 2] = [0.04, 0.03];

/// Fit, whether it leaves an ambient rest, and the techniques that suit its lights.
const FITS: [(&str, bool, &[&str]); 6] = [
    ("disks", true, SOFT),
    ("squares", false, &["pcss"]),
    ("rectangles", false, SOFT),
    ("partition", false, SOFT),
    ("optimized", false, SOFT),
    ("samples", false, &["hard"]),
];

const SOFT: &[&str] = &["convolution", "moments", "pcss"];

/// Compositing rules.
const RULES: [&str; 3] = ["ratio", "subtractive", "additive"];

/// One row of the table.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Choice {
    fit: &'static str,
    shadows: &'static str,
    /// None where the fit leaves nothing.
    ambient: Option<&'static str>,
    compositing: &'static str,
}

impl Choice {
    /// Every one.
    fn all() -> Vec<Self> {
        let mut all = Vec::new();
        for (fit, leaves_rest, techniques) in FITS {
            let ambients: &[Option<&str>] =
                if leaves_rest { &[Some("cells"), Some("occlusion"), Some("unshadowed")] } else { &[None] };
            for &shadows in techniques {
                for &ambient in ambients {
                    all.extend(RULES.map(|compositing| Self { fit, shadows, ambient, compositing }));
                }
            }
        }
        all
    }

    /// Some that differ much.
    fn few() -> Vec<Self> {
        let choice = |fit, shadows, ambient, compositing| Self { fit, shadows, ambient, compositing };
        vec![
            choice("partition", "pcss", None, "ratio"),
            choice("partition", "convolution", None, "ratio"),
            choice("disks", "pcss", Some("cells"), "ratio"),
            choice("samples", "hard", None, "subtractive"),
        ]
    }

    fn name(&self) -> String {
        let Self { fit, shadows, ambient, compositing } = self;
        match ambient {
            Some(ambient) => format!("{fit}, {shadows}, {ambient}, {compositing}"),
            None => format!("{fit}, {shadows}, {compositing}"),
        }
    }

    /// Lights that the fit is asked for.
    fn asked_for(&self) -> usize {
        if self.ambient.is_some() { LIGHTS - CELLS } else { LIGHTS }
    }

    fn settings(&self, frame: &RenderSettings, found: usize) -> RenderSettings {
        let ambient = self.ambient.map_or_else(|| frame.lighting.ambient.clone(), str::to_owned);
        frame.clone().with(|s| {
            s.techniques.shadows = self.shadows.to_owned();
            s.lighting.ambient = ambient;
            s.lighting.ambient_cells = LIGHTS.saturating_sub(found).max(CELLS);
            s.techniques.compositing = self.compositing.to_owned();
        })
    }
}

/// What one choice gave, pair by pair of scene and environment.
struct Outcome {
    choice: Choice,
    /// Whether it passed the screening, or that is still to come: all pairs are measured.
    is_in: bool,
    /// Relative RMSE; none where the adapter cannot hold it.
    errors: Vec<Option<f64>>,
    /// Frame times where they were taken [ms].
    milliseconds: Vec<f64>,
}

/// A scene under an environment.
struct Pair {
    view: Rc<View>,
    environment: Rc<Environment>,
    truth: Rc<Truth>,
    size: [u32; 2],
}

impl Experiment for Best {
    fn name(&self) -> &'static str {
        "best"
    }

    fn title(&self) -> &'static str {
        "The best setting with 64 lights or fewer"
    }

    fn run(&self, lab: &Lab<'_>) -> Result<Section, LabError> {
        let environments = lab.environments(lab.pick(&["grace"], &["grace", "rnl"], &ENVIRONMENTS))?;
        let views = lab.views(lab.pick(&["three_boxes"], &["bunny"], &["three_boxes", "bunny"]))?;
        let choices = lab.pick(Choice::few as fn() -> _, Choice::few, Choice::all)();
        let size = lab.pick([32, 24], [128, 96], [128, 96]);
        let frame = RenderSettings::default().with(|s| {
            s.techniques.shadow_resolution = lab.pick(32, 256, 256);
            s.techniques.supersample = lab.pick(2, 2, 4);
            s.techniques.shadow_memory = 256;
        });
        let unmeasured =
            |choice| Outcome { choice, is_in: true, errors: Vec::new(), milliseconds: Vec::new() };
        let mut results: Vec<Outcome> = choices.into_iter().map(unmeasured).collect();
        let mut sheet = ContactSheet::new("best", "Least error of every scene and environment", 3);
        sheet.enlargement = 2;
        let mut pairs: Vec<Pair> = Vec::new();
        let count = views.len() * environments.len();
        for environment in &environments {
            for view in &views {
                let share = pairs.len() as f32 / count as f32;
                lab.tell(&format!("best: {}, {}", view.name, environment.name), share);
                if pairs.len() == SCREENING {
                    screen(&mut results);
                }
                let truth = lab.truth(view, environment, size, lab.pick(2, 512, 4096))?;
                let (view, environment) = (Rc::clone(view), Rc::clone(environment));
                let pair = Pair { view, environment, truth, size };
                sheet.panels.extend(measure(lab, &pair, &frame, &mut results)?);
                pairs.push(pair);
            }
        }
        for pair in pairs.iter().take(views.len()) {
            lab.tell(&format!("best: timing {}", pair.view.name), 1.0);
            time(lab, pair, &frame, &mut results)?;
        }
        let mut paragraphs = vec![format!(
            "{} x {} pixels of {} x {} samples, Lambert 0.5, shadow maps of at most {} texels a side, every other setting that of `gnomon \
             render`. At most {LIGHTS} lights in all: a fit that leaves an ambient rest is asked for {}, the rest becomes cells or probes. \
             Times: median frames of 2 x 2 samples, mean over the scenes under their first environment.",
            size[0],
            size[1],
            frame.techniques.supersample,
            frame.techniques.supersample,
            frame.techniques.shadow_resolution,
            LIGHTS - CELLS
        )];
        if pairs.len() > SCREENING {
            paragraphs.push(format!(
                "Settings whose mean error over the first {SCREENING} pictures was more than {WORTHWHILE} times the least are not drawn \
                 again: their means are of those pictures."
            ));
        }
        paragraphs.push(verdict(&results));
        paragraphs.extend(stand_ins(&views, &environments));
        let tables = vec![ranking(&results, &pairs), by_pair(&results, &pairs)];
        Ok(Section {
            paragraphs,
            tables,
            plots: vec![plot(&results)],
            sheets: vec![sheet],
            ..Section::default()
        })
    }
}

/// One error more for every choice; truth, best picture and difference for the sheet.
fn measure(
    lab: &Lab<'_>,
    pair: &Pair,
    frame: &RenderSettings,
    results: &mut [Outcome],
) -> Result<Vec<Panel>, LabError> {
    let truth = &pair.truth.picture;
    let mut best: Option<(f64, Vec<Panel>)> = None;
    for result in results.iter_mut().filter(|result| result.is_in) {
        let lights =
            lab.lights(result.choice.fit, Some(result.choice.asked_for()), &pair.view, &pair.environment)?;
        let setup = Setup { view: &pair.view, map: &pair.environment.map, lights: &lights, size: pair.size };
        let settings = result.choice.settings(frame, lights.lights.len());
        let drawn = Drawn::new(lab, result.choice.name(), settings, setup, truth)?;
        let error = drawn.as_ref().map(|drawn| drawn.comparison.relative_rmse);
        result.errors.push(error);
        let Some(drawn) = drawn.filter(|_| best.as_ref().is_none_or(|(least, _)| error < Some(*least)))
        else {
            continue;
        };
        let stops = drawn.comparison.exposure;
        let title = format!("{}\ntruth: {}", pair.environment.name, pair.truth.source);
        let panels = vec![
            Panel::new(title, shown(truth, stops)),
            drawn.panel(stops),
            Panel::new("picture - truth", difference(&drawn.picture, truth)?),
        ];
        best = Some((drawn.comparison.relative_rmse, panels));
    }
    Ok(best.map(|(_, panels)| panels).unwrap_or_default())
}

/// Takes settings out that are far from the best so far.
fn screen(results: &mut [Outcome]) {
    let least = results.iter().map(|result| result.mean_and_worst()[0]).fold(f64::INFINITY, f64::min);
    for result in results {
        result.is_in = result.mean_and_worst()[0] <= WORTHWHILE * least;
    }
}

/// One frame time more for every choice that is still in.
fn time(lab: &Lab<'_>, pair: &Pair, frame: &RenderSettings, results: &mut [Outcome]) -> Result<(), LabError> {
    let frame = frame.clone().with(|s| s.techniques.supersample = 2);
    // A few at a time, so that their shadow maps fit in memory side by side.
    let mut worthwhile: Vec<&mut Outcome> = results.iter_mut().filter(|result| result.is_in).collect();
    for results in worthwhile.chunks_mut(8) {
        let mut sets = Vec::new();
        for result in results.iter() {
            sets.push(lab.lights(
                result.choice.fit,
                Some(result.choice.asked_for()),
                &pair.view,
                &pair.environment,
            )?);
        }
        let mut drawn = Vec::new();
        for (result, lights) in results.iter().zip(&sets) {
            let setup = Setup { view: &pair.view, map: &pair.environment.map, lights, size: pair.size };
            let settings = result.choice.settings(&frame, lights.lights.len());
            drawn.push(Drawn::new(lab, result.choice.name(), settings, setup, &pair.truth.picture)?);
        }
        let plan = TimingPlan { least_rounds: lab.pick(1, 2, 3), ..lab.timing_plan(10.0) };
        time_in_turns(drawn.iter_mut().flatten(), &plan)?;
        for (result, drawn) in results.iter_mut().zip(&drawn) {
            let spread = drawn.as_ref().and_then(|drawn| drawn.spread);
            result.milliseconds.extend(spread.map(|spread| spread.median));
        }
    }
    Ok(())
}

impl Outcome {
    /// Mean and worst error over all pairs that were measured; NaN where a picture is missing, which is no error of 0.
    fn mean_and_worst(&self) -> [f64; 2] {
        let errors: Option<Vec<f64>> = self.errors.iter().copied().collect();
        errors.and_then(|errors| mean_and_worst(&errors)).unwrap_or([f64::NAN; 2])
    }

    fn meets_the_limits(&self) -> bool {
        let [mean, worst] = self.mean_and_worst();
        self.is_in && worst <= LIMITS[0] && mean <= LIMITS[1]
    }

    fn milliseconds(&self) -> f64 {
        mean_and_worst(&self.milliseconds).map_or(f64::NAN, |[mean, _]| mean)
    }
}

/// Least mean error first, those that were screened out after the others; what could not be drawn last of all.
fn ranked(results: &[Outcome]) -> Vec<&Outcome> {
    let mut ranked: Vec<&Outcome> = results.iter().collect();
    let group = |result: &Outcome| (result.mean_and_worst()[0].is_nan(), !result.is_in);
    ranked.sort_by(|a, b| {
        let means = a.mean_and_worst()[0].total_cmp(&b.mean_and_worst()[0]);
        group(a).cmp(&group(b)).then(means)
    });
    ranked
}

/// One row a choice.
fn ranking(results: &[Outcome], pairs: &[Pair]) -> Table {
    let columns = [
        ("fit", ""),
        ("shadows", ""),
        ("ambient rest", ""),
        ("compositing", ""),
        ("relative RMSE, mean", ""),
        ("relative RMSE, worst", ""),
        ("worst at", ""),
        ("pictures", ""),
        ("frame, mean of medians", "ms"),
        ("within the limits", ""),
    ];
    let caption = format!(
        "Settings by mean error; the limits are {} for the worst and {} for the mean",
        LIMITS[0], LIMITS[1]
    );
    let mut table = Table::new("best", caption, &columns);
    for result in ranked(results) {
        let [mean, worst] = result.mean_and_worst();
        let worst_at = result.errors.iter().zip(pairs).find(|(error, _)| **error == Some(worst));
        let Choice { fit, shadows, ambient, compositing } = result.choice;
        table.push([
            fit.into(),
            shadows.into(),
            ambient.unwrap_or("none is left").into(),
            compositing.into(),
            mean.into(),
            worst.into(),
            worst_at.map(|(_, pair)| format!("{}, {}", pair.view.name, pair.environment.name)).into(),
            result.errors.len().into(),
            result.milliseconds().into(),
            if result.meets_the_limits() { "yes" } else { "no" }.into(),
        ]);
    }
    table
}

/// How many of the best are told pair by pair.
const TOLD: usize = 5;

/// One row a pair, one column a choice, the best ones.
fn by_pair(results: &[Outcome], pairs: &[Pair]) -> Table {
    let told: Vec<(String, &Outcome)> =
        ranked(results).into_iter().take(TOLD).map(|result| (result.choice.name(), result)).collect();
    let mut columns = vec![("scene", ""), ("environment", "")];
    columns.extend(told.iter().map(|(name, _)| (name.as_str(), "")));
    columns.extend([("noise of the truth", ""), ("truth", "")]);
    let mut table = Table::new("best_maps", "Relative RMSE of the best settings", &columns);
    for (place, pair) in pairs.iter().enumerate() {
        let mut row: Vec<Cell> = vec![pair.view.name.into(), pair.environment.name.into()];
        row.extend(told.iter().map(|(_, result)| Cell::from(result.errors.get(place).copied().flatten())));
        row.extend([pair.truth.noise.into(), pair.truth.source.as_str().into()]);
        table.push(row);
    }
    table
}

/// The best setting in words: of those within the limits the one with the least mean, else the least worst.
fn verdict(results: &[Outcome]) -> String {
    let ranked = ranked(results);
    let within: Vec<&&Outcome> = ranked.iter().filter(|result| result.meets_the_limits()).collect();
    let told = |result: &Outcome| {
        let [mean, worst] = result.mean_and_worst();
        format!(
            "{} (mean {}, worst {}, {} ms)",
            result.choice.name(),
            significant(mean, 3),
            significant(worst, 3),
            significant(result.milliseconds(), 3)
        )
    };
    if let Some(best) = within.first() {
        return format!("Within the limits: {} of {}. Best: {}.", within.len(), ranked.len(), told(best));
    }
    let least_worst = ranked
        .iter()
        .filter(|result| result.is_in)
        .min_by(|a, b| a.mean_and_worst()[1].total_cmp(&b.mean_and_worst()[1]));
    let words = ranked
        .first()
        .zip(least_worst)
        .map(|(mean, worst)| format!(" The least mean has {}; the least worst {}.", told(mean), told(worst)));
    format!("No setting is within the limits.{}", words.unwrap_or_default())
}

/// Mean error against time, one point a choice, by fit.
fn plot(results: &[Outcome]) -> Plot {
    let mut plot = Plot::new(
        "best",
        "Mean error against time",
        Axis::logarithmic("frame time", "ms"),
        Axis::logarithmic("relative RMSE, mean", ""),
    );
    for (fit, ..) in FITS {
        let of_fit = results.iter().filter(|result| result.choice.fit == fit);
        let points = of_fit.map(|result| (result.milliseconds(), result.mean_and_worst()[0]));
        plot.series.push(Series::new(fit, points.collect()).styled(Style::Points));
    }
    plot
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_combination_is_there_once() {
        let all = Choice::all();
        // Disks 3 x 3 x 3; rectangles, partition and optimized 3 x 3; squares and samples 3.
        assert_eq!(all.len(), 60);
        for (index, choice) in all.iter().enumerate() {
            assert!(!all[..index].contains(choice), "{choice:?}");
        }
        assert!(Choice::few().iter().all(|choice| all.contains(choice)));
        let disks = all.iter().find(|choice| choice.fit == "disks").unwrap();
        let frame = RenderSettings::default();
        assert_eq!(
            disks.asked_for() + disks.settings(&frame, disks.asked_for()).lighting.ambient_cells,
            LIGHTS
        );
        assert_eq!(disks.settings(&frame, 10).lighting.ambient_cells, LIGHTS - 10);
    }

    #[test]
    fn the_verdict_names_the_least_mean_within_the_limits() {
        let result = |place: usize, errors: [f64; 2]| Outcome {
            choice: Choice::few()[place],
            is_in: true,
            errors: errors.map(Some).to_vec(),
            milliseconds: vec![10.0],
        };
        // The first has the least mean, but one picture over the limit.
        let mut results = vec![result(0, [0.041, 0.001]), result(1, [0.03, 0.03]), result(2, [0.028, 0.029])];
        let words = verdict(&results);
        assert!(words.starts_with("Within the limits: 2 of 3. Best: disks"), "{words}");
        assert_eq!(ranked(&results)[0].choice, Choice::few()[0]);
        results.truncate(1);
        assert!(
            verdict(&results).starts_with("No setting is within the limits. The least mean has partition")
        );
        // A picture that could not be drawn counts against its setting.
        results.push(Outcome { errors: vec![Some(0.001), None], ..result(1, [0.0; 2]) });
        assert!(!results[1].meets_the_limits() && ranked(&results)[1].errors[1].is_none());
    }

    #[test]
    fn settings_far_from_the_best_are_screened_out() {
        let result = |place: usize, error: Option<f64>| Outcome {
            choice: Choice::few()[place],
            is_in: true,
            errors: vec![error],
            milliseconds: Vec::new(),
        };
        let mut results =
            vec![result(0, Some(0.031)), result(1, None), result(2, Some(0.02)), result(3, Some(0.03))];
        screen(&mut results);
        assert_eq!(results.iter().map(|result| result.is_in).collect::<Vec<_>>(), [false, false, true, true]);
        // What was measured less is behind, however good it was so far, and meets no limits.
        results[3].errors.push(Some(0.5));
        assert_eq!(ranked(&results)[1].choice, Choice::few()[3]);
        results[0].errors = vec![Some(0.01)];
        assert!(!results[0].meets_the_limits());
    }
}
