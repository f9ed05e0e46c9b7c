//! The panel: everything that the picture depends on.

mod environment;
mod fields;
mod material;
mod options;
mod rig;
mod scene;
mod times;
mod view;

use eframe::egui::Ui;
use gnomon_studio::{ENVIRONMENT, Look, SCENE};

pub use options::wrapped;

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
    let in_force = viewer.studio().map_or(Look::default(), |studio| studio.look_in_force());
    let mut fields = Fields { ui, targets };
    fields.section(SCENE.heading, true, |fields| scene::show(fields, viewer, &mut wanted));
    fields.section("View", true, |fields| view::show(fields, viewer));
    fields.section(ENVIRONMENT.heading, true, |fields| environment::show(fields, &mut wanted, &in_force));
    fields.section("Light rig", false, |fields| rig::show(fields, viewer, &mut wanted));
    for heading in options::headings(&wanted, &[SCENE.heading, ENVIRONMENT.heading]) {
        fields.section(heading.title, heading.open, |fields| {
            options::show(fields, &mut wanted, heading.title, &in_force, &options::as_declared);
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
