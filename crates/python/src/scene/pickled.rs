//! Scenes as they are pickled: what they were loaded from, and what was changed since.

use glam::{Affine3A, Mat4, Vec3};
use gnomon::scene::{NodeId, ReflectanceSettings};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::Scene;
use crate::arrays;
use crate::error::{raised, refused};
use crate::mesh::Shape;

/// A node that was added: name, vertices, triangles, normals, uvs, colours.
type Added<'py> = (String, [Bound<'py, PyAny>; 5]);

/// Vertices that were moved: node, vertices, normals.
type Moved<'py> = (usize, Bound<'py, PyAny>, Bound<'py, PyAny>);

/// A node's transforms, column by column: now, and where its angles count from.
type Posed = (Vec<f32>, Vec<f32>);

/// Arguments of `Scene._restored`.
pub type State<'py> = (
    Option<Bound<'py, PyAny>>,
    Bound<'py, PyDict>,
    Vec<Added<'py>>,
    Vec<Moved<'py>>,
    Vec<Posed>,
    Vec<(usize, String)>,
    (Option<String>, f32),
);

impl Scene {
    /// What makes the scene again.
    pub(super) fn state<'py>(&self, py: Python<'py>) -> PyResult<State<'py>> {
        let vectors = |values: &[Vec3]| arrays::floats(py, bytemuck::cast_slice(values), &[values.len(), 3]);
        let scene = &self.project.scene;
        let added = self.shapes.iter().map(|(&node, shape)| {
            let colors: Vec<Vec3> = shape.colors.iter().map(|color| color.truncate()).collect();
            let parts = [
                vectors(&shape.vertices)?,
                arrays::indices(py, &shape.triangles)?,
                vectors(&shape.normals)?,
                arrays::floats(py, bytemuck::cast_slice(&shape.uvs), &[shape.uvs.len(), 2])?,
                vectors(&colors)?,
            ];
            Ok((scene.nodes[node].name.clone(), parts))
        });
        let moved = self.bent.iter().map(|&node| {
            let mesh = self.mesh_of(node)?;
            Ok((node, vectors(&mesh.positions)?, vectors(&mesh.normals)?))
        });
        let cells = |affine: Affine3A| Mat4::from(affine).to_cols_array().to_vec();
        let poses = scene.nodes.iter().zip(&self.rest);
        let poses = poses.map(|(node, rest)| (cells(node.parent_from_node), cells(*rest)));
        let numbered = |material: usize| {
            let settings = ReflectanceSettings::of(&self.project.surface(material)).map_err(raised)?;
            Ok((material, settings.to_string()))
        };
        let changed = self.project.look.surfaces.iter();
        let surfaces = match self.shapes.is_empty() {
            true => changed.map(|(&material, settings)| (material, settings.to_string())).collect(),
            // Those of added meshes are no file's.
            false => (0..scene.materials.len()).map(numbered).collect::<PyResult<_>>()?,
        };
        let animation = &self.project.look.animation;
        Ok((
            self.source.as_ref().map(|source| source.bind(py).clone()),
            self.keywords.bind(py).clone(),
            added.collect::<PyResult<_>>()?,
            moved.collect::<PyResult<_>>()?,
            poses.collect(),
            surfaces,
            (animation.clip.clone(), animation.time),
        ))
    }

    /// The scene of a state.
    pub(super) fn of_state(py: Python<'_>, state: State<'_>) -> PyResult<Self> {
        let (source, keywords, added, moved, poses, surfaces, (clip, time)) = state;
        let mut scene = match &source {
            Some(source) => {
                let keywords = keywords.copy()?;
                let format = keywords.get_item("format")?.map(|format| format.extract()).transpose()?;
                keywords.call_method1("pop", ("format", py.None()))?;
                Self::load(py, source, format, Some(&keywords))?
            }
            None => Self::new(py, Some(&keywords))?,
        };
        for (name, arrays) in added {
            let [vertices, triangles, normals, uvs, colors] = &arrays;
            let shape = Shape::of(vertices, triangles, [Some(normals), Some(uvs), Some(colors)])?;
            scene.add_shape(&name, shape, Mat4::IDENTITY, Default::default())?;
        }
        let nodes = scene.project.scene.nodes.len();
        if poses.len() != nodes || moved.iter().any(|(node, ..)| *node >= nodes) {
            return Err(refused(format!("{} is not the scene that was pickled", scene.project.source)));
        }
        for (node, vertices, normals) in moved {
            let normals = arrays::vectors(&normals, "normals")?;
            scene.bend(node, arrays::vectors(&vertices, "vertices")?, normals)?;
        }
        for (node, (pose, rest)) in poses.iter().enumerate() {
            let (Some(pose), Some(rest)) = (affine(pose), affine(rest)) else {
                return Err(refused("this is no pickled scene"));
            };
            scene.project.place(NodeId(node), pose);
            scene.rest[node] = rest;
        }
        for (material, text) in surfaces {
            let settings = text.parse().map_err(|error: gnomon::scene::SceneError| raised(error))?;
            scene.project.look.surfaces.insert(material, settings);
        }
        scene.play(clip, time)?;
        Ok(scene)
    }
}

fn affine(cells: &[f32]) -> Option<Affine3A> {
    <&[f32; 16]>::try_from(cells).ok().map(|cells| Affine3A::from_mat4(Mat4::from_cols_array(cells)))
}
