//! Which placed meshes share vertices, and where they are drawn.

use std::collections::HashMap;
use std::ops::Range;

use gnomon_scene::{Instance, Scene};
use gnomon_shaders::layout;

use super::{Geometry, address, over};
use crate::bindings::Binding;
use crate::{Gpu, RenderError};

/// Copies of a rigid mesh share its vertices where they would else be more than so many: few of them are cheaper in world space, where
/// they are drawn with everything else at once.
const MOST_COPIED: usize = 4096;

/// Of the transform that a placement is.
const PLACEMENT_BYTES: u64 = 64;

/// The placed meshes in the order in which they are drawn, and the bodies that they are: what has vertices of its own is a body.
pub(crate) struct Bodies {
    /// Those that are a body each, in world space, then copies that share one, side by side. One draw a material: instances of the same
    /// material lie side by side among both.
    pub placed: Vec<Instance>,
    /// Number of those that are a body each.
    pub own: usize,
    /// Of each body, which of `placed` it is.
    pub ranges: Vec<Range<usize>>,
}

impl Bodies {
    /// Of a scene.
    pub fn of(scene: &Scene) -> Self {
        let mesh_of = |instance: &Instance| address(&scene.meshes[instance.mesh.0]);
        let placed = scene.instances();
        let mut copies: HashMap<usize, (usize, usize)> = HashMap::new();
        let rigid = placed.iter().filter(|instance| !scene.is_deformable(instance));
        for (number, instance) in rigid.enumerate() {
            copies.entry(mesh_of(instance)).or_insert((number, 0)).1 += 1;
        }
        copies.retain(|_, (_, count)| *count > 1);
        let (mut shared, mut placed): (Vec<_>, Vec<_>) = placed.into_iter().partition(|instance| {
            let count = copies.get(&mesh_of(instance)).map_or(1, |(_, count)| *count);
            let vertices = scene.meshes[instance.mesh.0].positions.len();
            !scene.is_deformable(instance) && (count - 1) * vertices > MOST_COPIED
        });
        let material =
            |instance: &Instance| scene.meshes[instance.mesh.0].material.map(|material| material.0);
        placed.sort_by_key(material);
        shared.sort_by_key(|instance| (material(instance), copies.get(&mesh_of(instance))));
        let own = placed.len();
        let mut ranges: Vec<Range<usize>> = (0..own).map(|place| place..place + 1).collect();
        for (place, instance) in (own..).zip(&shared) {
            match ranges.last_mut() {
                Some(last) if place > own && mesh_of(&shared[last.start - own]) == mesh_of(instance) => {
                    last.end = place + 1;
                }
                _ => ranges.push(place..place + 1),
            }
        }
        placed.extend(shared);
        Self { placed, own, ranges }
    }

    /// An instance of each body.
    pub fn firsts(&self) -> Vec<Instance> {
        self.ranges.iter().map(|range| self.placed[range.start]).collect()
    }

    /// Number of the placement that one of `placed` is drawn at; 0 in world space.
    pub fn placement(&self, place: usize) -> u32 {
        (place + 1).saturating_sub(self.own) as u32
    }

    /// The transforms of all placements, to world space from the space that their vertices are drawn from.
    pub fn placements(&self) -> Vec<glam::Mat4> {
        let shared = self.placed[self.own..].iter().map(|instance| instance.world_from_mesh.into());
        std::iter::once(glam::Mat4::IDENTITY).chain(shared).collect()
    }
}

/// Triangles, and the placements that they are drawn at.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Draw {
    pub indices: Range<u32>,
    pub placements: Range<u32>,
}

impl Draw {
    /// Of triangles in world space.
    pub fn in_world(indices: Range<u32>) -> Self {
        Self { indices, placements: 0..1 }
    }
}

/// Layout of [`Geometry::placements_group`].
pub(crate) fn placements_layout(gpu: &Gpu) -> wgpu::BindGroupLayout {
    gpu.layout("placements", wgpu::ShaderStages::VERTEX, &[(0, Binding::Storage { read_only: true })])
}

/// Refuses more placements than draws can number: `materials` are those of the scene.
pub(super) fn check_count(gpu: &Gpu, bodies: &Bodies, materials: usize) -> Result<(), RenderError> {
    let wanted = bodies.placements().len() as u64;
    let draws = (materials as u64 + 1) * u64::from(layout::MAX_BATCH_LIGHTS);
    let draws = draws.max(bodies.own as u64 + 1);
    // A buffer has room for a few more.
    let most = (gpu.largest_storage() / PLACEMENT_BYTES).min(u64::from(u32::MAX) / draws).saturating_sub(4);
    if wanted > most.max(1) { Err(over(gpu, "copies of meshes", wanted, most)) } else { Ok(()) }
}

impl Geometry {
    /// The number of placements that instances of draws count by, see `placements.wgsl`.
    fn placement_count(&self) -> u32 {
        (self.placements.size() / PLACEMENT_BYTES) as u32
    }

    /// Instances of a draw, by the number that its shader knows it by.
    pub fn instances_of(&self, draw: u32, placements: &Range<u32>) -> Range<u32> {
        let first = draw * self.placement_count();
        first + placements.start..first + placements.end
    }

    /// Placements of copies, for [`layout::GROUP_PLACEMENTS`].
    pub fn placements_group(&self) -> &wgpu::BindGroup {
        &self.placements_group
    }

    /// The transforms themselves.
    pub fn placements(&self) -> &wgpu::Buffer {
        &self.placements
    }
}
