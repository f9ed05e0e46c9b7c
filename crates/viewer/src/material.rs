//! The reflectance of all models, as sliders.

use std::ops::RangeInclusive;

/// A number of a reflectance model.
pub struct Parameter {
    /// As in a scene file.
    pub name: &'static str,
    /// What sliders offer.
    pub range: RangeInclusive<f32>,
    /// Where they start.
    pub start: f32,
}

const fn parameter(name: &'static str, range: RangeInclusive<f32>, start: f32) -> Parameter {
    Parameter { name, range, start }
}

const METALLIC: Parameter = parameter("metallic", 0.0..=1.0, 0.0);
const ROUGHNESS: Parameter = parameter("roughness", 0.0..=1.0, 0.4);
const SPECULAR: Parameter = parameter("specular", 0.0..=1.0, 0.3);
const SHININESS: Parameter = parameter("shininess", 0.0..=500.0, 40.0);
const SLOPE: Parameter = parameter("slope", 0.05..=1.0, 0.25);

/// Parameters with sliders of a model of [`gnomon_brdf::MODELS`]; the colour comes on top.
pub fn parameters(model: &str) -> &'static [Parameter] {
    match model {
        "metallic-roughness" => &[METALLIC, ROUGHNESS],
        "phong" | "blinn-phong" => &[SHININESS, SPECULAR],
        "torrance-sparrow-beckmann" | "torrance-sparrow-gaussian" => &[SLOPE, SPECULAR, METALLIC],
        _ => &[],
    }
}

/// A model and its sliders' values.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name of the model.
    pub model: String,
    /// One for each of [`parameters`].
    pub values: Vec<f32>,
    /// In place of the materials' own, linear.
    pub color: Option<[f32; 3]>,
    /// `KEY=VALUE` of parameters without a slider.
    pub others: Vec<String>,
}

impl Material {
    /// A model with its sliders where they start.
    pub fn of_model(model: &str) -> Self {
        let values = parameters(model).iter().map(|parameter| parameter.start).collect();
        Self { model: model.to_owned(), values, color: None, others: Vec::new() }
    }

    /// Reads `MODEL:KEY=VALUE,...`.
    pub fn parse(text: &str) -> Self {
        let (model, given) = text.split_once(':').unwrap_or((text, ""));
        let mut material = Self::of_model(model.trim());
        for (key, value) in given.split(',').filter_map(|part| part.split_once('=')) {
            let number = |text: &str| text.trim().parse::<f32>().ok().filter(|value| value.is_finite());
            let slot = parameters(model.trim()).iter().position(|parameter| parameter.name == key.trim());
            if matches!(key.trim(), "base_color" | "diffuse") {
                let channels: Vec<f32> = value.split('/').filter_map(number).collect();
                material.color = match channels.as_slice() {
                    [value] => Some([*value; 3]),
                    [r, g, b] => Some([*r, *g, *b]),
                    _ => None,
                };
            } else if slot.is_none() {
                material.others.push(format!("{}={}", key.trim(), value.trim()));
            } else if let (Some(slot), Some(value)) = (slot, number(value)) {
                material.values[slot] = value;
            }
        }
        material
    }

    /// The text of [`gnomon_scene::ReflectanceSettings`].
    pub fn text(&self) -> String {
        let numbers = parameters(&self.model).iter().zip(&self.values);
        let mut parts: Vec<String> =
            numbers.map(|(parameter, value)| format!("{}={value}", parameter.name)).collect();
        if let Some([r, g, b]) = self.color {
            parts.push(format!("base_color={r}/{g}/{b}"));
        }
        parts.extend(self.others.iter().cloned());
        match parts.is_empty() {
            true => self.model.clone(),
            false => format!("{}:{}", self.model, parts.join(",")),
        }
    }
}

#[cfg(test)]
mod tests {
    use gnomon_scene::ReflectanceSettings;

    use super::*;

    #[test]
    fn every_model_gives_a_text_that_the_library_takes_and_that_is_read_back() {
        for entry in gnomon_brdf::MODELS {
            for color in [None, Some([0.25, 0.5, 0.75])] {
                let material = Material { color, ..Material::of_model(entry.name) };
                let settings: ReflectanceSettings = material.text().parse().unwrap();
                assert_eq!(settings.model(), entry.model);
                assert_eq!(Material::parse(&material.text()), material);
            }
        }
    }

    #[test]
    fn the_ends_of_every_slider_are_allowed() {
        for entry in gnomon_brdf::MODELS {
            for end in [|p: &Parameter| *p.range.start(), |p: &Parameter| *p.range.end()] {
                let values = parameters(entry.name).iter().map(end).collect();
                let text = Material { values, ..Material::of_model(entry.name) }.text();
                assert!(text.parse::<ReflectanceSettings>().is_ok(), "{text}");
            }
        }
    }

    #[test]
    fn parameters_without_a_slider_are_kept() {
        let mut material = Material::parse("phong:shininess=40, specular_color = 1/0.5/0 ,specular=0.3");
        material.values[0] = 60.0;
        assert_eq!(material.text(), "phong:shininess=60,specular=0.3,specular_color=1/0.5/0");
        assert!(material.text().parse::<ReflectanceSettings>().is_ok());
    }

    #[test]
    fn odd_text_is_read_as_far_as_it_goes() {
        assert_eq!(Material::parse(""), Material::of_model(""));
        let material = Material::parse("phong:shininess=nan,specular=0.5,base_color=1/2");
        assert_eq!((material.values, material.color), (vec![40.0, 0.5], None));
    }
}
