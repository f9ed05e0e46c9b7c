//! The scene as rays see it: hierarchies of boxes around its triangles, brought to where the vertices are every time they move.
//!
//! Every mesh has a hierarchy of its own, built once on the CPU; every body has a copy of it, whose boxes follow the vertices on the GPU, so
//! that deformation costs no more than a placement. Copies of a mesh that share vertices share that too, and rays are taken to its space;
//! where edges are needed, each has its own in world space. Above them is one around the instances, built anew with every pose: what moves
//! apart does not spoil it.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use glam::{Affine3A, Mat4};
use gnomon_scene::{Bounds, Mesh};
use gnomon_shaders::layout;
use rayon::prelude::*;

use crate::bindings::Binding;
use crate::casters::PlacedBoxes;
use crate::geometry::{Geometry, PlacedMesh};
use crate::materials::Materials;
use crate::recorder::Recorder;
use crate::{Gpu, RenderError};

pub(crate) mod edges;
mod hierarchy;
mod hits;
mod micromap;

use edges::{EdgeParts, EdgeScene, EdgesOfMeshes, Shared, dispatch, edges_of_meshes};
use hierarchy::Hierarchy;
pub(crate) use hits::HitSurfaces;
pub(crate) use micromap::Micromaps;

/// Bytes of a triangle on the GPU.
const TRIANGLE_BYTES: u64 = 48;

/// Of a vertex in world space.
const VERTEX_BYTES: u64 = 16;

/// Of the transforms of a copy.
const COPY_BYTES: u64 = 7 * 16;

/// Whether an adapter holds the triangles of a scene for rays.
pub(crate) fn has_room_for(gpu: &Gpu, geometry: &Geometry) -> bool {
    let largest = gpu.largest_storage();
    let vertices = u64::from(geometry.vertex_count()) * VERTEX_BYTES;
    u64::from(geometry.index_count / 3) * TRIANGLE_BYTES <= largest && vertices <= largest
}

/// Brings boxes to the vertices.
pub(crate) struct RefitPass {
    layout: wgpu::BindGroupLayout,
    leaves: wgpu::ComputePipeline,
    nodes: wgpu::ComputePipeline,
}

impl RefitPass {
    pub fn new(gpu: &Gpu) -> Result<Self, RenderError> {
        let read = Binding::Storage { read_only: true };
        let write = Binding::Storage { read_only: false };
        let bindings = [
            (0, read),
            (1, read),
            (2, read),
            (3, write),
            (4, write),
            (5, Binding::Uniform),
            (6, read),
            (7, read),
        ];
        let layout = gpu.layout("ray refit", wgpu::ShaderStages::COMPUTE, &bindings);
        let shader = gpu.shader("ray_refit", &[])?;
        let pipeline = |entry| gpu.compute_pipeline(&shader, entry, &[(layout::GROUP_PASS, &layout)]);
        Ok(Self { leaves: pipeline("refit_leaves"), nodes: pipeline("refit_nodes"), layout })
    }
}

/// Hierarchies on the GPU.
pub(crate) struct RayScene {
    /// [`layout::RayNode`]s: the upper level, then every instance's.
    pub nodes: wgpu::Buffer,
    /// Triangles, micromaps and copies, see `ray_scene.wgsl`.
    pub triangles: wgpu::Buffer,
    /// What rays meet, where somebody asks.
    pub hits: Option<HitSurfaces>,
    /// Those that have triangles.
    instances: Vec<RayInstance>,
    /// Where their transforms begin among `triangles`, in 16 bytes.
    first_copy: u32,
    /// From the lowest nodes to the highest.
    levels: Vec<Level>,
    /// By the address of their mesh, which is kept from being used for another.
    hierarchies: HashMap<usize, (Arc<Mesh>, Arc<Hierarchy>)>,
    /// Where a technique needs them.
    pub edges: Option<EdgeScene>,
    edges_of_meshes: EdgesOfMeshes,
    is_stale: bool,
}

