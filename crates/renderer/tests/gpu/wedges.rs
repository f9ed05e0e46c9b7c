//! Shadows from the silhouettes of geometry against integrals over the light.

use crate::common::*;
use glam::{Affine3A, DVec2, DVec3, EulerRot, Mat3, Quat, Vec2, Vec3};
use gnomon_lights::{DistantLight, LightSet};
use gnomon_renderer::{Gpu, RenderSettings, Renderer};
use gnomon_scene::{AreaLight, AreaLightShape, Camera, Material, Mesh, Node, NodeId, Projection, Scene};
use gnomon_testing::tolerances;

/// Pixels along a side that are looked at, every so manyth of the picture's: rays begin a share of a pixel above the ground. Half the side
/// of the ground that they show [m].
const SIDE: u32 = 24;
const STEP: u32 = 10;
const HALF: f32 = 1.2;
/// Points of a light for integrals past a few triangles, and past many.
const MANY: usize = 4096;
const SOME: usize = 512;

/// What lights the ground.
#[derive(Clone, Copy)]
enum Lamp {
    Disk { direction: Vec3, radius: f32 },
    Rectangle { half: Vec2 },
    Near { shape: AreaLightShape, center: Vec3 },
}

impl Lamp {
    fn lights(self) -> LightSet {
        match self {
            Self::Disk { direction, radius } => one_disk(direction.normalize(), radius),
            Self::Rectangle { half } => {
                let half = half.as_dvec2();
                let frame = [DVec3::X, DVec3::Z, DVec3::Y];
                let shifted = DVec2::new(0.3, -0.1);
                let light = DistantLight::rectangle(frame, shifted - half, shifted + half, DVec3::ONE);
                LightSet::new("test", vec![light], no_light())
            }
            Self::Near { .. } => LightSet::new("test", Vec::new(), no_light()),
        }
    }

    /// Points of it as seen from a place, each with the irradiance that comes from it.
    fn points(self, from: Vec3, count: usize) -> Vec<(Vec3, f32)> {
        // The additive recurrence R2 (Roberts 2018): no edge runs along its points, as along those of a grid.
        let part = |i: usize, step: f64| (2.0 * ((i as f64 + 0.5) * step).fract() - 1.0) as f32;
        let grid =
            (0..count).map(|i| Vec2::new(part(i, 0.754_877_666_246_692_8), part(i, 0.569_840_290_998_053_3)));
        let flat = |center: Vec3, a: Vec3, b: Vec3, is_disk: bool| {
            let inside = grid.filter(|place| !is_disk || place.length() < 1.0);
            let normal = a.cross(b).normalize();
            inside
                .map(|place| center + place.x * a + place.y * b)
                .map(|v| (v, v.y.max(0.0) * v.dot(normal).abs() / v.length().powi(4)))
                .collect()
        };
        match self {
            Self::Disk { direction, radius } => {
                let d = direction.normalize();
                let a = d.any_orthonormal_vector();
                flat(d, radius.tan() * a, radius.tan() * d.cross(a), true)
            }
            Self::Rectangle { half } => {
                flat(Vec3::Y + 0.3 * Vec3::X - 0.1 * Vec3::Z, half.x * Vec3::X, half.y * Vec3::Z, false)
            }
            Self::Near { shape, center } => {
                let to_center = center - from;
                let half = shape.half_extent();
                match shape {
                    AreaLightShape::Sphere { radius } => {
                        let near = 1.0 - radius * radius / to_center.length_squared();
                        let a = to_center.normalize().any_orthonormal_vector();
                        let b = to_center.normalize().cross(a);
                        let seen = radius * near.sqrt();
                        flat(near * to_center, seen * a, seen * b, true)
                    }
                    AreaLightShape::Disk { .. } | AreaLightShape::Sun { .. } => {
                        flat(to_center, half.x * Vec3::X, half.y * Vec3::Z, true)
                    }
                    AreaLightShape::Rectangle { .. } => {
                        flat(to_center, half.x * Vec3::X, half.y * Vec3::Z, false)
                    }
                }
            }
        }
    }

