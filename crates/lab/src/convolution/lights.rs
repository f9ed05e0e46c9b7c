use std::rc::Rc;

use gnomon_lights::LightSet;
use gnomon_picture::{ContactSheet, Panel};

use super::common::{FITS, maps_by_footprint, uniform_maps};
use super::variant::Variant;
use crate::columns::{TIME_COLUMNS, mebibytes, stand_ins, time_cells};
use crate::drawn::time_in_turns;
use crate::pictures::{difference, shown};
use crate::report::{Axis, Cell, Plot, Section, Series, Table, significant};
use crate::timing::TimingPlan;
use crate::{Effort, Environment, Experiment, Lab, LabError, Setup, Truth, View};

/// Figs 10 and 11: number of lights, and convolution shadows against many hard maps.
pub(super) struct Lights;

/// Samples along the side of a tile of the shadow buffer: a sixteenth of all.
const COARSE_SAMPLING: u32 = 4;

/// What every picture of a map shares.
struct Scenery {
    view: Rc<View>,
    environment: Rc<Environment>,
    truth: Rc<Truth>,
    size: [u32; 2],
    resolution: u32,
}

impl Scenery {
    fn setup<'a>(&'a self, lights: &'a LightSet) -> Setup<'a> {
        Setup { view: &self.view, map: &self.environment.map, lights, size: self.size }
    }
}

impl Experiment for Lights {
    fn name(&self) -> &'static str {
        "lights"
    }

    fn title(&self) -> &'static str {
        "Number of lights, and many hard shadow maps (Figs 10 and 11)"
    }

    fn run(&self, lab: &Lab<'_>) -> Result<Section, LabError> {
        let view = lab.view("bunny")?;
        let environments =
            lab.environments(lab.pick(&["rnl"], &["rnl", "stpeters"], &["rnl", "stpeters"]))?;
        let size = lab.pick([32, 24], [128, 96], [256, 192]);
        let resolution = lab.pick(32, 256, 256);
        let columns = [
            &[("environment", ""), ("fit", ""), ("lights asked for", ""), ("lights", "")][..],
            &TIME_COLUMNS,
            &[
                ("shadow memory", "MiB"),
                ("relative RMSE", ""),
                ("relative bias", ""),
                ("FLIP, weighted median", ""),
            ],
        ]
        .concat();
        let caption = "Error against the number of lights: convolution, mip maps, M = 4, coarser maps for wider lights; timed interleaved";
        let mut section =
            Section { tables: vec![Table::new("lights", caption, &columns)], ..Section::default() };
        let mut duel = duel_table();
        let share = 1.0 / environments.len().max(1) as f32;
        for (index, environment) in environments.iter().enumerate() {
            let start = index as f32 * share;
            lab.tell(&format!("lights: tracing {}", environment.name), start);
            let truth = lab.truth(&view, environment, size, lab.pick(2, 256, 1024))?;
            let scenery = Scenery {
                view: Rc::clone(&view),
                environment: Rc::clone(environment),
                truth,
                size,
                resolution,
            };
            // A quick run does each part under one environment: the paper's Fig. 10 has RNL, its Fig. 11 St Peter's.
            if index == 0 || lab.effort() != Effort::Quick {
                counts(lab, &scenery, (start, 0.6 * share), &mut section)?;
            }
            if index + 1 == environments.len() || lab.effort() != Effort::Quick {
                let resolutions: &[u32] = lab.pick(&[32], &[128], &[64, 128, 256]);
                for (step, &resolution) in resolutions.iter().enumerate() {
                    let message = format!("lights: many hard maps of {resolution}, {}", environment.name);
                    let done = 0.7 + 0.3 * step as f32 / resolutions.len() as f32;
                    lab.tell(&message, start + done * share);
                    many_hard_maps(lab, &scenery, resolution, &mut duel, &mut section)?;
                }
            }
            section.paragraphs.push(format!(
                "{}: {} triangles, {} x {} pixels of 2 x 2 samples, truth: {}; numbers of lights: maps of {resolution} x {resolution} texels at most.",
                environment.name,
                view.scene.triangle_count(),
                size[0],
                size[1],
                scenery.truth.described()
            ));
        }
        section.tables.push(duel);
        section.paragraphs.extend(stand_ins(&[view], &environments));
        Ok(section)
    }
}

