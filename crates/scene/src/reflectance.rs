//! Reflectance by name: what scene files and the command line say of a material.

use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

use glam::Vec3;
use gnomon_brdf::{BASE_COLOR, EXTINCTION, INDEX, METALS, Model, Parameter, SPECULAR, Surface};
use gnomon_messages::quoted;
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

use crate::{Material, MaterialId, Mesh, MeshId, Scene, SceneError};

/// A reflectance model, and those of its parameters that are given.
///
/// As text it is `MODEL` or `MODEL:KEY=VALUE,KEY=VALUE,...`, as in `phong:shininess=40,specular=0.3,diffuse=0.5`; a colour is one
/// number, or three separated by `/`; `metal=gold` is index and extinction of a metal
/// that has no matte part unless one is given. The models are those of [`Model::ALL`]; `SCENE_FORMAT.md` lists the keys.
#[derive(Clone, Debug, PartialEq)]
pub struct ReflectanceSettings {
    model: Model,
    /// In range, each once.
    values: Vec<(&'static Parameter, Vec3)>,
}

impl ReflectanceSettings {
    /// A model with what it needs to be given, as sliders start.
    pub fn new(model: Model) -> Self {
        let values = model.required().iter().map(|parameter| (*parameter, Vec3::splat(parameter.start)));
        Self { model, values: values.collect() }
    }

    /// A model and its parameters, `(name, values)`: one value for a number, three or one for a colour.
    ///
    /// # Errors
    /// What is wrong with them.
    pub fn of_values<'a>(
        model: Option<&str>,
        given: impl IntoIterator<Item = (&'a str, &'a [f32])>,
    ) -> Result<Self, String> {
        let names = |names: &mut dyn Iterator<Item = &'static str>| names.collect::<Vec<_>>().join(", ");
        let model = match model {
            None => Model::default(),
            Some(name) => Model::named(name).ok_or_else(|| {
                let known = names(&mut Model::ALL.iter().map(|model| model.name()));
                format!("there is no reflectance '{}' (there are: {known})", quoted(name))
            })?,
        };
        let mut values: Vec<(&Parameter, Vec3)> = Vec::new();
        for (name, numbers) in given {
            let parameter =
                model.parameters().find(|parameter| parameter.is_called(name)).ok_or_else(|| {
                    let known = names(&mut model.parameters().map(|parameter| parameter.name));
                    format!("'{}' is no parameter of {} (there are: {known})", quoted(name), model.name())
                })?;
            if values.iter().any(|(other, _)| *other == parameter) {
                return Err(format!("{} is given twice", parameter.name));
            }
            let value = match *numbers {
                [value] => Vec3::splat(value),
                [x, y, z] if parameter.is_color => Vec3::new(x, y, z),
                _ => {
                    let count = if parameter.is_color { "one number or three" } else { "one number" };
                    return Err(format!("{name} takes {count}"));
                }
            };
            if !parameter.allows(value) {
                let [least, most] = parameter.range;
                let range =
                    if most == f32::MAX { format!("at least {least}") } else { format!("{least} to {most}") };
                return Err(format!("{name} must be {range}"));
            }
            values.push((parameter, value));
        }
        match model.required().iter().find(|needed| values.iter().all(|(given, _)| given != *needed)) {
            Some(missing) => Err(format!("{} needs '{}'", model.name(), missing.name)),
            None => Ok(Self { model, values }),
        }
    }