    fn faces(self, [a, b, c]: [Vec3; 3]) -> bool {
        let normal = (b - a).cross(c - a);
        match self {
            Self::Disk { direction, .. } => normal.dot(direction) > 0.0,
            Self::Rectangle { .. } => normal.dot(self.lights().lights[0].direction) > 0.0,
            Self::Near { center, .. } => normal.dot(center - a) > 0.0,
        }
    }

    fn add_to(self, scene: &mut Scene) {
        let Self::Near { shape, center } = self else { return };
        let down = Mat3::from_cols(Vec3::X, Vec3::NEG_Z, Vec3::Y);
        let parent_from_node = Affine3A::from_mat3_translation(down, center);
        scene.nodes.push(Node { parent_from_node, ..Node::default() });
        let node = NodeId(scene.nodes.len() - 1);
        scene.lights.push(AreaLight { node, shape, radiance: Vec3::ONE, spread: Default::default() });
    }
}

fn is_hit([a, b, c]: [Vec3; 3], from: Vec3, towards: Vec3, reach: f32) -> bool {
    let (edge, other, to) = (b - a, c - a, from - a);
    let across = towards.cross(other);
    let determinant = edge.dot(across);
    let u = to.dot(across) / determinant;
    let around = to.cross(edge);
    let v = towards.dot(around) / determinant;
    let distance = other.dot(around) / determinant;
    u >= 0.0 && v >= 0.0 && u + v <= 1.0 && distance > 1e-5 && distance < reach
}

fn corners(mesh: &Mesh) -> Vec<[Vec3; 3]> {
    mesh.triangles.iter().map(|triangle| triangle.map(|vertex| mesh.positions[vertex as usize])).collect()
}

/// Share of a lamp's irradiance that arrives on the ground past triangles.
fn exact(lamp: Lamp, triangles: &[[Vec3; 3]], place: Vec3, count: usize) -> f32 {
    let reach = if matches!(lamp, Lamp::Near { .. }) { 1.0 } else { f32::MAX };
    let (mut lit, mut all) = (0.0, 0.0);
    for (towards, irradiance) in lamp.points(place, count) {
        all += irradiance;
        if !triangles.iter().any(|triangle| is_hit(*triangle, place, towards, reach)) {
            lit += irradiance;
        }
    }
    lit / all
}

fn settings(shadows: &str) -> RenderSettings {
    RenderSettings::default().with(|s| {
        s.techniques.shadows = shadows.to_owned();
        s.techniques.compositing = "additive".to_owned();
        s.techniques.supersample = 1;
        s.techniques.shadow_sampling = 1;
        s.techniques.sharp_shadow_sampling = 1;
    })
}

/// From just above the ground, below all casters, and where each pixel shows it.
fn camera() -> (Camera, Vec<Vec3>) {
    let camera = Camera {
        projection: Projection::Orthographic { half_width: HALF },
        ..Camera::look_at(Vec3::new(0.0, 0.05, 0.0), Vec3::ZERO, 1.0)
    };
    let at = |i: u32| ((STEP * i) as f32 + 0.5) / (STEP * SIDE) as f32 * 2.0 - 1.0;
    let place = |x: u32, y: u32| {
        let seen = HALF * Vec3::new(at(x), -at(y), 0.0);
        camera.world_from_camera.transform_point3(seen).with_y(0.0)
    };
    let places = (0..SIDE * SIDE).map(|i| place(i % SIDE, i / SIDE)).collect();
    (camera, places)
}

fn ground() -> Mesh {
    horizontal(Vec2::splat(-3.0), Vec2::splat(3.0), 0.0)
}

