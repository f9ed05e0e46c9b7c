use glam::{Affine3A, Vec4};
use gnomon_scene::{Mesh, Node};

use super::*;
use crate::sampler::{Decision, Sequence};

fn scene(mesh: Mesh) -> Scene {
    let node = Node { meshes: vec![MeshId(0)], ..Node::default() };
    Scene { meshes: vec![mesh.into()], nodes: vec![node], ..Scene::default() }
}

/// Uniform numbers, three at a time, in -1..1.
fn random(index: u32) -> Vec3 {
    let sequence = Sequence::new(9, index, 0);
    let (a, b) = (sequence.pair(0, Decision::Pixel), sequence.pair(0, Decision::Choice));
    2.0 * Vec3::new(a.x as f32, a.y as f32, b.x as f32) - 1.0
}

/// Small random triangles, some without area, some not finite, at `scale` metres.
fn soup(scale: f32) -> Scene {
    let mut mesh = Mesh::default();
    for triangle in 0..500 {
        let centre = random(triangle);
        for corner in 0..3 {
            mesh.positions.push(scale * (centre + 0.2 * random(1000 + 3 * triangle + corner)));
        }
        mesh.triangles.push([3 * triangle, 3 * triangle + 1, 3 * triangle + 2]);
    }
    mesh.positions[4] = mesh.positions[3];
    mesh.positions[7] = Vec3::new(f32::NAN, 0.0, 0.0);
    mesh.positions[10] = Vec3::new(f32::INFINITY, 0.0, 0.0);
    scene(mesh)
}

#[test]
fn the_bvh_finds_what_trying_every_triangle_finds() {
    for scale in [1e-4, 1.0, 1e4] {
        let scene = soup(scale);
        let traced = TracedScene::new(&scene).unwrap();
        assert_eq!(traced.triangles.len(), 497);
        let mut hits = 0;
        for index in 0..3000 {
            let origin = 1.5 * scale * random(5000 + index);
            let ray = Ray { origin, direction: random(9000 + index).normalize() };
            let expected = traced
                .triangles
                .iter()
                .filter_map(|triangle| triangle.intersect(&ray).map(|(t, _)| t))
                .min_by(f32::total_cmp);
            let found = traced.closest_hit(&ray, 0.5);
            let distance = found.and_then(|hit| Some(traced.met(&ray, hit.triangle as usize)?.0));
            assert_eq!(distance, expected);
            assert_eq!(traced.transmittance(&ray, f32::INFINITY) == 0.0, expected.is_some());
            let end = 0.7 * scale;
            assert_eq!(
                traced.transmittance(&ray, end) == 0.0,
                expected.is_some_and(|t| t < end * (1.0 - END_CLEARANCE))
            );
            hits += usize::from(expected.is_some());
        }
        assert!(hits > 500, "{hits} hits");
    }
}

/// No ray leaves a closed surface, least of all through its edges and corners.
#[test]
fn closed_surfaces_are_tight() {
    let mut mesh = Mesh::default();
    let (rings, sectors) = (12, 16);
    for ring in 0..=rings {
        let (sin, cos) = (std::f32::consts::PI * ring as f32 / rings as f32).sin_cos();
        for sector in 0..sectors {
            let (s, c) = (std::f32::consts::TAU * sector as f32 / sectors as f32).sin_cos();
            mesh.positions.push(Vec3::new(sin * c + 3.0, cos, sin * s));
        }
    }
    for ring in 0..rings {
        for sector in 0..sectors {
            let next = (sector + 1) % sectors;
            let [a, b] = [ring * sectors + sector, ring * sectors + next];
            mesh.triangles.extend([[a, b, a + sectors], [b, b + sectors, a + sectors]]);
        }
    }
    let targets: Vec<Vec3> = mesh
        .triangles
        .iter()
        .flat_map(|t| {
            let [a, b, c] = t.map(|index| mesh.positions[index as usize]);
            [a, 0.5 * (a + b), 0.5 * (b + c), a.lerp(c, 0.3)]
        })
        .collect();
    let scene = scene(mesh);
    let traced = TracedScene::new(&scene).unwrap();
    for (index, target) in targets.into_iter().enumerate() {
        let origin = Vec3::new(3.0, 0.0, 0.0) + 0.3 * random(index as u32);
        let ray = Ray { origin, direction: (target - origin).normalize() };
        assert_eq!(traced.transmittance(&ray, f32::INFINITY), 0.0, "a ray escapes at {target}");
    }
}

