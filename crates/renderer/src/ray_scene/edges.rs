//! Edges between the triangles that rays meet, with a hierarchy of boxes of their own.

use std::collections::HashMap;
use std::sync::Arc;

use gnomon_scene::edges::{MeshEdges, SurfaceKind, Wing};
use gnomon_scene::{Bounds, Mesh};
use gnomon_shaders::layout;
use rayon::prelude::*;

use super::hierarchy::Hierarchy;
use super::{RefitPass, address};
use crate::Gpu;
use crate::bindings::Binding;
use crate::geometry::PlacedMesh;
use crate::recorder::Recorder;

/// Most edges of a leaf.
const MOST_IN_LEAF: usize = 4;

/// A mesh's edges, and boxes around them.
pub(super) struct EdgesOfMesh {
    edges: MeshEdges,
    hierarchy: Hierarchy,
}

impl EdgesOfMesh {
    fn new(mesh: &Mesh) -> Self {
        let edges = mesh.edges();
        let place = |wing: &Wing, next: u32| {
            let vertex = mesh.triangles[wing.triangle as usize][((wing.corner + next) % 3) as usize];
            mesh.positions[vertex as usize]
        };
        let around = |wing: &Wing| {
            let (from, to) = (place(wing, 0), place(wing, 1));
            Bounds { min: from.min(to), max: from.max(to) }
        };
        let boxes: Vec<Bounds> = edges.edges.iter().map(|edge| around(&edge.first)).collect();
        Self { hierarchy: Hierarchy::new(&boxes, MOST_IN_LEAF), edges }
    }
}

/// By the address of their mesh.
pub(super) type EdgesOfMeshes = HashMap<usize, Arc<EdgesOfMesh>>;

/// Of meshes without holes by masks: nothing tells where the edges of holes are.
pub(super) fn edges_of_meshes(placed: &[PlacedMesh<'_>], known: Option<&EdgesOfMeshes>) -> EdgesOfMeshes {
    let whole = placed.iter().filter(|place| place.micromaps.is_none());
    let meshes: HashMap<usize, &Arc<Mesh>> = whole.map(|place| (address(place.mesh), place.mesh)).collect();
    let edges = |(address, mesh): (usize, &Arc<Mesh>)| {
        let known = known.and_then(|known| known.get(&address)).cloned();
        (address, known.unwrap_or_else(|| Arc::new(EdgesOfMesh::new(mesh))))
    };
    meshes.into_par_iter().map(edges).collect()
}

/// Edges of all instances, in the making.
#[derive(Default)]
pub(super) struct EdgeParts {
    edges: Vec<[u32; 2]>,
    by_height: Vec<Vec<u32>>,
    pub instances: Vec<(usize, u32)>,
    /// Of every triangle, SIDE constants.
    sides: Vec<u32>,
    faults: Vec<String>,
}

impl EdgeParts {
    /// Adds those of an instance, by its number among placed meshes and its name. `order` are the mesh's triangles as rays have them from `first_triangle` on.
    pub fn push(
        &mut self,
        (number, name): (usize, &str),
        of_mesh: Option<&EdgesOfMesh>,
        (order, first_triangle): (&[u32], u32),
        nodes: &mut Vec<layout::RayNode>,
    ) {
        let Some(EdgesOfMesh { edges, hierarchy }) = of_mesh else {
            self.sides.extend(order.iter().map(|_| 0));
            return;
        };
        let side = |triangle: &u32| {
            let side = edges.sides[*triangle as usize];
            let sheet = if side.kind == SurfaceKind::Sheet { layout::SIDE_SHEET } else { 0 };
            sheet | if side.is_turned { layout::SIDE_TURNED } else { 0 }
        };
        self.sides.extend(order.iter().map(side));
        let fault = format!("shadows of {name}: {}", edges.faults);
        if !edges.faults.is_none() && !self.faults.contains(&fault) {
            self.faults.push(fault);
        }
        if hierarchy.nodes.is_empty() {
            return;
        }
        let mut places = vec![0; order.len()];
        for (place, &triangle) in (first_triangle..).zip(order) {
            places[triangle as usize] = place;
        }
        let (first_edge, first_node) = (self.edges.len() as u32, nodes.len() as u32);
        self.edges.extend(hierarchy.order.iter().map(|&edge| {
            let edge = edges.edges[edge as usize];
            let wing = |wing: Wing| 4 * places[wing.triangle as usize];
            let second =
                edge.second.map_or(layout::NO_WING, |second| wing(second) + u32::from(edge.same_sense));
            [wing(edge.first) + edge.first.corner, second]
        }));
        self.instances.push((number, first_node));
        nodes.extend(hierarchy.nodes.iter().map(|node| layout::RayNode {
            skip: first_node + node.skip,
            members: match node.count {
                0 => 0,
                count => (first_edge + node.first) * layout::RAY_LEAF + count,
            },
            ..Default::default()
        }));
        for (i, height) in (first_node..).zip(hierarchy.heights()) {
            let height = height as usize;
            if self.by_height.len() <= height {
                self.by_height.resize_with(height + 1, Vec::new);
            }
            self.by_height[height].push(i);
        }
    }

    /// Words that stand with the corners of triangles ([`layout::SIDE_TURNED`] and [`layout::SIDE_SHEET`] with the third one), to be
    /// there before corners are.
    pub fn triangle_words(&self) -> Vec<u32> {
        self.sides
            .iter()
            .flat_map(|&side| [0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, side << layout::SIDE_SHIFT])
            .collect()
    }
}

/// Nodes that are all as high.
pub(crate) struct EdgeLevel {
    pub count: u32,
    /// The first of them in [`EdgeScene::by_height`] and the one after the last.
    pub range: wgpu::Buffer,
    group: wgpu::BindGroup,
}

/// Edges on the GPU.
pub(crate) struct EdgeScene {
    /// See `edges.wgsl`.
    pub edges: wgpu::Buffer,
    /// Nodes around edges, the lowest first.
    pub by_height: wgpu::Buffer,
    /// From the lowest nodes to the highest.
    pub levels: Vec<EdgeLevel>,
    /// What marks are for; [`layout::SilhouetteCounts::words`] is left open.
    pub counts: layout::SilhouetteCounts,
    pub node_count: u32,
    /// Of meshes whose shadows are not exact: which, and why.
    pub faults: Vec<String>,
    pub(super) instances: Vec<(usize, u32)>,
    leaves: wgpu::ComputePipeline,
}

/// Buffers that edges and triangles share.
pub(super) struct Shared<'a> {
    pub positions_world: &'a wgpu::Buffer,
    pub normals_world: &'a wgpu::Buffer,
    pub indices: &'a wgpu::Buffer,
    pub nodes: &'a wgpu::Buffer,
    pub triangles: &'a wgpu::Buffer,
    pub placements: &'a wgpu::Buffer,
}