/// Share of the lamp's light that arrives at every place.
fn drawn(gpu: &Gpu, settings: &RenderSettings, lamp: Lamp, caster: &Mesh) -> (Vec<f32>, Vec<String>) {
    let mut radiance = Vec::new();
    let mut warnings = Vec::new();
    for meshes in [vec![ground(), caster.clone()], vec![ground()]] {
        let mut scene = scene_of(meshes, Material::default());
        scene.nodes.iter_mut().zip(["ground", "caster"]).for_each(|(node, name)| node.name = name.to_owned());
        lamp.add_to(&mut scene);
        let mut renderer = Renderer::new(gpu, settings.clone()).unwrap();
        renderer.set_scene(&scene).unwrap();
        renderer.set_lighting(&no_light(), &lamp.lights()).unwrap();
        warnings.extend(renderer.take_warnings());
        let picture = renderer.render(&camera().0, STEP * SIDE, STEP * SIDE).unwrap().radiance;
        let looked_at = (0..SIDE * SIDE).map(|i| picture.get(STEP * (i % SIDE), STEP * (i / SIDE)).y);
        radiance.push(looked_at.collect::<Vec<_>>());
    }
    assert!(radiance[1].iter().all(|all| *all > 0.0), "nothing but the ground, and dark");
    (radiance[0].iter().zip(&radiance[1]).map(|(lit, all)| lit / all).collect(), warnings)
}

/// A box of half sides, turned, about a place.
fn block(half: Vec3, turn: Quat, center: Vec3) -> Mesh {
    let mut mesh = Mesh::default();
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let first = mesh.positions.len() as u32;
            for (s, t) in [(-1.0, -1.0), (side, -side), (1.0, 1.0), (-side, side)] {
                let mut corner = Vec3::ZERO;
                (corner[axis], corner[(axis + 1) % 3], corner[(axis + 2) % 3]) = (side, s, t);
                mesh.positions.push(center + turn * (half * corner));
                mesh.normals.push(Vec3::Y);
            }
            mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        }
    }
    mesh
}

fn torus(center: Vec3) -> Mesh {
    let (around, across) = (16u32, 8u32);
    let at = |i: u32, count: u32| i as f32 / count as f32 * std::f32::consts::TAU;
    let position = |i: u32| {
        let (u, v) = (at(i / across, around), at(i % across, across));
        let out = Vec3::new(u.cos(), 0.0, u.sin());
        center + Quat::from_rotation_z(0.4) * ((0.4 + 0.15 * v.cos()) * out + 0.15 * v.sin() * Vec3::Y)
    };
    let index = |i: u32, j: u32| (i % around) * across + j % across;
    let positions: Vec<Vec3> = (0..around * across).map(position).collect();
    let quads = (0..around * across).map(|i| (i / across, i % across)).flat_map(|(i, j)| {
        let [a, b, c, d] = [index(i, j), index(i, j + 1), index(i + 1, j + 1), index(i + 1, j)];
        [[a, b, c], [a, c, d]]
    });
    Mesh { normals: vec![Vec3::Y; positions.len()], triangles: quads.collect(), positions, ..Mesh::default() }
}

fn turned() -> Quat {
    Quat::from_euler(EulerRot::XYZ, 0.5, 0.3, 0.2)
}

const LAMPS: [Lamp; 6] = [
    Lamp::Disk { direction: Vec3::new(0.2, 1.0, -0.3), radius: 0.15 },
    Lamp::Disk { direction: Vec3::new(-1.0, 0.25, 0.2), radius: 0.35 },
    Lamp::Rectangle { half: Vec2::new(0.3, 0.1) },
    Lamp::Near { shape: AreaLightShape::Sphere { radius: 0.3 }, center: Vec3::new(0.4, 2.2, 0.3) },
    Lamp::Near { shape: AreaLightShape::Disk { radius: 0.4 }, center: Vec3::new(-0.3, 2.0, 0.0) },
    Lamp::Near {
        shape: AreaLightShape::Rectangle { size: Vec2::new(0.8, 0.2) },
        center: Vec3::new(0.1, 1.8, 0.2),
    },
];

