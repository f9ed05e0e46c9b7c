use std::time::Instant;

use glam::Quat;
use gnomon_lights::fit::{FitOptions, by_name};
use gnomon_renderer::{PreparedLighting, RenderSettings, Renderer};

use crate::columns::stand_ins;
use crate::report::{Cell, Section, Table};
use crate::timing::Spread;
use crate::{Experiment, Lab, LabError};

/// An environment that turns, and one that changes.
pub(super) struct TurningEnvironment;

/// The fit that is the renderer's default.
const FIT: &str = "optimized";

/// A frame after a turn may take this many times the median frame.
const MOST_HITCH: f64 = 2.0;

impl Experiment for TurningEnvironment {
    fn name(&self) -> &'static str {
        "environment"
    }

    fn title(&self) -> &'static str {
        "An environment that turns, and one that changes"
    }

    fn run(&self, lab: &Lab<'_>) -> Result<Section, LabError> {
        let environments = lab.environments(lab.pick(
            &["grace"][..],
            &["grace", "galileo"],
            &["grace", "galileo", "kitchen", "rnl"],
        ))?;
        let mut tables = [turns_table(), changes_table()];
        for (index, environment) in environments.iter().enumerate() {
            lab.tell(&format!("environment: {}", environment.name), index as f32 / environments.len() as f32);
            tables[0].push(turns(lab, environment.name)?);
            tables[1].push(changes(lab, environment.name)?);
        }
        let mut paragraphs = stand_ins(&[lab.view("three_boxes")?], &environments);
        paragraphs.extend([
            "A turn changes directions of lights and of lookups; frames with one alternate with frames without, so that other load on the \
             machine meets both alike and shows in the longest of both."
                .to_owned(),
            "A change is everything from a file to its picture: reading, fitting, filtering of maps (which a thread does while frames go on), \
             the upload, and the first frame."
                .to_owned(),
        ]);
        Ok(Section { paragraphs, tables: tables.into(), ..Section::default() })
    }
}

fn settings(lab: &Lab<'_>) -> RenderSettings {
    RenderSettings::default().with(|s| {
        s.techniques.supersample = 1;
        s.techniques.shadow_resolution = lab.pick(64, 256, 256);
    })
}

fn milliseconds(since: Instant) -> f64 {
    1e3 * since.elapsed().as_secs_f64()
}

fn turns_table() -> Table {
    let columns = [
        ("environment", ""),
        ("lights", ""),
        ("frames", ""),
        ("at rest, median", "ms"),
        ("at rest, longest", "ms"),
        ("turning, median", "ms"),
        ("turning, longest", "ms"),
        ("longest over median at rest", ""),
        ("at most", ""),
        ("met", ""),
    ];
    Table::new("motion_turns", "Frames of three boxes while the environment turns", &columns)
}

fn turns(lab: &Lab<'_>, name: &str) -> Result<Vec<Cell>, LabError> {
    let (environment, view) = (lab.environment(name)?, lab.view("three_boxes")?);
    let lights = lab.lights(FIT, Some(lab.pick(6, 30, 60)), &view, &environment)?;
    let [width, height] = lab.pick([32, 24], [320, 240], [640, 480]);
    let mut renderer = Renderer::new(lab.gpu(), settings(lab))?;
    renderer.set_scene(&view.scene)?;
    renderer.set_lighting(&environment.map, &lights)?;
    // One frame compiles pipelines.
    renderer.draw(&view.camera, width, height)?;
    let (mut still, mut turning) = (Vec::new(), Vec::new());
    for step in 1..=lab.pick(2, 30, 120) {
        let start = Instant::now();
        renderer.draw(&view.camera, width, height)?;
        still.push(milliseconds(start));
        let start = Instant::now();
        renderer.set_environment_rotation(Quat::from_rotation_y(0.05 * step as f32))?;
        renderer.draw(&view.camera, width, height)?;
        turning.push(milliseconds(start));
    }
    let greatest = |times: &[f64]| times.iter().copied().fold(0.0, f64::max);
    let (longest, longest_rest) = (greatest(&turning), greatest(&still));
    let median = |times| Spread::of(times).map_or(f64::NAN, |spread: Spread| spread.median);
    let (frames, rest, turn) = (turning.len(), median(still), median(turning));
    let hitch = longest / rest;
    Ok(vec![
        environment.name.into(),
        lights.lights.len().into(),
        frames.into(),
        rest.into(),
        longest_rest.into(),
        turn.into(),
        longest.into(),
        hitch.into(),
        MOST_HITCH.into(),
        if hitch <= MOST_HITCH { "yes" } else { "no" }.into(),
    ])
}

fn changes_table() -> Table {
    let columns = [
        ("environment", ""),
        ("texels", ""),
        ("read", "ms"),
        ("fit", "ms"),
        ("filter", "ms"),
        ("upload", "ms"),
        ("first frame", "ms"),
        ("from file to picture", "ms"),
    ];
    Table::new("motion_changes", "Another environment, from its file to its picture", &columns)
}

fn changes(lab: &Lab<'_>, name: &str) -> Result<Vec<Cell>, LabError> {
    let (environment, view) = (lab.environment(name)?, lab.view("three_boxes")?);
    let [width, height] = lab.pick([32, 24], [320, 240], [640, 480]);
    let settings = settings(lab);
    let mut renderer = Renderer::new(lab.gpu(), settings.clone())?;
    renderer.set_scene(&view.scene)?;
    renderer.set_lighting(&environment.map, &*lab.lights(FIT, None, &view, &environment)?)?;
    renderer.draw(&view.camera, width, height)?;

    let start = Instant::now();
    let read = lab
        .options
        .data
        .environment_file(name)
        .map(|path| gnomon_envmap::load(&path, Default::default()))
        .transpose()?;
    let read_time = read.as_ref().map(|_| milliseconds(start));
    let map = read.map_or_else(|| environment.map.clone(), |read| read.map);
    let start_fit = Instant::now();
    let lights = by_name(FIT, &FitOptions::default())?.fit(&map)?;
    let fit = milliseconds(start_fit);
    let start_filter = Instant::now();
    let prepared = PreparedLighting::new(&map, &lights, &settings)?;
    let filter = milliseconds(start_filter);
    let start_upload = Instant::now();
    renderer.set_prepared_lighting(prepared)?;
    let upload = milliseconds(start_upload);
    let start_frame = Instant::now();
    renderer.draw(&view.camera, width, height)?;
    let frame = milliseconds(start_frame);
    Ok(vec![
        environment.name.into(),
        format!("{} x {}", map.width(), map.height()).into(),
        Cell::from(read_time),
        fit.into(),
        filter.into(),
        upload.into(),
        frame.into(),
        (read_time.unwrap_or(0.0) + fit + filter + upload + frame).into(),
    ])
}
