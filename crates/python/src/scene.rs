//! Scenes: from files and arrays, with poses, vertices and materials that change.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::{Affine3A, Mat4, Quat, Vec3};
use gnomon::brdf::Surface;
use gnomon::envmap::Equirect;
use gnomon::options::{Given, OptionSpec};
use gnomon::picture::RgbImage;
use gnomon::scene::NodeId;
use gnomon::studio::{Look, Project, SceneLook, Stage, Surroundings, changed_surface};
use gnomon_messages::quoted;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::camera::Camera;
use crate::environment::Environment;
use crate::error::{raised, refused};
use crate::mesh::Shape;
use crate::view::{PictureOptions, Size};
use crate::{arrays, keywords, work};

mod meshes;
mod pickled;
mod source;

/// A scene in a pose. It is changed in place; a copy shares meshes and textures.
#[pyclass(module = "gnomon")]
#[derive(Clone)]
pub struct Scene {
    pub project: Project,
    /// `parent_from_node` as nodes were loaded or added: what angles of joints count from.
    rest: Vec<Affine3A>,
    /// Of nodes that were added: their arrays.
    shapes: BTreeMap<usize, Arc<Shape>>,
    /// Nodes of files whose vertices were moved.
    bent: Vec<usize>,
    own_environment: Option<Environment>,
    /// What it was loaded from, to be loaded elsewhere; none for an empty scene.
    source: Option<Arc<Py<PyAny>>>,
    keywords: Arc<Py<PyDict>>,
}

/// Material parameters as keywords give them: names and one or three numbers each.
fn parameters(given: Option<&Bound<'_, PyDict>>) -> PyResult<Vec<(String, Vec<f32>)>> {
    let number = |value: Bound<'_, PyAny>| {
        let value = if value.hasattr("tolist")? { value.call_method0("tolist")? } else { value };
        value.extract::<f32>().map(|number| vec![number]).or_else(|_| value.extract::<Vec<f32>>())
    };
    given.into_iter().flatten().map(|(key, value)| Ok((key.extract()?, number(value)?))).collect()
}

impl Scene {
    fn of(project: Project, source: Option<Arc<Py<PyAny>>>, keywords: Py<PyDict>) -> Self {
        let rest = project.scene.nodes.iter().map(|node| node.parent_from_node).collect();
        let (shapes, bent, keywords) = (BTreeMap::new(), Vec::new(), Arc::new(keywords));
        Self { project, rest, shapes, bent, own_environment: None, source, keywords }
    }

    /// The environment that the scene's file names; it is read once.
    pub fn own_environment(scene: &Bound<'_, Self>) -> PyResult<Environment> {
        let (project, own) = {
            let scene = scene.borrow();
            (scene.project.clone(), scene.own_environment.clone())
        };
        if let Some(own) = own {
            return Ok(own);
        }
        if !project.look.has_environment() {
            return Err(refused(format!("{} brings no environment: give one", project.source)));
        }
        let own = Environment::of_scene(scene.py(), &project)?;
        scene.borrow_mut().own_environment = Some(own.clone());
        Ok(own)
    }

    /// A node by its name or number.
    fn node(&self, node: &Bound<'_, PyAny>) -> PyResult<usize> {
        match node.extract::<usize>() {
            Ok(number) => within("node", number, self.project.scene.nodes.len()),
            Err(_) => self.project.node(node.extract()?).map(|node| node.0).map_err(raised),
        }
    }

    /// A material by its name or number.
    fn material_number(&self, material: &Bound<'_, PyAny>) -> PyResult<usize> {
        match material.extract::<usize>() {
            Ok(number) => within("material", number, self.project.scene.materials.len()),
            Err(_) => self.project.material(material.extract()?).map_err(raised),
        }
    }
}

fn within(what: &str, number: usize, count: usize) -> PyResult<usize> {
    match number < count {
        true => Ok(number),
        false => Err(refused(format!("there is no {what} {number}: the scene has {count}, from 0"))),
    }
}

