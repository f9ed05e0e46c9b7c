//! Meshes (specification, section 3.7): every primitive becomes a [`Mesh`].

use std::collections::HashMap;
use std::sync::Arc;

use glam::{Vec2, Vec3, Vec4};
use gnomon_scene::{MaterialId, Mesh, MeshId, MorphTarget, Scene};

use super::accessors::Accessors;
use super::schema::{Int, MeshEntry, Primitive, Root};
use super::{Budget, Fault, get, materials, skins};
use crate::geometry;

/// The meshes of a file, each read when a node first uses it.
pub struct Meshes<'a> {
    root: &'a Root,
    accessors: &'a Accessors<'a>,
    known: HashMap<usize, Known>,
    /// Number of morph targets of every mesh of the file: the most that a primitive has.
    targets: Vec<usize>,
    unnamed_material: Option<MaterialId>,
}

/// A mesh that was read.
struct Known {
    ids: Vec<MeshId>,
    /// Largest joint that its vertices refer to, and in which primitive.
    last_joint: Option<(u32, usize)>,
}

impl<'a> Meshes<'a> {
    pub fn new(root: &'a Root, accessors: &'a Accessors<'a>) -> Self {
        let targets = |mesh: &MeshEntry| mesh.primitives.iter().map(|p| p.targets.len()).max().unwrap_or(0);
        let targets = root.meshes.iter().map(targets).collect();
        Self { root, accessors, known: HashMap::new(), targets, unnamed_material: None }
    }

    /// Number of morph targets of mesh `index`.
    pub fn targets(&self, index: usize) -> usize {
        self.targets.get(index).copied().unwrap_or(0)
    }

    /// Default weights of the morph targets of mesh `index` where a node gives `own`, if it does: those, or else the mesh's. What is
    /// not finite counts as 0.
    pub fn weights(&self, index: usize, own: Option<&[f32]>, budget: &mut Budget) -> Result<Vec<f32>, Fault> {
        let count = self.targets(index);
        budget.take(count, size_of::<f32>())?;
        let of_mesh = || self.root.meshes.get(index).and_then(|mesh| mesh.weights.as_deref());
        let given = own.or_else(of_mesh).unwrap_or_default();
        let finite = given.iter().map(|&weight| if weight.is_finite() { weight } else { 0.0 });
        Ok(finite.chain(std::iter::repeat(0.0)).take(count).collect())
    }

    /// The primitives of mesh `index` in `scene.meshes`, in the node's space.
    pub fn read(
        &mut self,
        index: usize,
        budget: &mut Budget,
        scene: &mut Scene,
    ) -> Result<Vec<MeshId>, Fault> {
        if let Some(known) = self.known.get(&index) {
            budget.take(known.ids.len(), size_of::<MeshId>())?;
            return Ok(known.ids.clone());
        }
        let mesh = get(&self.root.meshes, index, "mesh", "a node")?;
        let mut known = Known { ids: Vec::with_capacity(mesh.primitives.len()), last_joint: None };
        for (number, primitive) in mesh.primitives.iter().enumerate() {
            let name = format!("mesh {index}, primitive {number}");
            let Some(mut raw) = self.primitive(primitive, &name, budget, &mut scene.warnings)? else {
                continue;
            };
            let last = raw.influences.entries.iter().map(|&(joint, _)| (joint, number)).max();
            known.last_joint = known.last_joint.max(last);
            let material = match primitive.material {
                Some(Int(material)) => {
                    get(&scene.materials, material, "material", &name)?;
                    MaterialId(material)
                }
                None => *self.unnamed_material.get_or_insert_with(|| {
                    scene.materials.push(materials::unnamed());
                    MaterialId(scene.materials.len() - 1)
                }),
            };
            raw.material = Some(material);
            let tangent_set = scene.materials[material.0].tangent_set();
            let finished = geometry::finish(raw, tangent_set, &name, budget, &mut scene.warnings)?;
            known.ids.push(MeshId(scene.meshes.len()));
            scene.meshes.push(Arc::new(finished));
        }
        let ids = known.ids.clone();
        self.known.insert(index, known);
        Ok(ids)
    }

    /// Refuses a mesh that was read and whose vertices refer to joints that a skin of `joints` lacks.
    pub fn check_joints(&self, index: usize, joints: usize) -> Result<(), Fault> {
        match self.known.get(&index).and_then(|known| known.last_joint) {
            Some((joint, primitive)) if joint as usize >= joints => Err(Fault::Invalid(format!(
                "mesh {index}, primitive {primitive} refers to joint {joint}, but its skin has {joints}"
            ))),
            _ => Ok(()),
        }
    }