/// A soup on two joints with a morph target is hit as its vertices, moved beforehand, are.
#[test]
fn deformed_meshes_are_hit_where_they_are_bent_to() {
    let mut bent = soup(1.0);
    let mesh = Arc::make_mut(&mut bent.meshes[0]);
    let count = mesh.positions.len() as u32;
    mesh.positions.iter_mut().for_each(|p| *p = if p.is_finite() { *p } else { Vec3::ZERO });
    mesh.normals = (0..count).map(|i| random(i).normalize()).collect();
    let entries = (0..count).flat_map(|i| [(0, (i % 5) as f32 / 4.0), (1, 1.0 - (i % 5) as f32 / 4.0)]);
    mesh.influences.entries = entries.collect();
    mesh.influences.starts = (0..=count).map(|i| 2 * i).collect();
    let positions = (0..count).map(|i| 0.1 * random(7000 + i)).collect();
    mesh.targets.push(gnomon_scene::MorphTarget { positions, ..Default::default() });
    let joint =
        |axis: Vec3| Node { parent_from_node: Affine3A::from_axis_angle(axis, 0.8), ..Node::default() };
    bent.nodes[0].skin = Some(gnomon_scene::SkinId(0));
    bent.nodes[0].weights = vec![0.7];
    bent.nodes.extend([joint(Vec3::X), joint(Vec3::Y)]);
    bent.skins.push(gnomon_scene::Skin {
        joints: vec![gnomon_scene::NodeId(1), gnomon_scene::NodeId(2)],
        joint_from_bind: vec![Affine3A::IDENTITY; 2],
        ..Default::default()
    });
    let moved = bent.world_vertices(&bent.pose(), &bent.instances()[0]);
    let triangles = bent.meshes[0].triangles.clone();
    let (positions, normals) = (moved.positions, moved.normals);
    let baked = scene(Mesh { positions, normals, triangles, ..Mesh::default() });
    let [bent, baked] = [&bent, &baked].map(|scene| TracedScene::new(scene).unwrap());
    let mut hits = 0;
    for index in 0..2000 {
        let direction = random(9000 + index).normalize();
        let ray = Ray { origin: 1.5 * random(5000 + index), direction };
        let point = |traced: &TracedScene| {
            let point = traced.hit_point(&traced.closest_hit(&ray, 0.5)?, -direction);
            Some((point.position, point.geometric_normal, point.frame.n))
        };
        let (found, expected) = (point(&bent), point(&baked));
        assert_eq!(found.is_some(), expected.is_some());
        if let (Some(found), Some(expected)) = (found, expected) {
            assert_eq!((found.0, found.1), (expected.0, expected.1));
            assert!(found.2.distance(expected.2) < 1e-5);
            hits += 1;
        }
    }
    assert!(hits > 300, "{hits} hits");
}

/// Tangent and bitangent lie on the surface as the mesh has them, however it is placed and from whichever side it is seen.
#[test]
fn hits_carry_the_tangent_frame_of_the_mesh() {
    let turn = Affine3A::from_rotation_x(0.4) * Affine3A::from_rotation_z(0.7);
    for placement in [Affine3A::IDENTITY, turn, turn * Affine3A::from_scale(Vec3::new(-1.0, 1.0, 1.0))] {
        for sign in [1.0, -1.0] {
            let mut scene = scene(Mesh {
                positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
                normals: vec![Vec3::Z; 3],
                tangents: vec![Vec4::new(0.6, 0.8, 0.0, sign); 3],
                triangles: vec![[0, 1, 2]],
                ..Mesh::default()
            });
            scene.nodes[0].parent_from_node = placement;
            let traced = TracedScene::new(&scene).unwrap();
            for side in [1.0, -1.0] {
                let direction = placement.transform_vector3(Vec3::new(0.0, 0.0, -side));
                let origin = placement.transform_point3(Vec3::new(0.2, 0.2, 0.0)) - direction;
                let hit = traced.closest_hit(&Ray { origin, direction }, 0.5).unwrap();
                let frame = traced.hit_point(&hit, -direction).frame;
                let world = |local: Vec3| placement.transform_vector3(local);
                assert!(frame.n.distance(-direction) < 1e-5, "{frame:?}");
                assert!(frame.t.distance(world(Vec3::new(0.6, 0.8, 0.0))) < 1e-5, "{frame:?}");
                assert!(frame.b.distance(world(sign * Vec3::new(-0.8, 0.6, 0.0))) < 1e-5, "{frame:?}");
            }
        }
    }
}

#[test]
fn rays_that_are_not_numbers_hit_nothing() {
    let scene = soup(1.0);
    let traced = TracedScene::new(&scene).unwrap();
    let ray = Ray { origin: Vec3::ZERO, direction: Vec3::splat(f32::NAN) };
    assert!(traced.closest_hit(&ray, 0.5).is_none() && traced.transmittance(&ray, f32::INFINITY) == 1.0);
}
