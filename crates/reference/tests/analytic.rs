//! Scenes whose picture is known in closed form.
#![allow(clippy::unwrap_used, clippy::panic, reason = "tests and their helpers fail by panicking")]

mod support;

use glam::{DVec3, Vec2, Vec3};
use gnomon_brdf::{Frame, Model, Surface, dfg};
use gnomon_envmap::Equirect;
use gnomon_lights::{DistantLight, LightSet};
use gnomon_metrics::penumbra::disk_visibility;
use gnomon_picture::RgbImage;
use gnomon_reference::{Estimate, ReferenceOptions, ResidualShadows, render, render_lights};
use gnomon_scene::{Camera, Projection, Scene};
use gnomon_testing::{glossy_models, glossy_surface};
use support::{constant_environment, downward_strip, floor, lambert, polygon, scene, sphere};

fn options(width: u32, height: u32, samples_per_pixel: u32) -> ReferenceOptions<'static> {
    ReferenceOptions { width, height, samples_per_pixel, seed: 7, ..ReferenceOptions::default() }
}

/// Mean over the picture and the standard error of that mean.
fn overall(estimate: &Estimate) -> (DVec3, DVec3) {
    let count = estimate.mean.texels().len() as f64;
    let sum = |image: &RgbImage| image.texels().iter().map(|texel| texel.as_dvec3()).sum::<DVec3>();
    (sum(&estimate.mean) / count, sum(&estimate.variance).map(f64::sqrt) / count)
}

/// The picture's mean is `expected` within four standard errors and rounding, and those are small.
fn assert_mean(estimate: &Estimate, expected: Vec3, what: &str) {
    let (mean, error) = overall(estimate);
    let expected = expected.as_dvec3();
    let allowed = 4.0 * error + 1e-4 * expected;
    assert!((mean - expected).abs().cmple(allowed).all(), "{what}: {mean} against {expected}, error {error}");
    assert!(error.cmple(0.01 * expected + 1e-12).all(), "{what}: too noisy to tell, {error}");
}

#[test]
fn constant_light_on_lambert_is_albedo_times_radiance() {
    let radiance = Vec3::new(2.0, 1.0, 0.5);
    for albedo in [0.18, 0.5, 1.0] {
        let scene = scene(vec![(floor(5.0, 0.0), lambert(albedo))]);
        let estimate =
            render(&scene, &downward_strip(1.0, 2.0), &constant_environment(radiance), &options(16, 16, 256));
        assert_mean(&estimate.unwrap(), albedo * radiance, "floor");
    }
}

/// A white sphere in a white room cannot be seen: every pixel, edges and background included, has the room's radiance.
#[test]
fn white_furnace_hides_a_lambert_sphere() {
    let scene = scene(vec![(sphere(48, 96), lambert(1.0))]);
    let camera = Camera::look_at(Vec3::new(0.0, 1.0, 3.0), Vec3::ZERO, 1.0);
    let estimate = render(&scene, &camera, &constant_environment(Vec3::ONE), &options(32, 32, 256)).unwrap();
    let outside = estimate
        .mean
        .texels()
        .iter()
        .zip(estimate.variance.texels())
        .filter(|(mean, variance)| {
            let error = (**mean - Vec3::ONE).abs();
            error.cmpgt(5.0 * variance.map(f32::sqrt) + 1e-4).any()
        })
        .count();
    // The polygons bend away from the vertex normals, which costs a little light at the silhouette.
    assert!(outside <= 32 * 32 / 50, "{outside} pixels differ from 1");
    let (mean, _) = overall(&estimate);
    assert!((mean - 1.0).abs().max_element() < 2e-3, "{mean}");
}

/// GGX metal in a white room reflects its directional albedo, whose error in the table is under 0.003.
#[test]
fn white_furnace_shows_the_directional_albedo_of_ggx() {
    for (roughness, tilt) in [(0.2f32, 0.0f32), (0.5, 0.6), (1.0, 1.2)] {
        let surface = Surface { base_color: Vec3::ONE, metallic: 1.0, roughness, ..Surface::default() };
        let scene = scene(vec![(floor(50.0, 0.0), surface)]);
        let eye = Vec3::new(tilt.sin(), tilt.cos(), 0.0);
        let camera = Camera::look_at(eye, Vec3::ZERO, 1.0);
        let camera = Camera { projection: Projection::Orthographic { half_width: 0.1 }, ..camera };
        let estimate =
            render(&scene, &camera, &constant_environment(Vec3::ONE), &options(16, 16, 256)).unwrap();
        let (mean, error) = overall(&estimate);
        let table = dfg(tilt.cos(), roughness);
        let expected = f64::from(table.x + table.y);
        assert!((mean.x - expected).abs() < 4.0 * error.x + 3e-3, "{roughness} {tilt}: {mean} {expected}");
        assert!(error.x < 5e-3);
    }
}

