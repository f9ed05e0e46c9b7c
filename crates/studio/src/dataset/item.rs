//! An item as its table says, and the stage that it is.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glam::{Affine3A, Mat4, Quat, Vec3};
use gnomon_lights::fit::FitSettings;
use gnomon_options::{Given, Options};
use gnomon_renderer::{DisplaySettings, LightPaths, LightingSettings, TechniqueSettings};
use gnomon_scene::{Camera, Projection, builtin};
use gnomon_scene_files::EnvironmentSource;
use serde::Deserialize;
use toml::{Table, Value};

use crate::look::{AnimationLook, CameraLook, EnvironmentLook, PictureSettings, SceneLook};
use crate::{Look, Project, Stage, StudioError, Surroundings, environment_named, load_surroundings};

/// Tables of an item.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Tables {
    scene: Table,
    environment: Option<Table>,
    camera: Option<Table>,
    #[serde(default)]
    pose: Vec<PoseTable>,
    #[serde(default)]
    material: Vec<MaterialTable>,
    #[serde(default, deserialize_with = "Given::deserialize::<FitSettings, _>")]
    fit: Given,
    #[serde(
        default,
        deserialize_with = "Given::deserialize::<(LightPaths, (LightingSettings, TechniqueSettings)), _>"
    )]
    render: Given,
    #[serde(default, deserialize_with = "Given::deserialize::<(PictureSettings, DisplaySettings), _>")]
    display: Given,
    #[serde(default, deserialize_with = "Given::deserialize::<AnimationLook, _>")]
    animation: Given,
}

/// `[[pose]]`: how a node stands from where its file has it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PoseTable {
    node: Name,
    /// In its parent's space [m].
    #[serde(default, rename = "move")]
    moved: [f32; 3],
    /// About an axis of its own [degrees].
    #[serde(default)]
    turn: f32,
    #[serde(default = "upright")]
    axis: [f32; 3],
}

fn upright() -> [f32; 3] {
    [0.0, 1.0, 0.0]
}

/// `[[material]]`: parameters of a material, or its model.
#[derive(Deserialize)]
struct MaterialTable {
    material: Name,
    model: Option<String>,
    #[serde(flatten)]
    values: BTreeMap<String, Numbers>,
}

/// A name or a number from 0.
#[derive(Deserialize)]
#[serde(untagged)]
enum Name {
    Text(String),
    Number(u32),
}

impl Name {
    fn text(&self) -> String {
        match self {
            Self::Text(text) => text.clone(),
            Self::Number(number) => number.to_string(),
        }
    }
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Numbers {
    One(f32),
    Three([f32; 3]),
}

/// `[camera]` of a view around the models.
#[derive(Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Orbit {
    /// About +y from +z, right-hand rule [degrees].
    azimuth: f32,
    /// Above the horizon [degrees].
    elevation: f32,
    /// In distances from which the models fill the picture.
    distance: f32,
    /// Horizontal [degrees]; that of the view which frames the models where it is left out.
    fov: Option<f32>,
    /// What is in the middle, from the middle of the models [m].
    target: [f32; 3],
}

impl Default for Orbit {
    fn default() -> Self {
        Self { azimuth: 0.0, elevation: 0.0, distance: 1.0, fov: None, target: [0.0; 3] }
    }
}

impl Orbit {
    fn camera(&self, stage: &Stage) -> Result<Camera, StudioError> {
        let framing = stage.framing();
        let Projection::Perspective { fov_x } = framing.projection else { return Ok(framing) };
        let fov_x = self.fov.map_or(fov_x, f32::to_radians);
        if !(fov_x > 0.0 && fov_x < std::f32::consts::PI && self.distance > 0.0 && self.distance.is_finite())
        {
            return Err(StudioError::Request(
                "camera: fov must be between 0 and 180 degrees, and distance above 0".to_owned(),
            ));
        }
        let turn = Quat::from_rotation_y(self.azimuth.to_radians())
            * Quat::from_rotation_x(-self.elevation.to_radians());
        let center = stage.center();
        let target = center + Vec3::from(self.target);
        let eye = target + turn * Vec3::Z * self.distance * (framing.eye() - center).length();
        let camera = Camera { projection: Projection::Perspective { fov_x }, ..framing };
        Ok(Camera { world_from_camera: Mat4::from_rotation_translation(turn, eye), ..camera })
    }
}

