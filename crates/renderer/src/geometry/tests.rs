//! What of a scene is uploaded, and that nothing of it is missed.

use std::sync::Arc;

use glam::{Affine3A, Vec3};
use gnomon_scene::{Ground, MeshId, Node, builtin};

use super::*;
use crate::gpu::ReadBack;
use crate::recorder::{Clock, Recorder, new_encoder};
use crate::twins::gpu_or_skip;

/// A scene with a copy of its first mesh, as a mesh of its own.
fn with_one_more(scene: &Scene, x: f32) -> Scene {
    let mut more = scene.clone();
    more.meshes.push(Mesh::clone(&scene.meshes[0]).into());
    more.nodes.push(Node {
        meshes: vec![MeshId(more.meshes.len() - 1)],
        parent_from_node: Affine3A::from_translation(Vec3::X * x),
        ..Node::default()
    });
    more
}

/// What the passes draw: of every corner of every triangle in their order, place, normal, tangent and attributes.
fn drawn(gpu: &Gpu, pass: &TransformPass, geometry: &Geometry) -> Vec<[[u8; 16]; 5]> {
    let mut encoder = new_encoder(gpu);
    pass.encode(&mut Recorder::new(gpu, &mut encoder, Clock::Off), geometry);
    let mut read = |source: &wgpu::Buffer| {
        let usage = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
        let copy = gpu.empty_buffer("copy", source.size(), usage);
        encoder.copy_buffer_to_buffer(source, 0, &copy, 0, source.size());
        ReadBack::of_buffer(gpu, &encoder, copy)
    };
    let [positions, normals, tangents, attributes] = geometry.vertex_buffers().map(&mut read);
    let indices = read(&geometry.indices);
    gpu.queue.submit([encoder.finish()]);
    let bytes = |copy: ReadBack| -> Vec<u8> { gpu.wait_for(copy).unwrap() };
    let vectors = |copy: ReadBack| bytemuck::pod_collect_to_vec::<u8, [u8; 16]>(&bytes(copy));
    let (places, attributes) = ([positions, normals, tangents].map(vectors), vectors(attributes));
    let indices = bytemuck::pod_collect_to_vec::<u8, u32>(&bytes(indices));
    let last = geometry.boxes.iter().flat_map(|place| &place.simpler).map(|level| level.indices.end);
    let count = last.max().unwrap_or(0).max(geometry.index_count);
    let corner = |&index: &u32| {
        let at = index as usize;
        [places[0][at], places[1][at], places[2][at], attributes[2 * at], attributes[2 * at + 1]]
    };
    indices[..count as usize].iter().map(corner).collect()
}

fn uploaded<T>(gpu: &Gpu, work: impl FnOnce() -> T) -> (T, u64) {
    let before = gpu.uploaded_bytes();
    let made = work();
    (made, gpu.uploaded_bytes() - before)
}

#[test]
fn a_scene_with_one_more_mesh_uploads_and_works_out_that_mesh_alone() {
    let Some(gpu) = gpu_or_skip() else { return };
    let pass = TransformPass::new(&gpu).unwrap();
    let mut scene = builtin::by_name("terrain").unwrap();
    scene.add_ground(Ground::Plane);
    let build = |scene: &Scene, before| Geometry::new(&gpu, &pass, scene, before).unwrap();
    let (before, whole) = uploaded(&gpu, || build(&scene, None));
    let more = {
        let column = builtin::without_ground("column").unwrap();
        let mut more = scene.clone();
        more.append(column, Node::default());
        more
    };
    let (after, part) = uploaded(&gpu, || build(&more, Some(&before)));
    let own = &more.meshes[scene.meshes.len()..];
    let vertices: usize = own.iter().map(|mesh| mesh.positions.len()).sum();
    let triangles: usize = own.iter().map(|mesh| mesh.triangles.len()).sum();
    let simpler: usize =
        after.details.values().flat_map(|detail| &detail.simpler).map(|s| s.triangles.len()).sum();
    println!("{whole} bytes, then {part} for {vertices} vertices and {triangles} triangles");
    // Beside its vertices and triangles there are a table of instances, and a pose.
    let most = (48 + 32) * vertices + 12 * (triangles + simpler.min(triangles)) + 4096;
    assert!(part <= most as u64, "{part} of {most}");
    assert!(part < whole / 4, "{part} of {whole}");
    let shared = |(address, detail): &(&usize, &Arc<_>)| {
        before.details.get(address).is_some_and(|known| Arc::ptr_eq(known, detail))
    };
    assert_eq!(after.details.iter().filter(shared).count(), before.details.len());
}