impl EdgeScene {
    /// Nodes around instances begin at `first_node`, those around edges at `first_marked`.
    pub(super) fn new(
        gpu: &Gpu,
        pass: &RefitPass,
        parts: EdgeParts,
        shared: &Shared<'_>,
        [first_node, first_marked, node_end]: [u32; 3],
    ) -> Result<Self, crate::RenderError> {
        let storage = wgpu::BufferUsages::STORAGE;
        let edges = gpu.buffer_with("edges", bytemuck::cast_slice(&parts.edges), storage);
        let by_height =
            gpu.buffer_with("edge nodes by height", bytemuck::cast_slice(&parts.by_height.concat()), storage);
        let read = Binding::Storage { read_only: true };
        let write = Binding::Storage { read_only: false };
        let bindings = [(0, read), (1, read), (2, read), (3, write), (4, Binding::Uniform)];
        let leaf_layout = gpu.layout("edge refit", wgpu::ShaderStages::COMPUTE, &bindings);
        let mut first = 0;
        let level = |(height, members): (usize, &Vec<u32>)| {
            let count = members.len() as u32;
            let range = [first, first + count];
            first += count;
            let range =
                gpu.buffer_with("edge level", bytemuck::bytes_of(&range), wgpu::BufferUsages::UNIFORM);
            let group = |layout, buffers: &[&wgpu::Buffer]| {
                let resources: Vec<_> =
                    (0..).zip(buffers).map(|(number, buffer)| (number, buffer.as_entire_binding())).collect();
                gpu.bind_group("edge refit", layout, &resources)
            };
            let Shared { positions_world, normals_world, indices, nodes, triangles, placements } = *shared;
            let group = match height {
                0 => group(&leaf_layout, &[triangles, &edges, &by_height, nodes, &range]),
                _ => {
                    let buffers = [
                        positions_world,
                        indices,
                        &by_height,
                        nodes,
                        triangles,
                        &range,
                        normals_world,
                        placements,
                    ];
                    group(&pass.layout, &buffers)
                }
            };
            EdgeLevel { count, range, group }
        };
        let levels = parts.by_height.iter().enumerate().map(level).collect();
        let shader = gpu.shader("edge_refit", &[])?;
        Ok(Self {
            counts: layout::SilhouetteCounts {
                triangles: parts.sides.len() as u32,
                edges: parts.edges.len() as u32,
                first_node,
                first_marked,
                words: 0,
            },
            node_count: node_end - first_marked,
            leaves: gpu.compute_pipeline(&shader, "refit_edge_leaves", &[(layout::GROUP_PASS, &leaf_layout)]),
            edges,
            by_height,
            levels,
            faults: parts.faults,
            instances: parts.instances,
        })
    }

    /// Brings boxes to where triangles are.
    pub(super) fn refit(&self, recorder: &mut Recorder<'_>, pass: &RefitPass) {
        for (height, level) in self.levels.iter().enumerate() {
            let mut compute = recorder.encoder.begin_compute_pass(&Default::default());
            compute.set_pipeline(if height == 0 { &self.leaves } else { &pass.nodes });
            compute.set_bind_group(layout::GROUP_PASS, &level.group, &[]);
            dispatch(&mut compute, level.count);
        }
    }
}

/// An invocation for each of so many.
pub(crate) fn dispatch(pass: &mut wgpu::ComputePass<'_>, count: u32) {
    let groups = count.div_ceil(layout::RAY_WORKGROUP);
    let x = groups.min(1024);
    pass.dispatch_workgroups(x, groups.div_ceil(x.max(1)), 1);
}
