//! Changes while running: all of one or nothing, and no more work than each needs.

use std::sync::Arc;

use crate::common::{constant_map, gpu_or_skip, one_disk};
use glam::{Affine3A, Quat, Vec3};
use gnomon_brdf::Model;
use gnomon_envmap::{Equirect, Grade};
use gnomon_lights::LightSet;
use gnomon_picture::RgbImage;
use gnomon_picture::tonemap::ToneMapping;
use gnomon_renderer::wgpu;
use gnomon_renderer::{
    Change, Gpu, GpuOptions, LightingChange, PreparedLighting, RenderError, RenderSettings, Renderer,
    SceneChange,
};
use gnomon_scene::{Camera, Ground, Mesh, Node, Scene, Texture, TextureId, TextureRef, Wrap, builtin};
use gnomon_shaders::layout;

const SIZE: [u32; 2] = [48, 36];
/// Texels along the side of the largest texture of a device that has few.
const LARGEST_TEXTURE: u32 = 512;

fn narrow_gpu() -> Option<Gpu> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::all()));
    let adapter = match Gpu::choose_adapter(adapters, &GpuOptions::default()) {
        Ok(adapter) => adapter,
        Err(error) => {
            gnomon_testing::skip(&error.to_string());
            return None;
        }
    };
    let mut descriptor = wgpu::DeviceDescriptor::default();
    descriptor.required_limits.max_texture_dimension_2d = LARGEST_TEXTURE;
    let (device, queue) = pollster::block_on(adapter.request_device(&descriptor)).unwrap();
    Some(Gpu::from_wgpu(&adapter, device, queue).unwrap())
}

fn settings() -> RenderSettings {
    RenderSettings::default().with(|s| {
        s.techniques.supersample = 1;
        s.techniques.shadow_resolution = 64;
        s.techniques.sharp_shadow_resolution = 64;
        s.lighting.ambient = "unshadowed".to_owned();
    })
}

fn scene() -> Scene {
    builtin::by_name("three-boxes").unwrap()
}

fn lights() -> LightSet {
    one_disk(Vec3::new(0.4, 0.8, 0.3).normalize(), 0.2)
}

fn prepared(map: &Equirect, settings: &RenderSettings) -> Box<PreparedLighting> {
    Box::new(PreparedLighting::new(map, &lights(), settings).unwrap())
}

fn lit(gpu: &Gpu) -> Renderer {
    let mut renderer = Renderer::new(gpu, settings()).unwrap();
    renderer.set_scene(&scene()).unwrap();
    renderer.set_lighting(&constant_map(Vec3::splat(0.5)), &lights()).unwrap();
    renderer
}

fn camera() -> Camera {
    scene().cameras[0].clone()
}

fn picture(renderer: &mut Renderer) -> (RgbImage, Vec<[u8; 4]>) {
    let frame = renderer.render(&camera(), SIZE[0], SIZE[1]).unwrap();
    (frame.radiance, frame.display)
}

/// Whatever a scene can be another by.
fn other_scene() -> Scene {
    let mut other = scene();
    let column = builtin::without_ground("column").unwrap();
    other.append(column, Node { parent_from_node: Affine3A::from_translation(Vec3::Z), ..Node::default() });
    for material in &mut other.materials {
        (material.surface.model, material.surface.base_color) = (Model::Phong, Vec3::new(0.7, 0.2, 0.1));
    }
    other
}

fn moved(x: f32) -> Scene {
    let mut moved = scene();
    moved.nodes[0].parent_from_node.translation.x += x;
    moved
}

fn textured(side: u32) -> Scene {
    let mut scene = scene();
    let rgba8 = vec![[255; 4]; side as usize];
    let texture = Texture { width: side, height: 1, rgba8, wrap: [Wrap::Repeat; 2], nearest: false };
    scene.textures.push(Arc::new(texture));
    scene.materials[0].base_color_texture =
        Some(TextureRef { texture: TextureId(0), set: 0, uv_from_mesh: Default::default() });
    scene
}

/// More vertices than a buffer of WebGPU's default size holds.
fn vast() -> Scene {
    let mut scene = scene();
    for _ in 0..2 {
        scene.push_mesh("vast", Mesh { positions: vec![Vec3::ONE; 3 << 20], ..Mesh::default() });
    }
    scene
}

