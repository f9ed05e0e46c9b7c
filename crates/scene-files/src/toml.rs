//! Gnomon's own scene file: models and lights placed in a scene, materials, camera, environment and ground. The format is
//! described in `SCENE_FORMAT.md` beside this crate's manifest.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use ::toml::Spanned;
use glam::{Affine2, Affine3A, DMat3, DVec3, EulerRot, Mat3, Quat, Vec2, Vec3};
use gnomon_brdf::{BASE_COLOR, Model, SPECULAR, Tables};
use gnomon_messages::quoted;
use gnomon_scene::{
    Camera, Ground, Height, HeightMapId, Material, MaterialId, Node, NodeId, ReflectanceSettings, Scene,
    Wrap, builtin, excess,
};
use serde::Deserialize;
use serde::de::{DeserializeOwned, IgnoredAny};

use super::{
    Axes, Budget, EnvironmentSettings, EnvironmentSource, LoadOptions, LoadedScene, Source, UNITS, UpAxis,
    load_within,
};
use crate::error::Fault;
use crate::ies::IesFile;
use crate::{Resolver, SceneFileError, heights};

mod light;

/// Reads a scene file and the models that it places.
pub fn read(source: &Source, budget: &mut Budget) -> Result<LoadedScene, Fault> {
    let text = text_of(source.bytes)?;
    // The parsed document takes several times the size of its text.
    budget.take(text.len(), 16)?;
    let file: SceneFile = parse(text)?;
    let variant = source.options.variant.clone().or_else(|| file.variant.clone());
    let options = LoadOptions { variant, ..source.options.clone() };
    let source = &Source { options: &options, ..*source };
    let mut loaded = Reader { text, source }.scene(&file, budget)?;
    if loaded.scene.meshes.is_empty() {
        loaded.scene.warnings.push("the scene file places no model".to_owned());
    }
    Ok(loaded)
}

/// Those tables of a scene file that say how it is drawn, which [`super::load`] leaves alone: `T` has a field for each, with a default,
/// and refuses no others. `resolver` gives the file. `None` for one of another format.
///
/// # Errors
/// [`SceneFileError::Io`], or [`SceneFileError::Invalid`] with the line that `T` refuses.
pub fn read_sections<T: DeserializeOwned>(
    path: &Path,
    resolver: &dyn Resolver,
) -> Result<Option<T>, SceneFileError> {
    if !path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml")) {
        return Ok(None);
    }
    let mut budget = Budget::new(LoadOptions::default().memory_limit);
    let read = super::read_file(path, resolver, &mut budget).and_then(|bytes| parse(text_of(&bytes)?));
    read.map(Some).map_err(|fault| fault.at(path))
}

fn text_of(bytes: &[u8]) -> Result<&str, Fault> {
    std::str::from_utf8(super::without_bom(bytes)).map_err(|_| Fault::invalid("a scene file is UTF-8 text"))
}