/// Compares what a block and a square cover of lamps with integrals over their silhouettes.
fn compare_convex_casters(gpu: &Gpu, lamps: &[Lamp]) {
    let near = block(Vec3::new(0.3, 0.15, 0.25), turned(), Vec3::new(0.1, 0.55, 0.0));
    let flat = horizontal(Vec2::new(-0.4, -0.2), Vec2::new(0.3, 0.5), 0.8);
    for &lamp in lamps {
        for (name, caster) in [("block", &near), ("square", &flat)] {
            let (found, warnings) = drawn(gpu, &settings("wedges"), lamp, caster);
            // Of a flat caster both sides count.
            let facing: Vec<_> =
                corners(caster).into_iter().filter(|c| name == "square" || lamp.faces(*c)).collect();
            let errors = camera()
                .1
                .into_iter()
                .zip(found)
                .map(|(p, found)| (found - exact(lamp, &facing, p, MANY)).abs());
            let (mut worst, mut sum) = (0.0f32, 0.0);
            for error in errors {
                worst = worst.max(error);
                sum += error;
            }
            println!("{name}: worst {worst:.4}, mean {:.5}", sum / (SIDE * SIDE) as f32);
            assert!(worst <= tolerances::WEDGES, "{name}: {worst}");
            assert!(warnings.is_empty(), "{warnings:?}");
        }
    }
}

#[test]
fn a_convex_caster_covers_what_its_silhouette_from_the_center_does() {
    let Some(gpu) = gpu_or_skip() else { return };
    compare_convex_casters(&gpu, &LAMPS[..3]);
}

/// `cargo test -p gnomon-renderer --test gpu lamps_in_the_scene -- --ignored --nocapture`
#[test]
#[ignore = "a block under a sphere: the worst of 576 pixels is off by 0.06 (mean 0.0007), and it is not known why"]
fn a_convex_caster_covers_as_much_of_lamps_in_the_scene() {
    let Some(gpu) = gpu_or_skip() else { return };
    compare_convex_casters(&gpu, &LAMPS[3..]);
}

/// Places where what is expected is the same all around.
fn inner(expected: &[f32]) -> impl Iterator<Item = usize> + '_ {
    let side = SIDE as usize;
    let all = (1..side - 1).flat_map(move |y| (1..side - 1).map(move |x| y * side + x));
    let beside = move |i: usize| {
        [i - side - 1, i - side, i - side + 1, i - 1, i + 1, i + side - 1, i + side, i + side + 1]
    };
    all.filter(move |&i| beside(i).into_iter().all(|j| expected[j] == expected[i]))
}

#[test]
fn without_size_a_light_casts_the_hard_shadow_of_its_center() {
    let Some(gpu) = gpu_or_skip() else { return };
    let hard = settings("wedges").with(|s| s.techniques.shadow_settings.wedges.light_size = 0.0);
    for lamp in LAMPS {
        for caster in [torus(Vec3::new(0.1, 0.8, 0.0)), block(Vec3::new(0.3, 0.1, 0.3), turned(), Vec3::Y)] {
            let triangles = corners(&caster);
            let expected: Vec<f32> = camera()
                .1
                .iter()
                .map(|place| {
                    let towards = match lamp {
                        Lamp::Near { center, .. } => center - *place,
                        _ => lamp.lights().lights[0].direction,
                    };
                    let reach = if matches!(lamp, Lamp::Near { .. }) { 1.0 } else { f32::MAX };
                    let is_dark = triangles.iter().any(|triangle| is_hit(*triangle, *place, towards, reach));
                    if is_dark { 0.0 } else { 1.0 }
                })
                .collect();
            let (found, _) = drawn(&gpu, &hard, lamp, &caster);
            assert!(inner(&expected).count() > 200);
            for i in inner(&expected) {
                assert!((found[i] - expected[i]).abs() < 1e-3, "pixel {i}: {} {}", found[i], expected[i]);
            }
        }
    }
}

