use std::rc::Rc;

use gnomon_metrics::{Mask, compare};
use gnomon_renderer::{Background, RenderSettings, ShadowSizing, TechniqueSettings};

use crate::columns::{TIME_COLUMNS, stand_ins, time_cells};
use crate::drawn::{Drawn, time_in_turns};
use crate::report::{Axis, Plot, Section, Series, Style, Table};
use crate::timing::TimingPlan;
use crate::{Environment, Experiment, Lab, LabError, Setup, TimedRenderer, View};

/// Scenes under maps of which there are pictures by another renderer.
pub(super) struct Scenes;

const CASES: [(&str, &str); 6] = [
    ("three_boxes", "grace"),
    ("bunny", "stpeters"),
    ("fence", "grace"),
    ("shelf", "grace"),
    ("tree", "stpeters"),
    ("plaza", "galileo"),
];

/// A way to spend time on a frame.
struct Variant {
    name: &'static str,
    fit: &'static str,
    lights: Option<usize>,
    change: fn(&mut TechniqueSettings),
}

const DEFAULT: usize = 1;
const HARD: usize = 4;

const VARIANTS: [Variant; 5] = [
    Variant { name: "about half", fit: "optimized", lights: Some(24), change: |s| s.supersample = 2 },
    Variant { name: "the default", fit: "optimized", lights: None, change: |_| {} },
    Variant { name: "about twice", fit: "optimized", lights: Some(120), change: |_| {} },
    Variant {
        name: "about four times",
        fit: "partition",
        lights: Some(250),
        change: |s| s.shadow_resolution = 512,
    },
    Variant { name: "1000 hard maps", fit: "partition", lights: Some(1000), change: many_hard_maps },
];

/// Every light has a map of 512 x 512, and is summed for every pixel.
fn many_hard_maps(s: &mut TechniqueSettings) {
    s.shadows = "hard".to_owned();
    s.shadow_resolution = 512;
    s.sharp_shadow_resolution = 512;
    s.shadow_sizing = ShadowSizing::Uniform;
    s.shadow_sampling = 4;
}

impl Experiment for Scenes {
    fn name(&self) -> &'static str {
        "scenes"
    }

    fn title(&self) -> &'static str {
        "Error against time, scene by scene"
    }

    fn run(&self, lab: &Lab<'_>) -> Result<Section, LabError> {
        let columns = [
            &[("scene", ""), ("environment", ""), ("frame", ""), ("lights", "")][..],
            &TIME_COLUMNS,
            &[("relative RMSE", ""), ("error over that of hard maps", ""), ("time over theirs", "")],
        ]
        .concat();
        let mut table = Table::new("budget_scenes", "Error and time, timed in turns", &columns);
        let mut section = Section::default();
        let cases = lab.pick(&CASES[..1], &CASES, &CASES);
        let (mut views, mut environments) = (Vec::new(), Vec::new());
        for (index, &(view, environment)) in cases.iter().enumerate() {
            lab.tell(&format!("budget: {view}"), index as f32 / cases.len() as f32);
            let (view, environment) = (lab.view(view)?, lab.environment(environment)?);
            section.plots.extend(measured(lab, (&view, &environment), &mut table)?);
            views.push(view);
            environments.push(environment);
        }
        section.paragraphs = stand_ins(&views, &environments);
        section.paragraphs.push(
            "Pixels that show any of the background do not count. The noise of the truth is in every figure."
                .to_owned(),
        );
        section.tables.push(table);
        Ok(section)
    }
}

/// All variants of a scene, as rows of the table and a plot.
fn measured(
    lab: &Lab<'_>,
    (view, environment): (&Rc<View>, &Rc<Environment>),
    table: &mut Table,
) -> Result<Option<Plot>, LabError> {
    let size = lab.pick([32, 24], [256, 192], [256, 192]);
    let truth = lab.truth(view, environment, size, lab.pick(2, 1024, 4096))?;
    let models = scene_mask(lab, view, environment, size)?;
    let sets = VARIANTS
        .iter()
        .map(|variant| {
            let count = variant.lights.map(|count| count.min(lab.pick(8, 1000, 1000)));
            lab.lights(variant.fit, count, view, environment)
        })
        .collect::<Result<Vec<_>, _>>()?;
    let mut drawn = Vec::new();
    for (variant, lights) in VARIANTS.iter().zip(&sets) {
        let settings = RenderSettings::default().with(|s| (variant.change)(&mut s.techniques));
        let setup = Setup { view, map: &environment.map, lights, size };
        drawn.push(Drawn::new(lab, variant.name, settings, setup, &truth.picture)?);
    }
    let plan = TimingPlan { least_rounds: lab.pick(1, 1, 3), ..lab.timing_plan(20.0) };
    time_in_turns(drawn.iter_mut().flatten(), &plan)?;
    let found = |place: usize| -> Result<Option<(f64, f64)>, LabError> {
        let Some(drawn) = &drawn[place] else { return Ok(None) };
        let error = compare(&drawn.picture, &truth.picture, Some(&models))?.relative_rmse;
        Ok(Some((drawn.spread.map_or(f64::NAN, |spread| spread.median), error)))
    };
    let hard = found(HARD)?;
    let mut points = Vec::new();
    for (place, (variant, lights)) in VARIANTS.iter().zip(&sets).enumerate() {
        let (Some((time, error)), Some(drawn)) = (found(place)?, &drawn[place]) else { continue };
        let mut row =
            vec![view.name.into(), environment.name.into(), variant.name.into(), lights.lights.len().into()];
        row.extend(time_cells(drawn.spread.as_ref()));
        row.push(error.into());
        row.push(hard.map(|(_, of_hard)| error / of_hard).into());
        row.push(hard.map(|(of_hard, _)| time / of_hard).into());
        table.push(row);
        points.push((time, error));
    }
    let [time, error] =
        [("frame", "ms"), ("relative RMSE", "")].map(|(label, unit)| Axis::logarithmic(label, unit));
    let mut plot = Plot::new(
        format!("budget_{}", view.name),
        format!("{} under {}: error against time", view.name, environment.name),
        time,
        error,
    );
    let (by_default, others): (Vec<_>, Vec<_>) =
        points.iter().enumerate().partition(|(place, _)| *place == DEFAULT);
    let series = |name: &str, points: Vec<(usize, &(f64, f64))>| {
        Series::new(name, points.into_iter().map(|(_, point)| *point).collect()).styled(Style::Points)
    };
    plot.series.push(series("the default", by_default));
    let (hard, rest): (Vec<_>, Vec<_>) = others.into_iter().partition(|(place, _)| *place == HARD);
    plot.series.push(series("less and more of it", rest));
    plot.series.push(series("1000 hard maps", hard));
    Ok(Some(plot))
}

/// Pixels that show nothing of the background: they look the same without it.
fn scene_mask(
    lab: &Lab<'_>,
    view: &View,
    environment: &Environment,
    [width, height]: [u32; 2],
) -> Result<Mask, LabError> {
    let lights = lab.lights("optimized", None, view, environment)?;
    let setup = Setup { view, map: &environment.map, lights: &lights, size: [width, height] };
    let picture = |background: Background| {
        let unshadowed = RenderSettings::default().with(|s| {
            s.techniques.shadows = "none".to_owned();
            s.display.background = background;
        });
        TimedRenderer::new(lab, unshadowed, setup)?.picture()
    };
    let (before, without) = (picture(Background::Environment)?, picture(Background::None)?);
    Ok(Mask::from_fn(width, height, |x, y| before.get(x, y) == without.get(x, y)))
}
