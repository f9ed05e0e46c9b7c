//! Layers of a picture against what rays through the pixels' middles hit, worked out by hand.

use std::sync::Arc;

use crate::common::*;
use glam::{Affine3A, Mat3, Vec2, Vec3};
use gnomon_lights::FitOptions;
use gnomon_metrics::compare;
use gnomon_renderer::layers::{Layer, LayerRequest, LayerValues, RenderedLayers};
use gnomon_renderer::{RenderError, RenderSettings, Renderer};
use gnomon_scene::{
    AreaLight, AreaLightShape, Camera, Film, Material, MaterialId, Mesh, MeshId, Node, NodeId, Projection,
    Scene,
};

const SIZE: [u32; 2] = [96, 64];

/// A square of side 2 in the plane y = 0, whose coordinates run from 0 to 3 along x and to 2 along z.
fn square(material: usize) -> Mesh {
    let corners = [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)];
    let uv = |(x, z): (f32, f32)| Vec2::new(1.5 * (x + 1.0), z + 1.0);
    Mesh {
        uvs: [corners.map(uv).to_vec(), Vec::new()],
        material: Some(MaterialId(material)),
        ..horizontal(Vec2::NEG_ONE, Vec2::ONE, 0.0)
    }
}

/// A ground, and a square that leans over it; the nodes' numbers are not those of their meshes.
fn scene(lean: Affine3A) -> Scene {
    let node = |mesh: Option<usize>, parent_from_node| Node {
        meshes: mesh.map(MeshId).into_iter().collect(),
        parent_from_node,
        ..Node::default()
    };
    let ground = Affine3A::from_scale(Vec3::splat(3.0));
    let red = Material { emissive: Vec3::new(0.1, 0.2, 0.3), ..Material::default() };
    Scene {
        meshes: vec![Arc::new(square(1)), Arc::new(square(0))],
        nodes: vec![node(None, Affine3A::IDENTITY), node(Some(0), lean), node(Some(1), ground)],
        materials: vec![Material::default(), red],
        ..Scene::default()
    }
}

fn leaning(aside: f32) -> Affine3A {
    Affine3A::from_translation(Vec3::new(aside, 0.9, 0.2))
        * Affine3A::from_rotation_x(1.1)
        * Affine3A::from_scale(Vec3::splat(0.6))
}

fn cameras() -> [Camera; 2] {
    let mut camera = Camera::look_at(Vec3::new(0.8, 1.9, 3.2), Vec3::new(0.0, 0.5, 0.0), 0.9);
    camera.film = Film { shift: Vec2::new(0.1, -0.07), pixel_aspect: 1.25 };
    let parallel = Camera { projection: Projection::Orthographic { half_width: 1.7 }, ..camera.clone() };
    [camera, parallel]
}

fn rendered(renderer: &mut Renderer, camera: &Camera, layers: &[Layer]) -> RenderedLayers {
    renderer.render_layers(camera, SIZE[0], SIZE[1], layers).unwrap().1
}

fn floats(layers: &RenderedLayers, layer: Layer) -> &[f32] {
    match &layers.get(layer).unwrap().values {
        LayerValues::Floats(floats) => floats,
        LayerValues::Labels(_) => panic!("{layer:?} has labels"),
    }
}

fn labels(layers: &RenderedLayers, layer: Layer) -> &[u32] {
    match &layers.get(layer).unwrap().values {
        LayerValues::Labels(labels) => labels,
        LayerValues::Floats(_) => panic!("{layer:?} has floats"),
    }
}

fn vectors(layers: &RenderedLayers, layer: Layer) -> Vec<Vec3> {
    floats(layers, layer).chunks(3).map(Vec3::from_slice).collect()
}

/// Half the width of what is seen, at a distance of 1 m or in a parallel view [m].
fn extent(camera: &Camera) -> (f32, bool) {
    match camera.projection {
        Projection::Perspective { fov_x } => ((0.5 * fov_x).tan(), false),
        Projection::Orthographic { half_width } => (half_width, true),
    }
}

/// Origin and direction, whose length along the axis is 1, of the ray through a place in the picture [pixels].
fn ray(camera: &Camera, pixel: Vec2) -> (Vec3, Vec3) {
    let half = 0.5 * SIZE[0] as f32;
    let place = Vec2::new(pixel.x - half, 0.5 * SIZE[1] as f32 - pixel.y) / half;
    let (extent, is_parallel) = extent(camera);
    let plane = extent * (place * Vec2::new(1.0, camera.film.pixel_aspect) + 2.0 * camera.film.shift);
    let axes = Mat3::from_mat4(camera.world_from_camera);
    match is_parallel {
        true => (camera.eye() + axes * plane.extend(0.0), axes * Vec3::NEG_Z),
        false => (camera.eye(), axes * plane.extend(-1.0)),
    }
}