#[test]
fn a_concave_caster_is_near_the_truth_and_two_behind_one_another_too_dark() {
    let Some(gpu) = gpu_or_skip() else { return };
    let mean = |found: &[f32], truth: &[f32]| {
        let penumbra = || found.iter().zip(truth).filter(|(_, truth)| (0.01..0.99).contains(*truth));
        penumbra().map(|(found, truth)| found - truth).fold((0.0, 0.0), |(sum, all), difference| {
            (sum + difference / penumbra().count() as f32, all + difference.abs() / penumbra().count() as f32)
        })
    };
    let truth = |lamp: Lamp, caster: &Mesh| -> Vec<f32> {
        camera().1.into_iter().map(|place| exact(lamp, &corners(caster), place, SOME)).collect()
    };
    for lamp in [LAMPS[0], LAMPS[3]] {
        let caster = torus(Vec3::new(0.1, 0.8, 0.0));
        let (bias, error) = mean(&drawn(&gpu, &settings("wedges"), lamp, &caster).0, &truth(lamp, &caster));
        println!("torus: bias {bias:+.4}, error {error:.4} over penumbrae");
        assert!(error <= tolerances::WEDGES_CONCAVE, "{error}");
        let mut two = horizontal(Vec2::new(-0.6, -0.6), Vec2::new(0.0, 0.6), 0.5);
        let other = horizontal(Vec2::new(-0.3, -0.6), Vec2::new(0.5, 0.6), 1.0);
        two.positions.extend(&other.positions);
        two.normals.extend(&other.normals);
        two.triangles.extend(other.triangles.iter().map(|triangle| triangle.map(|vertex| vertex + 4)));
        let (bias, error) = mean(&drawn(&gpu, &settings("wedges"), lamp, &two).0, &truth(lamp, &two));
        println!("two squares: bias {bias:+.4}, error {error:.4} over penumbrae");
        assert!(bias < 0.01 && error < tolerances::WEDGES_TWO_CASTERS, "{bias} {error}");
    }
}

/// A torus that something is wrong with.
fn damaged(seed: usize) -> Mesh {
    let mut mesh = torus(Vec3::new(0.1, 0.8, 0.0));
    let count = mesh.triangles.len();
    let chosen = |i: usize| (seed * 7919 + i * 104_729) % count;
    for i in 0..4 {
        let [a, b, c] = mesh.triangles[chosen(i)];
        match (seed + i) % 7 {
            0 => mesh.triangles[chosen(i)].swap(0, 1),
            1 => mesh.triangles.push([a, b, c]),
            2 => {
                mesh.triangles.remove(chosen(i));
            }
            // One side of an edge has a vertex in its middle.
            3 => {
                let middle = mesh.positions.len() as u32;
                mesh.positions.push(0.5 * (mesh.positions[a as usize] + mesh.positions[b as usize]));
                mesh.triangles[chosen(i)] = [a, middle, c];
                mesh.triangles.push([middle, b, c]);
            }
            4 => mesh.triangles.extend([[a, b, b], [a, b, a]]),
            // A sliver, longer than the mesh.
            5 => {
                mesh.positions.push(mesh.positions[a as usize] + Vec3::new(1e-7, 0.9, 1e-7));
                mesh.triangles.push([a, b, mesh.positions.len() as u32 - 1]);
            }
            _ => mesh.triangles.push([a, c, mesh.triangles[chosen(i + 50)][1]]),
        }
    }
    mesh.normals = vec![Vec3::Y; mesh.positions.len()];
    mesh
}

#[test]
fn damaged_meshes_flood_nothing_and_are_named() {
    let Some(gpu) = gpu_or_skip() else { return };
    let lamp = LAMPS[0];
    for seed in 0..6 {
        let caster = damaged(seed);
        let triangles = corners(&caster);
        let truth: Vec<f32> =
            camera().1.into_iter().map(|place| exact(lamp, &triangles, place, SOME)).collect();
        for technique in ["wedges", "stencil"] {
            let (found, warnings) = drawn(&gpu, &settings(technique), lamp, &caster);
            assert!(warnings.len() == 1 && warnings[0].contains("mesh 1 of caster"), "{seed}: {warnings:?}");
            // Where nothing or everything is covered hard shadows are as good as soft ones.
            let counts = |truth: f32| technique == "wedges" || truth == 0.0 || truth == 1.0;
            let pairs = || found.iter().zip(&truth).filter(|(_, truth)| counts(**truth));
            let off = pairs().filter(|(a, b)| (*a - *b).abs() > 0.3).count();
            let lit = pairs().filter(|(a, b)| **b == 1.0 && **a < 0.95).count();
            println!("{technique} {seed}: {off} off by more than 0.3, {lit} lit ones dark; {}", warnings[0]);
            assert!(off <= found.len() / 100 && lit <= 2, "{technique} {seed}: {off} {lit}");
        }
    }
}
