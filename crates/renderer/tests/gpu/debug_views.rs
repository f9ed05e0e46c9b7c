//! Debug views against what they must show by construction.

use crate::common::{constant_map, gpu_or_skip, horizontal, no_light, one_disk, scene_of, sphere};
use glam::{Affine2, DVec3, Vec2, Vec3};
use gnomon_lights::{DistantLight, LightSet};
use gnomon_renderer::debug_view::DEBUG_VIEWS;
use gnomon_renderer::shadow::VisibilityPath;
use gnomon_renderer::{Gpu, RenderError, RenderSettings, Renderer, shadow};
use gnomon_scene::{Camera, Material, Scene, Texture, TextureId, TextureRef, Wrap};

const SIZE: u32 = 64;

fn settings() -> RenderSettings {
    RenderSettings::default().with(|s| {
        s.techniques.supersample = 1;
        s.techniques.shadow_sampling = 1;
        s.lighting.ambient = "unshadowed".to_owned();
    })
}

fn renderer(gpu: &Gpu, settings: RenderSettings, scene: &Scene, set: &LightSet) -> Renderer {
    let mut renderer = Renderer::new(gpu, settings).unwrap();
    renderer.set_scene(scene).unwrap();
    renderer.set_lighting(&constant_map(Vec3::ONE), set).unwrap();
    renderer
}

/// The displayed bytes of a view of `width` x `height` pixels.
fn shown(
    renderer: &mut Renderer,
    camera: &Camera,
    (name, light): (&str, usize),
    [width, height]: [u32; 2],
) -> impl Fn(u32, u32) -> [u8; 4] + use<> {
    renderer.set_debug_view(name, light).unwrap();
    let display = renderer.render(camera, width, height).unwrap().display;
    move |x, y| display[(y * width + x) as usize]
}

fn from_front() -> Camera {
    Camera::look_at(Vec3::new(0.0, 0.0, 4.0), Vec3::ZERO, 0.9)
}

#[track_caller]
fn assert_near(got: [u8; 4], want: [u8; 3]) {
    let off = (0..3).map(|i| got[i].abs_diff(want[i])).max();
    assert!(off <= Some(3), "{got:?}, not {want:?}");
}

#[test]
fn surface_views_show_normal_depth_and_base_colour() {
    let Some(gpu) = gpu_or_skip() else { return };
    let mut material = Material::default();
    material.surface.base_color = Vec3::new(0.5, 0.25, 0.0);
    let scene = scene_of(vec![sphere()], material);
    let mut renderer = renderer(&gpu, settings(), &scene, &one_disk(Vec3::Y, 0.3));
    let size = [SIZE, SIZE];
    let normals = shown(&mut renderer, &from_front(), ("normals", 0), size);
    assert_near(normals(32, 32), [128, 128, 255]);
    assert!(normals(45, 32)[0] > 180 && normals(32, 20)[1] > 180, "x is right, y is up");
    let depth = shown(&mut renderer, &from_front(), ("depth", 0), size);
    // The sphere's nearest point is the nearest that its box allows.
    assert_near(depth(32, 32), [255, 255, 255]);
    assert!(depth(46, 32)[0] < 220 && depth(0, 0)[0] < 40);
    let base = shown(&mut renderer, &from_front(), ("base-color", 0), size);
    assert_near(base(32, 32), [188, 137, 0]);
}

/// A floor seen from above, with a square in the air over its middle, as seen past it.
fn under_a_square() -> (Scene, Camera) {
    let floor = horizontal(Vec2::splat(-2.0), Vec2::splat(2.0), 0.0);
    let square = horizontal(Vec2::splat(-0.5), Vec2::splat(0.5), 1.0);
    let camera = Camera::look_at(Vec3::new(0.0, 0.6, 3.0), Vec3::new(0.0, 0.0, 0.0), 0.9);
    (scene_of(vec![floor, square], Material::default()), camera)
}

