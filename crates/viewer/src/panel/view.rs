//! What is shown.

use gnomon_renderer::debug_view::DEBUG_VIEWS;

use super::fields::Fields;
use crate::picture::{DebugChoice, Shown};
use crate::viewer::Viewer;

pub fn show(fields: &mut Fields<'_>, viewer: &mut Viewer) {
    let (fitted, lights) = viewer
        .studio()
        .map_or((0, 0), |studio| (studio.lights().lights.len(), studio.renderer().light_count()));
    fields.text("lights", &format!("{fitted} fitted, {lights} with ambient"));
    let picture = &mut viewer.picture;
    let shown = Shown::ALL.iter().find(|(shown, _)| *shown == picture.shown).map_or("", |(_, name)| name);
    if let Some(picked) =
        fields.choice("picture", "picture of", shown, Shown::ALL.map(|(_, name)| (name, "R")))
    {
        picture.shown =
            Shown::ALL.iter().find(|(_, name)| *name == picked).map_or(Shown::Gpu, |(shown, _)| *shown);
    }
    if picture.shown == Shown::Gpu {
        let choice = picture.debug.unwrap_or(DebugChoice { view: 0, light: 0 });
        let entries = DEBUG_VIEWS.iter().map(|view| (view.name, view.summary));
        let now = DEBUG_VIEWS.get(choice.view);
        if let Some(picked) =
            fields.choice("debug view", "debug view", now.map_or("", |view| view.name), entries)
        {
            let view = DEBUG_VIEWS.iter().position(|view| view.name == picked).unwrap_or(0);
            picture.debug = (view > 0).then_some(DebugChoice { view, ..choice });
        }
        if now.is_some_and(|view| view.of_light)
            && let Some(choice) = &mut picture.debug
        {
            fields.slider("light", "light", &mut choice.light, 0..=lights.saturating_sub(1), "");
        }
    }
}