/// Every model in a room with a bright window, against a sum over the whole map; Phong seen along the normal in a white room reflects
/// what its two colours are.
#[test]
fn glossy_models_match_quadrature() {
    let map = Equirect::new(RgbImage::from_fn(64, 32, |x, y| {
        Vec3::splat(if (x / 6, y / 4) == (3, 2) { 20.0 } else { 0.2 + 0.01 * x as f32 })
    }));
    for model in glossy_models() {
        let surface = Surface { specular: 0.3, ior: 3.0, ..glossy_surface(model, 0.45) };
        let seen = |tilt: f32, map: &Equirect| {
            let eye = Vec3::new(tilt.sin(), tilt.cos(), 0.0);
            let camera = Camera::look_at(eye, Vec3::ZERO, 1.0);
            let camera = Camera { projection: Projection::Orthographic { half_width: 0.1 }, ..camera };
            let floor = scene(vec![(floor(50.0, 0.0), surface)]);
            (eye, render(&floor, &camera, map, &options(16, 16, 256)).unwrap())
        };
        let (wo, estimate) = seen(0.7, &map);
        let (layers, frame) = (surface.layers(), Frame::from_normal(Vec3::Y));
        let (columns, rows) = (1024, 512);
        let mut expected = 0.0;
        for i in 0..columns * rows {
            let uv = Vec2::new((i % columns) as f32 + 0.5, (i / columns) as f32 + 0.5);
            let uv = uv / Vec2::new(columns as f32, rows as f32);
            let wi = Equirect::direction_from_uv(uv);
            if wi.y > 0.0 {
                let f = layers.evaluate(frame.local_from_world(wo), frame.local_from_world(wi));
                let weight = wi.y * (std::f32::consts::PI * uv.y).sin();
                expected += f64::from(f.x * map.lookup(wi).x * weight);
            }
        }
        expected *= 2.0 * std::f64::consts::PI.powi(2) / f64::from(columns * rows);
        assert_mean(&estimate, Vec3::splat(expected as f32), model.name());
        if model == Model::Phong {
            let (_, white) = seen(0.0, &constant_environment(Vec3::ONE));
            assert_mean(&white, Vec3::splat(0.5 + 0.3), "phong along the normal");
        }
    }
}

/// Irradiance of an uneven map, by quadrature of the lookup, on a tilted surface.
#[test]
fn uneven_light_matches_quadrature() {
    let map = Equirect::new(RgbImage::from_fn(32, 16, |x, y| {
        if (x, y) == (5, 4) {
            Vec3::new(90.0, 60.0, 30.0)
        } else {
            Vec3::new(0.1, 0.02 * x as f32, 0.03 * y as f32)
        }
    }));
    let n = Vec3::new(0.4, 0.8, -0.3).normalize();
    let (columns, rows) = (1024, 512);
    let mut irradiance = DVec3::ZERO;
    for y in 0..rows {
        let v = (y as f32 + 0.5) / rows as f32;
        for x in 0..columns {
            let d = Equirect::direction_from_uv(Vec2::new((x as f32 + 0.5) / columns as f32, v));
            let weight = f64::from(n.dot(d).max(0.0) * (std::f32::consts::PI * v).sin());
            irradiance += map.lookup(d).as_dvec3() * weight;
        }
    }
    irradiance *= 2.0 * std::f64::consts::PI.powi(2) / f64::from(columns * rows);
    let (t, b) = n.any_orthonormal_pair();
    let square = polygon(&[-t - b, t - b, t + b, b - t].map(|corner| 10.0 * corner));
    let scene = scene(vec![(square, lambert(0.5))]);
    let camera = Camera::look_at(n * 3.0 + 0.5 * t, Vec3::ZERO, 0.3);
    let estimate = render(&scene, &camera, &map, &options(16, 16, 1024)).unwrap();
    let expected = (0.5 * irradiance / std::f64::consts::PI).as_vec3();
    assert_mean(&estimate, expected, "tilted square");
}

