use gnomon_metrics::Region;
use gnomon_picture::{ContactSheet, Panel};

use super::common::{Lamp, uniform_maps};
use super::variant::Variant;
use crate::columns::{TIME_COLUMNS, mebibytes, stand_ins, time_cells};
use crate::drawn::time_in_turns;
use crate::pictures::{compare_within, cropped, shown};
use crate::report::{Axis, Cell, Plot, Section, Series, Style, Table, significant};
use crate::{Experiment, Lab, LabError};

/// Fig. 7: techniques on one light against ray tracing.
pub(super) struct Rivals;

/// Frames per second of the paper's Fig. 7 (GeForce 8800 GTX, 212 k faces, 512 x 512 map).
const PAPER: [(&str, f64); 3] =
    [("convolution SAT M=4", 60.0), ("convolution SAT M=16", 23.0), ("pcss", 18.0)];

/// Where the model meets the ground, and where the shadow of its top falls: shares of width and height, left, top, width, height.
const CLOSE_UPS: [(&str, [f32; 4]); 2] =
    [("contact", [0.44, 0.72, 0.25, 0.25]), ("penumbra", [0.70, 0.64, 0.25, 0.25])];

impl Experiment for Rivals {
    fn name(&self) -> &'static str {
        "rivals"
    }

    fn title(&self) -> &'static str {
        "Quality and time of techniques on one light (Fig. 7)"
    }

    fn run(&self, lab: &Lab<'_>) -> Result<Section, LabError> {
        let view = lab.view("buddha")?;
        let lamp = Lamp::over(&view);
        let size = lab.pick([32, 24], [256, 192], [512, 384]);
        let resolution = lab.pick(32, 256, 512);
        let setup = lamp.setup(size);
        let frame = uniform_maps(resolution);
        lab.tell("rivals: tracing", 0.0);
        let truth = lab.truth_of_lights(&setup, lab.pick(2, 128, 1024))?;
        lab.tell("rivals: drawing", 0.5);
        let mut drawn = Vec::new();
        for variant in Variant::all() {
            drawn.extend(variant.drawn(lab, setup, &frame, &truth.picture)?);
        }
        lab.tell("rivals: timing", 0.7);
        time_in_turns(&mut drawn, &lab.timing_plan(30.0))?;

        let regions = CLOSE_UPS.map(|(name, part)| region(name, part, size));
        let columns = [
            &[("technique", "")][..],
            &TIME_COLUMNS,
            &[
                ("shadow memory", "MiB"),
                ("relative RMSE", ""),
                ("RMSE at the contact", ""),
                ("RMSE in the penumbra", ""),
                ("FLIP, weighted median", ""),
                ("paper, 8800 GTX", "ms"),
            ],
        ]
        .concat();
        let mut table =
            Table::new("rivals", "One light: time, interleaved, and error of the same picture", &columns);
        for drawn in &drawn {
            let mut row: Vec<Cell> = vec![drawn.name.as_str().into()];
            row.extend(time_cells(drawn.spread.as_ref()));
            row.push(mebibytes(drawn.renderer.shadow_bytes()).into());
            row.push(drawn.comparison.relative_rmse.into());
            for region in &regions {
                row.push(compare_within(&drawn.picture, &truth.picture, region)?.relative_rmse.into());
            }
            row.push(f64::from(drawn.comparison.flip.weighted_median).into());
            let paper = PAPER.iter().find(|(name, _)| *name == drawn.name);
            row.push(paper.map(|(_, rate)| 1000.0 / rate).into());
            table.push(row);
        }

        let mut plot = Plot::new(
            "rivals",
            "Error against time, one light",
            Axis::logarithmic("frame time", "ms"),
            Axis::linear("relative RMSE", ""),
        );
        for drawn in &drawn {
            let time = drawn.spread.map_or(f64::NAN, |spread| spread.median);
            let point = (time, drawn.comparison.relative_rmse);
            plot.series.push(Series::new(drawn.name.as_str(), vec![point]).styled(Style::Points));
        }

        let mut paragraphs = vec![format!(
            "{} triangles, one square lamp in the scene, ten degrees wide, {resolution} x {resolution} map, {} x {} pixels of 2 x 2 samples. \
             Truth: {}.",
            view.scene.triangle_count(),
            size[0],
            size[1],
            truth.described()
        )];
        paragraphs.extend(stand_ins(&[view], &[]));
        let stops = drawn.first().map_or(0.0, |drawn| drawn.comparison.exposure);
        let (mut whole, mut wrong) = (
            ContactSheet::new("rivals", "One light", 3),
            ContactSheet::new("rivals_difference", "Picture - truth", 3),
        );
        whole.panels.push(Panel::new("ray traced", shown(&truth.picture, stops)));
        for drawn in &drawn {
            whole.panels.push(drawn.panel(stops));
            wrong.panels.push(drawn.difference_panel(&drawn.name, &truth.picture)?);
        }
        let mut close = Vec::new();
        for region in &regions {
            let title = format!("Close-up: {}", region.name);
            let mut sheet = ContactSheet::new(format!("rivals_{}", region.name), title, 4);
            sheet.enlargement = lab.pick(8, 4, 2);
            let part = |picture| shown(&cropped(picture, region), stops);
            sheet.panels.push(Panel::new("ray traced", part(&truth.picture)));
            for drawn in &drawn {
                let error = compare_within(&drawn.picture, &truth.picture, region)?.relative_rmse;
                let caption = format!("{}\nRMSE {}", drawn.name, significant(error, 3));
                sheet.panels.push(Panel::new(caption, part(&drawn.picture)));
            }
            close.push(sheet);
        }
        let sheets = [vec![whole, wrong], close].concat();
        Ok(Section { paragraphs, tables: vec![table], plots: vec![plot], sheets, ..Section::default() })
    }
}

fn region(name: &str, [left, top, width, height]: [f32; 4], [across, down]: [u32; 2]) -> Region {
    let pixels = |share: f32, whole: u32| (share * whole as f32).round() as u32;
    Region {
        name: name.to_owned(),
        x: pixels(left, across),
        y: pixels(top, down),
        width: pixels(width, across).max(1),
        height: pixels(height, down).max(1),
    }
}