/// One plot and one sheet of an environment: every fit with every number of lights.
fn counts(
    lab: &Lab<'_>,
    scenery: &Scenery,
    (start, share): (f32, f32),
    section: &mut Section,
) -> Result<(), LabError> {
    let counts: &[usize] = lab.pick(&[6], &[15, 30, 60], &[15, 30, 45, 60, 80, 120, 200]);
    let name = scenery.environment.name;
    let truth = &scenery.truth.picture;
    let frame = maps_by_footprint(scenery.resolution);
    let mut plot = Plot::new(
        format!("lights_{name}"),
        format!("Error against the number of lights: {name}"),
        Axis::logarithmic("lights", "").with_ticks(counts.iter().map(|&count| count as f64).collect()),
        Axis::logarithmic("relative RMSE", ""),
    );
    plot.series = FITS.into_iter().map(|fit| Series::new(fit, Vec::new())).collect();
    let mut sheet = ContactSheet::new(format!("lights_{name}"), format!("Lights: {name}"), 4);
    sheet.enlargement = lab.pick(1, 2, 1);
    for (step, &count) in counts.iter().enumerate() {
        lab.tell(&format!("lights: {name}, {count}"), start + share * step as f32 / counts.len() as f32);
        let mut sets = Vec::new();
        for fit in FITS {
            sets.push(lab.lights(fit, Some(count), &scenery.view, &scenery.environment)?);
        }
        let mut drawn = Vec::new();
        for set in &sets {
            drawn.push(Variant::mip(4).drawn(lab, scenery.setup(set), &frame, truth)?);
        }
        let few = TimingPlan { least_rounds: lab.pick(1, 2, 3), ..lab.timing_plan(3.0) };
        time_in_turns(drawn.iter_mut().flatten(), &few)?;
        for ((set, drawn), series) in sets.iter().zip(&drawn).zip(&mut plot.series) {
            let found = set.lights.len();
            let mut row: Vec<Cell> = vec![name.into(), set.method.into(), count.into(), found.into()];
            row.extend(time_cells(drawn.as_ref().and_then(|drawn| drawn.spread.as_ref())));
            if let Some(drawn) = drawn {
                let comparison = &drawn.comparison;
                row.push(mebibytes(drawn.renderer.shadow_bytes()).into());
                row.push(comparison.relative_rmse.into());
                row.push(comparison.relative_bias.into());
                row.push(f64::from(comparison.flip.weighted_median).into());
                series.points.push((found as f64, comparison.relative_rmse));
                sheet.panels.push(drawn.difference_panel(&format!("{found} {}", set.method), truth)?);
            }
            if let Some(table) = section.tables.first_mut() {
                table.push(row);
            }
        }
    }
    sheet.columns = FITS.len() as u32;
    sheet.title = format!("Picture - truth: {name}");
    section.plots.push(plot);
    section.sheets.push(sheet);
    Ok(())
}

fn duel_table() -> Table {
    let columns = [
        &[
            ("environment", ""),
            ("maps", "texels a side"),
            ("technique", ""),
            ("lights", ""),
            ("samples a light sum", ""),
        ][..],
        &TIME_COLUMNS,
        &[
            ("rounds", ""),
            ("over the first row's time", ""),
            ("shadow memory", "MiB"),
            ("relative RMSE", ""),
            ("paper, 8800 GTX", "ms"),
        ],
    ]
    .concat();
    let caption = "30 lights with soft shadows against many hard shadow maps, all maps of one size, timed interleaved; each with light summed at every sample, and once for 4 x 4";
    Table::new("lights_hard_maps", caption, &columns)
}