/// An instance.
struct RayInstance {
    /// Place in the geometry.
    number: usize,
    /// The first of its nodes.
    first_node: u32,
    /// Number of its transform, where its nodes are others' as well.
    copy: Option<u32>,
}

/// Nodes that are all as high.
struct Level {
    count: u32,
    group: wgpu::BindGroup,
}

impl RayScene {
    /// Of a geometry, with the surfaces that rays meet where their materials are given, and with edges where they are needed. Hierarchies that
    /// `before` has of the same meshes, by their `Arc`, are not built again.
    ///
    /// # Errors
    /// [`RenderError::OverLimit`] for more triangles or nodes than a buffer holds.
    pub fn new(
        gpu: &Gpu,
        pass: &RefitPass,
        geometry: &Geometry,
        materials: Option<&Materials>,
        before: Option<&Self>,
        has_edges: bool,
    ) -> Result<Self, RenderError> {
        let casting = geometry.placed_meshes().enumerate().filter(|(_, place)| place.casts);
        let (numbers, placed): (Vec<usize>, Vec<PlacedMesh<'_>>) = casting.unzip();
        let hierarchies = hierarchies(&placed, before);
        let of = |mesh: &Arc<Mesh>| &hierarchies[&address(mesh)].1;
        // What has nodes of its own.
        let mut seen = HashSet::new();
        let is_first: Vec<bool> = placed.iter().map(|place| has_edges || seen.insert(place.body)).collect();
        let with_own = || placed.iter().zip(&is_first).filter(|(_, first)| **first).map(|(place, _)| place);
        let known = before.map(|before| &before.edges_of_meshes);
        let edges_of_meshes = if has_edges { edges_of_meshes(&placed, known) } else { EdgesOfMeshes::new() };
        let mut edge_parts = EdgeParts::default();
        let top_count = (2 * placed.len()).max(1);
        let node_count = top_count + with_own().map(|place| of(place.mesh).nodes.len()).sum::<usize>();
        let triangle_count: usize = with_own().map(|place| place.mesh.triangles.len()).sum();
        let largest = gpu.largest_storage();
        let most = (largest / TRIANGLE_BYTES).min(u64::from(u32::MAX / layout::RAY_LEAF));
        let most_nodes = (largest / layout::size::<layout::RayNode>()).min(most);
        if triangle_count as u64 > most || node_count as u64 > most_nodes {
            return Err(RenderError::OverLimit {
                what: "triangles for rays",
                wanted: triangle_count as u64,
                limit: most.min(most_nodes),
                adapter: gpu.adapter().name.clone(),
            });
        }

        let vertices = u64::from(geometry.vertex_count());
        if vertices * VERTEX_BYTES > largest {
            return Err(RenderError::OverLimit {
                what: "vertices for rays",
                wanted: vertices,
                limit: largest / VERTEX_BYTES,
                adapter: gpu.adapter().name.clone(),
            });
        }

        let mut nodes = vec![layout::RayNode::default(); top_count];
        let mut indices: Vec<[u32; 4]> = Vec::with_capacity(triangle_count);
        let mut micromap_words: Vec<u32> = Vec::new();
        let mut micromaps: HashMap<*const Micromaps, u32> = HashMap::new();
        let mut instances = Vec::with_capacity(placed.len());
        let mut by_height: Vec<Vec<u32>> = Vec::new();
        let mut leaf_placements: Vec<u32> = Vec::new();
        let (mut first_nodes, mut copies) = (HashMap::new(), 0);
        let mut hits = materials.map(hits::HitTriangles::of);
        let mut placed_triangles = Vec::with_capacity(placed.len());
        for ((&number, place), is_first) in numbers.iter().zip(&placed).zip(is_first) {
            let hierarchy = of(place.mesh);
            let copy = (place.placement > 0 && !has_edges).then_some(copies);
            copies += u32::from(copy.is_some());
            if !is_first {
                let first_node = first_nodes.get(&place.body).copied();
                instances.extend(first_node.map(|first_node| RayInstance { number, first_node, copy }));
                continue;
            }
            placed_triangles.push((hierarchy.order.as_slice(), indices.len() as u32));
            if hierarchy.nodes.is_empty() {
                continue;
            }
            let (first_node, first_triangle) = (nodes.len() as u32, indices.len() as u32);
            first_nodes.insert(place.body, first_node);
            instances.push(RayInstance { number, first_node, copy });
            nodes.extend(hierarchy.nodes.iter().map(|node| layout::RayNode {
                skip: first_node + node.skip,
                members: match node.count {
                    0 => 0,
                    count => (first_triangle + node.first) * layout::RAY_LEAF + count,
                },
                ..Default::default()
            }));
            for (i, height) in (first_node..).zip(hierarchy.heights()) {
                let height = height as usize;
                if by_height.len() <= height {
                    by_height.resize_with(height + 1, Vec::new);
                }
                by_height[height].push(i);
                if height == 0 {
                    leaf_placements.push(if has_edges { place.placement } else { 0 });
                }
            }
            let micromap = place.micromaps.map(|maps| {
                let first = *micromaps.entry(std::ptr::from_ref(maps)).or_insert_with(|| {
                    let first = micromap_words.len() as u32 / 4;
                    for words in maps.words.chunks(maps.words_each() as usize) {
                        micromap_words.extend([maps.divisions, maps.bits, 0, 0]);
                        micromap_words.extend(words);
                    }
                    first
                });
                (3 * triangle_count as u32 + first, maps.words_each() / 4 + 1)
            });
            if let Some(hits) = &mut hits {
                hits.add(place, &hierarchy.order);
            }
            indices.extend(hierarchy.order.iter().map(|&triangle| {
                let [a, b, c] =
                    place.mesh.triangles[triangle as usize].map(|index| place.first_vertex + index);
                [a, b, c, micromap.map_or(0, |(first, each)| first + each * triangle)]
            }));
        }

        let edge_top = nodes.len() as u32;
        if has_edges {
            nodes.resize(nodes.len() + top_count, layout::RayNode::default());
            for ((&number, place), triangles) in numbers.iter().zip(&placed).zip(placed_triangles) {
                let of_mesh = edges_of_meshes.get(&address(place.mesh)).map(Arc::as_ref);
                let of_mesh = of_mesh.filter(|_| place.micromaps.is_none());
                edge_parts.push((number, place.name), of_mesh, triangles, &mut nodes);
            }
        }
        let edge_nodes = [edge_top, edge_top + top_count as u32, nodes.len() as u32];
        if nodes.len() as u64 > most_nodes {
            return Err(RenderError::OverLimit {
                what: "boxes around edges",
                wanted: nodes.len() as u64,
                limit: most_nodes,
                adapter: gpu.adapter().name.clone(),
            });
        }

        let storage = wgpu::BufferUsages::STORAGE;
        let copied = storage | wgpu::BufferUsages::COPY_DST;
        let micromap_offset = TRIANGLE_BYTES * triangle_count as u64;
        let copy_offset = micromap_offset + 4 * micromap_words.len() as u64;
        let bytes = copy_offset + COPY_BYTES * u64::from(copies);
        if bytes > largest {
            return Err(RenderError::OverLimit {
                what: "bytes of triangles and alpha for rays",
                wanted: bytes,
                limit: largest,
                adapter: gpu.adapter().name.clone(),
            });
        }
        let triangles = gpu.empty_buffer("ray triangles", bytes, copied);
        gpu.write_bytes(&triangles, 0, bytemuck::cast_slice(&edge_parts.triangle_words()));
        gpu.write_bytes(&triangles, micromap_offset, bytemuck::cast_slice(&micromap_words));
        let nodes = gpu.shared_buffer("ray nodes", nodes.as_slice(), copied);
        let indices = gpu.buffer_with("ray indices", bytemuck::cast_slice(&indices), storage);
        let mut first = leaf_placements.len() as u32;
        let order = [leaf_placements, by_height.concat()].concat();
        let order = gpu.buffer_with("ray nodes by height", bytemuck::cast_slice(&order), storage);
        let [positions_world, normals_world, ..] = geometry.vertex_buffers();
        let placements = geometry.placements();
        let level = |members: &Vec<u32>| {
            let count = members.len() as u32;
            let range = [first, first + count];
            first += count;
            let range = gpu.buffer_with("ray level", bytemuck::bytes_of(&range), wgpu::BufferUsages::UNIFORM);
            let buffers =
                [positions_world, &indices, &order, &nodes, &triangles, &range, normals_world, placements];
            let resources: Vec<_> =
                (0..).zip(buffers).map(|(number, buffer)| (number, buffer.as_entire_binding())).collect();
            Level { count, group: gpu.bind_group("ray refit", &pass.layout, &resources) }
        };
        let levels = by_height.iter().map(level).collect();
        let hits = hits.map(|hits| hits.upload(gpu)).transpose()?;
        let shared = Shared {
            positions_world,
            normals_world,
            indices: &indices,
            nodes: &nodes,
            triangles: &triangles,
            placements,
        };
        let edges = match has_edges {
            true => Some(EdgeScene::new(gpu, pass, edge_parts, &shared, edge_nodes)?),
            false => None,
        };
        Ok(Self {
            nodes,
            triangles,
            hits,
            instances,
            first_copy: (copy_offset / 16) as u32,
            levels,
            hierarchies,
            edges,
            edges_of_meshes,
            is_stale: true,
        })
    }

    /// Vertices are elsewhere from now on.
    pub fn moved(&mut self) {
        self.is_stale = true;
    }

    /// Brings everything to where the frame's vertices are, unless nothing has moved since.
    pub fn encode(&mut self, gpu: &Gpu, recorder: &mut Recorder<'_>, pass: &RefitPass, geometry: &Geometry) {
        if !std::mem::take(&mut self.is_stale) {
            return;
        }
        let bounds = bounds_of_instances(&geometry.placed_boxes);
        let members = self.instances.iter().map(|instance| {
            let member = match instance.copy {
                Some(copy) => self.copy_at(copy) * layout::RAY_LEAF + layout::RAY_COPY,
                None => instance.first_node * layout::RAY_LEAF + layout::RAY_INSTANCE,
            };
            (instance.number, member)
        });
        gpu.write(&self.nodes, upper_level(members, &bounds, 0).as_slice());
        gpu.write_bytes(&self.triangles, 16 * u64::from(self.first_copy), &self.copies(geometry));
        for (height, level) in self.levels.iter().enumerate() {
            // Each level reads what the one before it wrote.
            let mut compute = recorder.encoder.begin_compute_pass(&Default::default());
            compute.set_pipeline(if height == 0 { &pass.leaves } else { &pass.nodes });
            compute.set_bind_group(layout::GROUP_PASS, &level.group, &[]);
            dispatch(&mut compute, level.count);
        }
        if let Some(edges) = &self.edges {
            let first = edges.counts.first_node;
            let instance =
                |&(number, node): &(usize, u32)| (number, node * layout::RAY_LEAF + layout::RAY_INSTANCE);
            let nodes = upper_level(edges.instances.iter().map(instance), &bounds, first);
            let offset = u64::from(first) * layout::size::<layout::RayNode>();
            gpu.write_bytes(&self.nodes, offset, &layout::bytes(nodes.as_slice()));
            edges.refit(recorder, pass);
        }
    }
}

impl RayScene {
    /// Where the transform of a copy begins, see `ray_scene.wgsl`.
    fn copy_at(&self, copy: u32) -> u32 {
        self.first_copy + copy * (COPY_BYTES / 16) as u32
    }

