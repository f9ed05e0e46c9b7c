//! Vertices that the GPU deforms against those of the CPU, read back.

use glam::{Affine3A, Quat, Vec3, Vec4};
use gnomon_scene::{Influences, Mesh, MeshId, MorphTarget, Node, NodeId, Scene, Skin, SkinId};
use gnomon_scene_files::{LoadOptions, load};
use gnomon_testing::tolerances::GPU_POSE_ERROR;

use crate::Gpu;
use crate::geometry::{Bodies, Geometry, TransformPass};
use crate::gpu::ReadBack;
use crate::recorder::{Clock, Recorder, new_encoder};
use crate::twins::gpu_or_skip;

/// What the transform pass wrote: positions, normals, tangents.
fn on_gpu(gpu: &Gpu, pass: &TransformPass, geometry: &Geometry, count: usize) -> [Vec<Vec4>; 3] {
    let size = 16 * count as u64;
    let mut encoder = new_encoder(gpu);
    pass.encode(&mut Recorder::new(gpu, &mut encoder, Clock::Off), geometry);
    let [positions, normals, tangents, _] = geometry.vertex_buffers();
    let sources = [positions, normals, tangents];
    let copies = sources.map(|source| {
        let usage = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
        let copy = gpu.empty_buffer("copy", size, usage);
        encoder.copy_buffer_to_buffer(source, 0, &copy, 0, size);
        ReadBack::of_buffer(gpu, &encoder, copy)
    });
    gpu.queue.submit([encoder.finish()]);
    copies.map(|copy| {
        let bytes = gpu.wait_for(copy).unwrap();
        bytemuck::pod_collect_to_vec::<u8, Vec4>(&bytes)[..count].to_vec()
    })
}

/// Largest errors of positions (over the scene's size) and of directions, and the number of vertices that are outside of
/// their instance's box. Tangents are compared up to their length.
fn compare(gpu: &Gpu, pass: &TransformPass, geometry: &Geometry, scene: &Scene) -> (f32, f32, usize) {
    let pose = scene.pose();
    let placed = Bodies::of(scene).placed;
    let wanted: Vec<_> = placed.iter().map(|instance| scene.world_vertices(&pose, instance)).collect();
    let count = wanted.iter().map(|vertices| vertices.positions.len()).sum();
    let [positions, normals, tangents] = on_gpu(gpu, pass, geometry, count);
    let size = 2.0 * scene.bounds().unwrap().radius();
    let (mut apart, mut turned, mut outside) = (0.0_f32, 0.0_f32, 0);
    // Keeps NaN.
    let worst = |worst: &mut f32, error: f32| {
        if error.is_nan() || error > *worst {
            *worst = error;
        }
    };
    let mut at = 0;
    for (instance, vertices) in wanted.iter().enumerate() {
        let boxes: Vec<_> = geometry.boxes.iter().filter(|place| place.instance == instance).collect();
        let used: std::collections::BTreeSet<u32> =
            scene.meshes[placed[instance].mesh.0].triangles.iter().flatten().copied().collect();
        for (vertex, position) in vertices.positions.iter().enumerate() {
            worst(&mut apart, positions[at].truncate().distance(*position) / size);
            if let Some(normal) = vertices.normals.get(vertex) {
                worst(&mut turned, normals[at].truncate().distance(*normal));
            }
            if let Some(tangent) = vertices.tangents.get(vertex) {
                let found = tangents[at].truncate().normalize().extend(tangents[at].w);
                worst(&mut turned, found.distance(*tangent));
            }
            let inside = boxes.iter().any(|place| {
                let local = place.world_from_mesh.inverse().transform_point3(*position);
                let slack = Vec3::splat(1e-4 * (place.bounds.max - place.bounds.min).max_element().max(1e-6));
                local.cmpge(place.bounds.min - slack).all() && local.cmple(place.bounds.max + slack).all()
            });
            outside += usize::from(!inside && used.contains(&(vertex as u32)));
            at += 1;
        }
    }
    (apart, turned, outside)
}

/// In place: a pose is no reason to upload meshes.
fn take_pose(gpu: &Gpu, geometry: &mut Geometry, scene: &Scene) {
    let placed = geometry.placed_by(scene).unwrap();
    let moved = geometry.moved(scene, &placed).unwrap();
    geometry.take(moved);
    geometry.upload(gpu);
}

#[test]
fn models_bend_as_on_the_cpu() {
    let Some(gpu) = gpu_or_skip() else { return };
    let pass = TransformPass::new(&gpu).unwrap();
    let mut left = 0;
    for (name, clip) in [
        ("BrainStem.glb", 0),
        ("RobotExpressive.glb", 0),
        ("Fox.glb", 2),
        ("AnimatedMorphCube.glb", 0),
        ("SimpleSkin.gltf", 0),
        ("RiggedSimple.glb", 0),
        ("BoxAnimated.glb", 0),
    ] {
        let Some(path) = gnomon_testing::data_file(&format!("models/{name}")) else { return };
        let mut scene = load(&path, &LoadOptions::default()).unwrap().scene;
        scene.add_ground(gnomon_scene::Ground::Plane);
        let mut geometry = Geometry::new(&gpu, &pass, &scene, None).unwrap();
        let duration = scene.animations[clip].duration();
        for share in [None, Some(0.21), Some(0.68)] {
            if let Some(share) = share {
                scene.animate(clip, share * duration).unwrap();
            }
            take_pose(&gpu, &mut geometry, &scene);
            let (apart, turned, outside) = compare(&gpu, &pass, &geometry, &scene);
            assert!(apart <= GPU_POSE_ERROR && turned <= GPU_POSE_ERROR, "{name}: {apart}, {turned}");
            assert_eq!(outside, 0, "{name}: vertices leave their boxes");
            // Boxes are conservative, but not by much.
            let (exact, boxes) = (scene.bounds().unwrap(), geometry.bounds().unwrap());
            assert!(
                boxes.radius() < 1.3 * exact.radius(),
                "{name}: {} of {}",
                boxes.radius(),
                exact.radius()
            );
        }
        // A planted fault: a pose that was not taken over is seen.
        scene.animate(clip, 0.4 * duration).unwrap();
        let (apart, _, outside) = compare(&gpu, &pass, &geometry, &scene);
        assert!(apart > 10.0 * GPU_POSE_ERROR, "{name}: {apart}");
        left += outside;
    }
    assert!(left > 0, "boxes of other poses hold everything");
}

