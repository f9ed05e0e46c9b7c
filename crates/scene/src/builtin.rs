//! Scenes made by code, ground and camera included.

mod terrain;

use std::f32::consts::TAU;

use glam::{Mat3, Vec3};

use crate::framing::square;
use crate::{Camera, Material, MaterialId, Mesh, Scene, SceneError};

/// Names that [`by_name`] knows.
pub const NAMES: [&str; 3] = ["three-boxes", "column", "terrain"];

/// The built-in scene of that name.
///
/// # Errors
/// [`SceneError::Request`] naming the scenes that exist.
pub fn by_name(name: &str) -> Result<Scene, SceneError> {
    let mut scene = without_ground(name)?;
    if name == "terrain" {
        return Ok(scene);
    }
    let material = Material { name: "ground".to_owned(), double_sided: true, ..Material::default() };
    scene.materials.push(material);
    let material = Some(MaterialId(scene.materials.len() - 1));
    scene.ground = Some(scene.push_mesh("ground", Mesh { material, ..square(Vec3::ZERO, GROUND_HALF_SIDE) }));
    Ok(scene)
}

/// Half the side of the ground [m].
const GROUND_HALF_SIDE: f32 = 4.0;

/// The built-in scene's models and camera alone, to be placed in another scene.
///
/// # Errors
/// As [`by_name`].
pub fn without_ground(name: &str) -> Result<Scene, SceneError> {
    match name {
        "three-boxes" => Ok(three_boxes()),
        "column" => Ok(column()),
        "terrain" => Ok(terrain()),
        _ => {
            let name = gnomon_messages::quoted(name);
            Err(SceneError::Request(format!(
                "there is no built-in scene '{name}' (there are: {})",
                NAMES.join(", ")
            )))
        }
    }
}

/// Three boxes, 38 triangles with their ground, Lambert 0.5, flat: a scene of the size that Arbree et al. (2005) use.
fn three_boxes() -> Scene {
    let mut boxes = FlatMesh::default();
    // Footprint's centre (x, z), side, height [m], turn about +y [rad].
    for (x, z, side, height, turn) in
        [(-0.9, -0.2, 0.8, 1.0, 0.4), (0.6, -0.7, 0.7, 1.8, -0.3), (0.5, 0.8, 0.6, 0.6, 0.9)]
    {
        boxes.cuboid(Vec3::new(x, 0.0, z), Vec3::new(side, height, side), turn);
    }
    let camera = Camera::look_at(Vec3::new(3.2, 2.6, 4.2), Vec3::new(0.0, 0.5, 0.0), 40_f32.to_radians());
    matte("boxes", boxes.0, camera)
}

/// A round column with plinth, moulded base, swelling shaft, moulded capital and abacus, 440 triangles with its ground,
/// Lambert 0.5.
///
/// The solids are closed. Flat faces have flat normals; the turned part is smooth around its axis and creased along
/// its profile.
fn column() -> Scene {
    /// Radius and height [m] of the turned part, from the bottom.
    const PROFILE: [(f32, f32); 11] = [
        (0.44, 0.20),
        (0.50, 0.27),
        (0.44, 0.34),
        (0.38, 0.38),
        (0.36, 0.46),
        (0.35, 1.20),
        (0.31, 2.30),
        (0.36, 2.34),
        (0.33, 2.39),
        (0.38, 2.48),
        (0.46, 2.56),
    ];
    const SIDES: usize = 19;
    let mut mesh = FlatMesh::default();
    mesh.cuboid(Vec3::ZERO, Vec3::new(1.06, 0.2, 1.06), 0.0);
    mesh.cuboid(Vec3::new(0.0, 2.56, 0.0), Vec3::new(1.0, 0.16, 1.0), 0.0);
    mesh.turned(&PROFILE, SIDES);
    let camera = Camera::look_at(Vec3::new(3.6, 2.7, 5.2), Vec3::new(0.0, 1.15, 0.0), 42_f32.to_radians());
    matte("column", mesh.0, camera)
}

/// A mountain landscape, 32,768 triangles, Lambert 0.5, smooth; what it stands on is itself.
fn terrain() -> Scene {
    let camera = Camera::look_at(Vec3::new(4.2, 3.9, 5.6), Vec3::new(0.0, 0.2, 0.0), 46_f32.to_radians());
    matte("terrain", terrain::mesh(), camera)
}

/// One mesh, matte and seen from both sides, and a camera.
fn matte(name: &str, mesh: Mesh, mut camera: Camera) -> Scene {
    camera.name = "camera".to_owned();
    let mut scene = Scene { cameras: vec![camera], ..Scene::default() };
    scene.materials.push(Material { name: name.to_owned(), double_sided: true, ..Material::default() });
    scene.push_mesh(name, Mesh { material: Some(MaterialId(0)), ..mesh });
    scene
}

/// A mesh to which solids are added, each face with vertices of its own.
#[derive(Default)]
struct FlatMesh(Mesh);