#[test]
fn visibility_is_of_the_chosen_light_alone() {
    let Some(gpu) = gpu_or_skip() else { return };
    let (scene, camera) = under_a_square();
    // One light above the square, one that comes in from the left below it.
    let light = |direction: DVec3| DistantLight::disk(direction.normalize(), 0.05, DVec3::splat(0.01));
    let lights = vec![light(DVec3::Y), light(DVec3::new(-1.0, 0.35, 0.0)), light(DVec3::NEG_Y)];
    let set = LightSet::new("test", lights, no_light());
    let hard = settings().with(|s| {
        s.techniques.shadows = "hard".to_owned();
        s.techniques.shadow_resolution = 512;
    });
    let mut renderer = renderer(&gpu, hard, &scene, &set);
    assert_eq!(renderer.light_count(), 3);
    let mut at_middle = |view| shown(&mut renderer, &camera, view, [SIZE, SIZE])(32, 34);
    assert_near(at_middle(("visibility", 0)), [0, 0, 0]);
    assert_near(at_middle(("visibility", 1)), [255, 255, 255]);
    let below = at_middle(("visibility", 2));
    assert!(below[2] > below[0] && below[0] > 0, "below the horizon there is no answer: {below:?}");
    assert_eq!(at_middle(("visibility", 99)), below, "past the last is the last");
    // Both lights have one flux, and the floor's cosines weigh them.
    let slant = 0.35 / 1.0_f32.hypot(0.35);
    let share = (255.0 * slant / (1.0 + slant)).round() as u8;
    assert_near(at_middle(("shadow-buffer", 0)), [share; 3]);
}

/// Lights of a batch lie four to a word of the buffer, and batches take turns in it.
#[test]
fn visibility_through_a_buffer_is_shown_as_inline_visibility_is() {
    let Some(gpu) = gpu_or_skip() else { return };
    let (scene, camera) = under_a_square();
    let direction = |i: u32| {
        DVec3::new(0.4 * (f64::from(i) * 1.3).sin(), 1.0, 0.4 * (f64::from(i) * 1.3).cos()).normalize()
    };
    let lights = (0..10).map(|i| DistantLight::disk(direction(i), 0.2, DVec3::splat(0.01)));
    let set = LightSet::new("test", lights.collect(), no_light());
    for sampling in [1, 2] {
        // In a batch of its own a light takes other points of its outline: where batches differ, points of the outline must not count.
        for (shadows, memory) in [("hard", 1), ("pcss", 64)] {
            let with = |visibility| {
                settings().with(|s| {
                    s.techniques.shadows = shadows.to_owned();
                    s.techniques.visibility = visibility;
                    s.techniques.shadow_resolution = 256;
                    s.techniques.shadow_sampling = sampling;
                    s.techniques.shadow_memory = memory;
                    // A rounded visibility may ask for points elsewhere.
                    s.techniques.shadow_contrast = 1.0;
                })
            };
            let mut inline = renderer(&gpu, with(VisibilityPath::Inline), &scene, &set);
            let mut buffered = renderer(&gpu, with(VisibilityPath::Buffered), &scene, &set);
            let mut hidden = 0;
            for (view, light) in
                (0..10).map(|light| ("visibility", light)).chain([("shadow-buffer", 0), ("shadow-map", 7)])
            {
                let [expected, found] = [&mut inline, &mut buffered].map(|renderer| {
                    renderer.set_debug_view(view, light).unwrap();
                    renderer.render(&camera, SIZE, SIZE).unwrap().display
                });
                // A byte of visibility, encoded for a display.
                let far = found.iter().flatten().zip(expected.iter().flatten()).map(|(a, b)| a.abs_diff(*b));
                let far = far.max().unwrap();
                assert!(far <= 2, "{view} {light}, {sampling}, {memory} MiB: off by {far} of 255");
                hidden += usize::from(view == "visibility" && expected.iter().any(|texel| texel[0] < 8));
            }
            // Tiles of several samples lighten a shadow this small.
            assert!(hidden == 10 || sampling > 1, "the square hides every light from some of the floor");
            assert_eq!(buffered.shadow_batches() > 1, memory == 1);
        }
    }
}

