use super::*;
use crate::{Material, MaterialId, builtin};

/// Triangles of a polygon around a centre, counter-clockwise seen from +z.
fn polygon(corners: &[Vec3]) -> Mesh {
    let triangles = (1..corners.len() as u32 - 1).map(|i| [0, i, i + 1]).collect();
    Mesh { positions: corners.to_vec(), triangles, material: Some(MaterialId(0)), ..Mesh::default() }
}

fn glowing(mesh: Mesh, parent_from_node: Affine3A, double_sided: bool) -> Scene {
    let material = Material { emissive: Vec3::new(4.0, 2.0, 1.0), double_sided, ..Material::default() };
    let mut scene = Scene { materials: vec![material], ..Scene::default() };
    let node = scene.push_mesh("panel", mesh);
    scene.nodes[node.0].parent_from_node = parent_from_node;
    scene
}

#[test]
fn a_quad_becomes_a_rectangle_that_shines_from_its_front() {
    let quad = [Vec3::ZERO, Vec3::new(2.0, 0.0, 0.0), Vec3::new(2.0, 0.5, 0.0), Vec3::new(0.0, 0.5, 0.0)];
    for mirror in [1.0, -1.0] {
        let place = Affine3A::from_translation(Vec3::Y)
            * Affine3A::from_rotation_x(0.5 * PI)
            * Affine3A::from_scale(Vec3::new(2.0 * mirror, 2.0, 2.0));
        let mut scene = glowing(polygon(&quad), place, false);
        scene.light_emission();
        let [light] = scene.placed_lights()[..] else { panic!("one light") };
        let AreaLightShape::Rectangle { size } = light.shape else { panic!("{:?}", light.shape) };
        assert!((size.max_element() - 4.0).abs() < 1e-5 && (size.min_element() - 1.0).abs() < 1e-5, "{size}");
        assert!(light.center.abs_diff_eq(Vec3::new(2.0 * mirror, 1.0, 0.5), 2e-3), "{}", light.center);
        // From +z a quarter turn about x, and a mirror across turns no front.
        assert!(light.normal.abs_diff_eq(Vec3::NEG_Y, 1e-5), "{mirror}: {}", light.normal);
        assert!(light.radiance.abs_diff_eq(Vec3::new(4.0, 2.0, 1.0), 1e-5));
        assert!(scene.meshes[0].shines);
    }
}

/// Red on the left and green on the right, by the colours of vertices.
#[test]
fn a_picture_is_divided_where_it_changes_and_seen_from_behind_it_is_mirrored() {
    let mut mesh = Mesh { material: Some(MaterialId(0)), ..Mesh::default() };
    for (x, color) in [(0.0, Vec3::X), (1.0, Vec3::X), (1.0, Vec3::Y), (4.0, Vec3::Y)] {
        mesh.positions.extend([Vec3::new(x, 0.0, 0.0), Vec3::new(x, 1.0, 0.0)]);
        mesh.colors.extend([color.extend(1.0); 2]);
    }
    mesh.triangles = vec![[0, 2, 1], [1, 2, 3], [4, 6, 5], [5, 6, 7]];
    let mut scene = glowing(mesh, Affine3A::IDENTITY, true);
    scene.materials[0].emissive = Vec3::splat(2.0);
    scene.materials[0].emissive_vertex_colors = true;
    scene.light_emission();
    let lights = scene.placed_lights();
    assert_eq!(lights.len(), 4, "{lights:?}");
    for light in lights {
        let is_red = light.radiance.abs_diff_eq(2.0 * Vec3::X, 1e-4);
        let (middle, width) = if is_red { (0.5, 1.0) } else { (2.5, 3.0) };
        assert!(is_red || light.radiance.abs_diff_eq(2.0 * Vec3::Y, 1e-4), "{light:?}");
        assert!((light.center.x - middle).abs() < 1e-3, "{light:?}");
        let AreaLightShape::Rectangle { size } = light.shape else { panic!("{light:?}") };
        assert!((size.max_element() - width).abs() < 1e-3, "{light:?}");
        // A little before its side.
        assert!(light.center.z * light.normal.z > 0.0);
    }
}