/// Random numbers in -1..1 (Lehmer).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / f32::from(1_u16 << 15) / 256.0 - 1.0
    }

    fn vector(&mut self) -> Vec3 {
        Vec3::new(self.next(), self.next(), self.next())
    }

    fn affine(&mut self) -> Affine3A {
        let axis = self.vector().normalize_or(Vec3::Y);
        let turn = Quat::from_axis_angle(axis, 3.0 * self.next());
        // Some mirror.
        let scale = self.vector().signum() * (0.5 + 0.5 * self.vector().abs());
        Affine3A::from_scale_rotation_translation(scale, turn, 2.0 * self.vector())
    }
}

/// Two instances of one mesh, one skinned and one not, and a rigid mesh: up to 11 joints a vertex, 9 targets that each move part
/// of it.
fn random_scene(random: &mut Random) -> Scene {
    let (joints, targets, count) = (13_u32, 9, 300);
    let mut mesh = Mesh { targets: vec![MorphTarget::default(); targets], ..Mesh::default() };
    mesh.influences.starts.push(0);
    for vertex in 0..count {
        mesh.positions.push(random.vector());
        let normal = random.vector().normalize_or(Vec3::Y);
        mesh.normals.push(normal);
        mesh.tangents.push(normal.any_orthonormal_vector().extend(if vertex % 2 == 0 { 1.0 } else { -1.0 }));
        let bends = vertex as u32 % 12;
        let weight = 1.0 / bends.max(1) as f32;
        mesh.influences.entries.extend((0..bends).map(|i| ((vertex as u32 + 3 * i) % joints, weight)));
        mesh.influences.starts.push(mesh.influences.entries.len() as u32);
        for (number, target) in mesh.targets.iter_mut().enumerate() {
            let moved = (vertex + number) % 3 == 0;
            let mut offset = || if moved { 0.3 * random.vector() } else { Vec3::ZERO };
            target.positions.push(offset());
            target.normals.push(offset());
            target.tangents.push(offset());
        }
    }
    mesh.triangles = (0..count as u32 / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    let rigid = Mesh { influences: Influences::default(), targets: Vec::new(), ..mesh.clone() };
    let mut scene = Scene { meshes: vec![mesh.into(), rigid.into()], ..Scene::default() };
    let weights: Vec<f32> = (0..targets).map(|_| random.next()).collect();
    for (mesh, skin) in [(0, Some(SkinId(0))), (0, None), (1, Some(SkinId(0)))] {
        scene.nodes.push(Node {
            parent_from_node: random.affine(),
            meshes: vec![MeshId(mesh)],
            skin,
            weights: weights.iter().map(|weight| weight * random.next()).collect(),
            ..Node::default()
        });
    }
    let mut skin = Skin::default();
    for _ in 0..joints {
        skin.joints.push(NodeId(scene.nodes.len()));
        skin.joint_from_bind.push(random.affine());
        scene.nodes.push(Node { parent_from_node: random.affine(), ..Node::default() });
    }
    scene.skins.push(skin);
    scene
}

#[test]
fn random_meshes_bend_as_on_the_cpu() {
    let Some(gpu) = gpu_or_skip() else { return };
    let pass = TransformPass::new(&gpu).unwrap();
    let mut random = Random(7);
    let mut scene = random_scene(&mut random);
    let mut geometry = Geometry::new(&gpu, &pass, &scene, None).unwrap();
    for _ in 0..4 {
        let (apart, turned, outside) = compare(&gpu, &pass, &geometry, &scene);
        assert_eq!(outside, 0);
        // Sums of mirroring and turning joints nearly cancel at some vertices, whose normals then have few digits.
        assert!(apart <= GPU_POSE_ERROR && turned <= 100.0 * GPU_POSE_ERROR, "{apart}, {turned}");
        for node in &mut scene.nodes {
            node.parent_from_node = random.affine();
            node.weights.iter_mut().for_each(|weight| *weight = random.next());
        }
        take_pose(&gpu, &mut geometry, &scene);
    }
}

#[test]
fn poses_beyond_all_bounds_are_refused_and_other_meshes_noticed() {
    let Some(gpu) = gpu_or_skip() else { return };
    let pass = TransformPass::new(&gpu).unwrap();
    let mut scene = random_scene(&mut Random(3));
    let geometry = Geometry::new(&gpu, &pass, &scene, None).unwrap();
    for far in [1e20, f32::NAN, f32::INFINITY] {
        let mut broken = scene.clone();
        broken.nodes[5].parent_from_node.translation.x = far;
        let placed = geometry.placed_by(&broken).unwrap();
        assert!(geometry.moved(&broken, &placed).is_err(), "{far}");
        assert!(Geometry::new(&gpu, &pass, &broken, None).is_err(), "{far}");
    }
    scene.skins[0].joints.pop();
    scene.skins[0].joint_from_bind.pop();
    assert!(geometry.placed_by(&scene).is_none(), "a skin of other joints");
}