#[test]
fn a_view_leaves_the_picture_as_it_was() {
    let Some(gpu) = gpu_or_skip() else { return };
    let (scene, camera) = under_a_square();
    let mut renderer =
        renderer(&gpu, RenderSettings::default().with(|s| s.techniques.supersample = 1), &scene, &{
            one_disk(Vec3::new(0.3, 0.9, 0.1).normalize(), 0.3)
        });
    let before = renderer.render(&camera, SIZE, SIZE).unwrap().display;
    for view in DEBUG_VIEWS {
        renderer.set_debug_view(view.name, 1).unwrap();
        renderer.render(&camera, SIZE, SIZE).unwrap();
    }
    let Err(error @ RenderError::UnknownName { .. }) = renderer.set_debug_view("norms", 0) else {
        panic!("an unknown view was taken")
    };
    assert!(error.to_string().contains("base-color"), "{error}");
    renderer.set_debug_view("final", 0).unwrap();
    assert_eq!(renderer.render(&camera, SIZE, SIZE).unwrap().display, before);
}

#[test]
fn lights_are_outlined_where_they_are_on_the_map() {
    let Some(gpu) = gpu_or_skip() else { return };
    // +z is the map's middle; 0.5 rad are 20.4 of 256 columns.
    let set = one_disk(Vec3::Z, 0.5);
    let mut renderer = renderer(&gpu, settings(), &scene_of(vec![sphere()], Material::default()), &set);
    let map = shown(&mut renderer, &from_front(), ("lights", 0), [256, 144]);
    // The map is 256 x 128 in the middle of the picture.
    let plain = map(128, 72);
    assert_eq!(map(60, 72), plain);
    assert!(map(128, 3)[0] < 40, "above the map there is nothing");
    let outline = |from: u32, to: u32| (from..to).any(|x| map(x, 72) != plain);
    assert!(outline(105, 110) && outline(146, 151) && !outline(112, 144) && !outline(0, 104));
}

#[test]
fn a_shadow_map_shows_what_the_light_sees() {
    let Some(gpu) = gpu_or_skip() else { return };
    let scene = scene_of(vec![sphere()], Material::default());
    let mut renderer = renderer(&gpu, settings(), &scene, &one_disk(Vec3::Y, 0.2));
    let map = shown(&mut renderer, &from_front(), ("shadow-map", 0), [2 * SIZE, SIZE]);
    let (middle, corner, beside) = (map(64, 32), map(34, 2), map(5, 32));
    assert!(middle[0] > 200 && corner[2] > corner[0] && beside[0] < 40, "{middle:?} {corner:?} {beside:?}");
}

#[test]
fn a_shadow_map_is_the_chosen_lights_also_where_batches_share_their_maps() {
    let Some(gpu) = gpu_or_skip() else { return };
    let scene = scene_of(vec![sphere()], Material::default());
    let lights = [Vec3::Y, Vec3::X].map(|direction| one_disk(direction, 0.2).lights);
    let set = LightSet::new("two", lights.concat(), no_light());
    let picture = |shadow_memory| {
        let settings = settings().with(|s| {
            s.techniques.shadow_resolution = 512;
            s.techniques.shadow_memory = shadow_memory;
        });
        let mut renderer = renderer(&gpu, settings, &scene, &set);
        renderer.set_debug_view("shadow-map", 0).unwrap();
        (renderer.shadow_batches(), renderer.render(&from_front(), SIZE, SIZE).unwrap().display)
    };
    let (together, in_turn) = (picture(1024), picture(1));
    assert_eq!((together.0, in_turn.0), (1, 2));
    assert!(together.1 == in_turn.1, "another light's map is shown");
}