    /// The same of a metal by name: index and extinction are its, and where nothing else is given all of the surface is glossy.
    ///
    /// # Errors
    /// What is wrong with them, or what metals there are.
    pub fn of_metal<'a>(
        model: Option<&str>,
        metal: &str,
        given: impl IntoIterator<Item = (&'a str, &'a [f32])>,
    ) -> Result<Self, String> {
        let known = METALS.iter().find(|known| known.name == metal).ok_or_else(|| {
            let known: Vec<_> = METALS.iter().map(|metal| metal.name).collect();
            format!("there is no metal '{}' (there are: {})", quoted(metal), known.join(", "))
        })?;
        let own = [(INDEX.name, known.index.to_array()), (EXTINCTION.name, known.extinction.to_array())];
        let given: Vec<_> = given.into_iter().collect();
        let is_open = |parameter: &Parameter| !given.iter().any(|(name, _)| parameter.is_called(name));
        let is_known = |parameter: &Parameter| {
            model.and_then(Model::named).is_some_and(|model| model.parameters().any(|own| own == parameter))
        };
        let whole = [(&BASE_COLOR, [0.0]), (&SPECULAR, [1.0])];
        let whole = whole.iter().filter(|(parameter, _)| is_known(parameter) && is_open(parameter));
        let own = own.iter().map(|(name, values)| (*name, values.as_slice()));
        let whole = whole.map(|(parameter, value)| (parameter.name, value.as_slice()));
        Self::of_values(model, given.iter().copied().chain(own).chain(whole))
    }

    /// The model of a surface with every parameter that concerns it: [`ReflectanceSettings::apply`] makes of any surface one that
    /// reflects like it.
    ///
    /// # Errors
    /// [`SceneError::Request`] for a parameter out of its range.
    pub fn of(surface: &Surface) -> Result<Self, SceneError> {
        let values = surface.model.parameters().map(|parameter| (parameter, (parameter.get)(surface)));
        let settings = Self { model: surface.model, values: values.collect() };
        match settings.values.iter().find(|(parameter, value)| !parameter.allows(*value)) {
            Some((parameter, _)) => {
                Err(SceneError::Request(format!("reflectance: {} is out of its range", parameter.name)))
            }
            None => Ok(settings),
        }
    }

    /// The model.
    pub fn model(&self) -> Model {
        self.model
    }

    /// The value of a parameter, where it is given.
    pub fn get(&self, parameter: &Parameter) -> Option<Vec3> {
        self.values.iter().find(|(given, _)| *given == parameter).map(|(_, value)| *value)
    }

    /// Gives a parameter of the model the allowed value that is nearest. `None` leaves it to the surface, where the model does not need it.
    pub fn set(&mut self, parameter: &'static Parameter, value: Option<Vec3>) {
        let place = self.values.iter().position(|(given, _)| *given == parameter);
        let [least, most] = parameter.range.map(Vec3::splat);
        match (place, value.map(|value| value.max(least).min(most))) {
            (Some(place), Some(value)) => self.values[place].1 = value,
            (None, Some(value)) if self.model.parameters().any(|known| known == parameter) => {
                self.values.push((parameter, value));
            }
            (Some(place), None) if !self.model.required().contains(&parameter) => {
                self.values.remove(place);
            }
            _ => {}
        }
    }

    /// Gives a surface this model; parameters that are not given stay as they are.
    pub fn apply(&self, surface: &mut Surface) {
        surface.model = self.model;
        for (parameter, value) in &self.values {
            (parameter.set)(surface, *value);
        }
    }
}

impl fmt::Display for ReflectanceSettings {
    /// The text that parses to the same settings, to the last bit.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.model.name())?;
        for (index, (parameter, value)) in self.values.iter().enumerate() {
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
        let mut metal = None;
        for part in rest.split(',').filter(|part| !part.trim().is_empty()) {
            let (name, values) = part
                .split_once('=')
                .ok_or_else(|| bad(format!("'{}' is not KEY=VALUE", quoted(part.trim()))))?;
            if name.trim() == "metal" {
                if metal.replace(values.trim()).is_some() {
                    return Err(bad("metal is given twice".to_owned()));
                }
                continue;
            }
            let values = values
                .split('/')
                .map(|value| value.trim().parse::<f32>())
                .collect::<Result<Vec<_>, _>>()
                .map_err(|_| bad(format!("'{}' is no number", quoted(values.trim()))))?;
            given.push((name.trim(), values));
        }
        let given = given.iter().map(|(name, values)| (*name, values.as_slice()));
        let model = Some(model.trim());
        match metal {
            Some(metal) => Self::of_metal(model, metal, given),
            None => Self::of_values(model, given),
        }
        .map_err(bad)
    }
}

/// As text.
impl Serialize for ReflectanceSettings {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for ReflectanceSettings {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        String::deserialize(deserializer)?.parse().map_err(de::Error::custom)
    }
}

/// What is wrong with a surface that gives back more light than it gets, if it does.
pub fn excess(surface: &Surface) -> Option<String> {
    let most = surface.layers().strength().max_element();
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
        self.separate_materials();
        let ground = self.ground_meshes();
        let kept: Vec<_> = ground.into_iter().filter_map(|mesh| self.meshes[mesh.0].material).collect();
        let changed =
            (0..).zip(&mut self.materials).filter(|(number, _)| !kept.contains(&MaterialId(*number)));
        changed.for_each(|(_, material)| settings.apply(&mut material.surface));
        let warning = self.materials.iter().find_map(|material| excess(&material.surface));
        self.warnings.extend(warning);
        let lacks_tables = |material: &Material| {
            material.surface.model.is_tabulated() && material.reflectance_tables().is_none()
        };
        if self.materials.iter().any(lacks_tables) {
            self.warnings.push(format!(
                "{} needs tables of a file, which the scene file's material names: without them it is matte",
                settings.model.name()
            ));
        }
    }

    /// Gives what [`Scene::set_reflectance`] tells apart materials of its own: the ground's meshes, where they share theirs, and those
    /// without a material. Such meshes are copied, so that later it copies none.
    pub fn separate_materials(&mut self) {
        let ground = self.ground_meshes();
        for &MeshId(place) in &ground {
            let of = |mesh: &Arc<Mesh>| mesh.material;
            let is_shared = |material| {
                let others = (0..).zip(&self.meshes).filter(|(mesh, _)| !ground.contains(&MeshId(*mesh)));
                others.map(|(_, mesh)| of(mesh)).any(|other| other == Some(material))
            };
            if of(&self.meshes[place]).is_none_or(is_shared) {
                let copy = self.material(MeshId(place)).clone();
                Arc::make_mut(&mut self.meshes[place]).material = Some(MaterialId(self.materials.len()));
                self.materials.push(copy);
            }
        }
        let id = MaterialId(self.materials.len());
        let mut bare = self.meshes.iter_mut().filter(|mesh| mesh.material.is_none()).peekable();
        if bare.peek().is_some() {
            bare.for_each(|mesh| Arc::make_mut(mesh).material = Some(id));
            self.materials.push(Material::default());
        }
    }

    fn ground_meshes(&self) -> Vec<MeshId> {
        self.ground.map_or(Vec::new(), |node| self.nodes[node.0].meshes.clone())
    }
}