#[test]
fn both_sides_shine_where_both_are_seen() {
    let triangle = [Vec3::ZERO, Vec3::X, Vec3::Y];
    let mut scene = glowing(polygon(&triangle), Affine3A::IDENTITY, true);
    scene.light_emission();
    let [front, back] = scene.placed_lights()[..] else { panic!("two lights") };
    assert!(front.normal.abs_diff_eq(Vec3::Z, 1e-6) && back.normal.abs_diff_eq(Vec3::NEG_Z, 1e-6));
    // Half of the rectangle around it.
    assert!((front.radiance.x - 2.0).abs() < 1e-5, "{}", front.radiance);
}

#[test]
fn a_round_plate_becomes_a_disk_of_its_area() {
    let corners: Vec<Vec3> =
        (0..32).map(|i| (Vec2::from_angle(2.0 * PI * i as f32 / 32.0) * 0.5).extend(1.0)).collect();
    let mut scene = glowing(polygon(&corners), Affine3A::IDENTITY, false);
    scene.light_emission();
    let [light] = scene.placed_lights()[..] else { panic!("one light") };
    assert!(
        matches!(light.shape, AreaLightShape::Disk { radius } if (radius - 0.4984).abs() < 1e-3),
        "{:?}",
        light.shape
    );
    assert!(light.center.abs_diff_eq(Vec3::Z, 2e-3) && (light.radiance.x - 4.0).abs() < 1e-4);
}

#[test]
fn sides_of_a_box_are_lights_and_what_is_curved_is_only_seen() {
    let mut boxes = builtin::without_ground("three-boxes").unwrap();
    boxes.materials = vec![Material { emissive: Vec3::ONE, ..Material::default() }];
    boxes.meshes.iter_mut().for_each(|mesh| Arc::make_mut(mesh).material = Some(MaterialId(0)));
    let before = boxes.clone();
    boxes.light_emission();
    assert_eq!(boxes.placed_lights().len(), 3 * 6);
    assert_eq!(boxes.triangle_count(), before.triangle_count());
    // A strip that bends a little from piece to piece.
    let mut strip = Mesh { material: Some(MaterialId(0)), ..Mesh::default() };
    for i in 0..200_u32 {
        let (sin, cos) = (0.01 * i as f32).sin_cos();
        strip.positions.extend([Vec3::new(sin, 0.0, cos), Vec3::new(sin, 1.0, cos)]);
        if i > 0 {
            strip.triangles.extend([[2 * i - 2, 2 * i, 2 * i - 1], [2 * i - 1, 2 * i, 2 * i + 1]]);
        }
    }
    let mut curved = glowing(strip, Affine3A::IDENTITY, false);
    curved.light_emission();
    assert!(curved.lights.is_empty() && !curved.meshes[0].shines);
}

#[test]
fn materials_are_those_of_the_file_and_only_the_mesh_that_has_lights_shines() {
    let triangle = [Vec3::ZERO, Vec3::X, Vec3::Y];
    let mut scene = glowing(polygon(&triangle), Affine3A::IDENTITY, false);
    // Of the same material, but folded more often than there are lights.
    let mut folded = Mesh { material: Some(MaterialId(0)), ..Mesh::default() };
    for i in 0..=3 * MOST_PARTS as u32 {
        let x = i as f32;
        folded.positions.extend([Vec3::new(x, 0.0, (i % 2) as f32), Vec3::new(x, 1.0, (i % 2) as f32)]);
        if i > 0 {
            folded.triangles.extend([[2 * i - 2, 2 * i, 2 * i - 1], [2 * i - 1, 2 * i, 2 * i + 1]]);
        }
    }
    scene.push_mesh("folded", folded);
    let materials = scene.materials.clone();
    scene.light_emission();
    assert_eq!(scene.materials, materials);
    assert!(scene.meshes[0].shines && !scene.meshes[1].shines);
}

#[test]
fn a_panel_of_a_flattened_node_is_only_seen() {
    let flat = Affine3A::from_scale(Vec3::new(1.0, 1.0, 0.0));
    let mut scene = glowing(polygon(&[Vec3::ZERO, Vec3::X, Vec3::Y]), flat, false);
    scene.light_emission();
    assert!(scene.lights.is_empty() && !scene.meshes[0].shines);
}