#[test]
fn a_change_that_fails_leaves_no_trace() {
    let Some(gpu) = narrow_gpu() else { return };
    let mut renderer = lit(&gpu);
    let before = picture(&mut renderer);
    let with = |change: fn(&mut RenderSettings)| Some(settings().with(change));
    let (other, vast, moved_away) = (other_scene(), vast(), moved(1e20));
    let large_texture = textured(2 * LARGEST_TEXTURE);
    let large_map = prepared(&Equirect::new(RgbImage::filled(1024, 512, Vec3::ONE)), &settings());
    let turn = Some(Quat::from_rotation_y(1.0));
    // What is good of each must not be taken over either.
    let good = || Change {
        settings: with(|s| s.display.tone_mapping = ToneMapping::Linear),
        scene: Some(SceneChange::Whole(&other)),
        world_from_environment: turn,
        grade: Some(Grade { light: Vec3::splat(3.0), background: Vec3::ONE }),
        lighting: Some(LightingChange::Prepared(prepared(&constant_map(Vec3::X), &settings()))),
    };
    let of_settings = |settings| Change { settings, ..good() };
    let of_scene = |scene| Change { scene: Some(scene), ..good() };
    let refused: [(&str, Change<'_>); 14] = [
        ("candles", of_settings(with(|s| s.techniques.shadows = "candles".to_owned()))),
        ("shadow-resolution", of_settings(with(|s| s.techniques.shadow_resolution = 100))),
        ("exposure", of_settings(with(|s| s.display.exposure = Some(1e3)))),
        ("FLOAT32_FILTERABLE", of_settings(with(|s| s.techniques.shadows = "moments".to_owned()))),
        (
            "memory",
            of_settings(with(|s| {
                (s.techniques.shadow_memory, s.techniques.shadow_resolution) = (1, 8192);
            })),
        ),
        // What nobody but the device knows.
        ("device failed", of_settings(with(|s| s.techniques.shadow_resolution = 4 * LARGEST_TEXTURE))),
        (
            "device failed",
            Change {
                settings: with(|s| s.techniques.shadow_resolution = 4 * LARGEST_TEXTURE),
                ..Change::default()
            },
        ),
        ("vertices", of_scene(SceneChange::Whole(&vast))),
        ("vertices", of_scene(SceneChange::Materials(&vast))),
        ("texture", of_scene(SceneChange::Materials(&large_texture))),
        ("distance", of_scene(SceneChange::Pose(&moved_away))),
        ("rotation", Change { world_from_environment: Some(Quat::from_xyzw(0.0, 2.0, 0.0, 0.0)), ..good() }),
        ("radiance", Change { grade: Some(Grade { light: Vec3::NAN, background: Vec3::ONE }), ..good() }),
        ("environment", Change { lighting: Some(LightingChange::Prepared(large_map)), ..good() }),
    ];
    for (number, (reason, change)) in refused.into_iter().enumerate() {
        let Err(error) = renderer.change(change) else { panic!("{number}: {reason} was taken") };
        assert!(error.to_string().contains(reason), "{number}: {error}");
        assert_eq!(renderer.settings(), &settings(), "{number}");
        assert!(picture(&mut renderer) == before, "{number}: {error}");
    }
    renderer.set_debug_view("visibility", 0).unwrap();
    let view = picture(&mut renderer);
    let too_large = with(|s| s.techniques.shadow_resolution = 4 * LARGEST_TEXTURE).unwrap();
    assert!(matches!(renderer.set_settings(too_large, &lights()), Err(RenderError::Device(_))));
    assert!(picture(&mut renderer) == view && view != before);
    renderer.set_debug_view("final", 0).unwrap();
    assert!(picture(&mut renderer) == before);
    // And nothing was wrong with the rest.
    renderer.change(good()).unwrap();
    assert!(picture(&mut renderer) != before);
}

#[test]
fn a_change_of_everything_at_once_is_what_a_fresh_renderer_draws() {
    let Some(gpu) = gpu_or_skip() else { return };
    let (other, turn) = (other_scene(), Quat::from_rotation_y(0.7));
    let map = gnomon_envmap::builtin::sized("sky", 128, 64).unwrap();
    let settings = settings().with(|s| {
        s.techniques.shadows = "pcf".to_owned();
        s.techniques.shadow_sampling = 1;
        s.lighting.ambient = "cells".to_owned();
        s.lighting.ambient_cells = 8;
    });
    let all = || Change {
        settings: Some(settings.clone()),
        scene: Some(SceneChange::Whole(&other)),
        world_from_environment: Some(turn),
        grade: Some(Grade { light: Vec3::new(3.0, 2.0, 1.0), background: Vec3::ONE }),
        lighting: Some(LightingChange::Prepared(prepared(&map, &settings))),
    };
    let mut fresh = Renderer::new(&gpu, settings.clone()).unwrap();
    fresh.change(all()).unwrap();
    let mut live = lit(&gpu);
    picture(&mut live);
    live.change(all()).unwrap();
    assert_eq!(live.settings(), &settings);
    assert!(picture(&mut live) == picture(&mut fresh));
}

/// Also not on how many slices of the view their suns had maps for.
#[test]
fn a_picture_does_not_depend_on_the_scenes_before_it() {
    let Some(gpu) = gpu_or_skip() else { return };
    let mut renderer = Renderer::new(&gpu, settings()).unwrap();
    renderer.set_scene(&scene()).unwrap();
    let sun = one_disk(Vec3::new(0.4, 0.8, 0.3).normalize(), 0.01);
    renderer.set_lighting(&constant_map(Vec3::ONE), &sun).unwrap();
    let first = picture(&mut renderer);
    let mut vast = builtin::without_ground("column").unwrap();
    vast.add_ground(Ground::Catcher);
    renderer.set_scene(&vast).unwrap();
    picture(&mut renderer);
    renderer.set_scene(&scene()).unwrap();
    assert!(picture(&mut renderer) == first);
}

#[test]
fn a_change_uploads_what_is_new_of_it() {
    let Some(gpu) = gpu_or_skip() else { return };
    let mut renderer = lit(&gpu);
    picture(&mut renderer);
    let frame = {
        let before = gpu.uploaded_bytes();
        renderer.set_environment_rotation(Quat::from_rotation_y(0.1)).unwrap();
        picture(&mut renderer);
        gpu.uploaded_bytes() - before
    };
    let (moved, other, mut painted) = (moved(0.2), other_scene(), scene());
    painted.materials[0].surface.base_color = Vec3::X;
    // Instances and materials, with what stands for tables and heights that there are not.
    let tables = 144 * 8 + 336 * 4;
    let change = |scene| Change { scene: Some(scene), ..Change::default() };
    let display = settings().with(|s| s.display.exposure = Some(1.0));
    let column = builtin::without_ground("column").unwrap();
    let own: usize =
        column.meshes.iter().map(|mesh| 80 * mesh.positions.len() + 24 * mesh.triangles.len()).sum();
    // A reflectance model that is new, too: shadow techniques are made again, and this one has a table of points.
    let points = 16 * u64::from(layout::PCSS_POINTS);
    for (what, change, most) in [
        ("display", Change { settings: Some(display), ..Change::default() }, 0),
        ("pose", change(SceneChange::Pose(&moved)), tables),
        ("materials", change(SceneChange::Materials(&painted)), tables),
        ("the same scene", change(SceneChange::Whole(&painted)), tables),
        ("one more model", change(SceneChange::Whole(&other)), 2 * tables + own as u64 + points),
    ] {
        let before = gpu.uploaded_bytes();
        renderer.change(change).unwrap();
        let at_once = gpu.uploaded_bytes() - before;
        picture(&mut renderer);
        let with_frame = gpu.uploaded_bytes() - before;
        println!("{what}: {at_once} bytes, {with_frame} with the next frame of {frame}, at most {most} more");
        assert!(with_frame <= frame + most, "{what}: {with_frame}");
        assert!(at_once == 0 || what == "one more model", "{what}: {at_once} before its frame");
    }
    // Textures stay, too, where materials come beside theirs.
    let textured = textured(64);
    let mut more = textured.clone();
    more.append(builtin::without_ground("column").unwrap(), Node::default());
    renderer.set_scene(&textured).unwrap();
    let before = gpu.uploaded_bytes();
    renderer.set_scene(&more).unwrap();
    let found = gpu.uploaded_bytes() - before;
    assert!(found <= 2 * tables + own as u64 + 64, "{found}");
}