/// Soft shadows of 30 lights, then hard maps: 500, and at full effort also 100 and 1000.
fn many_hard_maps(
    lab: &Lab<'_>,
    scenery: &Scenery,
    resolution: u32,
    table: &mut Table,
    section: &mut Section,
) -> Result<(), LabError> {
    let hard: &[usize] = lab.pick(&[7], &[500], &[100, 500, 1000]);
    let truth = &scenery.truth.picture;
    let soft = lab.lights("optimized", Some(lab.pick(6, 30, 30)), &scenery.view, &scenery.environment)?;
    let mut soft_variants = Variant::prefilters(4);
    soft_variants.push(Variant::technique("pcss"));
    let soft_variants = soft_variants.into_iter();
    // The first is what the others' times are compared with.
    let mut rivals_of: Vec<_> = (soft_variants.clone())
        .map(|variant| (variant, Rc::clone(&soft), COARSE_SAMPLING))
        .chain(soft_variants.map(|variant| (variant, Rc::clone(&soft), 1)))
        .collect();
    for &count in hard {
        let points = lab.lights("samples", Some(count), &scenery.view, &scenery.environment)?;
        for sampling in [1, COARSE_SAMPLING] {
            rivals_of.push((Variant::technique("hard"), Rc::clone(&points), sampling));
        }
    }
    let name = scenery.environment.name;
    let mut sheet = ContactSheet::new(
        format!("lights_hard_maps_{name}_{resolution}"),
        format!("Many hard maps of {resolution} x {resolution}: {name}"),
        2,
    );
    sheet.enlargement = lab.pick(1, 2, 1);
    let mut drawn = Vec::new();
    for (variant, set, shadow_sampling) in &rivals_of {
        let frame = uniform_maps(resolution).with(|s| s.techniques.shadow_sampling = *shadow_sampling);
        let new = variant.drawn(lab, scenery.setup(set), &frame, truth)?;
        drawn.extend(new.map(|drawn| (drawn, set, *shadow_sampling)));
    }
    let least_rounds = lab.pick(1, 3, 5);
    let plan = TimingPlan { least_rounds, ..lab.timing_plan(40.0) };
    time_in_turns(drawn.iter_mut().map(|(drawn, ..)| drawn), &plan)?;
    let ours = drawn.first().and_then(|(drawn, ..)| drawn.spread).map_or(f64::NAN, |spread| spread.median);
    let stops = drawn.first().map_or(0.0, |(drawn, ..)| drawn.comparison.exposure);
    sheet.panels.push(Panel::new(format!("truth\n{}", scenery.truth.source), shown(truth, stops)));
    sheet.panels.push(Panel::new("truth - truth", difference(truth, truth)?));
    for (drawn, set, sampling) in &drawn {
        let Some(spread) = drawn.spread else { continue };
        let found = set.lights.len();
        let mut row: Vec<Cell> = vec![
            name.into(),
            resolution.into(),
            format!("{}, {}", drawn.name, set.method).into(),
            found.into(),
            (sampling * sampling).into(),
        ];
        row.extend(time_cells(Some(&spread)));
        row.extend([spread.rounds.into(), (spread.median / ours).into()]);
        row.push(mebibytes(drawn.renderer.shadow_bytes()).into());
        row.push(drawn.comparison.relative_rmse.into());
        // Fig. 11: St Peter's, 25.4, 7.5 and 1.4 frames a second.
        let paper = [("mip", 30, 25.4), ("SAT", 30, 7.5), ("hard", 500, 1.4)];
        let paper = paper.iter().find(|(part, count, _)| {
            name == "stpeters" && drawn.name.contains(part) && (found as i64 - count).abs() <= 5
        });
        row.push(paper.map(|(_, _, rate)| 1000.0 / rate).into());
        table.push(row);
        let caption = format!(
            "{found} {}, 1/{}\nRMSE {}, {} ms",
            drawn.name,
            sampling * sampling,
            significant(drawn.comparison.relative_rmse, 3),
            significant(spread.median, 3)
        );
        sheet.panels.push(Panel::new(caption, shown(&drawn.picture, stops)));
        sheet.panels.push(Panel::new("picture - truth", difference(&drawn.picture, truth)?));
    }
    section.sheets.push(sheet);
    Ok(())
}
