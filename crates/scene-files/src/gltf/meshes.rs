//! Meshes (specification, section 3.7): every primitive becomes a [`Mesh`].

use std::collections::HashMap;
use std::sync::Arc;

use glam::Vec3;
use gnomon_scene::{MaterialId, Mesh, MeshId, MorphTarget, Scene};

use super::accessors::Accessors;
use super::attributes::Attributes;
use super::materials::{self, CoordinateSets};
use super::schema::{Int, MeshEntry, Primitive, Root};
use super::{Budget, Fault, get, skins};
use crate::geometry;

/// The meshes of a file, each read when a node first uses it.
pub struct Meshes<'a> {
    root: &'a Root,
    accessors: &'a Accessors<'a>,
    /// By material.
    sets: &'a [CoordinateSets],
    /// Number of the material variant that is shown, where one is.
    variant: Option<usize>,
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
    pub fn new(
        root: &'a Root,
        accessors: &'a Accessors<'a>,
        sets: &'a [CoordinateSets],
        variant: Option<usize>,
    ) -> Self {
        let targets = |mesh: &MeshEntry| mesh.primitives.iter().map(|p| p.targets.len()).max().unwrap_or(0);
        let targets = root.meshes.iter().map(targets).collect();
        Self { root, accessors, sets, variant, known: HashMap::new(), targets, unnamed_material: None }
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
            let material = self.material_of(primitive);
            if let Some(material) = material {
                get(&self.root.materials, material, "material", &name)?;
            }
            let sets = material.map_or(materials::DEFAULT_SETS, |material| self.sets[material]);
            let Some(mut raw) = self.primitive(primitive, sets, &name, budget, &mut scene.warnings)? else {
                continue;
            };
            let last = raw.influences.entries.iter().map(|&(joint, _)| (joint, number)).max();
            known.last_joint = known.last_joint.max(last);
            let material = match material {
                Some(material) => MaterialId(material),
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

    /// The material of a primitive in the variant that is shown (`KHR_materials_variants`).
    fn material_of(&self, primitive: &Primitive) -> Option<usize> {
        let mappings = primitive.extensions.variants.iter().flat_map(|variants| &variants.mappings);
        let is_shown =
            |variants: &[Int]| self.variant.is_some_and(|variant| variants.contains(&Int(variant)));
        let mut mapped =
            mappings.filter(|mapping| is_shown(&mapping.variants)).filter_map(|mapping| mapping.material);
        mapped.next_back().or(primitive.material).map(|material| material.0)
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
        sets: CoordinateSets,
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
        let Some(attributes) = Attributes::new(primitive, self.accessors, name, budget)? else {
            warnings.push(format!("{name} has no positions and is left out"));
            return Ok(None);
        };
        let [first, second] = sets.map(|set| format!("TEXCOORD_{set}"));
        let mut mesh = Mesh {
            positions: attributes.vec3s("POSITION", budget)?,
            normals: attributes.vec3s("NORMAL", budget)?,
            tangents: attributes.vec4s("TANGENT", budget)?,
            uvs: [attributes.vec2s(&first, budget)?, attributes.vec2s(&second, budget)?],
            colors: attributes.colors(budget, warnings)?,
            influences: skins::influences(&attributes, budget, warnings)?,
            ..Mesh::default()
        };
        for target in &primitive.targets {
            let offsets = |semantic: &str, budget: &mut Budget| match target.get(semantic) {
                Some(&Int(accessor)) => self.offsets(accessor, &attributes, budget),
                None => Ok(Vec::new()),
            };
            budget.take(1, size_of::<MorphTarget>())?;
            mesh.targets.push(MorphTarget {
                positions: offsets("POSITION", budget)?,
                normals: offsets("NORMAL", budget)?,
                tangents: offsets("TANGENT", budget)?,
            });
        }
        let mode = if attributes.is_list() { 4 } else { mode };
        mesh.triangles = triangles(&attributes, mode, budget, warnings)?;
        Ok(Some(mesh))
    }

    /// Offsets of a morph target, which are never compressed.
    fn offsets(
        &self,
        accessor: usize,
        attributes: &Attributes,
        budget: &mut Budget,
    ) -> Result<Vec<Vec3>, Fault> {
        let offsets = self.accessors.floats(accessor, attributes.name, budget)?;
        if offsets.len() != attributes.count {
            let (name, count, wanted) = (attributes.name, offsets.len(), attributes.count);
            return Err(Fault::Invalid(format!(
                "{name}: accessor {accessor} has {count} elements, not {wanted}"
            )));
        }
        Ok(offsets.into_iter().map(Vec3::from_array).collect())
    }
}

fn triangles(
    attributes: &Attributes,
    mode: usize,
    budget: &mut Budget,
    warnings: &mut Vec<String>,
) -> Result<Vec<[u32; 3]>, Fault> {
    let Attributes { name, count, .. } = *attributes;
    let indices = attributes.indices(budget)?;
    if let Some(index) = indices.iter().find(|&&index| index as usize >= count) {
        return Err(Fault::Invalid(format!("{name} refers to vertex {index}, but there are {count}")));
    }
    budget.take(indices.len(), geometry::TRIANGLE_BYTES)?;
    let windows = indices.windows(3);
    // Section 3.7.2.1, the order of vertices for each mode.
    Ok(match mode {
        4 => {
            if !indices.len().is_multiple_of(3) {
                warnings.push(format!("{name}: {} indices make no whole number of triangles", indices.len()));
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
