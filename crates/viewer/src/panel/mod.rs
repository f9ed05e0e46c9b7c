//! The panel: everything that the picture depends on.

mod environment;
mod fields;
mod material;
mod options;
mod scene;
mod times;
mod view;

use eframe::egui::Ui;
use gnomon_options::OptionSpec;
use gnomon_studio::Look;

pub use environment::wrapped;

use crate::panel::fields::Fields;
use crate::targets::Targets;
use crate::viewer::Viewer;

/// Draws the panel, and takes over what was changed.
pub fn show(ui: &mut Ui, viewer: &mut Viewer, targets: &mut Targets) {
    ui.add_space(4.0);
    // Room for the scroll bar.
    ui.set_max_width(ui.available_width() - 10.0);
    let Some(look) = viewer.studio().map(|studio| studio.look().clone()) else {
        ui.weak("nothing is open yet");
        return;
    };
    let mut wanted: Look = look.clone();
    let mut fields = Fields { ui, targets };
    fields.section("Scene", true, |fields| scene::show(fields, viewer, &mut wanted));
    fields.section("View", true, |fields| view::show(fields, viewer));
    fields.section("Environment", true, |fields| environment::show(fields, &mut wanted));
    let (exposure, fitted, summed) = viewer.studio().map_or((0.0, 0, 0), |studio| {
        let (fitted, summed) = (studio.lights().lights.len(), studio.renderer().light_count());
        (studio.stage().exposure(), fitted, summed)
    });
    let in_force = |spec: &OptionSpec| match spec.name().as_str() {
        "exposure" => Some(exposure),
        "light-count" => Some(fitted.max(1) as f32),
        _ => None,
    };
    for heading in options::headings(&wanted) {
        fields.section(heading.title, heading.open, |fields| {
            options::show(fields, &mut wanted, heading.title, &in_force);
            if heading.title == "Lights" {
                fields.text("in force", &format!("{fitted} fitted, {summed} with ambient"));
            }
        });
    }
    fields.section("Material", false, |fields| material::show(fields, &mut wanted.reflectance));
    let mut times = viewer.times;
    fields.section("Time per pass", true, |fields| times::show(fields, viewer, &mut times));
    if times != viewer.times {
        viewer.times = times;
        viewer.picture.touch();
    }
    fields.section("Save", true, |fields| scene::save(fields, viewer));
    if wanted != look {
        viewer.edit(|look| *look = wanted);
    }
}