#[test]
fn points_are_white_once_a_tile_and_red_at_edges() {
    let Some(gpu) = gpu_or_skip() else { return };
    let floor = horizontal(Vec2::splat(-9.0), Vec2::splat(9.0), -1.0);
    let scene = scene_of(vec![floor, sphere()], Material::default());
    let camera = Camera::look_at(Vec3::new(0.0, 2.0, 4.0), Vec3::ZERO, 0.9);
    let coarse = settings().with(|s| {
        s.techniques.shadow_sampling = 8;
        s.techniques.sharp_shadow_sampling = 8;
        s.techniques.shadow_contrast = 1.0;
    });
    let mut renderer = renderer(&gpu, coarse, &scene, &one_disk(Vec3::Y, 0.2));
    let at = shown(&mut renderer, &camera, ("points", 0), [SIZE, SIZE]);
    let pixels = || (0..SIZE).flat_map(|y| (0..SIZE).map(move |x| (x, y)));
    let white = pixels().filter(|&(x, y)| at(x, y) == [255; 4]).count();
    let red = pixels().filter(|&(x, y)| at(x, y)[0] == 255 && at(x, y)[1] < 128).count();
    assert!((8..=64).contains(&white), "{white} tiles");
    assert!((1..(SIZE * SIZE / 4) as usize).contains(&red), "{red} samples of their own");
}

#[test]
fn every_view_draws_without_lights_maps_or_triangles() {
    let Some(gpu) = gpu_or_skip() else { return };
    let nothing = LightSet::new("none", Vec::new(), no_light());
    for technique in [shadow::names().next().unwrap().0, "none"] {
        for (scene, set) in [(Scene::default(), &nothing), (under_a_square().0, &one_disk(Vec3::Y, 0.2))] {
            let settings = settings().with(|s| s.techniques.shadows = technique.to_owned());
            let mut renderer = renderer(&gpu, settings, &scene, set);
            for view in DEBUG_VIEWS {
                renderer.set_debug_view(view.name, 0).unwrap();
                let radiance = renderer.render(&from_front(), 16, 9).unwrap().radiance;
                assert!(radiance.texels().iter().all(|texel| texel.is_finite()), "{}", view.name);
            }
        }
    }
}

#[test]
fn a_face_whose_texture_coordinates_stay_the_same_has_one_texel_s_colour() {
    let Some(gpu) = gpu_or_skip() else { return };
    // A palette: as a face of a low-polygon model uses it.
    let palette = (0..64_u8).map(|i| [4 * i, 255 - 4 * i, 128, 255]).collect();
    let texture = Texture { width: 8, height: 8, rgba8: palette, wrap: [Wrap::Repeat; 2], nearest: false };
    let mut mesh = horizontal(Vec2::splat(-4.0), Vec2::splat(4.0), 0.0);
    mesh.uvs[0] = vec![Vec2::new(2.5, 5.5) / 8.0; mesh.positions.len()];
    let reference = TextureRef { texture: TextureId(0), uv_from_mesh: Affine2::IDENTITY, set: 0 };
    let mut material = Material { base_color_texture: Some(reference), ..Default::default() };
    material.surface.base_color = Vec3::ONE;
    let mut scene = scene_of(vec![mesh], material);
    scene.textures.push(texture.into());
    let mut renderer = renderer(&gpu, settings(), &scene, &one_disk(Vec3::Y, 0.3));
    let camera = Camera::look_at(Vec3::new(0.0, 3.0, 3.0), Vec3::ZERO, 0.6);
    let shown = shown(&mut renderer, &camera, ("base-color", 0), [SIZE, SIZE]);
    assert_near(shown(32, 32), [4 * 42, 255 - 4 * 42, 128]);
}

#[test]
fn a_picture_that_is_none_is_an_error() {
    let Some(gpu) = gpu_or_skip() else { return };
    let mut material = Material::default();
    material.surface.base_color.y = f32::NAN;
    let scene = scene_of(vec![sphere()], material);
    let mut renderer = renderer(&gpu, settings(), &scene, &one_disk(Vec3::Y, 0.3));
    let Err(RenderError::NotFinite { pixels, .. }) = renderer.render(&from_front(), SIZE, SIZE) else {
        panic!("a picture");
    };
    assert!((200..2000).contains(&pixels), "{pixels}: as many as show the sphere");
}
