//! Shadows of surfaces that alpha cuts holes into.

use std::sync::Arc;

use crate::common::*;
use glam::{Affine2, Vec2, Vec3};
use gnomon_metrics::compare;
use gnomon_picture::RgbImage;
use gnomon_renderer::{Gpu, RenderSettings, Renderer};
use gnomon_scene::{
    AlphaMode, AreaLight, AreaLightShape, Camera, Material, MaterialId, Mesh, Node, NodeId, Projection,
    Scene, Texture, TextureId, TextureRef, Wrap,
};
use gnomon_testing::tolerances;

/// A plate 1 m above a floor, of 1 x 1 m with a texture whose left half is clear, or of its opaque half alone.
fn plate(material: Material, half: bool) -> Scene {
    let left = if half { 0.0 } else { -0.5 };
    let floor = horizontal(Vec2::splat(-2.0), Vec2::splat(2.0), 0.0);
    let mut plate = horizontal(Vec2::new(left, -0.5), Vec2::splat(0.5), 1.0);
    plate.uvs[0] = plate.positions.iter().map(|p| Vec2::new(p.x + 0.5, p.z + 0.5)).collect();
    let mut scene = scene_of(vec![floor, plate], Material::default());
    scene.materials.push(material);
    let mesh: &mut Mesh = Arc::make_mut(&mut scene.meshes[1]);
    mesh.material = Some(MaterialId(1));
    let rgba8 = (0..64).map(|i| [255, 255, 255, if i % 8 < 4 { 0 } else { 255 }]).collect();
    let texture = Texture { width: 8, height: 8, rgba8, wrap: [Wrap::ClampToEdge; 2], nearest: true };
    scene.textures.push(Arc::new(texture));
    scene
}

fn material(alpha_mode: AlphaMode) -> Material {
    let texture = TextureRef { texture: TextureId(0), uv_from_mesh: Affine2::IDENTITY, set: 0 };
    Material { base_color_texture: Some(texture), alpha_mode, ..Material::default() }
}

fn settings(shadows: &str) -> RenderSettings {
    RenderSettings::default().with(|s| {
        s.techniques.shadows = shadows.to_owned();
        s.techniques.compositing = "additive".to_owned();
        s.techniques.supersample = 1;
        s.techniques.shadow_sampling = 1;
    })
}

/// Beside the plate.
fn camera() -> Camera {
    Camera {
        projection: Projection::Orthographic { half_width: 0.9 },
        ..Camera::look_at(Vec3::new(1.6, 0.9, 1e-3), Vec3::new(1.6, 0.0, 0.0), 1.0)
    }
}

/// The floor beside the plate, under a light whose shadow falls there.
fn shadow(gpu: &Gpu, shadows: &str, scene: &Scene, near: bool) -> RgbImage {
    let mut scene = scene.clone();
    let set = if near {
        let down = glam::Mat3::from_cols(Vec3::X, Vec3::NEG_Z, Vec3::Y);
        let parent_from_node = glam::Affine3A::from_mat3_translation(down, Vec3::new(-1.5, 3.0, 0.0));
        scene.nodes.push(Node { parent_from_node, ..Node::default() });
        let shape = AreaLightShape::Disk { radius: 0.05 };
        scene.lights.push(AreaLight {
            node: NodeId(scene.nodes.len() - 1),
            shape,
            radiance: Vec3::splat(100.0),
            spread: Default::default(),
        });
        gnomon_lights::LightSet::new("none", Vec::new(), no_light())
    } else {
        one_disk(Vec3::new(-1.5, 1.0, 0.0).normalize(), 0.02)
    };
    render(gpu, settings(shadows), &scene, &no_light(), &set, &camera(), [48, 48]).radiance
}

#[test]
fn holes_cast_no_shadow() {
    let Some(gpu) = gpu_or_skip() else { return };
    let masked = plate(material(AlphaMode::Mask { cutoff: 0.5 }), false);
    let opaque = plate(material(AlphaMode::Opaque), false);
    let half = plate(Material::default(), true);
    for (shadows, near) in
        [("pcss", false), ("hard", false), ("rays", false), ("pcss", true), ("hard", true), ("rays", true)]
    {
        let of = |scene: &Scene| shadow(&gpu, shadows, scene, near);
        let right = of(&half);
        let error = |picture: RgbImage| compare(&picture, &right, None).unwrap().relative_rmse;
        let (masked, opaque) = (error(of(&masked)), error(of(&opaque)));
        println!("{shadows}, near {near}: {masked:.4}, a whole plate {opaque:.4}");
        assert!(masked <= tolerances::MASKED_SHADOW, "{shadows}, near {near}: {masked}");
        assert!(opaque > 5.0 * tolerances::MASKED_SHADOW, "{shadows}, near {near}: a whole plate {opaque}");
    }
}

#[test]
fn another_threshold_cuts_other_holes() {
    let Some(gpu) = gpu_or_skip() else { return };
    let of = |cutoff| plate(material(AlphaMode::Mask { cutoff }), false);
    let set = one_disk(Vec3::new(-1.5, 1.0, 0.0).normalize(), 0.02);
    for shadows in ["pcss", "rays"] {
        let mut renderer = Renderer::new(&gpu, settings(shadows)).unwrap();
        renderer.set_lighting(&no_light(), &set).unwrap();
        let mut drawn = |scene: &Scene| {
            renderer.set_materials(scene).unwrap();
            renderer.render(&camera(), 48, 48).unwrap().radiance
        };
        // Nothing is below 0: the whole plate casts its shadow.
        let (half, whole, half_again) = (drawn(&of(0.5)), drawn(&of(0.0)), drawn(&of(0.5)));
        assert_eq!(half, half_again, "{shadows}");
        assert!(compare(&whole, &half, None).unwrap().relative_rmse > 0.2, "{shadows}");
    }
}