    /// The primitive's arrays and triangles; `None` for one that shows nothing.
    fn primitive(
        &self,
        primitive: &Primitive,
        name: &str,
        budget: &mut Budget,
        warnings: &mut Vec<String>,
    ) -> Result<Option<Mesh>, Fault> {
        let mode = primitive.mode.map_or(4, |mode| mode.0);
        if mode > 6 {
            return Err(Fault::Invalid(format!("{name} has the unknown mode {mode}")));
        }
        if mode < 4 {
            warnings.push(format!("{name}: points and lines are left out"));
            return Ok(None);
        }
        let attribute = |semantic: &str| primitive.attributes.get(semantic).map(|index| index.0);
        let Some(position) = attribute("POSITION") else {
            warnings.push(format!("{name} has no positions and is left out"));
            return Ok(None);
        };
        let in_buffer =
            self.root.accessors.get(position).is_some_and(|accessor| accessor.buffer_view.is_some());
        if primitive.extensions.draco.is_some() && !in_buffer {
            return Err(Fault::Unsupported(format!("{name} is compressed with Draco")));
        }
        let read =
            Attributes { accessors: self.accessors, name, count: self.accessors.count(position, name)? };
        let mut mesh = Mesh {
            positions: read.vectors(position, budget)?,
            normals: attribute("NORMAL").map_or(Ok(Vec::new()), |index| read.vectors(index, budget))?,
            tangents: attribute("TANGENT").map_or(Ok(Vec::new()), |index| read.vec4s(index, budget))?,
            uvs: [
                attribute("TEXCOORD_0").map_or(Ok(Vec::new()), |index| read.vec2s(index, budget))?,
                attribute("TEXCOORD_1").map_or(Ok(Vec::new()), |index| read.vec2s(index, budget))?,
            ],
            colors: attribute("COLOR_0").map_or(Ok(Vec::new()), |index| read.colors(index, budget))?,
            ..Mesh::default()
        };
        mesh.influences = skins::influences(primitive, self.accessors, name, read.count, budget, warnings)?;
        for target in &primitive.targets {
            let offsets = |semantic: &str, budget: &mut Budget| match target.get(semantic) {
                Some(Int(index)) => read.vectors(*index, budget),
                None => Ok(Vec::new()),
            };
            budget.take(1, size_of::<MorphTarget>())?;
            mesh.targets.push(MorphTarget {
                positions: offsets("POSITION", budget)?,
                normals: offsets("NORMAL", budget)?,
                tangents: offsets("TANGENT", budget)?,
            });
        }
        mesh.triangles = self.triangles(primitive, mode, read.count, name, budget, warnings)?;
        Ok(Some(mesh))
    }

    fn triangles(
        &self,
        primitive: &Primitive,
        mode: usize,
        vertex_count: usize,
        name: &str,
        budget: &mut Budget,
        warnings: &mut Vec<String>,
    ) -> Result<Vec<[u32; 3]>, Fault> {
        let indices = match primitive.indices {
            Some(Int(accessor)) => self.accessors.indices(accessor, name, budget)?,
            None => {
                budget.take(vertex_count, size_of::<u32>())?;
                let count = u32::try_from(vertex_count);
                (0..count.map_err(|_| Fault::Invalid(format!("{name} has too many vertices")))?).collect()
            }
        };
        if let Some(index) = indices.iter().find(|&&index| index as usize >= vertex_count) {
            return Err(Fault::Invalid(format!(
                "{name} refers to vertex {index}, but there are {vertex_count}"
            )));
        }
        budget.take(indices.len(), geometry::TRIANGLE_BYTES)?;
        let windows = indices.windows(3);
        // Section 3.7.2.1, the order of vertices for each mode.
        Ok(match mode {
            4 => {
                if !indices.len().is_multiple_of(3) {
                    warnings
                        .push(format!("{name}: {} indices make no whole number of triangles", indices.len()));
                }
                indices.chunks_exact(3).map(|corner| [corner[0], corner[1], corner[2]]).collect()
            }
            5 => windows
                .enumerate()
                .map(|(i, v)| if i % 2 == 0 { [v[0], v[1], v[2]] } else { [v[0], v[2], v[1]] })
                .collect(),
            _ => windows.map(|v| [v[1], v[2], indices[0]]).collect(),
        })
    }
}

/// Vertex attributes of one primitive, all as long as its positions.
struct Attributes<'a> {
    accessors: &'a Accessors<'a>,
    name: &'a str,
    count: usize,
}

impl Attributes<'_> {
    fn read<const N: usize>(&self, index: usize, budget: &mut Budget) -> Result<Vec<[f32; N]>, Fault> {
        let count = self.accessors.count(index, self.name)?;
        if count != self.count {
            let (name, wanted) = (self.name, self.count);
            return Err(Fault::Invalid(format!(
                "{name}: accessor {index} has {count} elements, not {wanted}"
            )));
        }
        self.accessors.floats(index, self.name, budget)
    }

    fn vectors(&self, index: usize, budget: &mut Budget) -> Result<Vec<Vec3>, Fault> {
        Ok(self.read(index, budget)?.into_iter().map(Vec3::from_array).collect())
    }

    fn vec2s(&self, index: usize, budget: &mut Budget) -> Result<Vec<Vec2>, Fault> {
        Ok(self.read(index, budget)?.into_iter().map(Vec2::from_array).collect())
    }

    fn vec4s(&self, index: usize, budget: &mut Budget) -> Result<Vec<Vec4>, Fault> {
        Ok(self.read(index, budget)?.into_iter().map(Vec4::from_array).collect())
    }

    /// Linear colours with or without alpha.
    fn colors(&self, index: usize, budget: &mut Budget) -> Result<Vec<Vec4>, Fault> {
        if self.accessors.width(index, self.name)? == 3 {
            let colors = self.read::<3>(index, budget)?;
            budget.take(colors.len(), size_of::<Vec4>())?;
            return Ok(colors.into_iter().map(|[r, g, b]| Vec4::new(r, g, b, 1.0)).collect());
        }
        self.vec4s(index, budget)
    }
}