#[cfg(test)]
mod tests {
    use gnomon_brdf::{ROUGHNESS, SHININESS};

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
        for &model in Model::ALL {
            let surface = Surface {
                model,
                base_color: Vec3::new(0.1, 1.0 / 3.0, 0.7),
                specular: 0.123_456_79,
                shininess: 33.3,
                slope: 0.17,
                ..Surface::default()
            };
            let settings = ReflectanceSettings::of(&surface).unwrap();
            let text = settings.to_string();
            assert_eq!(text.parse::<ReflectanceSettings>().unwrap(), settings, "{text}");
            let mut other = Surface { model, ..Surface::default() };
            settings.apply(&mut other);
            assert_eq!(ReflectanceSettings::of(&other).unwrap(), settings, "{text}");
        }
        assert!(ReflectanceSettings::of(&Surface { roughness: f32::NAN, ..Surface::default() }).is_err());
    }

    #[test]
    fn a_metal_is_glossy_throughout_unless_told_otherwise() {
        let parsed = |text: &str| text.parse::<ReflectanceSettings>();
        let gold = parsed("microfacet-beckmann:slope=0.1,metal=gold").unwrap();
        assert_eq!((gold.get(&BASE_COLOR), gold.get(&SPECULAR)), (Some(Vec3::ZERO), Some(Vec3::ONE)));
        assert!(gold.get(&EXTINCTION).unwrap().min_element() > 1.0);
        let dusty = parsed("microfacet-beckmann:metal=gold,slope=0.1,diffuse=0.2,specular=0.7").unwrap();
        assert_eq!(
            (dusty.get(&BASE_COLOR), dusty.get(&SPECULAR)),
            (Some(Vec3::splat(0.2)), Some(Vec3::splat(0.7)))
        );
        for (text, reason) in [
            ("microfacet-beckmann:slope=0.1,metal=tin", "there is no metal 'tin' (there are: aluminium,"),
            ("microfacet-beckmann:slope=0.1,metal=gold,metal=gold", "metal is given twice"),
            ("microfacet-beckmann:slope=0.1,metal=gold,index=2", "index is given twice"),
            ("phong:shininess=9,metal=gold", "'index' is no parameter of phong"),
        ] {
            let error = parsed(text).unwrap_err().to_string();
            assert!(error.contains(reason), "{text}: {error}");
        }
    }

    #[test]
    fn values_are_typed_set_and_kept_in_range() {
        let mut settings = ReflectanceSettings::new(Model::Phong);
        assert_eq!(settings.to_string(), "phong:shininess=40,specular=0.3");
        settings.set(&SHININESS, Some(Vec3::splat(1e9)));
        settings.set(&BASE_COLOR, Some(Vec3::new(0.1, 0.2, 2.0)));
        settings.set(&ROUGHNESS, Some(Vec3::ONE));
        settings.set(&SHININESS, None);
        assert_eq!(settings.to_string(), "phong:shininess=10000,specular=0.3,base_color=0.1/0.2/1");
        settings.set(&BASE_COLOR, None);
        assert_eq!((settings.get(&BASE_COLOR), settings.get(&SHININESS)), (None, Some(Vec3::splat(1e4))));
        for &model in Model::ALL {
            let settings = ReflectanceSettings::new(model);
            assert_eq!(settings.to_string().parse::<ReflectanceSettings>().unwrap(), settings);
        }
    }

    #[test]
    fn mistakes_are_named() {
        for (text, reason) in [
            ("", "there is no reflectance ''"),
            ("shiny", "there is no reflectance 'shiny' (there are: metallic-roughness, lambert, phong,"),
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
        Arc::make_mut(&mut scene.meshes[0]).material = None;
        let ground = scene.nodes[scene.ground.unwrap().0].meshes[0];
        let before = scene.material(ground).clone();
        scene.set_reflectance(&"phong:shininess=9,specular=0.7,diffuse=0.6".parse().unwrap());
        assert_eq!(scene.material(ground), &before);
        let boxes = scene.material(MeshId(0));
        assert_eq!((boxes.surface.model, boxes.surface.shininess), (Model::Phong, 9.0));
        assert_eq!(scene.warnings.len(), 1);
        assert!(
            scene.warnings[0].contains("phong with matte and glossy parts of together 1.30"),
            "{:?}",
            scene.warnings
        );
    }
}