#[pymethods]
impl Scene {
    /// An empty scene.
    #[new]
    #[pyo3(signature = (**options))]
    fn new(py: Python<'_>, options: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let given = keywords::given::<(SceneLook, PictureOptions)>(
            options,
            keywords::flag as fn(&OptionSpec) -> String,
        )?;
        let mut project = Project::made("scene", gnomon::scene::Scene::default());
        given.apply(&mut project.look);
        let kept = options.map_or_else(|| Ok(PyDict::new(py)), |options| options.copy())?;
        Ok(Self::of(project, None, kept.unbind()))
    }

    #[staticmethod]
    #[pyo3(signature = (source, *, format=None, **options))]
    fn load(
        py: Python<'_>,
        source: &Bound<'_, PyAny>,
        format: Option<String>,
        options: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let given: Given = keywords::given::<(SceneLook, PictureOptions)>(
            options,
            keywords::flag as fn(&OptionSpec) -> String,
        )?;
        let kept = options.map_or_else(|| Ok(PyDict::new(py)), |options| options.copy())?;
        if let Some(format) = &format {
            kept.set_item("format", format)?;
        }
        let from = source::source(source, format.as_deref())?;
        let project = work::run(py, None, |_| Project::open_source(from, Look::default(), &given))?;
        Ok(Self::of(project, Some(Arc::new(source.clone().unbind())), kept.unbind()))
    }

    /// Names of the nodes; a node without one is meant by its number.
    #[getter]
    fn nodes(&self) -> Vec<String> {
        self.project.scene.nodes.iter().map(|node| node.name.clone()).collect()
    }

    /// Numbers of the nodes' parents; None for a root.
    #[getter]
    fn parents(&self) -> Vec<Option<usize>> {
        self.project.scene.nodes.iter().map(|node| node.parent.map(|parent| parent.0)).collect()
    }

    #[getter]
    fn materials(&self) -> Vec<String> {
        self.project.scene.materials.iter().map(|material| material.name.clone()).collect()
    }

    #[getter]
    fn cameras(&self) -> Vec<String> {
        self.project.scene.cameras.iter().map(|camera| camera.name.clone()).collect()
    }

    /// Names of the clips, and how long they are [s].
    #[getter]
    fn clips(&self) -> Vec<(String, f32)> {
        self.project.scene.animations.iter().map(|clip| (clip.name.clone(), clip.duration())).collect()
    }

    /// What the loader repaired or left out, a line each.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.project.scene.warnings.clone()
    }

    #[getter]
    fn triangle_count(&self) -> usize {
        self.project.scene.triangle_count()
    }

    /// Smallest and largest corner of a box around the models in the present pose [m]; None without any.
    #[getter]
    fn bounds(&self) -> Option<([f32; 3], [f32; 3])> {
        self.project.scene.bounds_to_frame().map(|bounds| (bounds.min.to_array(), bounds.max.to_array()))
    }

    #[getter]
    fn environment(slf: &Bound<'_, Self>) -> PyResult<Option<Environment>> {
        let has_one = slf.borrow().project.look.has_environment();
        has_one.then(|| Self::own_environment(slf)).transpose()
    }

    /// One of the scene's cameras; without a name the first, or one that frames the models in a picture of that size.
    #[pyo3(signature = (name=None, size=None))]
    fn camera(slf: &Bound<'_, Self>, name: Option<String>, size: Option<Size>) -> PyResult<Camera> {
        let mut project = slf.borrow().project.clone();
        if let Some(name) = name {
            project.look.camera = gnomon::studio::CameraLook::Named(name);
        }
        project.look.picture.size = size.map_or(project.look.picture.size, |Size(size)| size);
        let camera = work::run(slf.py(), None, |_| {
            let nothing = Equirect::new(RgbImage::filled(2, 1, Vec3::ZERO));
            Stage::under(project, Surroundings::from(Arc::new(nothing)), Vec::new())?.camera()
        })?;
        Ok(Camera(camera))
    }

    /// The transform of a node to its parent's space, float32 (4, 4).
    fn pose<'py>(&self, py: Python<'py>, node: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        arrays::matrix(py, Mat4::from(self.project.scene.nodes[self.node(node)?].parent_from_node))
    }

    /// The transform of a node to world space, float32 (4, 4).
    fn world_pose<'py>(&self, py: Python<'py>, node: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let node = self.node(node)?;
        arrays::matrix(py, Mat4::from(self.project.scene.world_from_nodes()[node]))
    }

    /// Moves a node.
    fn set_pose(&mut self, node: &Bound<'_, PyAny>, parent_from_node: &Bound<'_, PyAny>) -> PyResult<()> {
        let node = self.node(node)?;
        let matrix = arrays::to_matrix(parent_from_node, "parent_from_node")?;
        self.project.place(NodeId(node), Affine3A::from_mat4(matrix));
        Ok(())
    }

    /// Turns a node from where it was loaded, about an axis of its own.
    #[pyo3(signature = (node, degrees, axis=[0.0, 0.0, 1.0]))]
    fn set_joint(&mut self, node: &Bound<'_, PyAny>, degrees: f32, axis: [f32; 3]) -> PyResult<()> {
        let node = self.node(node)?;
        let axis = Vec3::from(axis).try_normalize().filter(|_| degrees.is_finite());
        let axis =
            axis.ok_or_else(|| refused("a joint turns by a finite angle about an axis that has a length"))?;
        let turn = Affine3A::from_quat(Quat::from_axis_angle(axis, degrees.to_radians()));
        self.project.place(NodeId(node), self.rest[node] * turn);
        Ok(())
    }

    /// Plays a clip up to a time [s]; None for the models as they stand.
    #[pyo3(signature = (clip, time=0.0))]
    fn play(&mut self, clip: Option<String>, time: f32) -> PyResult<()> {
        let names: Vec<&str> = self.project.scene.animations.iter().map(|clip| clip.name.as_str()).collect();
        let is_known = |clip: &String| {
            names.contains(&clip.as_str()) || clip.parse::<usize>().is_ok_and(|n| n < names.len())
        };
        if let Some(clip) = clip.as_ref().filter(|clip| !is_known(clip)) {
            return Err(refused(format!(
                "there is no clip '{}'; there are: {}",
                quoted(clip),
                names.join(", ")
            )));
        }
        if !time.is_finite() {
            return Err(refused("the time in a clip must be finite"));
        }
        let animation = &mut self.project.look.animation;
        (animation.clip, animation.time) = (clip, time);
        Ok(())
    }

    /// Reflectance model and parameters of a material, as it is drawn.
    fn material<'py>(&self, py: Python<'py>, material: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyDict>> {
        let surface = self.project.surface(self.material_number(material)?);
        let values = PyDict::new(py);
        values.set_item("model", surface.model.name())?;
        for parameter in surface.model.parameters() {
            let value = (parameter.get)(&surface);
            match parameter.is_color {
                true => values.set_item(parameter.name, value.to_array())?,
                false => values.set_item(parameter.name, value.x)?,
            }
        }
        Ok(values)
    }

    /// Changes parameters of a material, or its model.
    #[pyo3(signature = (material, *, model=None, **values))]
    fn set_material(
        &mut self,
        material: &Bound<'_, PyAny>,
        model: Option<&str>,
        values: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<()> {
        let material = self.material_number(material)?;
        self.project.change_surface(material, model, &parameters(values)?).map_err(raised)
    }

    /// Adds a mesh at the root, with a material of its name. Without normals its faces are flat.
    #[pyo3(signature = (name, vertices, triangles, *, normals=None, uvs=None, colors=None, pose=None, model=None, **values))]
    #[expect(clippy::too_many_arguments, reason = "each is a keyword in Python")]
    fn add_mesh(
        &mut self,
        name: &str,
        vertices: &Bound<'_, PyAny>,
        triangles: &Bound<'_, PyAny>,
        normals: Option<&Bound<'_, PyAny>>,
        uvs: Option<&Bound<'_, PyAny>>,
        colors: Option<&Bound<'_, PyAny>>,
        pose: Option<&Bound<'_, PyAny>>,
        model: Option<&str>,
        values: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<usize> {
        let shape = Shape::of(vertices, triangles, [normals, uvs, colors])?;
        let pose = pose.map_or(Ok(Mat4::IDENTITY), |matrix| arrays::to_matrix(matrix, "pose"))?;
        let surface = changed_surface(&Surface::default(), model, &parameters(values)?).map_err(raised)?;
        self.add_shape(name, shape, pose, surface)
    }

    /// Moves the vertices of a node's mesh, as many as it has. Without normals, faces that were flat stay so; others need theirs.
    #[pyo3(signature = (node, vertices, normals=None))]
    fn set_vertices(
        &mut self,
        node: &Bound<'_, PyAny>,
        vertices: &Bound<'_, PyAny>,
        normals: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let node = self.node(node)?;
        let vertices = arrays::vectors(vertices, "vertices")?;
        let normals = normals.map_or(Ok(Vec::new()), |array| arrays::vectors(array, "normals"))?;
        self.bend(node, vertices, normals)
    }

    /// Vertices of a node's mesh in its own space, float32 (n, 3).
    fn vertices<'py>(&self, py: Python<'py>, node: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let node = self.node(node)?;
        let mesh = self.mesh_of(node)?;
        let vertices = self.shapes.get(&node).map_or(&mesh.positions, |shape| &shape.vertices);
        arrays::floats(py, bytemuck::cast_slice(vertices), &[vertices.len(), 3])
    }

    /// Corners of a node's mesh, int64 (n, 3), of its vertices.
    fn triangles<'py>(&self, py: Python<'py>, node: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let node = self.node(node)?;
        let mesh = self.mesh_of(node)?;
        arrays::indices(py, self.shapes.get(&node).map_or(&mesh.triangles, |shape| &shape.triangles))
    }

    /// A copy that changes by itself.
    fn copy(&self) -> Self {
        self.clone()
    }

    fn __copy__(&self) -> Self {
        self.clone()
    }

    fn __deepcopy__(&self, _memo: &Bound<'_, PyAny>) -> Self {
        self.clone()
    }

    fn __repr__(&self) -> String {
        let scene = &self.project.scene;
        let (triangles, nodes) = (scene.triangle_count(), scene.nodes.len());
        format!("<gnomon.Scene {}: {triangles} triangles, {nodes} nodes>", self.project.source)
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, (pickled::State<'py>,))> {
        Ok((slf.get_type().getattr("_restored")?, (slf.borrow().state(slf.py())?,)))
    }

    #[staticmethod]
    fn _restored(py: Python<'_>, state: pickled::State<'_>) -> PyResult<Self> {
        Self::of_state(py, state)
    }
}