/// Which view an item has.
enum View {
    Automatic,
    Fixed(CameraLook),
    Orbit(Orbit),
}

/// An item, read from its table.
pub struct Item {
    scene: String,
    scene_options: Given,
    /// Its file, where it is not the scene's own.
    environment: Option<String>,
    environment_options: Given,
    view: View,
    pose: Vec<PoseTable>,
    material: Vec<MaterialTable>,
    look: Given,
}

/// The file that a table names, and the options of `T` beside it.
fn file_and_options<T: Options + Default>(
    mut table: Table,
    what: &str,
) -> Result<(Option<String>, Given), StudioError> {
    let file = match table.remove("file") {
        None => None,
        Some(Value::String(file)) => Some(file),
        Some(_) => return Err(StudioError::Request(format!("{what}: `file` is a text"))),
    };
    Ok((file, Given::deserialize::<T, _>(Value::Table(table)).map_err(|error| refused(what, &error))?))
}

fn refused(what: &str, error: &toml::de::Error) -> StudioError {
    StudioError::Request(format!("{what}: {}", gnomon_messages::one_line(error.message())))
}

impl Item {
    /// Reads the table of an item.
    ///
    /// # Errors
    /// [`StudioError::Request`] for what is no item's.
    pub fn new(table: Table) -> Result<Self, StudioError> {
        let tables: Tables = Value::Table(table).try_into().map_err(|error| refused("manifest", &error))?;
        let Tables { scene, environment, camera, pose, material, fit, render, display, animation } = tables;
        let (scene, scene_options) = file_and_options::<SceneLook>(scene, "scene")?;
        let scene = scene.ok_or_else(|| StudioError::Request("scene: `file` is missing".to_owned()))?;
        let (environment, environment_options) = match environment {
            Some(table) => file_and_options::<EnvironmentLook>(table, "environment")?,
            None => (None, Given::default()),
        };
        let look = fit.with(&render).with(&display).with(&animation);
        let view = match camera {
            None => View::Automatic,
            Some(table) => view(table)?,
        };
        Ok(Self { scene, scene_options, environment, environment_options, view, pose, material, look })
    }

    /// What items have in common that are best drawn one after another: first the environment, whose turn and grade need no other lights, then the
    /// scene.
    pub fn group(&self) -> (String, String) {
        let mut look = Look::default();
        self.environment_options.apply(&mut look.environment);
        let options = look.environment.shown_as(&EnvironmentLook::default());
        (format!("{:?} {options:?}", self.environment), self.scene_key())
    }

    fn scene_key(&self) -> String {
        format!("{} {:?}", self.scene, self.scene_options)
    }
}

fn view(mut table: Table) -> Result<View, StudioError> {
    let refused = |error: toml::de::Error| refused("camera", &error);
    if let Some(name) = table.remove("name") {
        return match (name, table.is_empty()) {
            (Value::String(name), true) => Ok(View::Fixed(CameraLook::Named(name))),
            _ => Err(StudioError::Request("camera: `name` is a text, and stands alone".to_owned())),
        };
    }
    let is_placed = table.contains_key("eye") || table.contains_key("matrix");
    let table = Value::Table(table);
    Ok(match is_placed {
        true => View::Fixed(CameraLook::Free(table.try_into().map_err(refused)?)),
        false => View::Orbit(table.try_into().map_err(refused)?),
    })
}

/// Makes stages of items. What the one before was made of is kept, so that its scene and environment are read once and shared on the device.
pub struct Stages {
    /// Where names of files are seen from.
    folder: PathBuf,
    scene: Option<((String, [u32; 2]), Project)>,
    surroundings: Option<((String, String), Surroundings)>,
}

impl Stages {
    /// Of a manifest in this folder.
    pub fn new(folder: &Path) -> Self {
        Self { folder: folder.to_owned(), scene: None, surroundings: None }
    }

