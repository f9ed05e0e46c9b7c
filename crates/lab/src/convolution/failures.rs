use glam::{DVec2, DVec3, Vec3};
use gnomon_envmap::Equirect;
use gnomon_lights::{DistantLight, LightSet};
use gnomon_picture::{ContactSheet, Panel, RgbImage};
use gnomon_scene::{Camera, Material, MaterialId, Mesh, MeshId, Node, Scene, builtin};

use super::common::{Lamp, add_light, maps_by_footprint, square_lamp};
use super::variant::Variant;
use crate::pictures::{difference, shown};
use crate::report::{Section, Table};
use crate::{Experiment, Lab, LabError, Setup, View};

/// Where one depth map a light is not enough: three scenes made for it.
pub(super) struct Failures;

/// Thickness of plates and ground [m].
const THICKNESS: f32 = 0.04;

impl Experiment for Failures {
    fn name(&self) -> &'static str {
        "failures"
    }

    fn title(&self) -> &'static str {
        "Known failures of one depth map a light"
    }

    fn run(&self, lab: &Lab<'_>) -> Result<Section, LabError> {
        let size = lab.pick([32, 24], [192, 144], [192, 144]);
        // The map is black: a ratio of it would be, too.
        let compositing = "additive".to_owned();
        let frame =
            maps_by_footprint(lab.pick(32, 256, 512)).with(|s| s.techniques.compositing = compositing);
        // Half the side of the lamp over its distance: 28 degrees across.
        let lamp = |name, plates: &[Plate]| Lamp::new(under_a_lamp(name, plates, 0.25));
        // Seen from the lamp's centre, the small plate near the ground lies behind the large one.
        let silhouette =
            lamp("single silhouette", &[plate([0.0, 1.4, 0.0], 0.5), plate([0.0, 0.22, 0.0], 0.42)]);
        // Both plates are seen from the lamp's centre, side by side.
        let stacked = lamp("stacked blockers", &[plate([0.0, 1.4, 0.0], 0.6), plate([0.45, 0.3, 0.0], 0.6)]);
        let black = Equirect::new(RgbImage::filled(64, 32, Vec3::ZERO));
        let (huge, quarter) = (three_boxes()?, quarter_of_a_sky(&black));
        let setups = [
            silhouette.setup(size),
            stacked.setup(size),
            Setup { view: &huge, map: &black, lights: &quarter, size },
        ];
        let columns = [
            ("scene", ""),
            ("technique", ""),
            ("relative RMSE", ""),
            ("relative bias", ""),
            ("noise of the truth", ""),
        ];
        let mut table = Table::new("failures", "Error where one depth map a light is not enough", &columns);
        let mut sheet = ContactSheet::new("failures", "Known failures: convolution, M = 4", 3);
        for (step, setup) in setups.into_iter().enumerate() {
            let name = setup.view.name;
            lab.tell(&format!("failures: {name}"), step as f32 / 3.0);
            let truth = lab.truth_of_lights(&setup, lab.pick(2, 256, 1024))?;
            for variant in [Variant::mip(4), Variant::technique("pcss"), Variant::technique("rays")] {
                let Some(drawn) = variant.drawn(lab, setup, &frame, &truth.picture)? else { continue };
                let comparison = &drawn.comparison;
                table.push([
                    name.into(),
                    drawn.name.as_str().into(),
                    comparison.relative_rmse.into(),
                    comparison.relative_bias.into(),
                    truth.noise.into(),
                ]);
                if variant.technique != "convolution" {
                    continue;
                }
                let stops = comparison.exposure;
                sheet.panels.extend([
                    Panel::new(drawn.caption(name), shown(&drawn.picture, stops)),
                    Panel::new("ray traced", shown(&truth.picture, stops)),
                    Panel::new("picture - truth", difference(&drawn.picture, &truth.picture)?),
                ]);
            }
        }
        let paragraph = format!(
            "{} x {} pixels of 2 x 2 samples; the scene's exact light is traced. Single silhouette and stacked blockers: two square \
             plates over a plane under one square lamp 28 degrees across. Huge lights: three boxes under one distant square of 90 \
             degrees.",
            size[0], size[1]
        );
        Ok(Section {
            paragraphs: vec![paragraph],
            tables: vec![table],
            sheets: vec![sheet],
            ..Section::default()
        })
    }
}

/// A horizontal square plate.
#[derive(Clone, Copy)]
struct Plate {
    center: Vec3,
    side: f32,
    thickness: f32,
}

