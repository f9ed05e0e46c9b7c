//! Scenes: from files and arrays, with poses, vertices and materials that change.

use std::collections::{BTreeMap, HashMap};
use std::path::PathBuf;
use std::sync::Arc;

use glam::{Affine3A, Mat4, Quat, Vec3};
use gnomon::brdf::Surface;
use gnomon::envmap::Equirect;
use gnomon::options::{Given, OptionSpec};
use gnomon::picture::RgbImage;
use gnomon::scene::{Material, MaterialId, Mesh, MeshId, NodeId, ReflectanceSettings};
use gnomon::studio::{
    Look, Project, SceneFiles, SceneLook, SceneSource, Stage, Surroundings, changed_surface,
};
use gnomon_messages::quoted;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyList};

use crate::camera::Camera;
use crate::environment::Environment;
use crate::error::{raised, refused};
use crate::mesh::Shape;
use crate::view::PictureOptions;
use crate::{arrays, keywords, work};

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

/// What a pickled scene is restored from, after it was loaded: nodes that were added (name, vertices, triangles, normals, uvs, colours).
type Added<'py> = (String, [Bound<'py, PyAny>; 5]);

/// Vertices that were moved: node, vertices, normals.
type Moved<'py> = (usize, Bound<'py, PyAny>, Bound<'py, PyAny>);

/// Material parameters as keywords give them: names and one or three numbers each.
fn parameters(given: Option<&Bound<'_, PyDict>>) -> PyResult<Vec<(String, Vec<f32>)>> {
    let number = |value: Bound<'_, PyAny>| {
        let value = if value.hasattr("tolist")? { value.call_method0("tolist")? } else { value };
        value.extract::<f32>().map(|number| vec![number]).or_else(|_| value.extract::<Vec<f32>>())
    };
    given.into_iter().flatten().map(|(key, value)| Ok((key.extract()?, number(value)?))).collect()
}

