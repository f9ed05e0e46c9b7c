//! Options of the look, each with the control that its declaration asks for.

use std::collections::BTreeMap;

use eframe::egui::Ui;
use gnomon_options::{Kind, OptionField, OptionSpec, OptionValue, Options};
use gnomon_studio::Look;

use super::fields::{Fields, drag, list, path, slide, tick};
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

/// What a scene makes of an option.
pub enum Offer {
    /// What its declaration says.
    Declared,
    /// These texts, with names for people.
    Texts(Vec<(String, String)>),
    /// A number from 0 to this, after which it starts again.
    UpTo(f32),
    /// It does not matter.
    Nothing,
}

/// No scene makes anything of any option.
pub fn as_declared(_: &OptionSpec) -> Offer {
    Offer::Declared
}

/// The headings but `others` of options that matter for a look, in the order of their declaration.
pub fn headings(look: &Look, others: &[&str]) -> Vec<Heading> {
    let mut headings: Vec<Heading> = Vec::new();
    let matters = gnomon_options::matters(look);
    look.visit(&mut |spec, _| {
        let title = spec.heading();
        if !others.contains(&title)
            && is_controlled(spec)
            && matters(spec)
            && headings.iter().all(|heading| heading.title != title)
        {
            headings.push(Heading { title, open: spec.group.table.is_empty() });
        }
    });
    headings
}

/// Controls for all options under a heading that matter. `in_force` is the look with what the program has come to where an option is left
/// to it.
pub fn show(
    fields: &mut Fields<'_>,
    wanted: &mut Look,
    title: &str,
    in_force: &Look,
    offer: &dyn Fn(&OptionSpec) -> Offer,
) {
    let matters = gnomon_options::matters(wanted);
    let mut values = BTreeMap::new();
    in_force.visit(&mut |spec, field| drop(values.insert(spec.name(), field.get())));
    wanted.visit_mut(&mut |spec, field| {
        if spec.heading() == title && is_controlled(spec) && matters(spec) {
            match offer(spec) {
                Offer::Nothing => {}
                offer => control(fields, spec, field, values.get(&spec.name()), &offer),
            }
        }
    });
}

/// The window itself is the picture's size.
fn is_controlled(spec: &OptionSpec) -> bool {
    !matches!(spec.kind, Kind::Size)
}

fn control(
    fields: &mut Fields<'_>,
    spec: &OptionSpec,
    field: &mut dyn OptionField,
    in_force: Option<&OptionValue>,
    offer: &Offer,
) {
    let (name, value) = (spec.name(), field.get());
    let tip = format!("{name}: {}\n{}", spec.help(), spec.allowed());
    let changed = fields.row(&spec.label(), &tip, |ui, targets| {
        let is_list = matches!(spec.kind, Kind::Choice(_) | Kind::Text | Kind::File);
        if spec.automatic.is_some() && !is_list {
            let mut automatic = value == OptionValue::Automatic;
            if tick(ui, targets, &format!("automatic {name}"), &mut automatic, "automatic") {
                return Some(if automatic { OptionValue::Automatic } else { start(spec, in_force) });
            }
            if automatic {
                if let Some(OptionValue::Number(_) | OptionValue::Whole(_)) = in_force {
                    ui.weak(start(spec, in_force).to_string());
                }
                return None;
            }
        }
        edit(ui, targets, spec, &name, value, offer)
    });
    // Bounds that are excluded are all that a control offers and an option cannot be.
    if let Some(Ok(changed)) = changed.map(|changed| spec.accept(changed)) {
        field.put(&changed);
    }
}

/// What an option begins with that is taken in hand.
fn start(spec: &OptionSpec, in_force: Option<&OptionValue>) -> OptionValue {
    match (spec.kind, in_force) {
        (_, Some(&OptionValue::Number(number))) => OptionValue::Number((100.0 * number).round() / 100.0),
        (_, Some(&OptionValue::Whole(number))) => OptionValue::Whole(number),
        (Kind::Number { .. }, _) => OptionValue::Number(spec.start),
        _ => OptionValue::Whole(spec.start as i64),
    }
}

/// The same angle from -180 to 180 degrees.
pub fn wrapped(degrees: f32) -> f32 {
    if degrees.abs() <= 180.0 { degrees } else { (degrees + 180.0).rem_euclid(360.0) - 180.0 }
}

/// What the user makes of a value, if anything.
fn edit(
    ui: &mut Ui,
    targets: &mut Targets,
    spec: &OptionSpec,
    name: &str,
    value: OptionValue,
    offer: &Offer,
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
        (Kind::Number { .. }, OptionValue::Number(number)) if let Offer::UpTo(end) = *offer => {
            let is_beyond = end > 0.0 && number > end;
            let mut number = if is_beyond { number.rem_euclid(end) } else { number };
            let changed = slide(ui, targets, name, &mut number, 0.0..=end.max(1e-3), spec.unit);
            changed.then_some(OptionValue::Number(number))
        }
        (Kind::Angle, OptionValue::Number(number)) => {
            let mut number = wrapped(number);
            slide(ui, targets, name, &mut number, -180.0..=180.0, "°").then_some(OptionValue::Number(number))
        }
        (Kind::Text, value) if let Offer::Texts(texts) = offer => {
            let automatic = spec.automatic.unwrap_or(AUTOMATIC);
            let chosen = texts.iter().find(|(text, _)| value == OptionValue::Name(text.clone()));
            let shown = chosen.map_or(automatic, |(_, label)| label);
            let labels = texts.iter().map(|(_, label)| (label.as_str(), ""));
            let entries = std::iter::once((automatic, "")).chain(labels);
            list(ui, targets, name, shown, entries).map(|picked| {
                let text = texts.iter().find(|(_, label)| label == picked);
                text.map_or(OptionValue::Automatic, |(text, _)| OptionValue::Name(text.clone()))
            })
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
        (Kind::Color, OptionValue::Color(mut color)) => {
            let channels = ["red", "green", "blue"].iter().zip(&mut color);
            let changed = channels
                .map(|(channel, value)| drag(ui, targets, &format!("{name} {channel}"), value, 0.0..=1e6));
            // All are drawn, whichever changes.
            changed.fold(false, |any, one| any | one).then_some(OptionValue::Color(color))
        }
        (Kind::File, value) => path(ui, targets, name, &value),
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