const fn plate(center: [f32; 3], side: f32) -> Plate {
    Plate { center: Vec3::from_array(center), side, thickness: THICKNESS }
}

/// Plates over a plane at y = 0, and a square lamp straight above, four metres over it.
fn under_a_lamp(name: &'static str, plates: &[Plate], half_side: f32) -> View {
    let mut scene = Scene::default();
    scene.materials.push(Material { name: "matte".to_owned(), double_sided: true, ..Material::default() });
    let ground = Plate { center: Vec3::new(0.0, -0.5 * THICKNESS, 0.0), side: 8.0, thickness: THICKNESS };
    for part in plates.iter().chain([&ground]) {
        scene.meshes.push(part.mesh().into());
        scene.nodes.push(Node {
            name: "plate".to_owned(),
            meshes: vec![MeshId(scene.meshes.len() - 1)],
            ..Node::default()
        });
    }
    add_light(&mut scene, square_lamp(Vec3::ZERO, Vec3::Y, 4.0, half_side));
    let camera = Camera::look_at(Vec3::new(2.1, 2.5, 3.3), Vec3::new(0.1, 0.55, 0.0), 40_f32.to_radians());
    View::new(name, scene, camera)
}

impl Plate {
    /// Its six faces, each with corners of its own.
    fn mesh(&self) -> Mesh {
        let half = 0.5 * Vec3::new(self.side, self.thickness, self.side);
        let mut mesh = Mesh { material: Some(MaterialId(0)), ..Mesh::default() };
        for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
            for normal in [axis, -axis] {
                // Right-handed with the normal, so that corners run counter-clockwise seen from outside.
                let across = Vec3::new(axis.z, axis.x, axis.y);
                let up = normal.cross(across);
                let first = mesh.positions.len() as u32;
                for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
                    mesh.positions.push(self.center + half * (normal + x * across + y * up));
                    mesh.normals.push(normal);
                }
                mesh.triangles.extend([[0, 1, 2], [0, 2, 3]].map(|triangle| triangle.map(|i| first + i)));
            }
        }
        mesh
    }
}

fn three_boxes() -> Result<View, LabError> {
    let scene = builtin::by_name("three-boxes")?;
    let camera = Camera::look_at(Vec3::new(3.2, 2.6, 4.2), Vec3::new(0.0, 0.5, 0.0), 45_f32.to_radians());
    Ok(View::new("huge light", scene, camera))
}

/// One square of 90 degrees, high on the left; irradiance across its axis is near pi.
fn quarter_of_a_sky(residual: &Equirect) -> LightSet {
    let forward = DVec3::new(-0.5, 1.1, 0.5).normalize();
    let right = forward.cross(DVec3::Y).normalize();
    let axes = [right, right.cross(forward), forward];
    let flux = DVec3::splat(std::f64::consts::PI);
    let light = DistantLight::rectangle(axes, DVec2::NEG_ONE, DVec2::ONE, flux);
    LightSet::new("one square", vec![light], residual.clone())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plates_are_closed_and_face_outwards() {
        let mesh = plate([1.0, 2.0, 3.0], 0.5).mesh();
        assert_eq!(mesh.triangles.len(), 12);
        let mut volume = 0.0;
        for triangle in &mesh.triangles {
            let [a, b, c] = triangle.map(|i| mesh.positions[i as usize]);
            assert!((b - a).cross(c - a).dot(mesh.normals[triangle[0] as usize]) > 0.0);
            volume += a.dot(b.cross(c)) / 6.0;
        }
        assert!((volume - 0.25 * THICKNESS).abs() < 1e-5, "{volume}");
    }

    #[test]
    fn the_hidden_plate_is_hidden_from_the_lamp_and_the_other_is_not() {
        let view = under_a_lamp("test", &[plate([0.0, 1.4, 0.0], 0.5)], 0.25);
        let [lamp] = view.scene.placed_lights()[..] else { panic!("one lamp") };
        assert!((lamp.center - 4.0 * Vec3::Y).length() < 1e-5 && lamp.normal.y < -0.999);
        // Where the upper plate's shadow from the centre ends at the lower plate's height.
        let shadow = |half: f32, height: f32| half * (lamp.center.y - height) / (lamp.center.y - 1.4);
        assert!(shadow(0.25, 0.22) > 0.21 && shadow(0.3, 0.3) < 0.45 + 0.3);
    }
}