/// Where a point is seen [pixels].
fn pixel_of(camera: &Camera, point: Vec3) -> Vec2 {
    let seen = camera.world_from_camera.inverse().transform_point3(point);
    let (extent, is_parallel) = extent(camera);
    let plane = seen.truncate() / extent / if is_parallel { 1.0 } else { -seen.z };
    let place = (plane - 2.0 * camera.film.shift) / Vec2::new(1.0, camera.film.pixel_aspect);
    0.5 * (Vec2::new(SIZE[0] as f32, SIZE[1] as f32) + SIZE[0] as f32 * place * Vec2::new(1.0, -1.0))
}

struct Hit {
    node: usize,
    depth: f32,
    /// In the node's space.
    local: Vec3,
}

/// The nearest square on a ray; `None` in the second place where the ray passes within a thousandth of an edge.
fn nearest(scene: &Scene, (origin, direction): (Vec3, Vec3)) -> Option<Option<Hit>> {
    let mut hit: Option<Hit> = None;
    for (node, placed) in scene.nodes.iter().enumerate().filter(|(_, node)| !node.meshes.is_empty()) {
        let inverse = placed.parent_from_node.inverse();
        let (o, d) = (inverse.transform_point3(origin), inverse.transform_vector3(direction));
        let depth = -o.y / d.y;
        let local = o + depth * d;
        let reach = local.x.abs().max(local.z.abs());
        if (reach - 1.0).abs() < 1e-3 {
            return None;
        }
        if reach < 1.0 && depth > 0.0 && hit.as_ref().is_none_or(|hit| depth < hit.depth) {
            hit = Some(Hit { node, depth, local });
        }
    }
    Some(hit)
}

fn lit(gpu: &gnomon_renderer::Gpu) -> Renderer {
    let mut renderer = Renderer::new(gpu, RenderSettings::default()).unwrap();
    let map = gnomon_envmap::builtin::sized("room", 128, 64).unwrap();
    let options = FitOptions { light_count: Some(8), ..FitOptions::default() };
    let set = gnomon_lights::fit::by_name("partition", &options).unwrap().fit(&map).unwrap();
    renderer.set_lighting(&map, &set).unwrap();
    renderer
}

/// One renderer for all of it: pipelines take their time.
#[test]
fn layers_are_what_rays_hit_and_parts_of_the_picture() {
    let Some(gpu) = gpu_or_skip() else { return };
    let mut renderer = lit(&gpu);
    geometry_layers_are_what_rays_hit(&mut renderer);
    motion_is_the_way_in_the_picture(&mut renderer);
    composed_layers_are_parts_of_the_picture(&mut renderer);
}

fn geometry_layers_are_what_rays_hit(renderer: &mut Renderer) {
    let scene = scene(leaning(0.0));
    renderer.set_scene(&scene).unwrap();
    let asked = [
        Layer::Depth,
        Layer::Normal,
        Layer::Position,
        Layer::Uv,
        Layer::Object,
        Layer::Material,
        Layer::Object,
    ];
    for camera in cameras() {
        let layers = rendered(renderer, &camera, &asked);
        assert_eq!(layers.layers.len(), 6, "each once");
        let (depths, uvs) = (floats(&layers, Layer::Depth), floats(&layers, Layer::Uv));
        let (normals, positions) = (vectors(&layers, Layer::Normal), vectors(&layers, Layer::Position));
        let (objects, materials) = (labels(&layers, Layer::Object), labels(&layers, Layer::Material));
        let mut counts = [0; 3];
        for (i, &depth) in depths.iter().enumerate() {
            let (x, y) = (i as u32 % SIZE[0], i as u32 / SIZE[0]);
            let ray = ray(&camera, Vec2::new(x as f32 + 0.5, y as f32 + 0.5));
            let Some(hit) = nearest(&scene, ray) else { continue };
            let Some(Hit { node, depth: expected, local }) = hit else {
                let is_empty = normals[i] == Vec3::ZERO && positions[i] == Vec3::ZERO;
                assert!(depth == f32::INFINITY && is_empty, "{x} {y}");
                assert_eq!((objects[i], materials[i]), (0, 0));
                counts[0] += 1;
                continue;
            };
            counts[node] += 1;
            assert_eq!((objects[i], materials[i]), (node as u32 + 1, 3 - node as u32), "{x} {y}");
            assert!((depth - expected).abs() < 2e-5 * expected, "{x} {y}: {depth}, not {expected}");
            assert!((positions[i] - (ray.0 + expected * ray.1)).length() < 5e-5 * expected);
            let up = scene.nodes[node].parent_from_node.transform_vector3(Vec3::Y).normalize();
            let normal = if up.dot(ray.1) < 0.0 { up } else { -up };
            assert!((normals[i] - normal).length() < 2e-4, "{x} {y}: {}, not {normal}", normals[i]);
            let uv = Vec2::new(1.5 * (local.x + 1.0), local.z + 1.0);
            assert!((Vec2::from_slice(&uvs[2 * i..]) - uv).length() < 1e-4, "{x} {y}");
        }
        println!("background, square, ground: {counts:?} pixels");
        assert!(counts.iter().all(|&count| count > 200), "{counts:?}");
    }
}

