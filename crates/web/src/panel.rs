//! What a panel offers, as JSON: every option that matters, with its kind, range, help and value.

use gnomon_brdf::{FINISH, Model, Parameter};
use gnomon_options::{Given, Kind, OptionError, OptionSpec, OptionValue, Options, matters, specs};
use gnomon_scene::ReflectanceSettings;
use gnomon_studio::{Clip, Look};
use serde::Serialize;

/// Options under one heading.
#[derive(Debug, Serialize)]
pub struct Section {
    title: &'static str,
    /// Whether they are few enough to be shown without being asked for: parameters of a technique are not.
    open: bool,
    options: Vec<Offer>,
}

/// One option.
#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Offer {
    name: String,
    label: String,
    help: String,
    unit: &'static str,
    control: Control,
    /// As a text, which `Session.set` takes back.
    value: String,
    /// What the program has come to, where it is left to it.
    in_force: Option<String>,
    /// What it means to leave it to the program, where that can be.
    automatic: Option<&'static str>,
}

/// How it is chosen.
#[derive(Debug, Serialize)]
#[serde(tag = "kind", rename_all = "camelCase")]
enum Control {
    YesNo,
    Number { least: f64, most: f64, whole: bool },
    Angle,
    Text,
    Choice { choices: Vec<Entry> },
    Color,
}

#[derive(Debug, Serialize)]
struct Entry {
    value: String,
    label: String,
    help: String,
}

/// Options that the page has controls of its own for, or that name files.
fn is_offered(spec: &OptionSpec) -> bool {
    !matches!(spec.kind, Kind::Size | Kind::File)
}

/// All options that matter for a look, by their headings in the order of their declaration. `in_force` is the look with what the program
/// has come to, `clips` are those of the scene.
pub fn sections(look: &Look, in_force: &Look, clips: &[Clip]) -> Vec<Section> {
    let matters = matters(look);
    let mut values = Vec::new();
    in_force.visit(&mut |_, field| values.push(field.get()));
    let mut values = values.into_iter();
    let mut sections: Vec<Section> = Vec::new();
    look.visit(&mut |spec, field| {
        let in_force = values.next();
        if !is_offered(spec) || !matters(spec) {
            return;
        }
        let Some(control) = control(spec, clips) else { return };
        let value = field.get();
        let in_force = in_force.filter(|_| value == OptionValue::Automatic);
        let offer = Offer {
            name: spec.name(),
            label: spec.label(),
            help: format!("{} Takes {}.", spec.help(), spec.allowed()),
            unit: spec.unit,
            control,
            value: value.to_string(),
            in_force: in_force
                .filter(|value| *value != OptionValue::Automatic)
                .map(|value| value.to_string()),
            automatic: spec.automatic,
        };
        match sections.iter_mut().find(|section| section.title == spec.heading()) {
            Some(section) => section.options.push(offer),
            None => sections.push(Section {
                title: spec.heading(),
                open: spec.group.table.is_empty(),
                options: vec![offer],
            }),
        }
    });
    sections
}

/// `None` for an option that the scene leaves nothing to choose of.
fn control(spec: &OptionSpec, clips: &[Clip]) -> Option<Control> {
    let number = |least: f64, most: f64, whole| Control::Number { least, most, whole };
    Some(match (spec.kind, spec.key) {
        (Kind::Text, "clip") => match clips {
            [] => return None,
            clips => {
                let entry = |clip: &Clip| Entry {
                    value: clip.name.clone(),
                    label: clip.label.clone(),
                    help: format!("{:.2} s", clip.duration),
                };
                Control::Choice { choices: clips.iter().map(entry).collect() }
            }
        },
        (Kind::Number { .. }, "time") => {
            number(0.0, clips.iter().find(|clip| clip.is_chosen)?.duration.into(), false)
        }
        (Kind::Bool, _) => Control::YesNo,
        (Kind::Whole { least, most }, _) => number(least as f64, most as f64, true),
        (Kind::Number { least, most, .. }, _) => number(least.into(), most.into(), false),
        (Kind::PowerOfTwo { least, most }, _) => {
            let powers = least.trailing_zeros()..=most.trailing_zeros();
            let entry = |power: u32| {
                let value = (1_i64 << power).to_string();
                Entry { label: value.clone(), value, help: String::new() }
            };
            Control::Choice { choices: powers.map(entry).collect() }
        }
        (Kind::Angle, _) => Control::Angle,
        (Kind::Text, _) => Control::Text,
        (Kind::Choice(choices), _) => {
            let entry = |choice: gnomon_options::Choice| Entry {
                value: choice.name.to_owned(),
                label: choice.name.to_owned(),
                help: choice.summary.to_owned(),
            };
            Control::Choice { choices: choices().into_iter().map(entry).collect() }
        }
        (Kind::Color, _) => Control::Color,
        (Kind::Size | Kind::File, _) => return None,
    })
}

