//! Area lights in the scene, in closed form.
#![allow(clippy::unwrap_used, clippy::panic, reason = "tests and their helpers fail by panicking")]

mod support;

use std::f32::consts::PI;

use glam::{Affine3A, DVec3, Mat3, Quat, Vec2, Vec3};
use gnomon_brdf::Surface;
use gnomon_lights::LightSet;
use gnomon_reference::{Estimate, ReferenceOptions, ResidualShadows, render, render_lights};
use gnomon_scene::{AreaLight, AreaLightShape, Camera, NodeId, Scene, Spread};
use support::{constant_environment, downward_strip, floor, lambert, node, polygon, scene};

const RADIANCE: Vec3 = Vec3::new(3.0, 2.0, 1.0);

/// Adds a light of [`RADIANCE`].
fn add_light(scene: &mut Scene, shape: AreaLightShape, parent_from_node: Affine3A) {
    let mut place = node(gnomon_scene::MeshId(0), parent_from_node);
    place.meshes.clear();
    scene.nodes.push(place);
    scene.lights.push(AreaLight {
        node: NodeId(scene.nodes.len() - 1),
        shape,
        radiance: RADIANCE,
        spread: Default::default(),
    });
}

/// Facing down from `position`, the width along x.
fn facing_down(position: Vec3) -> Affine3A {
    let axes = Mat3::from_cols(Vec3::X, Vec3::NEG_Z, Vec3::Y);
    Affine3A::from_mat3_translation(axes, position)
}

fn options(width: u32, height: u32, samples_per_pixel: u32) -> ReferenceOptions<'static> {
    ReferenceOptions { width, height, samples_per_pixel, seed: 7, ..ReferenceOptions::default() }
}

fn picture(scene: &Scene, camera: &Camera, samples_per_pixel: u32) -> Estimate {
    render(scene, camera, &constant_environment(Vec3::ZERO), &options(8, 8, samples_per_pixel)).unwrap()
}

/// Mean over the picture and the standard error of that mean.
fn overall(estimate: &Estimate) -> (DVec3, DVec3) {
    let count = estimate.mean.texels().len() as f64;
    let sum = |texels: &[Vec3]| texels.iter().map(|texel| texel.as_dvec3()).sum::<DVec3>();
    let variance = sum(estimate.variance.texels());
    (sum(estimate.mean.texels()) / count, variance.map(f64::sqrt) / count)
}

/// The picture's mean is `form_factor` times [`RADIANCE`] over pi within four standard errors, and those are small.
fn assert_irradiance(estimate: &Estimate, form_factor: f32, what: &str) {
    let (mean, error) = overall(estimate);
    let expected = (RADIANCE * form_factor / PI).as_dvec3();
    let allowed = 4.0 * error + 2e-4 * expected;
    assert!((mean - expected).abs().cmple(allowed).all(), "{what}: {mean} against {expected}, error {error}");
    assert!(error.cmple(0.008 * expected).all(), "{what}: too noisy to tell, {error}");
}

/// White floor seen over a patch so small that the irradiance is that of its centre.
fn lit_floor(shape: AreaLightShape, place: Affine3A) -> Estimate {
    let mut scene = scene(vec![(floor(5.0, 0.0), lambert(1.0))]);
    add_light(&mut scene, shape, place);
    picture(&scene, &downward_strip(0.05, 1e-3), 512)
}

#[test]
fn a_disk_on_its_axis_has_its_closed_form() {
    for (radius, height) in [(0.5_f32, 2.0_f32), (1.0, 0.5), (0.01, 3.0), (2.0, 0.1)] {
        let expected = PI * radius * radius / (radius * radius + height * height);
        let estimate = lit_floor(AreaLightShape::Disk { radius }, facing_down(Vec3::Y * height));
        assert_irradiance(&estimate, expected, &format!("disk {radius} at {height}"));
    }
}