    /// The stage of an item.
    ///
    /// # Errors
    /// Files that cannot be used, names of nothing.
    pub fn stage(&mut self, item: &Item) -> Result<Stage, StudioError> {
        let mut project = self.project(item)?;
        item.look.apply(&mut project.look);
        if let Some(file) = &item.environment {
            project.look.set_environment(self.environment_source(file));
        }
        item.environment_options.apply(&mut project.look.environment);
        for pose in &item.pose {
            let node = project.node(&pose.node.text())?;
            let axis = Vec3::from(pose.axis).try_normalize();
            let axis = axis.ok_or_else(|| StudioError::Request("pose: `axis` has no length".to_owned()))?;
            let turn = Affine3A::from_axis_angle(axis, pose.turn.to_radians());
            let moved = Affine3A::from_translation(pose.moved.into());
            let own = project.scene.nodes[node.0].parent_from_node;
            project.place(node, moved * own * turn);
        }
        for change in &item.material {
            let material = project.material(&change.material.text())?;
            let values: Vec<(String, Vec<f32>)> = change
                .values
                .iter()
                .map(|(name, value)| {
                    let numbers = match value {
                        Numbers::One(number) => vec![*number],
                        Numbers::Three(numbers) => numbers.to_vec(),
                    };
                    (name.clone(), numbers)
                })
                .collect();
            project.change_surface(material, change.model.as_deref(), &values)?;
        }
        if let View::Fixed(camera) = &item.view {
            project.look.camera = camera.clone();
        }
        let surroundings = self.surroundings(item, &project)?;
        let stage = Stage::under(project, surroundings, Vec::new())?;
        match &item.view {
            View::Orbit(orbit) => {
                let camera = CameraLook::Free(orbit.camera(&stage)?);
                let look = Look { camera, ..stage.look().clone() };
                Ok(stage.with_look(look)?.0)
            }
            _ => Ok(stage),
        }
    }

    fn project(&mut self, item: &Item) -> Result<Project, StudioError> {
        let (plain, mut picture) = (PictureSettings::default(), PictureSettings::default());
        item.look.apply(&mut picture);
        // The size decides about lenses that a file gives by a vertical angle.
        let key = (item.scene_key(), picture.size);
        if let Some((_, project)) = self.scene.as_ref().filter(|(known, _)| *known == key) {
            return Ok(project.clone());
        }
        let name = match builtin::NAMES.contains(&item.scene.as_str()) {
            true => item.scene.clone(),
            false => self.folder.join(&item.scene).to_string_lossy().into_owned(),
        };
        let given = item.scene_options.with(&Given::changes(&plain, &picture));
        let project = Project::open(&name, Look::default(), &given)?;
        self.scene = Some((key, project.clone()));
        Ok(project)
    }

    fn environment_source(&self, file: &str) -> EnvironmentSource {
        match environment_named(file) {
            EnvironmentSource::File(path) => EnvironmentSource::File(self.folder.join(path)),
            builtin => builtin,
        }
    }

    fn surroundings(&mut self, item: &Item, project: &Project) -> Result<Surroundings, StudioError> {
        let key = (item.group().0, if item.environment.is_none() { item.scene_key() } else { String::new() });
        if let Some((_, surroundings)) = self.surroundings.as_ref().filter(|(known, _)| *known == key) {
            return Ok(surroundings.clone());
        }
        let (surroundings, _) = match item.environment {
            Some(_) => load_surroundings(&project.look)?,
            None => project.surroundings()?,
        };
        self.surroundings = Some((key, surroundings.clone()));
        Ok(surroundings)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Another pose, turn, strength or tint leaves the surroundings where they are: a session then makes no other lights.
    #[test]
    fn items_that_differ_in_how_light_is_shown_share_it() {
        let item = |environment: &str| {
            let text =
                format!("scene = {{ file = 'column' }}\nenvironment = {{ file = 'room', {environment} }}");
            Item::new(text.parse().unwrap()).unwrap()
        };
        let (plain, clamped) = (item("rotation = 5.0"), item("clamp = 2.0"));
        let graded = item("rotation = 40.0, strength = 1.5, tint = [1.0, 0.5, 0.25]");
        let mut stages = Stages::new(Path::new("."));
        let [first, second, other] = [&plain, &graded, &clamped].map(|item| stages.stage(item).unwrap());
        assert_eq!(plain.group(), graded.group());
        assert_ne!(plain.group(), clamped.group());
        assert!(first.surroundings().is(second.surroundings()) && first.grade() != second.grade());
        assert!(!first.surroundings().is(other.surroundings()));
    }
}