/// Gives an option a value, both as texts.
///
/// # Errors
/// [`OptionError`] for a name of nothing and for what the option cannot be.
pub fn give(given: &mut Given, name: &str, text: &str) -> Result<(), OptionError> {
    let spec = specs::<Look>().into_iter().find(|spec| spec.name() == name);
    let unknown = || OptionError {
        option: gnomon_messages::quoted(name),
        value: gnomon_messages::quoted(text),
        allowed: "nothing: there is no such option".to_owned(),
    };
    given.parse(spec.ok_or_else(unknown)?, text)
}

/// The same of a look.
///
/// # Errors
/// As [`give`].
pub fn set(look: &mut Look, name: &str, text: &str) -> Result<(), OptionError> {
    let mut given = Given::default();
    give(&mut given, name, text)?;
    given.apply(look);
    Ok(())
}

/// Names and texts of the options that are not as they are by default.
pub fn changes(look: &Look) -> Vec<(String, String)> {
    let mut defaults = Vec::new();
    Look::default().visit(&mut |_, field| defaults.push(field.get()));
    let (mut defaults, mut changes) = (defaults.into_iter(), Vec::new());
    look.visit(&mut |spec, field| {
        let value = field.get();
        if defaults.next().as_ref() != Some(&value) && is_offered(spec) {
            changes.push((spec.name(), value.to_string()));
        }
    });
    changes
}

/// Names of what is built in.
#[derive(Debug, Serialize)]
pub struct BuiltIn {
    scenes: &'static [&'static str],
    environments: Vec<&'static str>,
}

/// What is built in.
pub fn built_in() -> BuiltIn {
    BuiltIn { scenes: &gnomon_scene::builtin::NAMES, environments: gnomon_envmap::builtin::names().collect() }
}

/// The reflectance that is given to all models, and what else there is.
#[derive(Debug, Serialize)]
pub struct Material {
    /// Empty where every material keeps its own.
    model: &'static str,
    models: Vec<Entry>,
    parameters: Vec<ParameterOffer>,
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
struct ParameterOffer {
    name: &'static str,
    help: &'static str,
    is_color: bool,
    /// Whether it may be left to the scene.
    optional: bool,
    slider: [f32; 2],
    start: f32,
    /// `None` where it is left to the scene.
    value: Option<[f32; 3]>,
}

/// What a panel offers of materials.
pub fn material(look: &Look) -> Material {
    let models = Model::ALL.iter().map(|model| Entry {
        value: model.name().to_owned(),
        label: model.name().to_owned(),
        help: model.summary().to_owned(),
    });
    let Some(settings) = &look.reflectance else {
        return Material { model: "", models: models.collect(), parameters: Vec::new() };
    };
    let model = settings.model();
    let offer = |parameter: &&'static Parameter, optional| ParameterOffer {
        name: parameter.name,
        help: parameter.help,
        is_color: parameter.is_color,
        optional,
        slider: parameter.slider,
        start: parameter.start,
        value: settings.get(parameter).map(|value| value.to_array()),
    };
    let required = model.required().iter().map(|parameter| offer(parameter, false));
    let optional = model.optional().iter().chain(FINISH).map(|parameter| offer(parameter, true));
    Material { model: model.name(), models: models.collect(), parameters: required.chain(optional).collect() }
}

/// Gives all models a reflectance; an empty name leaves every material its own.
pub fn set_model(look: &mut Look, name: &str) {
    look.reflectance = Model::named(name).map(ReflectanceSettings::new);
}

/// Sets a parameter of the reflectance of all models, or leaves it to the scene. One that the model does not have, or out of its range, is
/// passed over.
pub fn set_parameter(look: &mut Look, name: &str, value: Option<[f32; 3]>) {
    let Some(settings) = &mut look.reflectance else { return };
    let value = value.map(glam::Vec3::from);
    let parameter = settings.model().parameters().find(|parameter| parameter.is_called(name));
    if let Some(parameter) = parameter.filter(|parameter| value.is_none_or(|value| parameter.allows(value))) {
        settings.set(parameter, value);
    }
}
