//! Options of the look, each with the control that its declaration asks for.

use std::collections::BTreeMap;

use eframe::egui::Ui;
use gnomon_options::{Kind, OptionField, OptionSpec, OptionValue, Options};
use gnomon_studio::Look;

use super::fields::{Fields, drag, list, slide, tick};
use crate::targets::Targets;

/// Widest range of a slider; wider ones are typed or dragged.
const SLIDER_SPAN: f32 = 64.0;

/// The entry of a list that leaves an option to the program.
const AUTOMATIC: &str = "automatic";

/// Options under one heading.
pub struct Heading {
    pub title: &'static str,
    /// Whether they are few enough to be shown without being asked for: parameters of a technique are not.
    pub open: bool,
}

/// The headings of options that matter for a look, in the order of their declaration.
pub fn headings(look: &Look) -> Vec<Heading> {
    let mut headings: Vec<Heading> = Vec::new();
    let matters = condition(look);
    look.visit(&mut |spec, _| {
        let title = spec.heading();
        if is_controlled(spec) && matters(spec) && headings.iter().all(|heading| heading.title != title) {
            headings.push(Heading { title, open: spec.group.table.is_empty() });
        }
    });
    headings
}

/// Controls for all options under a heading that matter. `in_force` tells what the program has come to where an option is left to it.
pub fn show(
    fields: &mut Fields<'_>,
    wanted: &mut Look,
    title: &str,
    in_force: &dyn Fn(&OptionSpec) -> Option<f32>,
) {
    let matters = condition(wanted);
    wanted.visit_mut(&mut |spec, field| {
        if spec.heading() == title && is_controlled(spec) && matters(spec) {
            control(fields, spec, field, in_force(spec));
        }
    });
}

/// The window itself is the picture's size.
fn is_controlled(spec: &OptionSpec) -> bool {
    !matches!(spec.kind, Kind::Size)
}

/// Whether an option matters, by the choices that a look makes.
fn condition(look: &Look) -> impl Fn(&OptionSpec) -> bool + use<> {
    let mut chosen = BTreeMap::new();
    look.visit(&mut |spec, field| {
        if let OptionValue::Name(name) = field.get() {
            chosen.insert(spec.name(), name);
        }
    });
    move |spec| spec.condition().is_none_or(|(name, value)| chosen.get(name).is_some_and(|is| is == value))
}

fn control(fields: &mut Fields<'_>, spec: &OptionSpec, field: &mut dyn OptionField, in_force: Option<f32>) {
    let (name, value) = (spec.name(), field.get());
    let tip = format!("{name}: {}\n{}", spec.help(), spec.allowed());
    let changed = fields.row(&spec.label(), &tip, |ui, targets| {
        let is_list = matches!(spec.kind, Kind::Choice(_));
        if spec.automatic.is_some() && !is_list {
            let mut automatic = value == OptionValue::Automatic;
            if tick(ui, targets, &format!("automatic {name}"), &mut automatic, "automatic") {
                return Some(if automatic { OptionValue::Automatic } else { start(spec, in_force) });
            }
            if automatic {
                in_force.iter().for_each(|_| drop(ui.weak(start(spec, in_force).to_string())));
                return None;
            }
        }
        edit(ui, targets, spec, &name, value)
    });
    // Bounds that are excluded are all that a control offers and an option cannot be.
    if let Some(Ok(changed)) = changed.map(|changed| spec.accept(changed)) {
        field.put(&changed);
    }
}

/// What an option begins with that is taken in hand.
fn start(spec: &OptionSpec, in_force: Option<f32>) -> OptionValue {
    let number = in_force.unwrap_or(spec.start);
    match spec.kind {
        Kind::Number { .. } => OptionValue::Number((100.0 * number).round() / 100.0),
        _ => OptionValue::Whole(number as i64),
    }
}

/// What the user makes of a value, if anything.
fn edit(
    ui: &mut Ui,
    targets: &mut Targets,
    spec: &OptionSpec,
    name: &str,
    value: OptionValue,
) -> Option<OptionValue> {
    match (spec.kind, value) {
        (Kind::Bool, OptionValue::Bool(mut on)) => {
            tick(ui, targets, name, &mut on, "").then_some(OptionValue::Bool(on))
        }
        (Kind::Whole { least, most }, OptionValue::Whole(mut number)) => {
            let changed = match most - least <= SLIDER_SPAN as i64 {
                true => slide(ui, targets, name, &mut number, least..=most, ""),
                false => drag(ui, targets, name, &mut number, least..=most),
            };
            changed.then_some(OptionValue::Whole(number))
        }
        (Kind::Number { least, most, .. }, OptionValue::Number(mut number)) => {
            let changed = match most - least <= SLIDER_SPAN {
                true => slide(ui, targets, name, &mut number, least..=most, ""),
                false => drag(ui, targets, name, &mut number, least..=most),
            };
            changed.then_some(OptionValue::Number(number))
        }
        (Kind::PowerOfTwo { least, most }, value) => {
            let powers = least.trailing_zeros()..=most.trailing_zeros();
            let powers: Vec<String> = powers.map(|power| (1_i64 << power).to_string()).collect();
            let entries = powers.iter().map(|power| (power.as_str(), ""));
            let picked = list(ui, targets, name, &value.to_string(), entries)?;
            picked.parse().ok().map(OptionValue::Whole)
        }
        (Kind::Choice(choices), value) => {
            let automatic = spec.automatic.map(|meaning| (AUTOMATIC, meaning));
            let entries = choices().into_iter().map(|choice| (choice.name, choice.summary));
            let entries = automatic.into_iter().chain(entries);
            list(ui, targets, name, &value.to_string(), entries).map(|picked| match picked {
                AUTOMATIC if automatic.is_some() => OptionValue::Automatic,
                picked => OptionValue::Name(picked.to_owned()),
            })
        }
        _ => None,
    }
}
