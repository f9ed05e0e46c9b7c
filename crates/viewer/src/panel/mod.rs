//! The panel: everything that the picture depends on.

mod draw;
mod fields;
mod light;
mod material;
mod scene;
mod times;

use eframe::egui::Ui;
use gnomon_studio::Look;

pub use light::wrapped;

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
    fields.section("View", true, |fields| draw::view(fields, viewer, &mut wanted));
    fields.section("Environment", true, |fields| light::environment(fields, viewer, &mut wanted));
    fields.section("Lights", true, |fields| light::lights(fields, viewer, &mut wanted));
    fields.section("Shadows", true, |fields| draw::shadows(fields, &mut wanted));
    fields.section("Compositing", false, |fields| draw::compositing(fields, &mut wanted));
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
