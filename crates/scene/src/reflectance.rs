//! Reflectance by name: what scene files and the command line say of a material.

use std::fmt;
use std::str::FromStr;

use glam::Vec3;
use gnomon_brdf::{MAX_SHININESS, MAX_SLOPE, MIN_SLOPE, MODELS, Model, Surface};
use gnomon_messages::quoted;

use crate::{Material, MaterialId, Scene, SceneError};

/// A reflectance model, and those of its parameters that are given.
///
/// As text it is `MODEL` or `MODEL:KEY=VALUE,KEY=VALUE,...`, as in `phong:shininess=40,specular=0.3,diffuse=0.5`; a colour is one
/// number, or three separated by `/`. The models are those of [`gnomon_brdf::MODELS`]; `SCENE_FORMAT.md` lists the keys.
#[derive(Clone, Debug, PartialEq)]
pub struct ReflectanceSettings {
    model: Model,
    /// Keys of [`PARAMETERS`] and their values, in range.
    parameters: Vec<(&'static Parameter, Vec3)>,
}

/// A parameter of a surface as people write it.
#[derive(Debug)]
struct Parameter {
    name: &'static str,
    /// Three numbers instead of one.
    is_color: bool,
    least: f32,
    most: f32,
    get: fn(&Surface) -> Vec3,
    set: fn(&mut Surface, Vec3),
}

impl PartialEq for Parameter {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

const fn number(
    name: &'static str,
    [least, most]: [f32; 2],
    get: fn(&Surface) -> Vec3,
    set: fn(&mut Surface, Vec3),
) -> Parameter {
    Parameter { name, is_color: false, least, most, get, set }
}

static PARAMETERS: [Parameter; 8] = [
    Parameter {
        name: "base_color",
        is_color: true,
        least: 0.0,
        most: 1.0,
        get: |surface| surface.base_color,
        set: |surface, value| surface.base_color = value,
    },
    Parameter {
        name: "specular_color",
        is_color: true,
        least: 0.0,
        most: f32::MAX,
        get: |surface| surface.specular_color,
        set: |surface, value| surface.specular_color = value,
    },
    number(
        "metallic",
        [0.0, 1.0],
        |surface| Vec3::splat(surface.metallic),
        |surface, value| surface.metallic = value.x,
    ),
    number(
        "roughness",
        [0.0, 1.0],
        |surface| Vec3::splat(surface.roughness),
        |surface, value| surface.roughness = value.x,
    ),
    number(
        "specular",
        [0.0, 1.0],
        |surface| Vec3::splat(surface.specular),
        |surface, value| surface.specular = value.x,
    ),
    number("ior", [1.0, 10.0], |surface| Vec3::splat(surface.ior), |surface, value| surface.ior = value.x),
    number(
        "shininess",
        [0.0, MAX_SHININESS],
        |surface| Vec3::splat(surface.shininess),
        |surface, value| surface.shininess = value.x,
    ),
    number(
        "slope",
        [MIN_SLOPE, MAX_SLOPE],
        |surface| Vec3::splat(surface.slope),
        |surface, value| surface.slope = value.x,
    ),
];

/// Parameters that concern a model: those that must be given, and the others.
fn concerning(model: Model) -> (&'static [&'static str], &'static [&'static str]) {
    match model {
        Model::Lambert => (&[], &["base_color"]),
        Model::MetallicRoughness => {
            (&[], &["base_color", "metallic", "roughness", "specular", "specular_color", "ior"])
        }
        Model::Phong | Model::BlinnPhong => (&["shininess", "specular"], &["base_color", "specular_color"]),
        Model::TorranceSparrowBeckmann | Model::TorranceSparrowGaussian => {
            (&["slope", "specular"], &["base_color", "metallic", "specular_color", "ior"])
        }
    }
}