/// One disk light straight above, a half plane 1 m over the floor: the penumbra is the part of the disk that the edge leaves.
fn half_plane_under_disk(angular_radius: f64) -> (Scene, LightSet, Camera) {
    let edge = [[-50.0, 1.0, 50.0], [0.0, 1.0, 50.0], [0.0, 1.0, -50.0], [-50.0, 1.0, -50.0]].map(Vec3::from);
    let scene = scene(vec![(floor(100.0, 0.0), lambert(1.0)), (polygon(&edge), lambert(0.0))]);
    // Radiance such that the floor, unshadowed, has radiance 1: E = L pi sin^2.
    let solid_angle = std::f64::consts::TAU * (1.0 - angular_radius.cos());
    let flux = DVec3::splat(solid_angle / angular_radius.sin().powi(2));
    let light = DistantLight::disk(DVec3::Y, angular_radius, flux);
    let lights = LightSet::new("test", vec![light], constant_environment(Vec3::ZERO));
    // Under the half plane, seeing twice the penumbra.
    let camera = downward_strip(0.5, 4.0 * angular_radius.tan() as f32);
    (scene, lights, camera)
}

#[test]
fn the_penumbra_of_a_disk_has_its_closed_form() {
    let radius = 0.05;
    let (scene, lights, camera) = half_plane_under_disk(radius);
    let background = constant_environment(Vec3::ZERO);
    let options = options(64, 1, 4096);
    let estimate =
        render_lights(&scene, &camera, &lights, ResidualShadows::Cast, &background, &options).unwrap();
    for x in 0..64 {
        // The floor is 1 m under the edge: the penumbra is as wide as the disk, the view twice that.
        // Looking down with +z up in the picture, +x, where the floor is lit, lies to the left.
        let position = 1.5 - (x as f32 + 0.5) / 32.0;
        let expected = disk_visibility(position);
        let found = estimate.mean.get(x, 0).x;
        let error = estimate.variance.get(x, 0).x.sqrt();
        // 2e-3: the cosine varies over the disk by 1 - cos 0.05 = 0.00125.
        assert!((found - expected).abs() < 4.0 * error + 2e-3, "{position}: {found} {expected} +- {error}");
        assert!(error < 0.01);
    }
    // Planted fault: a light 10 % wider has another profile.
    let wider = disk_visibility(0.5 + 0.4 / 1.1) - disk_visibility(0.9);
    assert!(wider.abs() > 4.0 * 2e-3, "{wider}");
}

#[test]
fn residual_light_is_blocked_only_where_asked() {
    let lid = scene(vec![(floor(5.0, 0.0), lambert(0.5)), (floor(500.0, 1.0), lambert(0.5))]);
    let lights = LightSet::new("test", Vec::new(), constant_environment(Vec3::splat(2.0)));
    let camera = downward_strip(0.5, 1.0);
    let background = constant_environment(Vec3::ONE);
    let mean = |shadows| {
        let options = options(8, 8, 128);
        overall(&render_lights(&lid, &camera, &lights, shadows, &background, &options).unwrap()).0.x
    };
    assert!((mean(ResidualShadows::Ignore) - 1.0).abs() < 0.02);
    assert!(mean(ResidualShadows::Cast) < 0.01);
}

/// Lights and residual of a set that is nothing but the map itself give the map's own picture.
#[test]
fn a_set_of_all_residual_is_the_environment() {
    let scene = scene(vec![(floor(5.0, 0.0), lambert(0.5)), (sphere(16, 32), lambert(0.7))]);
    let map = Equirect::new(RgbImage::from_fn(16, 8, |x, y| Vec3::new(x as f32, y as f32, 1.0)));
    let lights = LightSet::new("test", Vec::new(), map.clone());
    let camera = Camera::look_at(Vec3::new(2.0, 2.0, 3.0), Vec3::ZERO, 0.8);
    let options = options(24, 16, 64);
    let by_map = render(&scene, &camera, &map, &options).unwrap();
    let by_set = render_lights(&scene, &camera, &lights, ResidualShadows::Cast, &map, &options).unwrap();
    assert_eq!(by_map, by_set);
}
