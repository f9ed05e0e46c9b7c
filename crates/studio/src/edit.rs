//! Changes of a loaded scene by name: what a program sets before one picture after another.

use glam::Affine3A;
use gnomon_brdf::Surface;
use gnomon_messages::quoted;
use gnomon_scene::{NodeId, ReflectanceSettings};

use crate::{Project, StudioError};

impl Project {
    /// The node of that name, or else of that number from 0.
    ///
    /// # Errors
    /// [`StudioError::Request`] where there is none, or more than one of the name.
    pub fn node(&self, name: &str) -> Result<NodeId, StudioError> {
        named("node", name, self.scene.nodes.iter().map(|node| node.name.as_str())).map(NodeId)
    }

    /// The number of the material of that name, or else the number itself.
    ///
    /// # Errors
    /// As [`Project::node`].
    pub fn material(&self, name: &str) -> Result<usize, StudioError> {
        named("material", name, self.scene.materials.iter().map(|material| material.name.as_str()))
    }

    /// Places a node in its parent's space, at rest as in all clips that do not move it. Cameras that it carries go with it.
    pub fn place(&mut self, node: NodeId, parent_from_node: Affine3A) {
        self.scene.nodes[node.0].parent_from_node = parent_from_node;
        if let Some(animated) = self.scene.animated.iter_mut().find(|animated| animated.node == node) {
            animated.parent_from_node = parent_from_node;
            (animated.scale, animated.rotation, animated.translation) =
                parent_from_node.to_scale_rotation_translation();
        }
        self.scene.take_cameras_along(&[node]);
    }

    /// The surface of a material as the look has it.
    pub fn surface(&self, material: usize) -> Surface {
        let mut surface = self.scene.materials[material].surface;
        let settings = [self.look.reflectance.as_ref(), self.look.surfaces.get(&material)];
        settings.into_iter().flatten().for_each(|settings| settings.apply(&mut surface));
        surface
    }

    /// Gives a material other parameters, or another model with what that needs.
    ///
    /// # Errors
    /// [`StudioError::Request`] for what the model cannot have.
    pub fn change_surface(
        &mut self,
        material: usize,
        model: Option<&str>,
        values: &[(String, Vec<f32>)],
    ) -> Result<(), StudioError> {
        let surface = changed_surface(&self.surface(material), model, values)?;
        self.look.set_surface(material, &surface)
    }
}

/// A surface with other parameters, `(name, values)`, or with another model.
///
/// # Errors
/// [`StudioError::Request`] for what the model cannot have.
pub fn changed_surface(
    surface: &Surface,
    model: Option<&str>,
    values: &[(String, Vec<f32>)],
) -> Result<Surface, StudioError> {
    let own = surface.model;
    let mut given: Vec<(&str, Vec<f32>)> =
        values.iter().map(|(name, value)| (name.as_str(), value.clone())).collect();
    if model.is_none_or(|model| model == own.name()) {
        let is_given =
            |parameter: &gnomon_brdf::Parameter| values.iter().any(|(name, _)| parameter.is_called(name));
        for parameter in own.required().iter().filter(|parameter| !is_given(parameter)) {
            given.push((parameter.name, vec![(parameter.get)(surface).x]));
        }
    }
    let given = given.iter().map(|(name, value)| (*name, value.as_slice()));
    let settings = ReflectanceSettings::of_values(Some(model.unwrap_or(own.name())), given)
        .map_err(|error| StudioError::Request(format!("material: {error}")))?;
    let mut changed = *surface;
    settings.apply(&mut changed);
    Ok(changed)
}

/// The number of what is called so, or else of that number.
fn named<'a>(
    what: &'static str,
    wanted: &str,
    names: impl ExactSizeIterator<Item = &'a str> + Clone,
) -> Result<usize, StudioError> {
    let mut found = names.clone().enumerate().filter(|(_, name)| *name == wanted).map(|(number, _)| number);
    match (found.next(), found.count()) {
        (Some(number), 0) => return Ok(number),
        (Some(_), others) => {
            return Err(StudioError::Request(format!(
                "{} {what}s of the scene are called '{}': say which by its number",
                others + 1,
                quoted(wanted)
            )));
        }
        (None, _) => {}
    }
    let number = wanted.parse().ok().filter(|&number: &usize| number < names.len());
    number.ok_or_else(|| {
        let known: Vec<&str> = names.clone().filter(|name| !name.is_empty()).collect();
        StudioError::Request(format!(
            "there is no {what} '{}'; the scene has {} from 0, and their names are: {}",
            quoted(wanted),
            names.len(),
            known.join(", ")
        ))
    })
}