fn motion_is_the_way_in_the_picture(renderer: &mut Renderer) {
    let (before, now) = (scene(leaning(-0.1)), scene(leaning(0.05)));
    for camera in cameras() {
        let mut camera_before = camera.clone();
        camera_before.world_from_camera =
            glam::Mat4::from_rotation_translation(glam::Quat::from_rotation_y(0.02), Vec3::X * 0.1)
                * camera.world_from_camera;
        renderer.move_scene(&before).unwrap();
        renderer.remember_for_motion(&camera_before).unwrap();
        renderer.move_scene(&now).unwrap();
        let layers = rendered(renderer, &camera, &[Layer::Motion]);
        let motion = floats(&layers, Layer::Motion);
        let mut longest = [0.0_f32; 3];
        for i in 0..SIZE[0] * SIZE[1] {
            let pixel = Vec2::new((i % SIZE[0]) as f32 + 0.5, (i / SIZE[0]) as f32 + 0.5);
            let ray = ray(&camera, pixel);
            let is_parallel = matches!(camera.projection, Projection::Orthographic { .. });
            let (place, node) = match nearest(&now, ray) {
                None => continue,
                Some(Some(Hit { node, local, .. })) => {
                    let place = before.nodes[node].parent_from_node.transform_point3(local);
                    (pixel_of(&camera_before, place), node)
                }
                // Nothing far away moves in a parallel view.
                Some(None) if is_parallel => (pixel, 0),
                Some(None) => (pixel_of(&camera_before, camera_before.eye() + ray.1), 0),
            };
            let found = Vec2::from_slice(&motion[2 * i as usize..]);
            assert!((found - (pixel - place)).length() < 5e-3, "{pixel}: {found}, not {}", pixel - place);
            longest[node] = longest[node].max(found.length());
        }
        assert!(longest[1] > 1.0 && longest[2] > 0.5, "{longest:?}");
    }
    // Another scene has no frame before it.
    renderer.set_scene(&scene_of(vec![square(0)], Material::default())).unwrap();
    let layers = rendered(renderer, &cameras()[0], &[Layer::Motion]);
    assert!(floats(&layers, Layer::Motion).iter().all(|way| way.abs() < 1e-3));
}

fn composed_layers_are_parts_of_the_picture(renderer: &mut Renderer) {
    let mut scene = scene(leaning(0.0));
    scene.materials[0].surface.base_color = Vec3::new(0.5, 0.25, 0.125);
    renderer.set_scene(&scene).unwrap();
    let camera = &cameras()[0];
    let asked = [Layer::Albedo, Layer::Alpha, Layer::Shadow, Layer::Diffuse, Layer::Specular, Layer::Object];
    let (frame, layers) = renderer.render_layers(camera, SIZE[0], SIZE[1], &asked).unwrap();
    let plain = renderer.render(camera, SIZE[0], SIZE[1]).unwrap();
    assert_eq!(frame.display, plain.display, "layers change no picture");
    let (diffuse, specular) = (vectors(&layers, Layer::Diffuse), vectors(&layers, Layer::Specular));
    let (alpha, objects) = (floats(&layers, Layer::Alpha), labels(&layers, Layer::Object));
    let (shadow, albedo) = (vectors(&layers, Layer::Shadow), vectors(&layers, Layer::Albedo));
    let mut darkest = 1.0_f32;
    for (i, radiance) in frame.radiance.texels().iter().enumerate() {
        if alpha[i] == 0.0 {
            assert_eq!((objects[i], diffuse[i], shadow[i]), (0, Vec3::ZERO, Vec3::ONE));
        }
        if alpha[i] < 1.0 {
            continue;
        }
        assert_ne!(objects[i], 0);
        let ground = objects[i] == 3;
        let emission = if ground { Vec3::ZERO } else { Vec3::new(0.1, 0.2, 0.3) };
        let sum = diffuse[i] + specular[i] + emission;
        let is_edge =
            (albedo[i] - if ground { Vec3::new(0.5, 0.25, 0.125) } else { Vec3::splat(0.5) }).length() > 2e-3;
        assert!(
            is_edge || (sum - *radiance).length() < 1e-3 * radiance.length(),
            "{i}: {sum}, not {radiance}"
        );
        darkest = darkest.min(shadow[i].min_element());
    }
    assert!((0.01..0.8).contains(&darkest), "{darkest}");
    renderer.set_debug_view("normals", 0).unwrap();
    let refused = renderer.render_layers(camera, 8, 8, &[Layer::Depth]);
    assert!(matches!(refused, Err(RenderError::NoLayers { .. })));
}

