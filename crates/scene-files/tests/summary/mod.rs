//! What a scene looks like, in a few sums: the same whatever its triangles, nodes and files are called, and however polygons were cut.
#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests fail the test")]
#![allow(dead_code, reason = "each test uses some of it")]

use std::path::Path;

use glam::{DVec3, Vec3};
use gnomon_scene::Scene;
use gnomon_scene_files::{LoadOptions, LoadedScene, load};

/// Sums over the area of all surfaces; places are seen from the smallest corner.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    pub area: f64,
    pub centroid: DVec3,
    pub normal: DVec3,
    pub color: DVec3,
    /// Where which colour is.
    pub moment: DVec3,
}

impl Summary {
    pub fn of(scene: &Scene) -> Self {
        let corner = scene.bounds().map_or(Vec3::ZERO, |bounds| bounds.min);
        let mut sum = Self {
            area: 0.0,
            centroid: DVec3::ZERO,
            normal: DVec3::ZERO,
            color: DVec3::ZERO,
            moment: DVec3::ZERO,
        };
        for instance in scene.instances() {
            let mesh = &scene.meshes[instance.mesh.0];
            for (index, triangle) in mesh.triangles.iter().enumerate() {
                let [a, b, c] = triangle.map(|vertex| {
                    (instance.world_from_mesh.transform_point3(mesh.positions[vertex as usize]) - corner)
                        .as_dvec3()
                });
                let area = 0.5 * (b - a).cross(c - a).length();
                sum.area += area;
                // A few points, so that textures count.
                for weights in
                    [Vec3::new(0.5, 0.25, 0.25), Vec3::new(0.25, 0.5, 0.25), Vec3::new(0.25, 0.25, 0.5)]
                {
                    let share = area / 3.0;
                    let place =
                        f64::from(weights.x) * a + f64::from(weights.y) * b + f64::from(weights.z) * c;
                    let point = scene.surface_at(instance.mesh, index, weights);
                    let color = point.surface.base_color.as_dvec3() + point.emissive.as_dvec3();
                    sum.centroid += share * place;
                    sum.normal += share * point.shading_normal.as_dvec3();
                    sum.color += share * color;
                    sum.moment += share * color.dot(DVec3::new(1.0, 3.0, 5.0)) * place;
                }
            }
        }
        sum
    }

    /// Fails unless both are the same within rounding.
    pub fn assert_like(&self, other: &Self, what: &str) {
        let near = |a: f64, b: f64| (a - b).abs() <= 1e-4 * self.area.max(1e-6);
        let same = |a: DVec3, b: DVec3| a.to_array().into_iter().zip(b.to_array()).all(|(a, b)| near(a, b));
        assert!(
            near(self.area, other.area)
                && same(self.centroid, other.centroid)
                && same(self.normal, other.normal)
                && same(self.color, other.color)
                && same(self.moment, other.moment),
            "{what}: {self:?}\nis not {other:?}"
        );
    }
}

pub fn open(path: &Path) -> LoadedScene {
    load(path, &LoadOptions::default()).unwrap_or_else(|error| panic!("{error}"))
}

/// Writes files into a folder of their own and opens the first.
pub fn scene_of(files: &[(&str, &[u8])]) -> Scene {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in files {
        std::fs::write(folder.path().join(name), bytes).unwrap();
    }
    open(&folder.path().join(files[0].0)).scene
}

/// A picture of two texels a side: red, green; blue, white.
pub fn picture() -> Vec<u8> {
    let texels = [[255, 0, 0], [0, 255, 0], [0, 0, 255], [255, 255, 255]];
    let picture = image::RgbImage::from_fn(2, 2, |x, y| image::Rgb(texels[(2 * y + x) as usize]));
    png(image::DynamicImage::from(picture))
}

pub fn png(picture: image::DynamicImage) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    picture.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    bytes.into_inner()
}