fn parse<T: DeserializeOwned>(text: &str) -> Result<T, Fault> {
    ::toml::from_str(text).map_err(|error| {
        let at =
            error.span().map_or_else(String::new, |span| format!("line {}: ", line_of(text, span.start)));
        Fault::Invalid(format!("{at}{}", error.message()))
    })
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SceneFile {
    ground: Option<Ground>,
    variant: Option<String>,
    up: Option<UpAxis>,
    unit: Option<Unit>,
    camera: Option<Camera>,
    environment: Option<Spanned<EnvironmentEntry>>,
    #[serde(default)]
    material: BTreeMap<String, Spanned<MaterialEntry>>,
    #[serde(default)]
    model: Vec<Spanned<ModelEntry>>,
    #[serde(default)]
    light: Vec<Spanned<light::LightEntry>>,
    // How the scene is drawn is read by whoever draws it, through `read_sections`.
    #[serde(rename = "bump_scale")]
    _bump_scale: Option<IgnoredAny>,
    #[serde(rename = "ground_camera_height")]
    _ground_camera_height: Option<IgnoredAny>,
    #[serde(rename = "emission")]
    _emission: Option<IgnoredAny>,
    #[serde(rename = "lamp_strength")]
    _lamp_strength: Option<IgnoredAny>,
    #[serde(rename = "paper")]
    _paper: Option<IgnoredAny>,
    #[serde(rename = "fit")]
    _fit: Option<IgnoredAny>,
    #[serde(rename = "render")]
    _render: Option<IgnoredAny>,
    #[serde(rename = "display")]
    _display: Option<IgnoredAny>,
    #[serde(rename = "animation")]
    _animation: Option<IgnoredAny>,
    #[serde(rename = "surface")]
    _surface: Option<IgnoredAny>,
}

/// What [`super::ENVIRONMENT_KEYS`] say; the others are read by whoever draws, through [`read_sections`].
#[derive(Deserialize)]
struct EnvironmentEntry {
    file: Option<String>,
    builtin: Option<String>,
    rig: Option<IgnoredAny>,
    #[serde(default)]
    exposure: Exposure,
}

/// Stops, or the word for what suits the environment.
#[derive(Clone, Copy, Deserialize)]
#[serde(untagged, expecting = "exposure is a number of stops or \"automatic\"")]
enum Exposure {
    Stops(f32),
    Automatic(Automatic),
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Automatic {
    Automatic,
}

impl Default for Exposure {
    fn default() -> Self {
        Self::Stops(0.0)
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ModelEntry {
    file: Option<String>,
    builtin: Option<String>,
    ground: Option<bool>,
    name: Option<String>,
    up: Option<UpAxis>,
    unit: Option<Unit>,
    #[serde(default)]
    translation: [f64; 3],
    #[serde(default)]
    rotation: [f32; 3],
    #[serde(default)]
    scale: Scale,
    material: Option<String>,
}

impl ModelEntry {
    fn scale(&self) -> Vec3 {
        match self.scale {
            Scale::Uniform(scale) => Vec3::splat(scale),
            Scale::Axes(scale) => Vec3::from_array(scale),
        }
    }

    /// Turned about x, y and z, in this order.
    fn rotation(&self) -> Quat {
        let [x, y, z] = self.rotation.map(f32::to_radians);
        Quat::from_euler(EulerRot::ZYX, z, y, x)
    }

    /// By how much scale and rotation in double precision differ from those of its node, which moves a model that is far from its origin.
    fn turn_error(&self) -> DMat3 {
        let [x, y, z] = self.rotation.map(|angle| f64::from(angle).to_radians());
        let exact = DMat3::from_euler(EulerRot::ZYX, z, y, x) * DMat3::from_diagonal(self.scale().as_dvec3());
        let single = Affine3A::from_scale_rotation_translation(self.scale(), self.rotation(), Vec3::ZERO);
        exact - Mat3::from(single.matrix3).as_dmat3()
    }
}

#[derive(Clone, Copy, Deserialize)]
#[serde(untagged, expecting = "scale is one number or three")]
enum Scale {
    Uniform(f32),
    Axes([f32; 3]),
}

impl Default for Scale {
    fn default() -> Self {
        Self::Uniform(1.0)
    }
}

/// A unit by its name or its length [m].
#[derive(Clone, Copy, Deserialize)]
#[serde(try_from = "UnitEntry")]
struct Unit(f32);

#[derive(Deserialize)]
#[serde(untagged, expecting = "unit is a number of metres, or m, cm, mm, in, ft")]
enum UnitEntry {
    Length(f32),
    Name(String),
}

impl TryFrom<UnitEntry> for Unit {
    type Error = String;

    fn try_from(entry: UnitEntry) -> Result<Self, String> {
        let length = match &entry {
            UnitEntry::Length(length) => Some(*length),
            UnitEntry::Name(name) => UNITS.iter().find(|(known, _)| known == name).map(|(_, length)| *length),
        };
        let length = length.filter(|length| (1e-6..=1e6).contains(length));
        length.map(Self).ok_or_else(|| "unit must be 0.000001 to 1000000 m, or m, cm, mm, in, ft".to_owned())
    }
}

#[derive(Deserialize)]
struct MaterialEntry {
    reflectance: Option<String>,
    emissive: Option<[f32; 3]>,
    double_sided: Option<bool>,
    height: Option<HeightEntry>,
    /// A file of tables or of a measurement.
    tables: Option<String>,
    metal: Option<String>,
    /// Of the reflectance model.
    #[serde(flatten)]
    parameters: BTreeMap<String, Numbers>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct HeightEntry {
    file: String,
    scale: f32,
    #[serde(default)]
    tiling: Tiling,
    #[serde(default)]
    offset: [f32; 2],
    #[serde(default)]
    wrap: HeightWrap,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(untagged, expecting = "tiling is one number or two")]
enum Tiling {
    Uniform(f32),
    Axes([f32; 2]),
}

impl Default for Tiling {
    fn default() -> Self {
        Self::Uniform(1.0)
    }
}

#[derive(Clone, Copy, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
enum HeightWrap {
    #[default]
    Repeat,
    Mirror,
    Clamp,
}

impl From<HeightWrap> for Wrap {
    fn from(wrap: HeightWrap) -> Self {
        match wrap {
            HeightWrap::Repeat => Self::Repeat,
            HeightWrap::Mirror => Self::MirroredRepeat,
            HeightWrap::Clamp => Self::ClampToEdge,
        }
    }
}

#[derive(Deserialize)]
#[serde(untagged, expecting = "a parameter of a material is one number or three")]
enum Numbers {
    One(f32),
    Three([f32; 3]),
}

impl Numbers {
    fn as_slice(&self) -> &[f32] {
        match self {
            Self::One(number) => std::slice::from_ref(number),
            Self::Three(numbers) => numbers,
        }
    }
}

struct Reader<'a> {
    text: &'a str,
    source: &'a Source<'a>,
}

impl Reader<'_> {
    fn scene(&self, file: &SceneFile, budget: &mut Budget) -> Result<LoadedScene, Fault> {
        let mut scene = Scene::default();
        let mut materials = BTreeMap::new();
        for (name, entry) in &file.material {
            let mut material = self.material(name, entry, &mut scene.warnings, budget)?;
            if let Some(height) = &entry.get_ref().height {
                material.height = Some(self.height(height, entry, budget, &mut scene)?);
            }
            let excess = excess(&material.surface);
            scene.warnings.extend(excess.map(|excess| format!("material '{}': {excess}", quoted(name))));
            materials.insert(name.as_str(), MaterialId(scene.materials.len()));
            scene.materials.push(material);
        }
        scene.cameras.extend(file.camera.clone());
        let of_file = Axes { up: file.up, unit: file.unit.map(|unit| unit.0) };
        let axes = self.source.options.axes.or(of_file);
        // What the scene places, and where, in file coordinates.
        let mut places = Vec::new();
        for model in &file.model {
            places.push(self.place(model, axes, &materials, &mut scene, budget)?);
        }
        for light in &file.light {
            let entry = light.get_ref();
            let profile = entry.profile_file().map(|file| self.profile(file, budget)).transpose()?;
            let place = entry.add_to(&mut scene, profile.as_ref());
            places.push(place.map_err(|message| self.at(light, message))?);
        }
        let origin = scene.suitable_origin();
        scene.move_origin(origin, &places);
        let environment = file.environment.as_ref().map(|entry| self.environment(entry)).transpose()?;
        let ground = file.ground.unwrap_or(Ground::None);
        let variant = self.source.options.variant.clone();
        Ok(LoadedScene { scene, environment, ground, variant, axes })
    }

    /// A lamp's photometric file.
    fn profile(&self, file: &str, budget: &mut Budget) -> Result<IesFile, Fault> {
        let path = self.source.sibling(file);
        let bytes = self.source.read(&path, budget)?;
        IesFile::parse(&bytes).map_err(|message| {
            Fault::Invalid(format!("the profile '{}' cannot be used: {message}", quoted(file)))
        })
    }

    /// Adds a model. Returns its root and where that stands.
    fn place(
        &self,
        spanned: &Spanned<ModelEntry>,
        axes: Axes,
        materials: &BTreeMap<&str, MaterialId>,
        scene: &mut Scene,
        budget: &mut Budget,
    ) -> Result<(NodeId, DVec3), Fault> {
        let model = spanned.get_ref();
        let (mut placed, name) = match (&model.file, &model.builtin) {
            (Some(file), None) => {
                let path = self.source.sibling(file);
                let own = Axes { up: model.up, unit: model.unit.map(|unit| unit.0) };
                let options = LoadOptions { axes: own.or(axes), ..self.source.options.clone() };
                let loaded = load_within(&path, (self.source.resolver, &options), budget, false)?;
                (loaded.scene, super::stem(Path::new(file)))
            }
            (None, Some(name)) => {
                let with_ground = model.ground == Some(true);
                let builtin =
                    if with_ground { builtin::by_name(name) } else { builtin::without_ground(name) };
                (builtin.map_err(|error| self.at(spanned, error.to_string()))?, name.clone())
            }
            _ => return Err(self.at(spanned, "a model has either 'file' or 'builtin'".to_owned())),
        };
        if model.ground.is_some() && model.builtin.is_none() {
            return Err(self.at(spanned, "only a built-in model has a 'ground' to bring".to_owned()));
        }
        if (model.up.is_some() || model.unit.is_some()) && model.file.is_none() {
            return Err(self.at(spanned, "only a model of a file has 'up' and 'unit'".to_owned()));
        }
        let translation = DVec3::from_array(model.translation) + model.turn_error() * placed.origin;
        // The root of the model comes first.
        let root = NodeId(scene.nodes.len());
        let ground = placed.ground.map(|node| NodeId(node.0 + 1 + scene.nodes.len()));
        if let Some(material) = &model.material {
            let id = materials.get(material.as_str()).ok_or_else(|| {
                self.at(spanned, format!("there is no [material.{}] in this file", quoted(material)))
            })?;
            // One material for the whole model; the file's own go, and so do its textures.
            placed.meshes.iter_mut().for_each(|mesh| Arc::make_mut(mesh).material = None);
            placed.materials.clear();
            placed.textures.clear();
            placed.height_maps.clear();
            let first = scene.meshes.len();
            scene.append_at(placed, self.root(spanned, name)?, translation);
            scene.meshes[first..].iter_mut().for_each(|mesh| Arc::make_mut(mesh).material = Some(*id));
            let has_heights = scene.materials[id.0].height.is_some();
            if has_heights && scene.meshes[first..].iter().any(|mesh| mesh.uvs[0].is_empty()) {
                scene.warnings.push(format!(
                    "material '{}': its heights need texture coordinates, which a mesh has not",
                    quoted(material)
                ));
            }
        } else {
            // Heights of a model grow with it.
            let scale = model.scale().element_product().abs().cbrt();
            let heights = placed.materials.iter_mut().filter_map(|material| material.height.as_mut());
            heights.for_each(|height| height.scale *= scale);
            scene.append_at(placed, self.root(spanned, name)?, translation);
        }
        scene.ground = scene.ground.or(ground);
        Ok((root, translation))
    }

    /// The node that places a model: scaled, then turned about x, y and z in this order. It is moved by [`Scene::append_at`].
    fn root(&self, spanned: &Spanned<ModelEntry>, name: String) -> Result<Node, Fault> {
        let model = spanned.get_ref();
        let (scale, rotation) = (model.scale(), model.rotation());
        let translation = DVec3::from_array(model.translation).as_vec3();
        if !(scale.is_finite() && rotation.is_finite() && translation.is_finite()) {
            return Err(self.at(spanned, "translation, rotation and scale must be finite".to_owned()));
        }
        if scale.abs().min_element() < f32::MIN_POSITIVE {
            return Err(self.at(spanned, "scale must not be 0".to_owned()));
        }
        Ok(Node {
            name: model.name.as_deref().map_or(name, quoted),
            parent_from_node: Affine3A::from_scale_rotation_translation(scale, rotation, translation),
            ..Node::default()
        })
    }

    fn material(
        &self,
        name: &str,
        spanned: &Spanned<MaterialEntry>,
        warnings: &mut Vec<String>,
        budget: &mut Budget,
    ) -> Result<Material, Fault> {
        let entry = spanned.get_ref();
        let mistake = |message: String| self.at(spanned, format!("material '{}': {message}", quoted(name)));
        let mut material = Material { name: quoted(name), double_sided: true, ..Material::default() };
        let parameters = entry.parameters.iter().map(|(name, numbers)| (name.as_str(), numbers.as_slice()));
        let measured = entry.tables.as_ref().map(|_| Model::Measured.name());
        let model = entry.reflectance.as_deref().or(measured);
        let settings = match &entry.metal {
            Some(metal) => ReflectanceSettings::of_metal(model, metal, parameters),
            None => ReflectanceSettings::of_values(model, parameters),
        }
        .map_err(mistake)?;
        settings.apply(&mut material.surface);
        match &entry.tables {
            Some(_) if settings.model() != Model::Measured => {
                return Err(mistake(format!("{} makes its tables itself", settings.model().name())));
            }
            Some(file) => {
                if settings.get(&SPECULAR).is_none() {
                    material.surface.specular = 1.0;
                }
                if settings.get(&BASE_COLOR).is_none() {
                    // The measurement is all of the surface.
                    material.surface.base_color = Vec3::ZERO;
                }
                let (tables, warning) = self.tables(file, budget)?;
                material.tables = Some(Arc::new(tables));
                warnings.extend(warning.map(|warning| format!("material '{}': {warning}", quoted(name))));
            }
            None if settings.model() == Model::Measured => {
                return Err(mistake("measured needs 'tables', a .bsdf, .binary or .json file".to_owned()));
            }
            None => {}
        }
        if let Some(color) = entry.emissive {
            if !color.iter().all(|value| (0.0..=f32::MAX).contains(value)) {
                return Err(mistake("emissive must be at least 0".to_owned()));
            }
            material.emissive = Vec3::from_array(color);
        }
        material.double_sided = entry.double_sided.unwrap_or(true);
        Ok(material)
    }

    fn height(
        &self,
        entry: &HeightEntry,
        of: &Spanned<MaterialEntry>,
        budget: &mut Budget,
        scene: &mut Scene,
    ) -> Result<Height, Fault> {
        let tiling = match entry.tiling {
            Tiling::Uniform(tiling) => Vec2::splat(tiling),
            Tiling::Axes(tiling) => Vec2::from_array(tiling),
        };
        let offset = Vec2::from_array(entry.offset);
        if !(entry.scale.is_finite() && tiling.is_finite() && offset.is_finite()) {
            return Err(self.at(of, "scale, tiling and offset of heights must be finite".to_owned()));
        }
        let path = self.source.sibling(&entry.file);
        let bytes = super::read_file(&path, self.source.resolver, budget)?;
        let wrap = Wrap::from(entry.wrap);
        let map = heights::decode(&bytes, [wrap; 2], budget, |warning| scene.warnings.push(warning));
        scene.height_maps.push(Arc::new(map.map_err(|fault| Fault::from(fault.at(&path)))?));
        Ok(Height {
            map: HeightMapId(scene.height_maps.len() - 1),
            uv_from_mesh: Affine2::from_scale_angle_translation(tiling, 0.0, offset),
            set: 0,
            scale: entry.scale,
        })
    }

    /// Tables of a file that this one names.
    fn tables(&self, file: &str, budget: &mut Budget) -> Result<(Tables, Option<String>), Fault> {
        let path = self.source.sibling(file);
        let bytes = self.source.read(&path, budget)?;
        let extension = path.extension().map(|extension| extension.to_string_lossy().to_lowercase());
        let loaded = gnomon_measured::load(&extension.unwrap_or_default(), &bytes);
        loaded.map_err(|error| Fault::invalid(error.to_string()).at(&path).into())
    }

    fn environment(&self, spanned: &Spanned<EnvironmentEntry>) -> Result<EnvironmentSettings, Fault> {
        let entry = spanned.get_ref();
        let source = match (&entry.file, &entry.builtin) {
            (Some(file), None) => Some(EnvironmentSource::File(self.source.sibling(file))),
            (None, Some(name)) => Some(EnvironmentSource::Builtin(name.clone())),
            (None, None) if entry.rig.is_some() => None,
            _ => return Err(self.at(spanned, "an environment has either 'file' or 'builtin'".to_owned())),
        };
        let exposure_ev = match entry.exposure {
            Exposure::Stops(stops) => Some(stops),
            Exposure::Automatic(Automatic::Automatic) => None,
        };
        if !exposure_ev.is_none_or(f32::is_finite) {
            return Err(self.at(spanned, "exposure must be finite".to_owned()));
        }
        Ok(EnvironmentSettings { source, exposure_ev })
    }

    fn at<T>(&self, spanned: &Spanned<T>, message: String) -> Fault {
        Fault::Invalid(format!("line {}: {message}", line_of(self.text, spanned.span().start)))
    }
}

/// Line number, from 1, of a byte offset.
fn line_of(text: &str, offset: usize) -> usize {
    1 + text.bytes().take(offset).filter(|&byte| byte == b'\n').count()
}
