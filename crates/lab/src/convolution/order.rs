use gnomon_picture::ContactSheet;
use gnomon_renderer::RenderSettings;
use gnomon_renderer::shadow::ConvolutionSettings;

use super::common::{Lamp, uniform_maps};
use super::variant::Variant;
use crate::columns::{TIME_COLUMNS, mebibytes, stand_ins, time_cells};
use crate::drawn::time_in_turns;
use crate::report::{Axis, Cell, Plot, Section, Series, Table};
use crate::{Experiment, Lab, LabError, Setup};

/// Figs 8 and 9: order of the series, ringing suppression and sharpening; filters.
pub(super) struct Order;

/// Orders of the series.
const ORDERS: [u32; 5] = [1, 2, 4, 8, 16];

/// What of the reconstruction is on: name, ringing suppression, sharpening.
const PARTS: [(&str, bool, bool); 4] = [
    ("suppression and sharpening", true, true),
    ("suppression alone", true, false),
    ("sharpening alone", false, true),
    ("neither", false, false),
];

/// The paper's method of the variant's order and filter, with parts of its reconstruction switched off.
fn with_parts(mut variant: Variant, suppression: bool, sharpening: bool) -> Variant {
    let settings = &mut variant.settings.convolution;
    *settings = ConvolutionSettings {
        order: settings.order,
        prefilter: settings.prefilter,
        ..ConvolutionSettings::paper()
    };
    if !suppression {
        (settings.black_point, settings.white_point) = (0.0, 1.0);
        // It makes up for what the stretch between the two narrows.
        settings.footprint_scale = Some(1.0);
    }
    if !sharpening {
        settings.sharpening_a = Some(0.0);
    }
    variant
}

impl Experiment for Order {
    fn name(&self) -> &'static str {
        "order"
    }

    fn title(&self) -> &'static str {
        "Order of the series, ringing suppression, sharpening and filters (Figs 8 and 9)"
    }

    fn run(&self, lab: &Lab<'_>) -> Result<Section, LabError> {
        let view = lab.view("footbones")?;
        let lamp = Lamp::over(&view);
        let size = lab.pick([32, 24], [192, 144], [384, 288]);
        let resolution = lab.pick(32, 256, 512);
        let setup = lamp.setup(size);
        let frame = uniform_maps(resolution);
        lab.tell("order: tracing", 0.0);
        let truth = lab.truth_of_lights(&setup, lab.pick(2, 128, 1024))?;

        let columns = [
            ("order M", ""),
            ("reconstruction", ""),
            ("relative RMSE", ""),
            ("relative bias", ""),
            ("FLIP, weighted median", ""),
        ];
        let mut quality =
            Table::new("order", "Error with parts of the reconstruction switched off", &columns);
        let mut plot = Plot::new(
            "order",
            "Error against the order of the series",
            Axis::logarithmic("order M", "").with_ticks(ORDERS.map(f64::from).to_vec()),
            Axis::linear("relative RMSE", ""),
        );
        let mut sheet = ContactSheet::new("order", "Order M and parts of the reconstruction", 5);
        let orders: &[u32] = lab.pick(&[4], &ORDERS, &ORDERS);
        let steps = (orders.len() * PARTS.len()) as f32;
        for (row, (name, suppression, sharpening)) in PARTS.into_iter().enumerate() {
            let mut points = Vec::new();
            for (column, &order) in orders.iter().enumerate() {
                let step = (row * orders.len() + column) as f32;
                lab.tell(&format!("order: M = {order}, {name}"), 0.3 + 0.4 * step / steps);
                let variant = with_parts(Variant::mip(order), suppression, sharpening);
                let Some(mut drawn) = variant.drawn(lab, setup, &frame, &truth.picture)? else { continue };
                let comparison = &drawn.comparison;
                quality.push([
                    order.into(),
                    name.into(),
                    comparison.relative_rmse.into(),
                    comparison.relative_bias.into(),
                    f64::from(comparison.flip.weighted_median).into(),
                ]);
                points.push((f64::from(order), comparison.relative_rmse));
                let stops = comparison.exposure;
                drawn.name = format!("M={order}, {name}");
                sheet.panels.push(drawn.panel(stops));
            }
            plot.series.push(Series::new(name, points));
        }
        lab.tell("order: timing", 0.7);
        let (filters, filter_sheet) = filters(lab, orders, setup, &frame, &truth.picture)?;
        let mut paragraphs = vec![format!(
            "{} triangles, one square lamp in the scene, ten degrees wide, {resolution} x {resolution} map, truth: {}. \
             Without suppression the kernel's factor that makes up for it is 1.",
            view.scene.triangle_count(),
            truth.described()
        )];
        paragraphs.extend(stand_ins(&[view], &[]));
        let tables = vec![quality, filters];
        let sheets = vec![sheet, filter_sheet];
        Ok(Section { paragraphs, tables, plots: vec![plot], sheets, ..Section::default() })
    }
}

/// Every order with every filter: time and error.
fn filters(
    lab: &Lab<'_>,
    orders: &[u32],
    setup: Setup<'_>,
    frame: &RenderSettings,
    truth: &gnomon_picture::RgbImage,
) -> Result<(Table, ContactSheet), LabError> {
    let columns =
        [&[("technique", "")][..], &TIME_COLUMNS, &[("shadow memory", "MiB"), ("relative RMSE", "")]]
            .concat();
    let mut table = Table::new("order_filters", "Filters and orders: time, interleaved, and error", &columns);
    let mut sheet = ContactSheet::new("order_filters", "Filters", 2);
    let mut drawn = Vec::new();
    for variant in orders.iter().flat_map(|&order| Variant::prefilters(order)) {
        drawn.extend(variant.drawn(lab, setup, frame, truth)?);
    }
    time_in_turns(&mut drawn, &lab.timing_plan(20.0))?;
    for drawn in &drawn {
        let mut row: Vec<Cell> = vec![drawn.name.as_str().into()];
        row.extend(time_cells(drawn.spread.as_ref()));
        row.push(mebibytes(drawn.renderer.shadow_bytes()).into());
        row.push(drawn.comparison.relative_rmse.into());
        table.push(row);
        if drawn.name.ends_with("M=4") || drawn.name.ends_with("M=16") {
            sheet.panels.push(drawn.panel(drawn.comparison.exposure));
        }
    }
    Ok((table, sheet))
}