#[test]
fn a_disk_aside_and_tilted_is_lamberts_polygon() {
    let (radius, position) = (0.6, Vec3::new(0.7, 1.1, -0.4));
    let turn = Quat::from_euler(glam::EulerRot::XYZ, -1.2, 0.4, 0.2);
    let place = Affine3A::from_rotation_translation(turn, position);
    let expected = polygon_form_factor(
        &(0..720)
            .map(|i| {
                let (sin, cos) = (2.0 * PI * i as f32 / 720.0).sin_cos();
                place.transform_point3(radius * Vec3::new(cos, sin, 0.0))
            })
            .collect::<Vec<_>>(),
    );
    assert_irradiance(&lit_floor(AreaLightShape::Disk { radius }, place), expected, "tilted disk");
}

#[test]
fn a_sphere_has_its_closed_form_above_and_across_the_horizon() {
    for (radius, center) in [(0.5_f32, Vec3::Y * 2.0), (0.02, Vec3::new(1.0, 1.0, 0.5)), (0.9, Vec3::Y)] {
        let distance2 = center.length_squared();
        let expected = PI * radius * radius / distance2 * center.y / distance2.sqrt();
        let estimate = lit_floor(AreaLightShape::Sphere { radius }, Affine3A::from_translation(center));
        assert_irradiance(&estimate, expected, &format!("sphere {radius} at {center}"));
    }
    // Half sunk: the projected solid angle of half a cone about the horizon is gamma - sin gamma cos gamma, halved by the cut.
    let gamma = 0.5_f32.asin();
    let place = Affine3A::from_translation(Vec3::X);
    let expected = gamma - gamma.sin() * gamma.cos();
    assert_irradiance(&lit_floor(AreaLightShape::Sphere { radius: 0.5 }, place), expected, "half sunk");
}

#[test]
fn a_sun_has_its_closed_form_and_is_no_part_of_the_environment() {
    let (angular_radius, tilt) = (0.1_f32, 0.8_f32);
    // From straight above, then turned.
    let place = Affine3A::from_rotation_z(tilt) * facing_down(Vec3::new(3.0, 9.0, 1.0));
    let expected = PI * angular_radius.sin().powi(2) * tilt.cos();
    assert_irradiance(&lit_floor(AreaLightShape::Sun { angular_radius }, place), expected, "sun");
}

#[test]
fn a_spot_has_a_quarter_of_its_intensity_half_way_between_its_cones() {
    for (angle, share) in [(0.3_f32, 1.0_f32), (0.55_f32.acos(), 0.25)] {
        let mut scene = scene(vec![(floor(5.0, 0.0), lambert(1.0))]);
        let turned = Affine3A::from_translation(Vec3::Y * 2.0) * Affine3A::from_rotation_z(angle);
        let shape = AreaLightShape::Sphere { radius: 0.02 };
        add_light(&mut scene, shape, turned * facing_down(Vec3::ZERO));
        scene.lights[0].spread = Spread::Cone { inner: 0.7_f32.acos(), outer: 0.4_f32.acos() };
        let estimate = picture(&scene, &downward_strip(0.05, 1e-3), 512);
        assert_irradiance(&estimate, share * shape.facing_irradiance() / 4.0, &format!("spot at {angle}"));
    }
}

