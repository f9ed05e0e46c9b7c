//! The reflectance of all models, as controls of whatever parameters a model declares.

use glam::Vec3;
use gnomon_brdf::{FINISH, Model, Parameter};
use gnomon_scene::ReflectanceSettings;

use super::fields::Fields;

/// Name of the entry that leaves every material its own.
const OWN: &str = "as in the scene";

/// Model and parameters; `None` where the materials keep their own.
pub fn show(fields: &mut Fields<'_>, wanted: &mut Option<ReflectanceSettings>) {
    let chosen = wanted.as_ref().map_or(OWN, |settings| settings.model().name());
    let models = Model::ALL.iter().map(|model| (model.name(), model.summary()));
    let entries = std::iter::once((OWN, "every material keeps its own")).chain(models);
    if let Some(picked) = fields.choice("model", "model", chosen, entries) {
        *wanted = Model::named(picked).map(ReflectanceSettings::new);
    }
    let Some(settings) = wanted else { return };
    for parameter in settings.model().required() {
        control(fields, settings, parameter);
    }
    for &parameter in settings.model().optional().iter().chain(FINISH) {
        let (label, name) = (parameter.name.replace('_', " "), format!("own {}", parameter.name));
        let mut own = settings.get(parameter).is_none();
        if fields.check(&label, &name, &mut own, "the scene's") {
            settings.set(parameter, (!own).then_some(Vec3::splat(parameter.start)));
        }
        if own {
            continue;
        }
        control(fields, settings, parameter);
    }
}

/// A colour field for what is a colour, else a slider for every number.
fn control(fields: &mut Fields<'_>, settings: &mut ReflectanceSettings, parameter: &'static Parameter) {
    match (parameter.is_color, parameter.slider == [0.0, 1.0]) {
        (true, true) => color(fields, settings, parameter),
        (true, false) => channels(fields, settings, parameter),
        (false, _) => slider(fields, settings, parameter),
    }
}

fn channels(fields: &mut Fields<'_>, settings: &mut ReflectanceSettings, parameter: &'static Parameter) {
    let Some(mut value) = settings.get(parameter) else { return };
    let [least, most] = parameter.slider;
    for (channel, name) in ["red", "green", "blue"].into_iter().enumerate() {
        let name = format!("{} {name}", parameter.name);
        if fields.slider(&name, &name, &mut value[channel], least..=most, "") {
            settings.set(parameter, Some(value));
        }
    }
}

fn slider(fields: &mut Fields<'_>, settings: &mut ReflectanceSettings, parameter: &'static Parameter) {
    let Some(mut value) = settings.get(parameter).map(|value| value.x) else { return };
    let [least, most] = parameter.slider;
    if fields.slider(parameter.name, parameter.name, &mut value, least..=most, "") {
        settings.set(parameter, Some(Vec3::splat(value)));
    }
}

fn color(fields: &mut Fields<'_>, settings: &mut ReflectanceSettings, parameter: &'static Parameter) {
    let Some(value) = settings.get(parameter) else { return };
    let mut shown = value.to_array();
    if fields.ui.color_edit_button_rgb(&mut shown).changed() {
        settings.set(parameter, Some(Vec3::from_array(shown)));
    }
}
