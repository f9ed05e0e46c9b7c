use super::common::uniform_maps;
use super::variant::Variant;
use crate::columns::{TIME_COLUMNS, mebibytes, stand_ins, time_cells};
use crate::drawn::time_in_turns;
use crate::report::{Axis, Cell, Line, Plot, PowerLaw, Section, Series, Style, Table};
use crate::timing::TimingPlan;
use crate::{Experiment, Lab, LabError, Setup, TimedRenderer};

/// Table 1: frame time against map resolution and number of lights.
pub(super) struct Cost;

/// A frame rate of the paper's Table 1 (GeForce 8800 GTX).
struct Paper {
    filter: &'static str,
    /// Texels along a map's side.
    side: u32,
    lights: usize,
    /// Frames per second.
    rate: f64,
}

const fn paper(filter: &'static str, side: u32, lights: usize, rate: f64) -> Paper {
    Paper { filter, side, lights, rate }
}

/// The table, as far as it can be read.
const PAPER: &[Paper] = &[
    paper("mip", 512, 1, 189.0),
    paper("mip", 512, 10, 38.0),
    paper("mip", 512, 20, 20.0),
    paper("mip", 512, 40, 13.0),
    paper("mip", 1024, 1, 110.0),
    paper("mip", 1024, 10, 24.0),
    paper("mip", 1024, 20, 5.0),
    paper("SAT", 128, 1, 128.0),
    paper("SAT", 128, 10, 15.0),
    paper("SAT", 128, 20, 8.8),
    paper("SAT", 256, 1, 110.0),
    paper("SAT", 256, 10, 13.0),
    paper("SAT", 256, 20, 7.5),
    paper("SAT", 512, 1, 89.0),
    paper("SAT", 512, 10, 11.0),
    paper("SAT", 512, 20, 6.0),
    paper("SAT", 1024, 1, 52.0),
    paper("SAT", 1024, 10, 3.0),
    paper("SAT", 1024, 20, 1.5),
];

/// Fewest lights of a partition: one a face of the cube.
const LEAST_PARTITION: usize = 6;

/// Passes whose time is the lights'; the others are the camera's.
const PASSES_OF_LIGHTS: [&str; 4] = ["shadow maps", "shadow filter", "visibility", "light"];

/// What the lights of one frame cost.
struct Row {
    technique: String,
    resolution: u32,
    lights: usize,
    milliseconds: f64,
}

/// Time of the passes that the lights cost [ms].
fn of_lights(times: &PassTimes) -> f64 {
    times.iter().filter(|(name, _)| PASSES_OF_LIGHTS.contains(name)).map(|(_, time)| time).sum()
}

impl Experiment for Cost {
    fn name(&self) -> &'static str {
        "cost"
    }

    fn title(&self) -> &'static str {
        "Frame time against lights and shadow-map resolution (Table 1)"
    }

    fn run(&self, lab: &Lab<'_>) -> Result<Section, LabError> {
        let view = lab.view("buddha")?;
        let environment = lab.environment("rnl")?;
        let size = lab.pick([32, 24], [128, 96], [512, 384]);
        let resolutions: &[u32] = lab.pick(&[16, 32], &[128, 256, 512], &[128, 256, 512, 1024]);
        let counts: &[usize] = lab.pick(&[1, 6], &[1, 10, 20, 40], &[1, 10, 20, 40]);
        lab.tell("cost: tracing", 0.0);
        let truth = lab.truth(&view, &environment, size, lab.pick(2, 64, 256))?;

        let columns = [
            &[("technique", ""), ("map side", "texels"), ("lights", "")][..],
            &TIME_COLUMNS,
            &[("shadow memory", "MiB"), ("relative RMSE", ""), ("paper, 8800 GTX", "ms")],
        ]
        .concat();
        let mut times =
            Table::new("cost_frame", "Frame time, interleaved, and error of the same picture", &columns);
        let mut passes = PassTable::default();
        let mut rows = Vec::new();
        let steps = (resolutions.len() * counts.len()) as f32;
        for (step, (&resolution, &count)) in
            resolutions.iter().flat_map(|r| counts.iter().map(move |c| (r, c))).enumerate()
        {
            lab.tell(&format!("cost: {resolution} texels, {count} lights"), 0.1 + 0.9 * step as f32 / steps);
            // A partition needs more lights than one.
            let method = if count < LEAST_PARTITION { "disks" } else { "partition" };
            let lights = lab.lights(method, Some(count), &view, &environment)?;
            // What a disk leaves over is ambient: with cells there would be more maps than lights asked for.
            let frame = uniform_maps(resolution).with(|s| s.lighting.ambient = "unshadowed".to_owned());
            let setup = Setup { view: &view, map: &environment.map, lights: &lights, size };
            let mut variants = Variant::prefilters(4);
            variants.push(Variant::technique("hard"));
            let mut drawn = Vec::new();
            for variant in &variants {
                drawn.push(variant.drawn(lab, setup, &frame, &truth.picture)?);
            }
            time_in_turns(drawn.iter_mut().flatten(), &lab.timing_plan(8.0))?;
            for (variant, drawn) in variants.iter().zip(&drawn) {
                let found = lights.lights.len();
                let mut row: Vec<Cell> = vec![variant.name.as_ref().into(), resolution.into(), found.into()];
                row.extend(time_cells(drawn.as_ref().and_then(|drawn| drawn.spread.as_ref())));
                row.push(drawn.as_ref().map(|drawn| mebibytes(drawn.renderer.shadow_bytes())).into());
                row.push(drawn.as_ref().map(|drawn| drawn.comparison.relative_rmse).into());
                row.push(paper_milliseconds(&variant.name, resolution, count).into());
                times.push(row);
            }
            drop(drawn);
            let profiled = frame.with(|s| s.measure.profile = true);
            for variant in &variants {
                let renderer = TimedRenderer::if_it_fits(lab, variant.settings(&profiled), setup)?;
                if let Some(mut renderer) = renderer {
                    let times =
                        renderer.pass_times(&TimingPlan { least_rounds: 3, ..lab.timing_plan(4.0) })?;
                    let lights = lights.lights.len();
                    let technique = variant.name.to_string();
                    rows.push(Row { technique, resolution, lights, milliseconds: of_lights(&times) });
                    passes.push(&variant.name, resolution, lights, times);
                }
            }
        }
        let mut paragraphs = vec![format!(
            "{} triangles under {} (one disk, else a partition; nothing ambient has shadows of its own), {} x {} pixels of 2 x 2 \
             samples, all maps of the size stated, truth: {}. Growth is that of the passes that lights cost: {}. A missing time did \
             not fit the adapter.",
            view.scene.triangle_count(),
            environment.name,
            size[0],
            size[1],
            truth.source,
            PASSES_OF_LIGHTS.join(", ")
        )];
        paragraphs.extend(stand_ins(&[view], &[environment]));
        Ok(Section {
            paragraphs,
            tables: vec![times, growth(&rows), passes.table()],
            plots: plots(&rows),
            ..Section::default()
        })
    }
}

