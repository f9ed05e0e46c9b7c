//! Time per pass.

use eframe::egui::{Align, Grid, Layout, RichText, Ui, Vec2};

use super::fields::Fields;
use crate::viewer::Viewer;

pub fn show(fields: &mut Fields<'_>, viewer: &Viewer, times: &mut bool) {
    fields.check("passes", "times", times, "time each");
    let picture = &viewer.picture;
    let column = 0.5 * fields.ui.available_width() - 8.0;
    Grid::new("times").num_columns(2).min_col_width(column).spacing(Vec2::new(16.0, 2.0)).striped(true).show(
        fields.ui,
        |ui| {
            for pass in &picture.passes {
                row(ui, pass.name, pass.milliseconds, false);
            }
            row(ui, "frame", picture.frame_ms, true);
        },
    );
}

fn row(ui: &mut Ui, name: &str, milliseconds: f64, strong: bool) {
    let text = |text: &str| match strong {
        true => RichText::new(text).strong(),
        false => RichText::new(text),
    };
    ui.label(text(name));
    ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
        ui.label(text(&format!("{milliseconds:.2} ms")).monospace());
    });
    ui.end_row();
}
