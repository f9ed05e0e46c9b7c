//! What is shown, and the techniques that draw it.

use gnomon_picture::tonemap::ToneMapping;
use gnomon_renderer::debug_view::DEBUG_VIEWS;
use gnomon_renderer::{ambient, composite, shadow, unshadowed};
use gnomon_studio::{Look, PrefilterName, SizingName};

use super::fields::Fields;
use crate::picture::{DebugChoice, Shown};
use crate::viewer::Viewer;

pub fn view(fields: &mut Fields<'_>, viewer: &mut Viewer, wanted: &mut Look) {
    let lights = viewer.studio().map_or(0, |studio| studio.renderer().light_count());
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
    let rules = ToneMapping::ALL.map(|rule| (rule.name(), ""));
    if let Some(picked) = fields.choice("tone mapping", "tone mapping", &wanted.display.tone_mapping, rules) {
        wanted.display.tone_mapping = picked.to_owned();
    }
    fields.slider("samples", "supersample", &mut wanted.render.supersample, 1..=4, "²");
}

pub fn shadows(fields: &mut Fields<'_>, wanted: &mut Look) {
    let render = &mut wanted.render;
    if let Some(picked) = fields.choice("technique", "shadows", &render.shadows, shadow::names()) {
        render.shadows = picked.to_owned();
    }
    fields.power("map size", "shadow resolution", &mut render.shadow_resolution, (32, 2048));
    fields.power("sampling", "shadow sampling", &mut render.shadow_sampling, (1, 32));
    let sizing = |name| if name == SizingName::Uniform { "uniform" } else { "footprint" };
    let entries = [("footprint", "the wider the light, the coarser its map"), ("uniform", "all alike")];
    if let Some(picked) = fields.choice("map sizes", "shadow sizing", sizing(render.shadow_sizing), entries) {
        render.shadow_sizing = if picked == "uniform" { SizingName::Uniform } else { SizingName::Footprint };
    }
    fields.number(
        "deviation",
        "caster deviation",
        &mut render.caster_deviation,
        0.0..=16.0,
        "texels by which what is drawn into shadow maps may deviate from the meshes",
    );
    if render.shadows != "convolution" {
        return;
    }
    fields.slider("order", "order", &mut render.order, 1..=16, "");
    let now = if render.prefilter == PrefilterName::Sat { "sat" } else { "mip" };
    let entries = [("mip", "mip chains, half floats"), ("sat", "summed-area tables, 32-bit floats")];
    if let Some(picked) = fields.choice("prefilter", "prefilter", now, entries) {
        render.prefilter = if picked == "sat" { PrefilterName::Sat } else { PrefilterName::Mip };
    }
    fields.slider("contact samples", "contact samples", &mut render.contact_samples, 0..=64, "");
}

pub fn compositing(fields: &mut Fields<'_>, wanted: &mut Look) {
    let render = &mut wanted.render;
    let rules = composite::COMPOSITINGS.iter().map(|rule| (rule.name, rule.summary));
    if let Some(picked) = fields.choice("rule", "compositing", &render.compositing, rules) {
        render.compositing = picked.to_owned();
    }
    let sources = unshadowed::UNSHADOWED.iter().map(|source| (source.name, source.summary));
    if let Some(picked) = fields.choice("unshadowed", "unshadowed", &render.unshadowed, sources) {
        render.unshadowed = picked.to_owned();
    }
    let ambients = ambient::AMBIENTS.iter().map(|ambient| (ambient.name, ambient.summary));
    if let Some(picked) = fields.choice("ambient", "ambient", &render.ambient, ambients) {
        render.ambient = picked.to_owned();
    }
    fields.number(
        "cells",
        "cells",
        &mut render.ambient_cells,
        6..=4096,
        "lights or probes that the rest may become",
    );
}