/// The format that bytes begin like.
fn sniffed(bytes: &[u8]) -> Option<&'static str> {
    [(b"glTF".as_slice(), "glb"), (b"ply", "ply"), (b"solid", "stl")]
        .into_iter()
        .find(|(start, _)| bytes.starts_with(start))
        .map(|(_, format)| format)
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

    /// The only mesh of a node.
    fn mesh_of(&self, node: usize) -> PyResult<MeshId> {
        match *self.project.scene.nodes[node].meshes {
            [mesh] => Ok(mesh),
            ref meshes => Err(refused(format!("node {node} places {} meshes, not one", meshes.len()))),
        }
    }

    fn replace(&mut self, node: usize, mesh: Mesh) -> PyResult<()> {
        let MeshId(place) = self.mesh_of(node)?;
        let material = self.project.scene.meshes[place].material;
        self.project.scene.meshes[place] = Arc::new(Mesh { material, ..mesh });
        Ok(())
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
        let from = if let Ok(path) = source.extract::<PathBuf>() {
            let text = path.to_str().ok_or_else(|| refused("the path is no text"))?;
            SceneSource::named(text)
        } else if let Ok(bytes) = source.cast::<PyBytes>() {
            let bytes = bytes.as_bytes().to_vec();
            let format = format.as_deref().or_else(|| sniffed(&bytes)).ok_or_else(|| {
                refused("these bytes do not say what they are: give format='obj', 'gltf', 'toml' or another extension")
            })?;
            let path = PathBuf::from(format!("scene.{format}"));
            SceneSource::Files(SceneFiles::new(path.clone(), HashMap::from([(path, bytes)])))
        } else {
            return Err(refused("a scene is loaded from a path, the name of a built-in one, or bytes"));
        };
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
    fn camera(slf: &Bound<'_, Self>, name: Option<String>, size: Option<[u32; 2]>) -> PyResult<Camera> {
        let mut project = slf.borrow().project.clone();
        if let Some(name) = name {
            project.look.camera = gnomon::studio::CameraLook::Named(name);
        }
        project.look.picture.size = size.unwrap_or(project.look.picture.size);
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
        let vertices = arrays::vectors(vertices, "vertices")?;
        let shape = Shape {
            triangles: arrays::triangles(triangles, vertices.len(), "triangles")?,
            vertices,
            normals: normals.map_or(Ok(Vec::new()), |array| arrays::vectors(array, "normals"))?,
            uvs: uvs.map_or(Ok(Vec::new()), |array| arrays::pairs(array, "uvs"))?,
            colors: colors.map_or(Ok(Vec::new()), |array| arrays::colors(array, "colors"))?,
        };
        let pose = pose.map_or(Ok(Mat4::IDENTITY), |matrix| arrays::to_matrix(matrix, "pose"))?;
        let surface = changed_surface(&Surface::default(), model, &parameters(values)?).map_err(raised)?;
        let mesh = shape.mesh()?;
        let scene = &mut self.project.scene;
        scene.materials.push(Material { name: name.to_owned(), surface, ..Material::default() });
        let material = Some(MaterialId(scene.materials.len() - 1));
        let NodeId(node) = scene.push_mesh(name, Mesh { material, ..mesh });
        scene.nodes[node].parent_from_node = Affine3A::from_mat4(pose);
        self.rest.push(Affine3A::from_mat4(pose));
        self.shapes.insert(node, Arc::new(shape));
        Ok(node)
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
        let own = match self.shapes.get(&node) {
            Some(shape) => Shape::clone(shape),
            None => {
                let mesh = &self.project.scene.meshes[self.mesh_of(node)?.0];
                Shape {
                    vertices: mesh.positions.clone(),
                    triangles: mesh.triangles.clone(),
                    normals: mesh.normals.clone(),
                    ..Shape::default()
                }
            }
        };
        if vertices.len() != own.vertices.len() {
            return Err(refused(format!(
                "the mesh has {} vertices, not {}",
                own.vertices.len(),
                vertices.len()
            )));
        }
        if normals.is_empty() && !own.normals.is_empty() {
            return Err(refused("the mesh has smooth normals: give those of the moved vertices"));
        }
        let shape = Shape { vertices, normals, ..own };
        if self.shapes.contains_key(&node) {
            self.replace(node, shape.mesh()?)?;
            self.shapes.insert(node, Arc::new(shape));
            return Ok(());
        }
        let Mesh { positions, normals, .. } = shape.mesh()?;
        let mesh = Mesh::clone(&self.project.scene.meshes[self.mesh_of(node)?.0]);
        self.replace(node, Mesh { positions, normals, ..mesh })?;
        if !self.bent.contains(&node) {
            self.bent.push(node);
        }
        Ok(())
    }

    /// Vertices of a node's mesh in its own space, float32 (n, 3).
    fn vertices<'py>(&self, py: Python<'py>, node: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let node = self.node(node)?;
        let mesh = &self.project.scene.meshes[self.mesh_of(node)?.0];
        let vertices = self.shapes.get(&node).map_or(&mesh.positions, |shape| &shape.vertices);
        arrays::floats(py, bytemuck::cast_slice(vertices), &[vertices.len(), 3])
    }

    /// Corners of a node's mesh, int64 (n, 3), of its vertices.
    fn triangles<'py>(&self, py: Python<'py>, node: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let node = self.node(node)?;
        let mesh = &self.project.scene.meshes[self.mesh_of(node)?.0];
        let triangles = self.shapes.get(&node).map_or(&mesh.triangles, |shape| &shape.triangles);
        indices(py, triangles)
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

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let (py, this) = (slf.py(), slf.borrow());
        let vectors = |values: &[Vec3]| arrays::floats(py, bytemuck::cast_slice(values), &[values.len(), 3]);
        let scene = &this.project.scene;
        let added = this.shapes.iter().map(|(&node, shape)| {
            let colors: Vec<Vec3> = shape.colors.iter().map(|color| color.truncate()).collect();
            let parts = [
                vectors(&shape.vertices)?,
                indices(py, &shape.triangles)?,
                vectors(&shape.normals)?,
                arrays::floats(py, bytemuck::cast_slice(&shape.uvs), &[shape.uvs.len(), 2])?,
                vectors(&colors)?,
            ];
            Ok((scene.nodes[node].name.clone(), parts))
        });
        let added: Vec<Added<'_>> = added.collect::<PyResult<_>>()?;
        let moved = this.bent.iter().map(|&node| {
            let mesh = &scene.meshes[this.mesh_of(node)?.0];
            Ok((node, vectors(&mesh.positions)?, vectors(&mesh.normals)?))
        });
        let moved: Vec<Moved<'_>> = moved.collect::<PyResult<_>>()?;
        let cells = |affine: Affine3A| Mat4::from(affine).to_cols_array().to_vec();
        let poses: Vec<(Vec<f32>, Vec<f32>)> = scene
            .nodes
            .iter()
            .zip(&this.rest)
            .map(|(node, rest)| (cells(node.parent_from_node), cells(*rest)))
            .collect();
        let number = |material: usize| {
            ReflectanceSettings::of(&this.project.surface(material))
                .map(|settings| (material, settings.to_string()))
        };
        let surfaces: Vec<(usize, String)> = match this.source {
            // Those of added meshes are no file's.
            _ if !this.shapes.is_empty() => {
                (0..scene.materials.len()).map(number).collect::<Result<_, _>>().map_err(raised)?
            }
            _ => this
                .project
                .look
                .surfaces
                .iter()
                .map(|(&material, settings)| (material, settings.to_string()))
                .collect(),
        };
        let animation = &this.project.look.animation;
        let state = (
            this.source.as_ref().map(|source| source.clone_ref(py)),
            this.keywords.clone_ref(py),
            added,
            moved,
            poses,
            surfaces,
            (animation.clip.clone(), animation.time),
        );
        Ok((slf.get_type().getattr("_restored")?, state.into_pyobject(py)?.into_any()))
    }

    #[staticmethod]
    #[expect(clippy::too_many_arguments, reason = "the parts of a pickled scene")]
    fn _restored(
        py: Python<'_>,
        source: Option<&Bound<'_, PyAny>>,
        keywords: &Bound<'_, PyDict>,
        added: &Bound<'_, PyList>,
        moved: &Bound<'_, PyList>,
        poses: Vec<(Vec<f32>, Vec<f32>)>,
        surfaces: Vec<(usize, String)>,
        animation: (Option<String>, f32),
    ) -> PyResult<Self> {
        let keywords = keywords.copy()?;
        let mut scene = match source {
            Some(source) => {
                let format = keywords.get_item("format")?.map(|format| format.extract()).transpose()?;
                keywords.call_method1("pop", ("format", py.None()))?;
                Self::load(py, source, format, Some(&keywords))?
            }
            None => Self::new(py, Some(&keywords))?,
        };
        for part in added.iter() {
            let (name, [vertices, triangles, normals, uvs, colors]): Added<'_> = part.extract()?;
            scene.add_mesh(
                &name,
                &vertices,
                &triangles,
                Some(&normals),
                Some(&uvs),
                Some(&colors),
                None,
                None,
                None,
            )?;
        }
        for part in moved.iter() {
            let (node, vertices, normals): Moved<'_> = part.extract()?;
            scene.set_vertices(node.into_pyobject(py)?.as_any(), &vertices, Some(&normals))?;
        }
        if poses.len() != scene.project.scene.nodes.len() {
            return Err(refused(format!("{} is not the scene that was pickled", scene.project.source)));
        }
        let affine = |cells: &[f32]| {
            <&[f32; 16]>::try_from(cells).map(|cells| Affine3A::from_mat4(Mat4::from_cols_array(cells)))
        };
        for (node, (pose, rest)) in poses.iter().enumerate() {
            let (Ok(pose), Ok(rest)) = (affine(pose), affine(rest)) else {
                return Err(refused("this is no pickled scene"));
            };
            scene.project.place(NodeId(node), pose);
            scene.rest[node] = rest;
        }
        for (material, text) in surfaces {
            let settings = text.parse().map_err(|error: gnomon::scene::SceneError| raised(error))?;
            scene.project.look.surfaces.insert(material, settings);
        }
        scene.play(animation.0, animation.1)?;
        Ok(scene)
    }
}

fn indices<'py>(py: Python<'py>, triangles: &[[u32; 3]]) -> PyResult<Bound<'py, PyAny>> {
    let corners: Vec<i64> = triangles.iter().flatten().map(|&corner| i64::from(corner)).collect();
    if corners.is_empty() {
        return py.import("numpy")?.call_method1("zeros", ((0, 3), "int64"));
    }
    arrays::array(py, bytemuck::cast_slice(&corners), "int64", &[triangles.len(), 3])
}