    /// What is there of every copy: rows of the transforms to its mesh and back, and the first of its nodes.
    fn copies(&self, geometry: &Geometry) -> Vec<u8> {
        let copied = self.instances.iter().filter(|instance| instance.copy.is_some());
        let of_copy = |instance: &RayInstance| {
            let world_from_mesh = geometry.world_from_mesh(instance.number);
            let rows = |transform: Affine3A| {
                let matrix = Mat4::from(transform);
                [0, 1, 2].map(|row| matrix.row(row).to_array().map(f32::to_bits))
            };
            let [a, b, c] = rows(world_from_mesh.inverse());
            let [d, e, f] = rows(world_from_mesh);
            [a, b, c, d, e, f, [instance.first_node, 0, 0, 0]]
        };
        let words: Vec<[[u32; 4]; 7]> = copied.map(of_copy).collect();
        bytemuck::cast_slice(&words).to_vec()
    }
}

/// Around every instance that has triangles.
fn bounds_of_instances(placed: &PlacedBoxes) -> HashMap<usize, Bounds> {
    let mut boxes: HashMap<usize, Bounds> = HashMap::new();
    for place in &placed.boxes {
        let Some(around) = Bounds::around(place.corners) else { continue };
        let joined = boxes.entry(place.instance).or_insert(around);
        *joined = Bounds { min: joined.min.min(around.min), max: joined.max.max(around.max) };
    }
    boxes
}

/// Nodes around instances, of which the numbers and what leads to them are given, to lie from the node `base` on.
fn upper_level(
    instances: impl Iterator<Item = (usize, u32)>,
    bounds: &HashMap<usize, Bounds>,
    base: u32,
) -> Vec<layout::RayNode> {
    let (members, boxes): (Vec<u32>, Vec<Bounds>) =
        instances.filter_map(|(number, member)| Some((member, *bounds.get(&number)?))).unzip();
    let hierarchy = Hierarchy::new(&boxes, 1);
    let node = |node: &hierarchy::Node| {
        // Boxes of placed meshes round as vertices do.
        let padding = 1e-6 * node.bounds.min.abs().max(node.bounds.max.abs());
        layout::RayNode {
            low: node.bounds.min - padding,
            skip: base + node.skip,
            high: node.bounds.max + padding,
            members: match node.count {
                0 => 0,
                _ => members[hierarchy.order[node.first as usize] as usize],
            },
        }
    };
    let mut nodes: Vec<_> = hierarchy.nodes.iter().map(node).collect();
    if nodes.is_empty() {
        // A box that no ray meets.
        let (low, high) = (glam::Vec3::MAX, glam::Vec3::MIN);
        nodes.push(layout::RayNode { low, skip: base + 1, high, members: 0 });
    }
    nodes
}

fn address(mesh: &Arc<Mesh>) -> usize {
    Arc::as_ptr(mesh) as usize
}

/// By the address of their mesh.
fn hierarchies(
    placed: &[PlacedMesh<'_>],
    before: Option<&RayScene>,
) -> HashMap<usize, (Arc<Mesh>, Arc<Hierarchy>)> {
    let meshes: HashMap<usize, &Arc<Mesh>> =
        placed.iter().map(|place| (address(place.mesh), place.mesh)).collect();
    let hierarchy = |(address, mesh): (usize, &Arc<Mesh>)| {
        let known =
            before.and_then(|before| before.hierarchies.get(&address)).map(|(_, known)| known.clone());
        let made = || Arc::new(Hierarchy::of_triangles(&mesh.positions, &mesh.triangles));
        (address, (Arc::clone(mesh), known.unwrap_or_else(made)))
    };
    meshes.into_par_iter().map(hierarchy).collect()
}