impl ReflectanceSettings {
    /// A model and its parameters, `(name, values)`: one value for a number, three or one for a colour.
    ///
    /// # Errors
    /// What is wrong with them.
    pub fn new<'a>(
        model: Option<&str>,
        given: impl IntoIterator<Item = (&'a str, &'a [f32])>,
    ) -> Result<Self, String> {
        let model = match model {
            None => Model::default(),
            Some(name) => gnomon_brdf::model(name).map(|entry| entry.model).ok_or_else(|| {
                let names: Vec<_> = MODELS.iter().map(|entry| entry.name).collect();
                format!("there is no reflectance '{}' (there are: {})", quoted(name), names.join(", "))
            })?,
        };
        let (required, optional) = concerning(model);
        let concerns = |name: &str| required.contains(&name) || optional.contains(&name);
        let mut parameters: Vec<(&Parameter, Vec3)> = Vec::new();
        for (name, values) in given {
            // What the papers call the base colour of a model with a separate highlight.
            let key = if name == "diffuse" { "base_color" } else { name };
            let Some(parameter) = PARAMETERS.iter().find(|parameter| parameter.name == key && concerns(key))
            else {
                return Err(format!(
                    "'{}' is no parameter of {} (there are: {})",
                    quoted(name),
                    model.name(),
                    [required, optional].concat().join(", ")
                ));
            };
            if parameters.iter().any(|(other, _)| other.name == key) {
                return Err(format!("{key} is given twice"));
            }
            let value = match *values {
                [value] => Vec3::splat(value),
                [x, y, z] if parameter.is_color => Vec3::new(x, y, z),
                _ => {
                    let count = if parameter.is_color { "one number or three" } else { "one number" };
                    return Err(format!("{name} takes {count}"));
                }
            };
            let Parameter { least, most, .. } = *parameter;
            if !value.to_array().iter().all(|value| (least..=most).contains(value)) {
                let range =
                    if most == f32::MAX { format!("at least {least}") } else { format!("{least} to {most}") };
                return Err(format!("{name} must be {range}"));
            }
            parameters.push((parameter, value));
        }
        match required.iter().find(|&&name| parameters.iter().all(|(parameter, _)| parameter.name != name)) {
            Some(missing) => Err(format!("{} needs '{missing}'", model.name())),
            None => Ok(Self { model, parameters }),
        }
    }

    /// The model.
    pub fn model(&self) -> Model {
        self.model
    }

    /// The model of a surface with every parameter that concerns it: [`ReflectanceSettings::apply`] makes of any surface one that
    /// reflects like it.
    ///
    /// # Errors
    /// [`SceneError::Request`] for a parameter out of its range.
    pub fn of(surface: &Surface) -> Result<Self, SceneError> {
        let (required, optional) = concerning(surface.model);
        let names = required.iter().chain(optional).copied();
        let given: Vec<(&str, [f32; 3], usize)> = names
            .filter_map(|name| PARAMETERS.iter().find(|parameter| parameter.name == name))
            .map(|parameter| {
                let count = if parameter.is_color { 3 } else { 1 };
                (parameter.name, (parameter.get)(surface).to_array(), count)
            })
            .collect();
        let given = given.iter().map(|(name, values, count)| (*name, &values[..*count]));
        Self::new(Some(surface.model.name()), given)
            .map_err(|message| SceneError::Request(format!("reflectance: {message}")))
    }

    /// Gives a surface this model; parameters that are not given stay as they are.
    pub fn apply(&self, surface: &mut Surface) {
        surface.model = self.model;
        for (parameter, value) in &self.parameters {
            (parameter.set)(surface, *value);
        }
    }
}

impl fmt::Display for ReflectanceSettings {
    /// The text that parses to the same settings, to the last bit.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.model.name())?;
        for (index, (parameter, value)) in self.parameters.iter().enumerate() {
            let before = if index == 0 { ':' } else { ',' };
            write!(f, "{before}{}={}", parameter.name, value.x)?;
            if parameter.is_color {
                write!(f, "/{}/{}", value.y, value.z)?;
            }
        }
        Ok(())
    }
}

impl FromStr for ReflectanceSettings {
    type Err = SceneError;

    fn from_str(text: &str) -> Result<Self, SceneError> {
        let bad = |message: String| SceneError::Request(format!("reflectance: {message}"));
        let (model, rest) = text.split_once(':').unwrap_or((text, ""));
        let mut given = Vec::new();
        for part in rest.split(',').filter(|part| !part.trim().is_empty()) {
            let (name, values) = part
                .split_once('=')
                .ok_or_else(|| bad(format!("'{}' is not KEY=VALUE", quoted(part.trim()))))?;
            let values = values
                .split('/')
                .map(|value| value.trim().parse::<f32>())
                .collect::<Result<Vec<_>, _>>()
                .map_err(|_| bad(format!("'{}' is no number", quoted(values.trim()))))?;
            given.push((name.trim(), values));
        }
        let given = given.iter().map(|(name, values)| (*name, values.as_slice()));
        Self::new(Some(model.trim()), given).map_err(bad)
    }
}

/// What is wrong with a surface that gives back more light than it gets, if it does.
pub fn excess(surface: &Surface) -> Option<String> {
    // glTF's base lies under its interface, which takes its share.
    if surface.model == Model::MetallicRoughness {
        return None;
    }
    let layers = surface.layers();
    let most = match surface.model {
        Model::Phong | Model::BlinnPhong => (layers.diffuse + layers.f0).max_element(),
        _ => (layers.diffuse + layers.f0.max(Vec3::splat(layers.f90))).max_element(),
    };
    (most > 1.0 + 1e-5).then(|| {
        format!(
            "{} with matte and glossy parts of together {most:.2} gives back more light than it gets",
            surface.model.name()
        )
    })
}