impl FlatMesh {
    /// A planar polygon, counter-clockwise from the front, as a fan.
    fn polygon(&mut self, corners: &[Vec3]) {
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
        let first = self.0.positions.len() as u32;
        self.0.positions.extend(corners);
        self.0.normals.extend(corners.iter().map(|_| normal));
        self.0.triangles.extend((1..corners.len() as u32 - 1).map(|i| [first, first + i, first + i + 1]));
    }

    /// A box that stands on `bottom`, turned about its vertical axis.
    fn cuboid(&mut self, bottom: Vec3, size: Vec3, turn: f32) {
        let rotation = Mat3::from_rotation_y(turn);
        let corner = |x: f32, y: f32, z: f32| bottom + rotation * (Vec3::new(x - 0.5, y, z - 0.5) * size);
        let (low, high) = (0.0, 1.0);
        self.polygon(&[
            corner(low, low, low),
            corner(high, low, low),
            corner(high, low, high),
            corner(low, low, high),
        ]);
        self.polygon(&[
            corner(low, high, low),
            corner(low, high, high),
            corner(high, high, high),
            corner(high, high, low),
        ]);
        self.polygon(&[
            corner(low, low, high),
            corner(high, low, high),
            corner(high, high, high),
            corner(low, high, high),
        ]);
        self.polygon(&[
            corner(high, low, low),
            corner(low, low, low),
            corner(low, high, low),
            corner(high, high, low),
        ]);
        self.polygon(&[
            corner(low, low, low),
            corner(low, low, high),
            corner(low, high, high),
            corner(low, high, low),
        ]);
        self.polygon(&[
            corner(high, low, high),
            corner(high, low, low),
            corner(high, high, low),
            corner(high, high, high),
        ]);
    }

    /// A closed solid of revolution about +y: radius and height along `profile`, from the bottom.
    fn turned(&mut self, profile: &[(f32, f32)], sides: usize) {
        let around = |side: usize| {
            let (sin, cos) = (TAU * (side % sides) as f32 / sides as f32).sin_cos();
            Vec3::new(cos, 0.0, -sin)
        };
        let at = |(radius, height): (f32, f32), side: usize| radius * around(side) + height * Vec3::Y;
        for band in profile.windows(2) {
            let slope = (band[1].1 - band[0].1, band[0].0 - band[1].0);
            let first = self.0.positions.len() as u32;
            for side in 0..sides {
                let normal = (slope.0 * around(side) + slope.1 * Vec3::Y).normalize();
                self.0.positions.extend([at(band[0], side), at(band[1], side)]);
                self.0.normals.extend([normal; 2]);
            }
            for side in 0..sides as u32 {
                let (here, next) = (first + 2 * side, first + 2 * ((side + 1) % sides as u32));
                self.0.triangles.extend([[here, next, next + 1], [here, next + 1, here + 1]]);
            }
        }
        if let (Some(&bottom), Some(&top)) = (profile.first(), profile.last()) {
            self.polygon(&(0..sides).rev().map(|side| at(bottom, side)).collect::<Vec<_>>());
            self.polygon(&(0..sides).map(|side| at(top, side)).collect::<Vec<_>>());
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;

    use super::*;
    use crate::triangle_normal;

    #[test]
    fn triangle_counts_are_those_of_the_papers() {
        assert_eq!(by_name("three-boxes").unwrap().triangle_count(), 38);
        assert_eq!(by_name("column").unwrap().triangle_count(), 440);
        for name in NAMES {
            let scene = by_name(name).unwrap();
            assert_eq!(scene.cameras.len(), 1);
            assert_eq!(scene.bounds().unwrap().min.y, 0.0);
        }
        let error = by_name("teapot").unwrap_err().to_string();
        assert!(error.contains("three-boxes, column, terrain"), "{error}");
        assert!(by_name("terrain").unwrap().ground.is_none());
    }

    /// Every edge of a closed, consistently oriented solid is run once in each direction.
    #[test]
    fn solids_are_closed_and_face_outwards() {
        for scene in ["three-boxes", "column"].map(|name| by_name(name).unwrap()) {
            let mesh = &scene.meshes[0];
            let key = |i: u32| mesh.positions[i as usize].to_array().map(|x| (x * 1e4).round() as i64);
            let mut edges: HashMap<_, i32> = HashMap::new();
            let mut volume = 0.0;
            for &[a, b, c] in &mesh.triangles {
                for (from, to) in [(a, b), (b, c), (c, a)] {
                    let (from, to) = (key(from), key(to));
                    let sign = if from < to { 1 } else { -1 };
                    *edges.entry((from.min(to), from.max(to))).or_default() += sign;
                }
                let corners = [a, b, c].map(|i| mesh.positions[i as usize]);
                volume += corners[0].dot(corners[1].cross(corners[2])) / 6.0;
                let normal = triangle_normal(corners).unwrap();
                for i in [a, b, c] {
                    assert!(mesh.normals[i as usize].is_normalized());
                    assert!(mesh.normals[i as usize].dot(normal) > 0.9);
                }
            }
            assert!(edges.values().all(|&sum| sum == 0));
            assert!(volume > 0.5, "{volume}");
        }
    }
}