#[test]
fn what_was_kept_is_drawn_as_what_is_uploaded_whole() {
    let Some(gpu) = gpu_or_skip() else { return };
    let pass = TransformPass::new(&gpu).unwrap();
    let scene = builtin::by_name("three-boxes").unwrap();
    let (more, most) = (with_one_more(&scene, 2.0), with_one_more(&with_one_more(&scene, 2.0), 4.0));
    let mut twice = more.clone();
    twice.nodes.push(Node { meshes: vec![MeshId(0)], ..Node::default() });
    let mut fewer = most.clone();
    fewer.nodes[0].meshes.clear();
    let other = builtin::by_name("column").unwrap();
    let mut before: Option<Geometry> = None;
    let mut was = Vec::new();
    // Growing, shrinking, in another order, from scratch, and back.
    for (step, scene) in
        [&scene, &more, &most, &fewer, &twice, &scene, &other, &scene].into_iter().enumerate()
    {
        let fresh = drawn(&gpu, &pass, &Geometry::new(&gpu, &pass, scene, None).unwrap());
        let next = Geometry::new(&gpu, &pass, scene, before.as_ref()).unwrap();
        assert!(drawn(&gpu, &pass, &next) == fresh, "step {step}");
        // A change that fails after all leaves no trace.
        if let Some(before) = &before {
            assert!(drawn(&gpu, &pass, before) == was, "step {step}: the geometry before");
        }
        (before, was) = (Some(next), fresh);
    }
}

#[test]
fn instances_that_come_and_go_do_not_fill_the_buffers() {
    let Some(gpu) = gpu_or_skip() else { return };
    let pass = TransformPass::new(&gpu).unwrap();
    let scene = builtin::by_name("three-boxes").unwrap();
    let mut geometry = Geometry::new(&gpu, &pass, &scene, None).unwrap();
    let count = |scene: &Scene| {
        let meshes =
            scene.instances().into_iter().map(|instance| scene.meshes[instance.mesh.0].positions.len());
        meshes.sum::<usize>() as f64
    };
    for step in 0..40 {
        let now = if step % 2 == 0 { with_one_more(&scene, step as f32) } else { scene.clone() };
        geometry = Geometry::new(&gpu, &pass, &now, Some(&geometry)).unwrap();
        assert!(f64::from(geometry.vertices.count()) <= 1.25 * count(&now), "step {step}");
        assert!(geometry.instances.size() <= 16 * 1024);
    }
}

#[test]
fn copies_take_the_room_of_one_mesh_and_their_places() {
    let Some(gpu) = gpu_or_skip() else { return };
    let pass = TransformPass::new(&gpu).unwrap();
    let mut scene = builtin::without_ground("terrain").unwrap();
    let node = scene.nodes.iter().find(|node| !node.meshes.is_empty()).unwrap().clone();
    let build = |scene: &Scene, before: Option<&Geometry>| Geometry::new(&gpu, &pass, scene, before).unwrap();
    let (mut geometry, one) = uploaded(&gpu, || build(&scene, None));
    for copies in [2, 1000, 3] {
        scene.nodes.truncate(1);
        for copy in 1..copies {
            let parent_from_node = Affine3A::from_translation(Vec3::X * copy as f32) * node.parent_from_node;
            scene.nodes.push(Node { parent_from_node, ..node.clone() });
        }
        let (next, more) = uploaded(&gpu, || build(&scene, Some(&geometry)));
        println!("{one} bytes, {more} for {copies} copies");
        assert!(more <= 64 * copies as u64 + 4096, "{more} bytes for {copies} copies");
        assert_eq!(next.vertices.count(), geometry.vertices.count());
        assert_eq!(next.boxes.len(), copies);
        let drawn: usize = next.ranges.iter().map(|range| range.placements.len()).sum();
        assert_eq!(drawn, copies);
        geometry = next;
    }
}

/// A device whose bindings hold so many bytes.
fn narrow_gpu(bytes: u64) -> Option<Gpu> {
    gpu_or_skip()?;
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::all()));
    let adapter = Gpu::choose_adapter(adapters, &Default::default()).unwrap();
    let mut descriptor = Gpu::device_descriptor(&adapter);
    descriptor.required_limits.max_storage_buffer_binding_size = bytes;
    let (device, queue) = pollster::block_on(adapter.request_device(&descriptor)).unwrap();
    Some(Gpu::from_wgpu(&adapter, device, queue).unwrap())
}

#[test]
fn a_mesh_that_no_binding_holds_is_drawn_as_any_other() {
    let Some(narrow) = narrow_gpu(1 << 16) else { return };
    let Some(wide) = gpu_or_skip() else { return };
    let mut scene = builtin::by_name("terrain").unwrap();
    scene.nodes[0].parent_from_node = Affine3A::from_rotation_y(0.7);
    let drawn = |gpu: &Gpu| {
        let pass = TransformPass::new(gpu).unwrap();
        let geometry = Geometry::new(gpu, &pass, &scene, None).unwrap();
        (geometry.windows.len(), drawn(gpu, &pass, &geometry))
    };
    let ((windows, one), (whole, other)) = (drawn(&narrow), drawn(&wide));
    assert!(windows > 3 && whole == 1, "{windows} windows, {whole}");
    assert!(one == other);
}