#[test]
fn a_rectangle_has_its_form_factor() {
    // Parallel, the point under a corner: 1 / 2 (A / sqrt(1 + A^2) atan(B / sqrt(1 + A^2)) + ...) (Howell, C-11, times pi).
    let (a, b, height) = (1.2_f32, 0.7_f32, 0.9_f32);
    let (x, y) = (a / height, b / height);
    let half = |x: f32, y: f32| x / (1.0 + x * x).sqrt() * (y / (1.0 + x * x).sqrt()).atan();
    let expected = 0.5 * (half(x, y) + half(y, x));
    let size = Vec2::new(a, b);
    let place = facing_down(Vec3::new(0.5 * a, height, 0.5 * b));
    assert_irradiance(&lit_floor(AreaLightShape::Rectangle { size }, place), expected, "under a corner");
    // Upright on the floor, facing the point: 1 / 2 (atan(1 / Y) - Y / sqrt(X^2 + Y^2) atan(1 / sqrt(X^2 + Y^2))) (Howell, C-12),
    // for the half on one side, X = height over width, Y = distance over width.
    let (width, height, distance) = (0.8_f32, 1.1_f32, 0.5_f32);
    let (x, y) = (height / width, distance / width);
    let root = (x * x + y * y).sqrt();
    let expected = (1.0 / y).atan() - y / root * (1.0 / root).atan();
    let size = Vec2::new(2.0 * width, height);
    let place = Affine3A::from_translation(Vec3::new(0.0, 0.5 * height, distance));
    assert_irradiance(&lit_floor(AreaLightShape::Rectangle { size }, place), expected, "upright");
    // Sunk half under the floor it gives what the upper half alone does.
    let size = Vec2::new(2.0 * width, 2.0 * height);
    let place = Affine3A::from_translation(Vec3::new(0.0, 0.0, distance));
    assert_irradiance(&lit_floor(AreaLightShape::Rectangle { size }, place), expected, "half sunk");
}

/// Irradiance at the origin on a floor from a polygon above it, counter-clockwise seen from there (Lambert 1760).
fn polygon_form_factor(corners: &[Vec3]) -> f32 {
    let edge = |a: Vec3, b: Vec3| f64::from(a.angle_between(b) * a.cross(b).normalize().y);
    let sum: f64 = (0..corners.len()).map(|i| edge(corners[i], corners[(i + 1) % corners.len()])).sum();
    (0.5 * sum.abs()) as f32
}

/// Between two emitting planes that fill the whole sky every wall sees one radiance.
#[test]
fn a_furnace_of_lights_is_albedo_times_radiance() {
    let surface = Surface { specular: 0.0, ..lambert(0.5) };
    let mut scene = scene(vec![(floor(1.0, 0.0), surface)]);
    let size = Vec2::splat(4000.0);
    add_light(&mut scene, AreaLightShape::Rectangle { size }, facing_down(Vec3::Y));
    let (mean, error) = overall(&picture(&scene, &downward_strip(0.5, 1.0), 2048));
    let expected = 0.5 * RADIANCE.as_dvec3();
    assert!((mean - expected).abs().cmple(4.0 * error + 5e-4 * expected).all(), "{mean} +- {error}");
}

#[test]
fn lights_shine_to_the_front_and_on_what_they_see_only() {
    let bright = |estimate: &Estimate| overall(estimate).0.x;
    let disk = AreaLightShape::Disk { radius: 0.3 };
    let up = Affine3A::from_mat3_translation(Mat3::from_cols(Vec3::X, Vec3::Z, Vec3::NEG_Y), Vec3::Y);
    assert_eq!(bright(&lit_floor(disk, up)), 0.0, "its back");
    assert_eq!(bright(&lit_floor(disk, facing_down(Vec3::NEG_Y))), 0.0, "under the floor");
    assert_eq!(bright(&lit_floor(AreaLightShape::Sphere { radius: 2.0 }, up)), 0.0, "inside the sphere");

    let lid = |height: f32| {
        let mut scene = scene(vec![(floor(5.0, 0.0), lambert(1.0)), (floor(3.0, height), lambert(0.0))]);
        add_light(&mut scene, disk, facing_down(Vec3::Y));
        bright(&picture(&scene, &downward_strip(0.05, 1e-3), 64))
    };
    let open = bright(&lit_floor(disk, facing_down(Vec3::Y)));
    assert_eq!(lid(0.5), 0.0, "a lid between");
    assert!((lid(1.0) / open - 1.0).abs() < 0.01, "a lamp on the ceiling, in its very plane");
    assert!((lid(1.5) / open - 1.0).abs() < 0.01, "a lid above");
}