impl Scene {
    /// Gives every material another reflectance model, that of the ground excepted: for meshes from files that know no other
    /// than their own, or none. Textures stay and multiply what they did.
    pub fn set_reflectance(&mut self, settings: &ReflectanceSettings) {
        let ground: Vec<_> = self.ground.map_or(Vec::new(), |node| self.nodes[node.0].meshes.clone());
        // The ground keeps what it has, in a material of its own.
        for mesh in &ground {
            let copy = self.material(*mesh).clone();
            self.meshes[mesh.0].material = Some(MaterialId(self.materials.len()));
            self.materials.push(copy);
        }
        let kept = self.materials.len() - ground.len();
        let bare = (0..self.meshes.len()).filter(|&mesh| self.meshes[mesh].material.is_none());
        let bare: Vec<_> = bare.collect();
        if !bare.is_empty() {
            let id = MaterialId(self.materials.len());
            let mut material = Material::default();
            settings.apply(&mut material.surface);
            self.materials.push(material);
            bare.into_iter().for_each(|mesh| self.meshes[mesh].material = Some(id));
        }
        self.materials[..kept].iter_mut().for_each(|material| settings.apply(&mut material.surface));
        let warning = self.materials.iter().find_map(|material| excess(&material.surface));
        self.warnings.extend(warning);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builtin;

    #[test]
    fn text_names_model_and_parameters() {
        let settings: ReflectanceSettings =
            "phong: shininess=40, specular=0.3, diffuse=0.5/0.4/0.2".parse().unwrap();
        let mut surface = Surface::default();
        settings.apply(&mut surface);
        let expected = Surface {
            model: Model::Phong,
            shininess: 40.0,
            specular: 0.3,
            base_color: Vec3::new(0.5, 0.4, 0.2),
            ..Surface::default()
        };
        assert_eq!(surface, expected);
        let settings: ReflectanceSettings = "lambert".parse().unwrap();
        assert_eq!(settings.model(), Model::Lambert);
        settings.apply(&mut surface);
        assert_eq!(surface, Surface { model: Model::Lambert, ..expected });
    }

    #[test]
    fn a_surface_and_its_text_are_the_same_reflectance() {
        for entry in MODELS {
            let surface = Surface {
                model: entry.model,
                base_color: Vec3::new(0.1, 1.0 / 3.0, 0.7),
                specular: 0.123_456_79,
                shininess: 33.3,
                slope: 0.17,
                ..Surface::default()
            };
            let settings = ReflectanceSettings::of(&surface).unwrap();
            let text = settings.to_string();
            assert_eq!(text.parse::<ReflectanceSettings>().unwrap(), settings, "{text}");
            let mut other = Surface { model: entry.model, ..Surface::default() };
            settings.apply(&mut other);
            assert_eq!(ReflectanceSettings::of(&other).unwrap(), settings, "{text}");
        }
        assert!(ReflectanceSettings::of(&Surface { roughness: f32::NAN, ..Surface::default() }).is_err());
    }

    #[test]
    fn mistakes_are_named() {
        for (text, reason) in [
            ("", "there is no reflectance ''"),
            ("shiny", "there is no reflectance 'shiny' (there are: lambert, metallic-roughness, phong,"),
            ("phong", "phong needs 'shininess'"),
            ("phong:shininess=40", "phong needs 'specular'"),
            ("phong:shininess=40,specular=2", "specular must be 0 to 1"),
            ("phong:shininess=1e9,specular=0", "shininess must be 0 to 10000"),
            ("phong:shininess=nan,specular=0", "shininess must be 0 to 10000"),
            ("phong:shininess=-1,specular=0", "shininess must be 0 to 10000"),
            ("phong:shininess=1/2/3,specular=0", "shininess takes one number"),
            ("phong:diffuse=1/2", "diffuse takes one number or three"),
            ("phong:shininess=x", "'x' is no number"),
            ("phong:shininess", "'shininess' is not KEY=VALUE"),
            ("phong:slope=0.3", "'slope' is no parameter of phong (there are: shininess, specular,"),
            ("phong:diffuse=0.1,base_color=0.2", "base_color is given twice"),
            ("torrance-sparrow-beckmann:slope=0,specular=1", "slope must be 0.01 to 1"),
            ("blinn-phong:shin\niness=3", "'shin iness' is no parameter"),
        ] {
            let error = text.parse::<ReflectanceSettings>().unwrap_err().to_string();
            assert!(error.contains(reason) && !error.contains('\n'), "{text}: {error}");
        }
    }

    #[test]
    fn every_material_but_the_grounds_changes() {
        let mut scene = builtin::by_name("three-boxes").unwrap();
        scene.meshes[0].material = None;
        let ground = scene.nodes[scene.ground.unwrap().0].meshes[0];
        let before = scene.material(ground).clone();
        scene.set_reflectance(&"phong:shininess=9,specular=0.7,diffuse=0.6".parse().unwrap());
        assert_eq!(scene.material(ground), &before);
        let boxes = scene.material(crate::MeshId(0));
        assert_eq!((boxes.surface.model, boxes.surface.shininess), (Model::Phong, 9.0));
        assert_eq!(scene.warnings.len(), 1);
        assert!(
            scene.warnings[0].contains("phong with matte and glossy parts of together 1.30"),
            "{:?}",
            scene.warnings
        );
    }
}