/// Rows of the paper's table for the same filter; none for what is no convolution.
fn paper_rows(technique: &str) -> impl Iterator<Item = &'static Paper> {
    PAPER.iter().filter(move |row| technique.starts_with("convolution") && technique.contains(row.filter))
}

fn paper_milliseconds(technique: &str, side: u32, lights: usize) -> Option<f64> {
    paper_rows(technique).find(|row| (row.side, row.lights) == (side, lights)).map(Paper::milliseconds)
}

impl Paper {
    fn milliseconds(&self) -> f64 {
        1000.0 / self.rate
    }
}

/// Times of passes, whichever a frame has.
#[derive(Default)]
struct PassTable {
    names: Vec<&'static str>,
    rows: Vec<(Vec<Cell>, PassTimes)>,
}

/// Name and time [ms] of every pass.
type PassTimes = Vec<(&'static str, f64)>;

impl PassTable {
    fn push(&mut self, technique: &str, resolution: u32, lights: usize, times: PassTimes) {
        for (name, _) in &times {
            if !self.names.contains(name) {
                self.names.push(name);
            }
        }
        self.rows.push((vec![technique.into(), resolution.into(), lights.into()], times));
    }

    fn table(self) -> Table {
        let mut columns = vec![("technique", ""), ("map side", "texels"), ("lights", "")];
        columns.extend(self.names.iter().map(|&name| (name, "ms")));
        let mut table =
            Table::new("cost_passes", "Median time of every pass, each submitted alone", &columns);
        for (mut row, times) in self.rows {
            let time = |name: &str| times.iter().find(|(n, _)| *n == name).map(|(_, time)| *time);
            row.extend(self.names.iter().map(|name| time(name).into()));
            table.push(row);
        }
        table
    }
}

/// Values of `key` in the order in which they come first.
fn distinct<T: PartialEq>(rows: &[Row], key: impl Fn(&Row) -> T) -> Vec<T> {
    let mut found = Vec::new();
    for row in rows {
        let value = key(row);
        if !found.contains(&value) {
            found.push(value);
        }
    }
    found
}

fn against_lights(rows: &[Row], technique: &str, resolution: u32) -> Vec<(f64, f64)> {
    let chosen = rows.iter().filter(|row| row.technique == technique && row.resolution == resolution);
    chosen.map(|row| (row.lights as f64, row.milliseconds)).collect()
}

fn against_resolution(rows: &[Row], technique: &str, lights: usize) -> Vec<(f64, f64)> {
    let chosen = rows.iter().filter(|row| row.technique == technique && row.lights == lights);
    chosen.map(|row| (f64::from(row.resolution), row.milliseconds)).collect()
}

/// How cost grows: a line in the number of lights, a power of the number of texels.
fn growth(rows: &[Row]) -> Table {
    let columns = [
        ("technique", ""),
        ("grows with", ""),
        ("at", ""),
        ("exponent", ""),
        ("each light", "ms"),
        ("without lights", "ms"),
        ("R squared of the line", ""),
    ];
    let caption = "Growth of what lights cost: 1 is linear; a line in the number of lights, a power of a map's number of texels";
    let mut table = Table::new("cost_growth", caption, &columns);
    for technique in distinct(rows, |row| row.technique.clone()) {
        for resolution in distinct(rows, |row| row.resolution) {
            let points = against_lights(rows, &technique, resolution);
            let line = Line::fit(&points);
            table.push([
                technique.as_str().into(),
                "lights".into(),
                format!("{resolution} texels a side").into(),
                PowerLaw::fit(&points).map(|law| law.exponent).into(),
                line.map(|line| line.slope).into(),
                line.map(|line| line.intercept).into(),
                line.map(|line| line.r_squared).into(),
            ]);
        }
        for lights in distinct(rows, |row| row.lights) {
            let points = against_resolution(rows, &technique, lights);
            let texels: Vec<_> = points.iter().map(|(side, time)| (side * side, *time)).collect();
            table.push([
                technique.as_str().into(),
                "texels of a map".into(),
                format!("{lights} lights").into(),
                PowerLaw::fit(&texels).map(|law| law.exponent).into(),
            ]);
        }
    }
    table
}

/// For every technique, time against lights and against resolution, the paper's beside ours.
fn plots(rows: &[Row]) -> Vec<Plot> {
    let mut plots = Vec::new();
    let sides = distinct(rows, |row| row.resolution);
    let counts = distinct(rows, |row| row.lights);
    for technique in distinct(rows, |row| row.technique.clone()) {
        let short = technique.replace("convolution ", "");
        let key: String = short.chars().filter(|character| character.is_alphanumeric()).collect();
        let plot = |what: &str, label: &str, unit: &str, ticks: Vec<f64>| {
            let title = format!("Time of maps, filters, shading against {what}: {technique}");
            let x = Axis::logarithmic(label, unit).with_ticks(ticks);
            Plot::new(format!("cost_{what}_{key}"), title, x, Axis::logarithmic("time", "ms"))
        };
        let ours = |name: String, points| Series::new(name, points).with_slope();
        let theirs = |name: String, points| Series::new(name, points).styled(Style::Dashed);

        let mut lights = plot("lights", "lights", "", counts.iter().map(|&count| count as f64).collect());
        for &side in &sides {
            lights.series.push(ours(format!("{side} x {side}"), against_lights(rows, &technique, side)));
        }
        for &side in &sides {
            let points: Vec<_> = paper_rows(&technique)
                .filter(|row| row.side == side)
                .map(|row| (row.lights as f64, row.milliseconds()))
                .collect();
            if !points.is_empty() {
                lights.series.push(theirs(format!("paper, frame, {side} x {side}"), points));
            }
        }

        let ticks = sides.iter().map(|&side| f64::from(side)).collect();
        let mut resolution = plot("resolution", "side of a shadow map", "texels", ticks);
        for &count in &counts {
            resolution
                .series
                .push(ours(format!("{count} lights"), against_resolution(rows, &technique, count)));
        }
        for &count in &counts {
            let points: Vec<_> = paper_rows(&technique)
                .filter(|row| row.lights == count)
                .map(|row| (f64::from(row.side), row.milliseconds()))
                .collect();
            if !points.is_empty() {
                resolution.series.push(theirs(format!("paper, frame, {count} lights"), points));
            }
        }
        plots.extend([lights, resolution]);
    }
    plots
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(resolution: u32, lights: usize, milliseconds: f64) -> Row {
        Row { technique: "convolution mip M=4".to_owned(), resolution, lights, milliseconds }
    }

    #[test]
    fn growth_of_known_times() {
        // 2 ms and 0.5 ms a light at 512 texels; four times the texels take twice the time.
        let rows = [row(512, 1, 2.5), row(512, 11, 7.5), row(1024, 1, 5.0), row(1024, 11, 15.0)];
        let table = growth(&rows);
        let number = |row: usize, column: usize| match table.rows()[row][column] {
            Cell::Number(number) => number,
            _ => f64::NAN,
        };
        assert!((number(0, 4) - 0.5).abs() < 1e-9 && (number(0, 5) - 2.0).abs() < 1e-9);
        assert!((number(2, 3) - 0.5).abs() < 1e-9 && (number(3, 3) - 0.5).abs() < 1e-9);
        let plots = plots(&rows);
        assert_eq!(plots.len(), 2);
        // The paper's points are those of mip maps.
        assert!(plots[0].series.iter().any(|series| series.points.contains(&(10.0, 1000.0 / 38.0))));
    }

    #[test]
    fn the_paper_is_beside_its_own_filter() {
        assert_eq!(paper_milliseconds("convolution mip M=4", 512, 20), Some(50.0));
        assert_eq!(paper_milliseconds("convolution SAT M=4", 128, 1), Some(1000.0 / 128.0));
        assert_eq!(paper_milliseconds("convolution mip M=4", 128, 1), None);
        assert_eq!(paper_milliseconds("hard", 512, 20), None);
    }
}