/// A square light above a half plane: visibility across the penumbra is linear, a box cut by an edge.
#[test]
fn the_penumbra_of_a_square_has_its_closed_form() {
    let (side, height, blocker) = (0.2_f32, 2.0_f32, 1.0_f32);
    let edge = [[-9.0, blocker, 9.0], [0.0, blocker, 9.0], [0.0, blocker, -9.0], [-9.0, blocker, -9.0]];
    let mut scene =
        scene(vec![(floor(20.0, 0.0), lambert(1.0)), (polygon(&edge.map(Vec3::from)), lambert(0.0))]);
    add_light(
        &mut scene,
        AreaLightShape::Rectangle { size: Vec2::splat(side) },
        facing_down(Vec3::Y * height),
    );
    // D (d - z) / z with the light's height d and the blocker's depth z under it.
    let width = side * blocker / (height - blocker);
    let camera = downward_strip(0.5, 2.0 * width);
    let options = options(32, 1, 1024);
    let estimate = render(&scene, &camera, &constant_environment(Vec3::ZERO), &options).unwrap();
    for x in 0..32 {
        // Looking down, +x, where the floor is lit, lies to the left.
        let position = 1.5 - (x as f32 + 0.5) / 16.0;
        let expected = position.clamp(0.0, 1.0);
        let aside = width * (position - 0.5);
        let full =
            RADIANCE.x / PI * side * side * height * height / (height * height + aside * aside).powi(2);
        let (found, error) = (estimate.mean.get(x, 0).x / full, estimate.variance.get(x, 0).x.sqrt() / full);
        // The cosines vary over the light.
        assert!((found - expected).abs() < 4.0 * error + 0.01, "{x}: {found} {expected} +- {error}");
        assert!(error < 0.01);
    }
}

/// A mirror shows the light, the camera does not.
#[test]
fn mirrors_show_lights_and_the_camera_does_not() {
    let mirror = Surface { base_color: Vec3::ONE, metallic: 1.0, roughness: 0.0, ..Surface::default() };
    let mut scene = scene(vec![(floor(5.0, 0.0), mirror)]);
    add_light(&mut scene, AreaLightShape::Disk { radius: 0.5 }, facing_down(Vec3::Y * 2.0));
    let down = overall(&picture(&scene, &downward_strip(1.0, 0.2), 256)).0;
    assert!((down / RADIANCE.as_dvec3() - 1.0).abs().max_element() < 0.02, "{down}");
    let aside = Camera::look_at(Vec3::new(0.0, 1.0, 0.0), Vec3::new(0.0, 3.0, 0.0), 0.3);
    assert_eq!(overall(&picture(&scene, &aside, 16)).0, DVec3::ZERO);
}

#[test]
fn both_ways_of_rendering_include_the_lights_and_their_light_adds_up() {
    let dark = scene(vec![(floor(5.0, 0.0), lambert(0.5))]);
    let mut lit = dark.clone();
    add_light(&mut lit, AreaLightShape::Sphere { radius: 0.2 }, Affine3A::from_translation(Vec3::Y));
    add_light(&mut lit, AreaLightShape::Disk { radius: 0.2 }, facing_down(Vec3::new(0.5, 1.0, 0.0)));
    let camera = downward_strip(0.5, 1.0);
    let (night, day) = (constant_environment(Vec3::ZERO), constant_environment(Vec3::ONE));
    let options = options(8, 8, 1024);
    let parts = |scene: &Scene, map| overall(&render(scene, &camera, map, &options).unwrap());
    let (ambient, noise_ambient) = parts(&dark, &day);
    let (lights, noise_lights) = parts(&lit, &night);
    let agrees = |estimate: &Estimate| {
        let (mean, noise) = overall(estimate);
        let allowed = 4.0 * (noise + noise_ambient + noise_lights);
        assert!(allowed.cmple(0.02 * mean).all(), "too noisy to tell, {allowed}");
        assert!((mean - ambient - lights).abs().cmple(allowed).all(), "{mean} is not {ambient} + {lights}");
    };
    agrees(&render(&lit, &camera, &day, &options).unwrap());
    for shadows in [ResidualShadows::Cast, ResidualShadows::Ignore] {
        let set = LightSet::new("test", Vec::new(), day.clone());
        agrees(&render_lights(&lit, &camera, &set, shadows, &day, &options).unwrap());
    }
}