/// A scene with everything that the picture may be the sum of: a gloss, an emission, a lamp, and lights that share maps in turns.
#[test]
fn layers_of_lights_add_up_to_the_picture() {
    let Some(gpu) = gpu_or_skip() else { return };
    let mut scene = scene(leaning(0.0));
    scene.materials[0].surface.base_color = Vec3::new(0.6, 0.25, 0.125);
    scene.materials[0].surface.specular = 1.0;
    scene.materials[0].surface.roughness = 0.4;
    scene.nodes.push(Node {
        parent_from_node: Affine3A::from_translation(Vec3::new(0.8, 1.2, 0.9)),
        ..Node::default()
    });
    scene.lights.push(AreaLight {
        node: NodeId(3),
        shape: AreaLightShape::Sphere { radius: 0.05 },
        radiance: Vec3::new(30.0, 20.0, 10.0),
        spread: Default::default(),
    });
    let camera = &cameras()[0];
    let map = gnomon_envmap::builtin::sized("room", 128, 64).unwrap();
    let options = FitOptions { light_count: Some(12), ..FitOptions::default() };
    let set = gnomon_lights::fit::by_name("disks", &options).unwrap().fit(&map).unwrap();
    for (compositing, shadows, memory) in [("ratio", "pcss", 1), ("additive", "rays", 1024)] {
        let settings = RenderSettings::default().with(|s| {
            s.techniques.compositing = compositing.to_owned();
            s.techniques.shadows = shadows.to_owned();
            s.techniques.shadow_memory = memory;
            s.techniques.shadow_resolution = 64;
            s.techniques.sharp_shadow_resolution = 256;
        });
        let mut renderer = Renderer::new(&gpu, settings).unwrap();
        renderer.set_scene(&scene).unwrap();
        renderer.set_lighting(&map, &set).unwrap();
        let request = LayerRequest { layers: vec![Layer::Lights], light_layers: 4 };
        let (frame, layers) = renderer.render_layers(camera, SIZE[0], SIZE[1], &request).unwrap();
        let names: Vec<_> =
            layers.layers.iter().map(|layer| layer.channels[0].trim_end_matches(".R").to_owned()).collect();
        assert_eq!(names[..4], ["emission", "reflections", "background", "ambient"]);
        assert_eq!(names.len(), 8, "{names:?}");
        assert_eq!(names[7], "lights-rest");
        let radiance = frame.radiance.texels();
        let mut sum = vec![Vec3::ZERO; radiance.len()];
        for (layer, name) in layers.layers.iter().zip(&names) {
            let LayerValues::Floats(values) = &layer.values else { panic!("no radiance") };
            assert!(values.iter().all(|value| *value >= 0.0), "{name}");
            let is_dark = values.iter().all(|value| *value == 0.0);
            assert!(!is_dark, "{compositing} {shadows}: {name} gives nothing");
            sum.iter_mut().zip(values.chunks(3)).for_each(|(sum, value)| *sum += Vec3::from_slice(value));
        }
        let off = |(sum, radiance): (&Vec3, &Vec3)| (*sum - *radiance).length() / radiance.length().max(1e-3);
        let worst = sum.iter().zip(radiance).map(off).fold(0.0, f32::max);
        println!("{compositing} {shadows} {memory} MiB: {worst:.1e}");
        assert!(worst < 1e-4, "{compositing} {shadows}: {worst}");
        // The next picture is drawn as ever.
        let plain = renderer.render(camera, SIZE[0], SIZE[1]).unwrap().radiance;
        let other = compare(&plain, &frame.radiance, None).unwrap().relative_rmse;
        assert!(other < 1e-3, "{other}");
    }
    let settings = RenderSettings::default().with(|s| s.techniques.compositing = "subtractive".to_owned());
    let mut renderer = Renderer::new(&gpu, settings).unwrap();
    renderer.set_lighting(&map, &set).unwrap();
    let refused = renderer.render_layers(camera, 8, 8, &[Layer::Lights]);
    assert!(matches!(refused, Err(RenderError::NoLayers { .. })));
}
